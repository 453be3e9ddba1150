"""The wall: planks end to end in running bond, closed at both ends."""

from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, RowParams, Specs, height, layout
from stackdsl.language.value_types import MAX_BRICKS, Levels


class WallParams(RowParams):
    """Planks end to end, in running bond."""

    levels: Levels = Field(description="number of levels")
    bricks: Annotated[int, Field(strict=True, ge=1, le=MAX_BRICKS)] = Field(
        description="number of planks in a level without half planks"
    )

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
    gap = params.gap_of(length)
    pitch, half_plank = length + gap, ((length - gap) / 2, width, thickness)
    # from the middle of the wall to that of a half plank
    end = (params.bricks * pitch - gap - half_plank[0]) / 2
    specs = []
    for level in range(1, params.levels + 1):
        z, whole = height(level, thickness), params.bricks - (level % 2 == 0)
        row = [BrickSpec(level, ((i - (whole - 1) / 2) * pitch, 0.0, z)) for i in range(whole)]
        ends = [BrickSpec(level, (x, 0.0, z), size=half_plank) for x in (-end, end)]
        specs += row if level % 2 else [ends[0], *row, ends[1]]
    return tuple(specs)
