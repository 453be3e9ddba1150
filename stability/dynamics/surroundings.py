"""Region around moving bricks in which a scene is complete, until they leave it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist, inf
from typing import Final

from stability.model import Vec3
from stability.problem import Placed

TIMES = 2.0  # radius, in units of the extent of a part from its first brick: the reach of its rotation, and more


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Ball in which all bodies are known."""

    middle_W: Vec3  # [m]
    within: float  # [m]


EVERYWHERE: Final = Surroundings((0.0, 0.0, 0.0), inf)


def surroundings_of(part: Sequence[Placed]) -> Surroundings:
    """Return the surroundings of a part, about its first brick."""
    middle_W = part[0].pose.position_W
    return Surroundings(middle_W, TIMES * max(dist(middle_W, brick.pose.position_W) + across(brick) for brick in part))


def across(placed: Placed) -> float:
    """Return the diameter of a brick [m]."""
    return 2.0 * placed.brick.shape.bounding_radius
