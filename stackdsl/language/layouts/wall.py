"""The wall: planks end to end in running bond, closed at both ends."""

from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import MistakeError
from stackdsl.language.value_types import MAX_BRICKS, Levels, NonNegativeLength
from stackdsl.wording import mm


class WallParams(LayoutParams):
    """Planks end to end, in running bond."""

    levels: Levels = Field(description="how many levels")
    bricks: Annotated[int, Field(strict=True, ge=1, le=MAX_BRICKS)] = Field(description="planks of a full level")
    # Planks that touch end to end would carry loads between them that no builder means.
    gap: NonNegativeLength = default("0.2 mm", "between the ends of neighbours")

    @property
    def bricks_at_most(self) -> int:
        return self.levels * (self.bricks + 1)


@layout("wall", WallParams)
def wall(params: WallParams, size: Vec3) -> Specs:
    """Planks end to end along x in running bond, closed at both ends.

    Even levels are shifted by half a plank. Whole planks only would leave their ends hanging out past their centres, or
    else the level would be shorter than the one below and the wall a triangle; half planks close them instead. So all
    levels are equally long, and every plank lies on two others or wholly on one.
    """
    length, width, thickness = size
    if params.gap >= length:
        raise MistakeError("SD104", f"the gap is longer than a plank of {mm(length, 6)}", "write less, such as 0.2 mm")
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
