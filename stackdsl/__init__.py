"""StackDSL: write down what is built, when, what hits it and what must come of it; see it proven, played and locked."""

import os
from time import time

# Matrices here are small: threads cost more than they bring, on a busy machine tenfold, and sums must not depend on how
# many there are. Read when numpy is loaded, so it is said before.
for _library in ("OPENBLAS", "MKL", "OMP"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

LOADED = time()  # [s] since 1970; code that is written later is not what this process runs
