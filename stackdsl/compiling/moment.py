"""When something of a scenario happens, among all that happens at one time."""

from typing import Final, NamedTuple

BUILD: Final = 0  # among what happens at one time, the build comes first, and then impact by impact


class Moment(NamedTuple):
    """A time, and a place among what happens at that time."""

    time: float  # [s]
    turn: int = BUILD  # 1 for the first impact, and so on


START: Final = Moment(0.0)
