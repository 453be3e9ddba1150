"""The one file that imports pybullet; the rest of the package has it from here."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["pybullet"]


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """PyBullet greets with its build time, from C, into whatever its user is printing."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with _silent_stderr():
    import pybullet
