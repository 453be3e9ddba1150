"""The only module that imports pybullet."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["pybullet"]


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Suppress the build time that PyBullet prints from C when it is imported."""
    stderr_copy, devnull = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, 2)
    try:
        yield
    finally:
        os.dup2(stderr_copy, 2)
        os.close(stderr_copy)
        os.close(devnull)


with _silent_stderr():
    import pybullet
