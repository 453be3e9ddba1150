"""Where does something begin, or cease, to hold? Halving between a number for which it does and one for which not.

Whether it holds may be open close to the limit, as it is on the limit itself. Then both sides are closed in on what is
open, and what comes out is still certain on either side.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor
from typing import Final, TypeAlias

MOST_HALVINGS: Final = 100

Holds: TypeAlias = Callable[[float], bool | None]  # None where that cannot be said


@dataclass(frozen=True, slots=True)
class Bracket:
    """Two numbers between which it changes; both were asked for."""

    holds: float
    fails: float
    is_open: bool = False  # whether a number between them was asked for, and could not be judged

    @property
    def width(self) -> float:
        """How far apart they are, relative to the larger; of zero and zero, nothing."""
        size = max(abs(self.holds), abs(self.fails))
        return abs(self.holds - self.fails) / size if size else 0.0


def narrowed(
    holds: float, fails: float, within: float, whole: bool, asked: Holds, nothing: float = 0.0
) -> Bracket:
    """The bracket halved down until it is `within` a share of the larger of both; of whole numbers, until they meet.

    Where the limit is at zero, no share of it is wide enough: `nothing` is a width that always is.
    """
    middle = None
    for _ in range(MOST_HALVINGS):
        if _is_narrow(holds, fails, within, whole, nothing):
            return Bracket(holds, fails)
        middle = _between(holds, fails, whole)
        answer = asked(middle)
        if answer is None:
            break
        holds, fails = (middle, fails) if answer else (holds, middle)
    if middle is None:
        return Bracket(holds, fails)
    return Bracket(
        _closed_in(holds, middle, within, whole, lambda value: asked(value) is True, nothing),
        _closed_in(fails, middle, within, whole, lambda value: asked(value) is False, nothing),
        is_open=True,
    )


def _closed_in(
    certain: float, unsure: float, within: float, whole: bool, is_so: Callable[[float], bool], nothing: float
) -> float:
    """The number next to what is open for which it is still certain."""
    for _ in range(MOST_HALVINGS):
        if _is_narrow(certain, unsure, 0.25 * within, whole, nothing):
            break
        middle = _between(certain, unsure, whole)
        certain, unsure = (middle, unsure) if is_so(middle) else (certain, middle)
    return certain


def _is_narrow(one: float, other: float, within: float, whole: bool, nothing: float) -> bool:
    return abs(one - other) <= (1.0 if whole else max(nothing, within * max(abs(one), abs(other))))


def _between(one: float, other: float, whole: bool) -> float:
    middle = 0.5 * (one + other)
    return float(floor(middle)) if whole else middle
