"""What things cost. Each is run as a module, `python -m benchmarks.statics`."""

import stackdsl  # noqa: F401 -- it asks for one thread, which must be said before numpy is loaded
