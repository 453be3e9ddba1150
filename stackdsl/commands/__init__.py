"""The command line: thin shells around the pipeline; `bench` has a module of its own, all others stand in `main.py`."""
