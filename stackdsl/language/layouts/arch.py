r"""The arch: stones with radial joints, between two springings.

      ______
     /  |   \        Its inner side, the intrados, is an arc of a circle through both springings and the crown. Joints
    /\ _|__ /\       point to the centre of that circle, and each stone ends in straight lines between them.
 ___\/      \/___    A flatter arch springs from the inclined face of an abutment at each end, which takes the thrust by
|   |        |   |   its weight and by friction on the ground. Its stones do not touch the ground, since an edge on the
|___|        |___|   ground would have a second support. A semicircle, whose lowest joints are level, stands on the
                     ground or on abutments.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import atan2, cos, dist, pi, sin
from typing import Annotated, Final

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Outline, Specs, layout
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_STONES, PositiveLength
from stackdsl.wording import mm

SEMICIRCLE: Final = 1e-9  # tolerance on the rise of a semicircle, as a share of half the span


class ArchParams(MortaredParams):
    """An arch of stones."""

    span: PositiveLength = Field(description="clear span between the springings")
    rise: PositiveLength | None = Field(
        None,
        description="height of the inner crown above the springings; default: half the span, for a semicircle",
    )
    thickness: PositiveLength = Field(description="thickness of the ring of stones, measured along the joints")
    voussoirs: Annotated[int, Field(strict=True, ge=2, le=MAX_STONES)] = Field(description="number of stones")
    depth: PositiveLength | None = Field(None, description="depth from front to back; default: the width of the brick")
    abutment: PositiveLength | None = Field(
        None, description="width of each abutment behind the arch; default: none, for a semicircle on the ground"
    )
    height: PositiveLength | None = Field(
        None, description="height of the springings above the ground, for arches with abutments; default: the thickness"
    )

    count = "voussoirs"

    @property
    def bricks_at_most(self) -> int:
        return self.voussoirs + 2


@layout("arch", ArchParams)
def arch(params: ArchParams, size: Vec3) -> Specs:
    """Stones with radial joints, all set down at the same time, since no part of an arch stands by itself."""
    half, depth = 0.5 * params.span, params.depth or size[1]
    rise = half if params.rise is None else params.rise
    semicircle = abs(rise - half) <= SEMICIRCLE * half
    _admit(params, rise, semicircle)
    height = 0.0 if params.abutment is None else params.height or params.thickness
    radius = half if semicircle else (half * half + rise * rise) / (2.0 * rise)
    middle = 0.0 if semicircle else rise - radius  # height of the centre of the circle above the springings
    lowest = atan2(-middle, half)  # angle of the lowest joint, seen from the centre
    joints = []
    for number in range(params.voussoirs + 1):
        angle = pi - lowest - (pi - 2.0 * lowest) * number / params.voussoirs
        inner, outer = radius, radius + params.thickness
        joints.append(tuple((r * cos(angle), height + middle + r * sin(angle)) for r in (inner, outer)))
    if semicircle:  # make its lowest joints level despite rounding
        joints[0], joints[-1] = (tuple((x, height) for x, _ in joint) for joint in (joints[0], joints[-1]))
    stones: list[Outline] = [(a[0], a[1], b[1], b[0]) for a, b in pairwise(joints)]
    admit_mortar(params.joint, joints)
    mortar = params.joint * params.thickness * depth  # of one joint
    ends: list[Outline] = []
    if params.abutment is not None:
        ends = [_abutment(joints[0], -params.abutment), _abutment(joints[-1], params.abutment)]
    specs = [BrickSpec(1, (0.0, 0.0, 0.0), outline=end, depth=depth, mortar=0.5 * mortar) for end in ends]
    level = len(specs[:1]) + 1
    specs += [
        BrickSpec(level, (0.0, 0.0, 0.0), outline=stone, depth=depth, together=number > 0, mortar=mortar)
        for number, stone in enumerate(stones)
    ]
    return tuple(specs)


def admit_mortar(joint: float, joints: Sequence[Sequence[tuple[float, float]]]) -> None:
    """Raise InputError for joints of mortar [m] that leave nothing of a stone; its share of the arch includes them."""
    narrowest = min(dist(a[0], b[0]) for a, b in pairwise(joints))
    if joint >= narrowest:
        message = f"joints of {mm(joint)} leave nothing of stones whose share of the arch is {mm(narrowest)} long"
        raise InputError("SD104", message, "write thinner joints, or fewer `voussoirs`")


def _admit(params: ArchParams, rise: float, semicircle: bool) -> None:
    half = 0.5 * params.span
    if rise > half and not semicircle:
        message = f"the rise of the arch, {mm(rise)}, exceeds half its span, {mm(half)}"
        raise InputError("SD104", message, "reduce `rise`, or increase `span`")
    if params.abutment is None and not semicircle:
        raise InputError("SD102", "an arch flatter than a semicircle needs abutments", "add `abutment`")
    if params.abutment is None and params.height is not None:
        raise InputError("SD102", "`height` applies only to arches with abutments", "add `abutment`")


def _abutment(joint: tuple[tuple[float, float], ...], wide: float) -> Outline:
    """Return a stone on the ground, outwards from the joint; `wide` is positive to the right [m]."""
    (inner, springing), (outer, high) = joint
    face = ((inner, springing), (outer, high)) if high > springing else ((inner, springing),)
    return ((inner, 0.0), *face, (outer + wide, high), (outer + wide, 0.0))
