"""Benchmarks of cost and accuracy. Each runs as a module: `python -m benchmarks.statics`."""

import stackdsl  # noqa: F401 -- importing it requests one thread, which must happen before numpy is loaded
