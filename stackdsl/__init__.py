"""StackDSL: write down what is built, when, what hits it and what must come of it; see it proven, played and locked."""

import os
from time import time

# Matrices here are small: threads cost more than they bring, on a busy machine tenfold, and a process that has some is
# copied for no worker. Read when numpy is loaded, so it is said before; who says otherwise has as many for numpy of his
# own, and results do not depend on it (`stability.blas_threads`).
THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
for _setting in THREADS:
    os.environ.setdefault(_setting, "1")

LOADED = time()  # [s] since 1970; code that is written later is not what this process runs
