"""Reading without the collector of garbage, which would go again and again through all that is kept."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Let nothing be collected meanwhile; what is read of one file is bounded, and hardly any of it is garbage."""
    if not gc.isenabled():  # somebody around does the same
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
