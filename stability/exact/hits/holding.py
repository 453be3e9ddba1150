"""With what forces is a frozen brick held between those above and those below? Friction there has these to rub with.

They are those of the proof. What lies higher presses too, so the bricks just above a brick are a lower bound, and more
of them are asked only where it is not enough: what a hit costs does not grow with the height of the wall.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from math import ceil

from stability.geometry.vectors import norm
from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.watching.life_cycle import BrickObserver

FEWEST = 4  # courses above a brick that are asked first
SIDEWAYS = 0.5  # vertical part of a normal up to which bricks stand side by side
MORE = 1.5  # times the courses that would press enough if each pressed with the weight of one brick


@dataclass
class Holding(BrickObserver):
    """The normal forces on frozen bricks of one engine, kept until a proof may have changed."""

    _known: dict[BodyId, "_Known"] = field(default_factory=dict, init=False)

    def at_least(self, assembly: Assembly, brick: BodyId, enough: float) -> bool:
        """Whether normal forces from above and below come to at least so much in all [N]."""
        known = self._known.setdefault(brick, _Known())
        while known.force < enough and not known.is_all:
            known.ask_more(assembly, brick, enough)
        return known.force >= enough

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Proofs may be others than they were."""
        self._known.clear()

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Likewise, also if none was woken."""
        self._known.clear()

    def gone(self, bricks: Collection[BodyId]) -> None:
        """What pressed on a brick may be gone."""
        self._known.clear()


@dataclass
class _Known:
    """What is known of the normal forces on one brick."""

    force: float = 0.0  # [N]; a lower bound
    courses: int = 0  # above the brick that were asked
    is_all: bool = False  # whether nothing presses on it from higher up

    def ask_more(self, assembly: Assembly, brick: BodyId, enough: float) -> None:
        weight = assembly.bricks[brick].brick.mass * assembly.gravity
        self.courses = max(2 * self.courses, FEWEST, ceil(MORE * enough / (2.0 * weight)))
        above, front = {brick}, {brick}
        for _ in range(self.courses):
            if not front:
                break  # what a block would need of slivers is millions of courses
            front = {upper for lower in front for upper in _carried(assembly, lower)} - above
            above |= front
        self.is_all = not front
        most = sum(assembly.bricks[name].brick.mass for name in above) * assembly.gravity
        if self.is_all and 2.0 * most < enough:
            self.force = max(self.force, weight)  # all of it would not be enough
            return
        pressing = assembly.forces_above([brick], above).onto(brick)
        from_above = sum(norm(force_W) for _, at_points in pressing for in_cones in at_points for force_W in in_cones)
        self.force = 2.0 * from_above + weight


def _carried(assembly: Assembly, brick: BodyId) -> Iterator[BodyId]:
    """The bricks that lie on a brick."""
    for contact in assembly.contacts(brick):
        if contact.lower == brick and any(normal[2] > SIDEWAYS for normal in contact.normals_W):
            yield contact.upper
