"""Where does something begin, or cease, to hold? Halving between a number for which it does and one for which not.

Whether it holds may be open close to the limit, as it is on the limit itself. Then both sides are closed in on what is
open, and what comes out is still certain on either side.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import floor
from typing import Final, TypeAlias

MOST_HALVINGS: Final = 100
OPEN: Final = 0.25  # of the width: so near to what is open both sides go

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


@dataclass(frozen=True, slots=True)
class Closeness:
    """How near to each other both sides of a limit are to be."""

    within: float  # a share of the larger of both
    whole: bool = False  # of whole numbers: next to each other
    nothing: float = 0.0  # a width that always is narrow; where the limit is at zero, no share of it is

    def is_of(self, one: float, other: float) -> bool:
        """Whether two numbers are as near as that."""
        close = 1.0 if self.whole else max(self.nothing, self.within * max(abs(one), abs(other)))
        return abs(one - other) <= close

    def middle(self, one: float, other: float) -> float:
        """A number between two."""
        middle = 0.5 * (one + other)
        return float(floor(middle)) if self.whole else middle


def narrowed(holds: float, fails: float, closeness: Closeness, asked: Holds) -> Bracket:
    """The bracket halved down until both sides are close enough, or close to what is open."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(holds, fails):
            break
        middle = closeness.middle(holds, fails)
        answer = asked(middle)
        if answer is None:
            closer = replace(closeness, within=OPEN * closeness.within)
            return Bracket(
                _closed_in(holds, middle, closer, lambda value: asked(value) is True),
                _closed_in(fails, middle, closer, lambda value: asked(value) is False),
                is_open=True,
            )
        holds, fails = (middle, fails) if answer else (holds, middle)
    return Bracket(holds, fails)


def _closed_in(certain: float, unsure: float, closeness: Closeness, is_so: Callable[[float], bool]) -> float:
    """The number next to what is open for which it is still certain."""
    for _ in range(MOST_HALVINGS):
        if closeness.is_of(certain, unsure):
            break
        middle = closeness.middle(certain, unsure)
        certain, unsure = (middle, unsure) if is_so(middle) else (certain, middle)
    return certain
