"""How often Python looks for garbage while much is made that stays.

What is made of thousands of bricks are millions of objects without a cycle among them. Left alone, the collector goes
through each of them several times, which takes a quarter of what judging and playing such a structure does.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

SELDOM: Final = 20_000  # objects that are made, and stay, before the collector looks at them; Python's own is 700


@contextmanager
def rarely_collected() -> Iterator[None]:
    """Let the collector look more seldom meanwhile, unless somebody has it look as seldom already, or not at all."""
    before = gc.get_threshold()
    if not 0 < before[0] < SELDOM:
        yield
        return
    try:
        gc.set_threshold(SELDOM, *before[1:])
        yield
    finally:
        gc.set_threshold(*before)
