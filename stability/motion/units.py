"""Units in which what bricks do in a step is near one, so that a solver's tolerances mean something."""

from collections.abc import Collection
from statistics import median
from typing import NamedTuple

import numpy as np

from stability.statics.facts import Placed
from stability.statics.solvers.conic_program import Array


class Units(NamedTuple):
    """What makes numbers near one."""

    speed: float  # [m/s]
    mass: float  # [kg]
    columns: Array  # (6 n,) [m/s], and [rad/s]


def units_of(bricks: Collection[Placed], speed: float) -> Units:
    mass = median(placed.brick.mass for placed in bricks)
    length = median(placed.brick.shape.bounding_radius for placed in bricks)
    return Units(speed, mass, np.tile([speed] * 3 + [speed / length] * 3, len(bricks)))
