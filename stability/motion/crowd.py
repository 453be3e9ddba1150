"""Bricks that stand about: which of them may touch a brick, and which of them it meets on its way straight down."""

from collections.abc import Container, Iterable, Iterator

from stability.geometry.neighbours import Neighbours
from stability.geometry.touching import reach_between
from stability.graph import reached
from stability.model import BodyId, Vec3
from stability.shapes.apart import InPlace, bodies_apart, in_place, meeting
from stability.statics.facts import Placed

DOWN: Vec3 = (0.0, 0.0, -1.0)
LEVEL = 1e-9  # height of a unit normal: a face that leans by less is a wall, which bears nothing
PASSES = 1e-6  # share of the smallest side: what would touch by less sideways slides past


class Crowd:
    """Bricks, found by where they are."""

    def __init__(self, bricks: Iterable[Placed] = ()) -> None:
        """Nobody is there but these."""
        self.bricks: dict[BodyId, Placed] = {}
        self._blocks: dict[BodyId, InPlace] = {}
        self._in_space = Neighbours[BodyId]()
        self._in_plan = Neighbours[BodyId]()
        for placed in bricks:
            self.add(placed)

    def add(self, placed: Placed) -> None:
        """Take in a brick; its name must be new."""
        name = placed.brick.id
        self.bricks[name] = placed
        block = self._blocks[name] = in_place(placed.brick.shape, placed.pose)
        self._in_space.add(name, block.low_W, block.high_W)
        self._in_plan.add(name, *_in_plan(block))

    def around(self, placed: Placed) -> list[BodyId]:
        """Those that may touch a brick, by name."""
        block = in_place(placed.brick.shape, placed.pose)
        return self._in_space.around(block.low_W, block.high_W, reach_between(block.thickness))

    def connected(self, bricks: Iterable[Placed]) -> list[Placed]:
        """Those that may touch one of these bricks, directly or through each other, by name."""
        first = {name for placed in bricks for name in self.around(placed)}
        return [self.bricks[name] for name in sorted(reached(first, lambda name: self.around(self.bricks[name])))]

    def below(self, placed: Placed) -> Iterator[tuple[BodyId, float]]:
        """Those that a brick meets on its way straight down, and how far down that is [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if (depth := _drop(own, self._blocks[name])) is not None:
                yield name, depth

    def above(self, placed: Placed, of: Container[BodyId]) -> Iterator[tuple[BodyId, float]]:
        """Those of some that meet a brick on their way straight down, and how far down that is [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if name in of and (depth := _drop(self._blocks[name], own)) is not None:
                yield name, depth


def _drop(upper: InPlace, lower: InPlace) -> float | None:
    """How far a body is above another one, straight down [m]; None if it is not, or has passed it."""
    met = meeting(upper, lower, DOWN, PASSES * upper.thickness)
    if met is None or met[1] <= 0.0:
        return None
    if met[0] <= 0.0 and abs(bodies_apart(upper, lower).normal_BA_W[2]) < LEVEL:
        return None  # a wall beside it, into which it may be written by as much as counts as contact
    return max(0.0, met[0])


def _in_plan(block: InPlace) -> tuple[Vec3, Vec3]:
    """What a block covers, seen from above, as an upright box of one height for all."""
    (ax, ay, _), (bx, by, _) = block.low_W, block.high_W
    return (ax, ay, 0.0), (bx, by, 1.0)
