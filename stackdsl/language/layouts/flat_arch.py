r"""The flat arch, or jack arch: wedges between two abutments, with level upper and lower sides.

________________________
|    \    \  |  /    /    |     all joints point to one point below the middle, so that every stone narrows downwards
|     \____\_|_/____/     |     and its neighbours hold it; the outermost joints lean the most
|     |             |     |
|_____|             |_____|
"""

from itertools import pairwise
from math import dist, tan
from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.arch import admit_mortar
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Outline, Specs, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_STONES, PositiveLength, Slope


class FlatArchParams(MortaredParams):
    """Wedges between two abutments."""

    span: PositiveLength = Field(description="distance between the abutments at the lower side")
    height: PositiveLength = Field(description="height of the lower side above the ground")
    thickness: PositiveLength = Field(description="thickness between the lower and the upper side")
    voussoirs: Annotated[int, Field(strict=True, ge=1, le=MAX_STONES)] = Field(description="number of stones")
    lean: Slope = default("20 deg", "angle between the outermost joints and the vertical")
    abutment: PositiveLength = Field(description="width of each abutment at its top")
    depth: PositiveLength | None = Field(None, description="depth from front to back; default: the width of the brick")

    count = "voussoirs"

    @property
    def bricks_at_most(self) -> int:
        return self.voussoirs + 2


@layout("flat_arch", FlatArchParams)
def flat_arch(params: FlatArchParams, size: Vec3) -> Specs:
    """Two abutments, and wedges between them, level below and above, all set down at the same time."""
    if not 0.0 < tan(params.lean) < params.span / params.thickness:
        raise InputError(
            "SD104", "with this `lean` the joints cannot support the stones", "write, for example, `lean: 20 deg`"
        )
    half, low, high = 0.5 * params.span, params.height, params.height + params.thickness
    widening = 1.0 + params.thickness * tan(params.lean) / half  # from the lower side to the upper one
    below = [half * (2.0 * number / params.voussoirs - 1.0) for number in range(params.voussoirs + 1)]
    stones: list[Outline] = [
        ((a, low), (a * widening, high), (b * widening, high), (b, low)) for a, b in pairwise(below)
    ]
    joints = [((x, low), (x * widening, high)) for x in below]
    admit_mortar(params.joint, joints)
    depth, out = params.depth or size[1], half * widening
    far = out + params.abutment
    ends: list[Outline] = [
        ((side * half, 0.0), (side * half, low), (side * out, high), (side * far, high), (side * far, 0.0))
        for side in (-1.0, 1.0)
    ]
    layers = [0.5 * params.joint * depth * dist(*joint) for joint in joints]  # half of the mortar of each joint
    specs = [
        BrickSpec(1, (0.0, 0.0, 0.0), outline=end, depth=depth, mortar=layer)
        for end, layer in zip(ends, (layers[0], layers[-1]), strict=True)
    ]
    specs += [
        BrickSpec(2, (0.0, 0.0, 0.0), outline=stone, depth=depth, together=number > 0, mortar=one + other)
        for number, (stone, (one, other)) in enumerate(zip(stones, pairwise(layers), strict=True))
    ]
    return tuple(specs)
