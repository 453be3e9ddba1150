"""Which contacts of what leans an engine gives a wrong normal while a timeline is played."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import hypot

from stability.engines.edge_normals import WrongNormal, wrong_normals
from stability.engines.protocol import World
from stability.model import BodyId, BodyState
from stackdsl.trace import WrongEdges

QUIET = 5e-3  # [m/s] normals of slower bricks hardly change: they are looked at less often
THOROUGH = 10  # at every such look all of them are


@dataclass
class EdgeWatch:
    """Looks at contacts as often as the runner looks at bricks."""

    world: World
    gravity: float  # [m/s2]
    _looks: int = field(default=0, init=False)
    _seen: set[tuple[BodyId, BodyId]] = field(default_factory=set, init=False)
    _first: float | None = field(default=None, init=False)  # [s]
    _most: tuple[WrongNormal, float] | None = field(default=None, init=False)  # and when it was seen [s]

    def look(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in the contacts of all that moves."""
        thorough, self._looks = self._looks % THOROUGH == 0, self._looks + 1
        moving = {brick: state for brick, state in states.items() if thorough or hypot(*state.velocity_W) > QUIET}
        for wrong in wrong_normals(self.world, moving, self.gravity):
            self._seen.add((wrong.upper, wrong.lower))
            self._first = time if self._first is None else self._first
            if self._most is None or wrong.angle > self._most[0].angle:
                self._most = wrong, time

    def absorb(self, other: "EdgeWatch") -> None:
        """Know what another one has seen."""
        self._seen |= other._seen
        first = [seen for seen in (self._first, other._first) if seen is not None]
        self._first = min(first, default=None)
        if other._most is not None and (self._most is None or other._most[0].angle > self._most[0].angle):
            self._most = other._most

    def wrong(self) -> WrongEdges | None:
        """All that was seen; None if nothing was."""
        if self._most is None or self._first is None:
            return None
        most, time = self._most
        return WrongEdges(len(self._seen), most.upper, most.lower, most.angle, time, self._first)
