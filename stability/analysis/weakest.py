"""Finds the weakest brick: the mechanism that opens at the least horizontal acceleration, and that acceleration.

This is the one measure of weakness. Everything that calls a brick the weakest takes it from here. Other numbers have
names of their own: the margin of placement and the joint that limits it, and the room of a brick's centre.
"""

from dataclasses import dataclass
from math import degrees, pi, radians
from typing import TYPE_CHECKING

from stability.model import BodyId
from stability.name_order import in_order, natural_key
from stability.problem import Problem
from stability.statics.fall_description import described, really_moving

if TYPE_CHECKING:
    from stability.analysis.acceleration_margin import AccelerationMargin

DIGITS = 6  # of a bearing in degrees, and of heights in metres: beyond, rounding would choose what is named


@dataclass(frozen=True, slots=True)
class Weakest:
    """The first mechanism of a structure that is proven to stand."""

    brick: BodyId  # the lowest brick of the mechanism, the first by name of several
    bricks: tuple[BodyId, ...]  # all that begin to move, as people count them
    acceleration: float  # level, that is survived in every direction [g]
    fails: float  # at which the mechanism is proven to open [g]
    bearing: float  # that bricks are pulled along then, from +x towards +y, from 0 to 2 pi [rad]
    gives_way: str  # how they move: "L5.1, L5.2 tip over L4.1"


def weakest(problem: Problem, gravity: float | None = None) -> Weakest | None:
    """Return the first mechanism; None if it is held on all sides or not proven to stand. See `acceleration`."""
    from stability.analysis.acceleration_margin import acceleration  # noqa: PLC0415 -- it brings numpy

    margin = acceleration(problem, gravity=gravity)
    return None if margin is None else weakest_at(problem, margin)


def weakest_at(problem: Problem, margin: "AccelerationMargin") -> Weakest | None:
    """The same, where the margin of acceleration is known already."""
    if margin.motion is None:
        return None
    bricks = in_order(really_moving(problem, margin.motion))
    heights = {name: round(problem.bricks[name].pose.position_W[2], DIGITS) for name in bricks}
    lowest = min(bricks, key=lambda name: (heights[name], natural_key(name)))
    bearing = radians(round(degrees(margin.bearing), DIGITS)) % (2.0 * pi)
    words = described(problem, margin.motion)
    return Weakest(lowest, tuple(bricks), margin.value, margin.upper, bearing, words)
