"""What counts as not moving, of each brick by its own size: that of another one changes nothing."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from math import sqrt
from typing import TypeAlias

from stability.engines.protocol import Engine
from stability.engines.scene_scale import USUAL_DIAGONAL, USUAL_SIDE
from stability.model import BodyId, ConvexShape, convex
from stability.watching.life_cycle import BrickObserver
from stability.watching.rest import RestLimits

# Of the usual brick's proportions. An engine steps by diagonals, and so shakes what is flatter as much as this.
SHEET = 0.1
LimitsOf: TypeAlias = Callable[[BodyId], RestLimits]


@dataclass
class LimitsBySize(BrickObserver):
    """Limits that were chosen for the usual brick, scaled to each brick of an engine (Froude)."""

    engine: Engine
    usual: RestLimits
    _of: dict[BodyId, RestLimits] = field(default_factory=dict, init=False)

    def __call__(self, brick: BodyId) -> RestLimits:
        """The limits of a brick; the usual ones of what is no solid."""
        limits = self._of.get(brick)
        if limits is None:
            shape = convex(self.engine.shape(brick))
            size = 1.0 if shape is None else times_the_usual(shape)
            limits = self._of[brick] = self.usual.scaled(lengths=size, times=sqrt(size))
        return limits

    def gone(self, bricks: Collection[BodyId]) -> None:
        """A brick of another size may come back under the same name."""
        for brick in bricks:
            self._of.pop(brick, None)


def times_the_usual(shape: ConvexShape) -> float:
    """How many times the usual brick a brick is, by its smallest side; a sheet is held to what an engine can do."""
    return max(shape.least_thickness / USUAL_SIDE, SHEET * 2.0 * shape.bounding_radius / USUAL_DIAGONAL)
