"""Finds the weakest brick: the mechanism that opens at the least horizontal acceleration, and that acceleration.

This is the only definition of the weakest brick. Other measures have other names: the placement margin with its
limiting joint, and the clearance of a brick's centre.
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

DIGITS = 6  # of a bearing in degrees, and of heights in metres: with more, rounding would choose the named brick


@dataclass(frozen=True, slots=True)
class Weakest:
    """First mechanism of a structure that is proven to stand."""

    brick: BodyId  # the lowest brick of the mechanism, ties by name
    bricks: tuple[BodyId, ...]  # all bricks that begin to move, in natural order
    acceleration: float  # horizontal, survived in every direction [g]
    fails: float  # horizontal acceleration at which the mechanism is proven to open [g]
    bearing: float  # of the pull on the bricks, from +x towards +y, from 0 to 2 pi [rad]
    gives_way: str  # description of the motion: "L5.1, L5.2 tip over L4.1"


def weakest(problem: Problem, gravity: float | None = None) -> Weakest | None:
    """Return the first mechanism; None if it is held on all sides or not proven to stand. See `acceleration`."""
    from stability.analysis.acceleration_margin import acceleration  # noqa: PLC0415 -- it brings numpy

    margin = acceleration(problem, gravity=gravity)
    return None if margin is None else weakest_at(problem, margin)


def weakest_at(problem: Problem, margin: "AccelerationMargin") -> Weakest | None:
    """Return the same for a known margin of acceleration."""
    if margin.motion is None:
        return None
    bricks = in_order(really_moving(problem, margin.motion))
    heights = {name: round(problem.bricks[name].pose.position_W[2], DIGITS) for name in bricks}
    lowest = min(bricks, key=lambda name: (heights[name], natural_key(name)))
    bearing = radians(round(degrees(margin.bearing), DIGITS)) % (2.0 * pi)
    words = described(problem, margin.motion)
    return Weakest(lowest, tuple(bricks), margin.value, margin.upper, bearing, words)
