"""By how much does an assembly stand? A margin costs a program of its own, so it is worked out only on request."""

from collections.abc import Collection
from dataclasses import dataclass

from stability.geometry.given_numbers import admit_in_range, listed
from stability.model import GROUND, BodyId
from stability.statics.admission import STRONGEST, WEAKEST, admit_name, admit_problem
from stability.statics.facts import Problem
from stability.statics.margins.acceleration import AccelerationMargin, acceleration, tilt
from stability.statics.margins.friction import FrictionMargin, least_friction
from stability.statics.margins.placement import PlacementMargin, placement
from stability.statics.margins.weakest import Weakest, weakest, weakest_at

__all__ = [
    "AccelerationMargin",
    "FrictionMargin",
    "Margins",
    "PlacementMargin",
    "Weakest",
    "acceleration",
    "least_friction",
    "margins",
    "placement",
    "tilt",
    "weakest",
    "weakest_at",
]


@dataclass(frozen=True, slots=True)
class Margins:
    """All margins of an assembly that stands."""

    acceleration_g: float  # horizontal, in the worst direction, in units of g
    bearing: float  # that direction, from x towards y [rad]
    tilt: float  # of the ground, in the worst direction [rad]
    friction: float  # the least coefficient, of brick on brick, that still allows equilibrium
    placement: float  # the error of every brick's place in plan that is survived for certain [m]
    weakest: Weakest | None  # the mechanism that opens first at that acceleration; None of what is held on all sides


def margins(
    problem: Problem,
    tolerance: float = 1e-6,
    gravity: float | None = None,
    planes: Collection[BodyId] = (GROUND,),
) -> Margins | None:
    """All margins; None if the problem is not proven to stand. See `acceleration`, `least_friction` and `placement`."""
    admit_problem(problem)
    admit_in_range("the tolerance is", tolerance, 1e-15, 0.5, "write a share of the limit, from 1e-15 to 0.5")
    if gravity is not None:
        admit_in_range("the gravity is", gravity, WEAKEST, STRONGEST, "write m/s2, as a number that is more than 0")
    planes = listed(planes, f"names of planes, such as ['{GROUND}']")
    for plane in planes:
        admit_name("a plane", plane)
    shaken = acceleration(problem, tolerance, gravity)
    if shaken is None:
        return None
    friction = least_friction(problem, tolerance).coefficient
    place = placement(problem, tolerance, planes).value
    return Margins(shaken.value, shaken.bearing, tilt(shaken.value), friction, place, weakest_at(problem, shaken))
