"""The tower of the game Jenga: planks side by side, turned by 90 deg from level to level."""

from math import pi
from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_BRICKS, Levels, PositiveLength
from stackdsl.wording import mm

ROUNDING = 1e-9  # share of a width: a third of 75 mm is 25 mm


class JengaParams(MortaredParams):
    """Planks side by side, turned by 90 deg from level to level."""

    levels: Levels = Field(description="number of levels")
    bricks: Annotated[int, Field(strict=True, ge=2, le=MAX_BRICKS)] = default(3, "number of planks on each level")
    spacing: PositiveLength | None = Field(
        None,
        description="distance between the centres of neighbouring planks; default: plank length / planks per level",
    )

    @property
    def bricks_at_most(self) -> int:
        return self.levels * self.bricks


@layout("jenga", JengaParams)
def jenga(params: JengaParams, size: Vec3) -> Specs:
    """Planks side by side, turned by 90 deg from level to level, to be pulled out one by one.

    Odd levels lie along x and are counted towards +y, even ones along y and are counted towards +x. A level carries
    the levels above as long as their common centre is between the outermost edges of its remaining planks.
    """
    length, width, thickness = size
    spacing = length / params.bricks if params.spacing is None else params.spacing
    if spacing < width * (1.0 - ROUNDING):
        message = f"{params.bricks} planks with a width of {mm(width)} overlap at a spacing of {mm(spacing)}"
        raise InputError("SD104", message, f"write a spacing of at least {mm(width)}, or fewer bricks")
    specs = []
    for level in range(1, params.levels + 1):
        for number in range(params.bricks):
            side, z = (number - (params.bricks - 1) / 2) * spacing, height(level, thickness)
            if level % 2:
                specs.append(BrickSpec(level, (0.0, side, z)))
            else:
                specs.append(BrickSpec(level, (side, 0.0, z), yaw=pi / 2))
    return tuple(specs)
