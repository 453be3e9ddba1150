"""Spatial index of bricks, with queries for contacts and for bricks below and above."""

from collections.abc import Container, Iterable, Iterator

from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import InPlace, bodies_apart, in_place, meeting
from stability.geometry.spatial_grid import Neighbours
from stability.graph import reached
from stability.model import BodyId, Vec3
from stability.problem import Placed

DOWN: Vec3 = (0.0, 0.0, -1.0)
LEVEL = 1e-9  # vertical component of a unit normal below which a face is a wall, which carries no load
PASSES = 1e-6  # share of the smallest side: a smaller horizontal overlap is no collision


class BrickIndex:
    """Spatial index of bricks."""

    def __init__(self, bricks: Iterable[Placed] = ()) -> None:
        """Create an index of these bricks."""
        self.bricks: dict[BodyId, Placed] = {}
        self._blocks: dict[BodyId, InPlace] = {}
        self._in_space = Neighbours[BodyId]()
        self._in_plan = Neighbours[BodyId]()
        for placed in bricks:
            self.add(placed)

    def add(self, placed: Placed) -> None:
        """Add a brick with a new name."""
        name = placed.brick.id
        self.bricks[name] = placed
        block = self._blocks[name] = in_place(placed.brick.shape, placed.pose)
        self._in_space.add(name, block.low_W, block.high_W)
        self._in_plan.add(name, *_in_plan(block))

    def around(self, placed: Placed) -> list[BodyId]:
        """Return the bricks that may touch a brick, sorted by name."""
        block = in_place(placed.brick.shape, placed.pose)
        return self._in_space.around(block.low_W, block.high_W, reach_between(block.thickness))

    def connected(self, bricks: Iterable[Placed]) -> list[Placed]:
        """Return the bricks that may touch one of these bricks, directly or through others, sorted by name."""
        first = {name for placed in bricks for name in self.around(placed)}
        return [self.bricks[name] for name in sorted(reached(first, lambda name: self.around(self.bricks[name])))]

    def below(self, placed: Placed) -> Iterator[tuple[BodyId, float]]:
        """Yield the bricks that a brick hits when it moves straight down, with the distances [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if (depth := _drop(own, self._blocks[name])) is not None:
                yield name, depth

    def above(self, placed: Placed, of: Container[BodyId]) -> Iterator[tuple[BodyId, float]]:
        """Yield the bricks in `of` that hit a brick when they move straight down, with the distances [m]."""
        own = in_place(placed.brick.shape, placed.pose)
        for name in self._in_plan.around(*_in_plan(own), 0.0):
            if name in of and (depth := _drop(self._blocks[name], own)) is not None:
                yield name, depth


def _drop(upper: InPlace, lower: InPlace) -> float | None:
    """Return the distance down from a body to another one [m]; None if it is not above it."""
    met = meeting(upper, lower, DOWN, PASSES * upper.thickness)
    if met is None or met[1] <= 0.0:
        return None
    if met[0] <= 0.0 and abs(bodies_apart(upper, lower).normal_BA_W[2]) < LEVEL:
        return None  # a wall beside it, which it may overlap within the tolerance of contacts
    return max(0.0, met[0])


def _in_plan(block: InPlace) -> tuple[Vec3, Vec3]:
    """Return the bounding box of a block in plan, with a common height."""
    (ax, ay, _), (bx, by, _) = block.low_W, block.high_W
    return (ax, ay, 0.0), (bx, by, 1.0)
