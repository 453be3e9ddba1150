"""What of a golden file may be too close to call, and which values such an observation may have all the same.

A file says so where the run that it locks came out so, and agrees then with any value that a run may have there; what
is no such value is a slip of whoever edited it.
"""

from collections.abc import Callable
from typing import TypeAlias, TypeGuard

from stackdsl.snapshots.record import UNCLEAR
from stackdsl.trace import NO_PART, BrickState

LARGEST = 1e300  # of a number that is compared as one

IsValue: TypeAlias = Callable[[object], bool]  # whether a JSON value is one that an observation may have


def is_excused(expected: object, got: object, unclear: IsValue | None) -> bool:
    """Whether one is too close to call, which agrees with any value that there may be in its place, and no other."""
    if unclear is None or UNCLEAR not in (expected, got):
        return False
    return unclear(got if expected == UNCLEAR else expected)


def is_undecided_state(value: object) -> bool:
    return isinstance(value, str) and value in {state.value for state in BrickState} - NO_PART


def is_name_or_none(value: object) -> bool:
    return value is None or isinstance(value, str)


def is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < LARGEST


def is_number(value: object) -> TypeGuard[float]:
    # The bound keeps out NaN, infinities, and integers too large to become floats.
    return isinstance(value, int | float) and not isinstance(value, bool) and -LARGEST < value < LARGEST
