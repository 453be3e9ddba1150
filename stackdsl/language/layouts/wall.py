"""The wall: planks end to end in running bond, closed at both ends."""

from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_BRICKS, Levels, NonNegativeLength
from stackdsl.wording import mm


class WallParams(LayoutParams):
    """Planks end to end, in running bond."""

    levels: Levels = Field(description="number of levels")
    bricks: Annotated[int, Field(strict=True, ge=1, le=MAX_BRICKS)] = Field(
        description="number of planks in a level without half planks"
    )
    # Planks that touch end to end would press on each other, which a real wall does not intend.
    gap: NonNegativeLength = default("0.2 mm", "gap between the ends of neighbours")

    @property
    def bricks_at_most(self) -> int:
        return self.levels * (self.bricks + 1)


@layout("wall", WallParams)
def wall(params: WallParams, size: Vec3) -> Specs:
    """Planks end to end along x in running bond, closed at both ends.

    Even levels are shifted by half a plank and have a half plank at both ends. So all levels are equally long, and
    every plank lies on two others or entirely on one.
    """
    length, width, thickness = size
    if params.gap >= length:
        hint = "write a shorter gap, such as 0.2 mm"
        raise InputError("SD104", f"the gap must be shorter than a plank of {mm(length, 6)}", hint)
    pitch, half_plank = length + params.gap, ((length - params.gap) / 2, width, thickness)
    end = (
        params.bricks * pitch - params.gap - half_plank[0]
    ) / 2  # from the middle of the wall to that of a half plank
    specs = []
    for level in range(1, params.levels + 1):
        z, whole = height(level, thickness), params.bricks - (level % 2 == 0)
        row = [BrickSpec(level, ((i - (whole - 1) / 2) * pitch, 0.0, z)) for i in range(whole)]
        ends = [BrickSpec(level, (x, 0.0, z), size=half_plank) for x in (-end, end)]
        specs += row if level % 2 else [ends[0], *row, ends[1]]
    return tuple(specs)
