"""How far around bricks that move it is known what there is: as far as they get before it is asked again."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import dist, inf
from typing import Final

from stability.model import Vec3
from stability.problem import Placed

TIMES = 2.0  # the farthest that a part reaches from its first brick: as far as it may turn, and more


@dataclass(frozen=True, slots=True)
class Surroundings:
    """A ball in which all that there is is known."""

    middle_W: Vec3  # [m]
    within: float  # [m]

    def hold(self, bricks: Collection[Placed]) -> bool:
        """Whether all of these bricks are in it."""
        return all(dist(self.middle_W, one.pose.position_W) + 0.5 * across(one) <= self.within for one in bricks)


EVERYWHERE: Final = Surroundings((0.0, 0.0, 0.0), inf)


def surroundings_of(part: Sequence[Placed]) -> Surroundings:
    """Those of the bricks of a part, about the first of them."""
    middle_W = part[0].pose.position_W
    return Surroundings(middle_W, TIMES * max(dist(middle_W, one.pose.position_W) + across(one) for one in part))


def across(placed: Placed) -> float:
    """What a brick measures across at most [m]."""
    return 2.0 * placed.brick.shape.bounding_radius
