"""How far must one number be changed until something holds that does not? A limit, shown from both sides.

The number is tried further and further away, on either side, until it holds; between that and the last number for which
it did not, the limit is halved down. What is handed out was tried itself: it holds there, and not just before.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, log10
from typing import Final

from stackdsl.judging.brackets import Closeness, Holds, narrowed

CLOSE: Final = 1e-6  # of the number's size: sides of a limit this near to each other show it
DIGITS: Final = 4  # of a limit as people are told it, where it holds with so many


@dataclass(frozen=True, slots=True)
class Limit:
    """The nearest number on one side for which it holds."""

    value: float  # it holds here
    beyond: float  # it does not here
    least: bool  # whether it holds from `value` upwards, rather than down to it


def limits(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> tuple[Limit, ...]:
    """The limits on both sides of a number for which something does not hold.

    `steps`: how far away it is tried, each more than the one before; a limit further than the last is not found. Of a
    `whole` number, whole ones are tried.
    """
    found = (_on_side(number, [sign * step for step in steps], whole, holds) for sign in (-1.0, 1.0))
    return tuple(limit for limit in found if limit is not None)


def _on_side(number: float, steps: Sequence[float], whole: bool, holds: Holds) -> Limit | None:
    fails = number
    for step in steps:
        tried = number + step
        held = holds(tried)
        if held:
            return _shown(tried, fails, whole, holds)
        if held is False:
            fails = tried
    return None


def _shown(held: float, fails: float, whole: bool, holds: Holds) -> Limit | None:
    """The limit between a number for which it holds and one for which it does not; None if it cannot be shown."""
    found = narrowed(held, fails, Closeness(CLOSE, whole), holds)
    if whole:
        return _limit(found.holds, found.fails)
    return _told(found.holds, found.fails, holds) if found.width <= 2.0 * CLOSE else None


def _told(held: float, fails: float, holds: Holds) -> Limit:
    """The limit in few digits, if it holds there: the nearest such number, or the next on the side that holds."""
    largest = max(abs(held), abs(fails))
    unit = 10.0 ** (floor(log10(largest)) + 1 - DIGITS) if largest > 0.0 else 1.0
    inwards = unit if held > fails else -unit
    nearest = unit * round(held / unit)
    for tried in (nearest, nearest + inwards):
        shown = float(f"{tried:.{DIGITS}g}")
        if abs(shown - held) <= 1.5 * unit and holds(shown):
            return _limit(shown, fails)
    return _limit(held, fails)


def _limit(held: float, fails: float) -> Limit:
    return Limit(held, fails, least=held > fails)
