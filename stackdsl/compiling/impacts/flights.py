"""Does a brick that comes flying, or falls, begin where another one still is on its way?

Where they are is known until they arrive, or something else is done to them; beyond, only a run can tell.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from stability.geometry.vectors import add_scaled
from stability.model import BodyId
from stability.shapes.apart import apart
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.moment import Moment
from stackdsl.timeline import Placement

ROUNDING = 1e-9  # [s] of times that are worked out from others


@dataclass(frozen=True, slots=True)
class Coming:
    """A brick that comes, by the number of its impact."""

    number: int
    moment: Moment
    placement: Placement


@dataclass(frozen=True, slots=True)
class Crossing:
    """One that begins inside another."""

    later: Coming
    earlier: Coming
    depth: float  # [m]


def crossings(coming: Sequence[Coming], known_until: Mapping[BodyId, Moment], gravity: float) -> Iterator[Crossing]:
    """Of each brick that begins inside others the first.

    `known_until` says which are pulled out or pushed, and when.
    """
    in_time = sorted(coming, key=lambda one: one.moment)
    for index, later in enumerate(in_time):
        there = [one for one in in_time[:index] if _flies_at(one, later.moment, known_until)]
        found = (Crossing(later, one, _depth(one, later, gravity)) for one in there)
        yield from [crossing for crossing in found if crossing.depth > OVERLAP][:1]


def _flies_at(coming: Coming, moment: Moment, known_until: Mapping[BodyId, Moment]) -> bool:
    """Whether it is on its way then, undisturbed."""
    arrives = coming.moment.time + coming.placement.flight
    end = known_until.get(coming.placement.brick.id)
    return moment.time <= arrives + ROUNDING and (end is None or moment < end)


def _depth(earlier: Coming, later: Coming, gravity: float) -> float:
    """How far the later one is inside the earlier one when it begins [m]."""
    one, other, time = earlier.placement, later.placement, later.moment.time - earlier.moment.time
    fallen = add_scaled(one.pose.position_W, -0.5 * gravity * time * time, (0.0, 0.0, 1.0))
    pose = replace(one.pose, position_W=add_scaled(fallen, time, one.velocity_W))
    return -apart(one.brick.shape, pose, other.brick.shape, other.pose).gap
