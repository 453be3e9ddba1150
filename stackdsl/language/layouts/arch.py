r"""The arch: stones with radial joints, between two springings.

____
/   |    \         its inner side, the intrados, is an arc of a circle through both springings and the crown;
/  \  |  /   \       joints lead to the middle of that circle, and each stone ends in straight lines between them
|__   ___    __|
|   | /   \  |   |     a semicircle stands on its two lowest joints, which are level; a flatter arch needs an
|___|       |____|     abutment at each end, which takes the thrust by its weight and by friction on the ground
"""

from itertools import pairwise
from math import atan2, cos, pi, sin
from typing import Annotated, Final

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.author_types import MAX_STONES, PositiveLength
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Outline, Specs, layout
from stackdsl.language.mistakes import MistakeError
from stackdsl.wording import mm

SEMICIRCLE: Final = 1e-9  # share of half a span by which a rise may miss it, and still be meant to be it


class ArchParams(LayoutParams):
    """An arch of stones."""

    span: PositiveLength = Field(description="between the springings, on the inner side")
    rise: PositiveLength | None = Field(
        None, description="of the crown above the springings, on the inner side; default: half the span, a semicircle"
    )
    thickness: PositiveLength = Field(description="of the ring of stones, along the joints")
    voussoirs: Annotated[int, Field(strict=True, ge=2, le=MAX_STONES)] = Field(description="how many stones")
    depth: PositiveLength | None = Field(None, description="from front to back; default: the width of the brick")
    abutment: PositiveLength | None = Field(
        None, description="how wide each abutment is behind the arch; for one that is flatter than a semicircle"
    )

    count = "voussoirs"

    @property
    def bricks_at_most(self) -> int:
        return self.voussoirs + 2


@layout("arch", ArchParams)
def arch(params: ArchParams, size: Vec3) -> Specs:
    """Stones with radial joints, all set down at one moment, as no part of an arch stands by itself."""
    half, depth = 0.5 * params.span, params.depth or size[1]
    rise = half if params.rise is None else params.rise
    _admit_rise(params, rise)
    radius = (half * half + rise * rise) / (2.0 * rise)
    middle = 0.0 if _is_semicircle(rise, half) else rise - radius  # the height of the middle of the circle
    lowest = atan2(-middle, half)  # of the joints, seen from there
    joints = []
    for number in range(params.voussoirs + 1):
        angle = pi - lowest - (pi - 2.0 * lowest) * number / params.voussoirs
        inner, outer = radius, radius + params.thickness
        joints.append(tuple((r * cos(angle), middle + r * sin(angle)) for r in (inner, outer)))
    if middle == 0.0:  # of a semicircle, both ends lie on the ground, whatever rounding says
        joints[0], joints[-1] = (tuple((x, 0.0) for x, _ in joint) for joint in (joints[0], joints[-1]))
    stones: list[Outline] = [(a[0], a[1], b[1], b[0]) for a, b in pairwise(joints)]
    ends: list[Outline] = []
    if middle < 0.0:
        ends = [_abutment(joints[0], -_wide(params)), _abutment(joints[-1], _wide(params))]
    specs = [BrickSpec(1, (0.0, 0.0, 0.0), outline=end, depth=depth) for end in ends]
    level = len(specs[:1]) + 1
    specs += [
        BrickSpec(level, (0.0, 0.0, 0.0), outline=stone, depth=depth, together=number > 0)
        for number, stone in enumerate(stones)
    ]
    return tuple(specs)


def _is_semicircle(rise: float, half: float) -> bool:
    return abs(rise - half) <= SEMICIRCLE * half


def _admit_rise(params: ArchParams, rise: float) -> None:
    half = 0.5 * params.span
    if rise > half * (1.0 + SEMICIRCLE):
        message = f"the arch rises by {mm(rise)}, and half its span is {mm(half)}"
        raise MistakeError("SD104", message, "let it rise by half its span at most")
    if _is_semicircle(rise, half) and params.abutment is not None:
        raise MistakeError("SD104", "a semicircle stands on the ground by itself", "leave `abutment` out")
    if not _is_semicircle(rise, half) and params.abutment is None:
        raise MistakeError(
            "SD102", "an arch that is flatter than a semicircle has no ends to stand on", "add `abutment`"
        )


def _wide(params: ArchParams) -> float:
    return params.abutment or 0.0


def _abutment(joint: tuple[tuple[float, float], ...], wide: float) -> Outline:
    """A stone from the joint outwards, on the ground; `wide` to the right, or less than nothing to the left [m]."""
    (inner, _), (outer, high) = joint
    return ((inner, 0.0), (outer, high), (outer + wide, high), (outer + wide, 0.0))
