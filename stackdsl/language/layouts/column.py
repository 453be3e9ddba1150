"""The column: one flat plank on each level."""

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.value_types import Length, Levels


class ColumnParams(MortaredParams):
    """One plank on each level."""

    levels: Levels = Field(description="number of planks")
    step: Length = default("0 mm", "shift of each plank along its length, relative to the one below")

    @property
    def bricks_at_most(self) -> int:
        return self.levels


@layout("column", ColumnParams)
def column(params: ColumnParams, size: Vec3) -> Specs:
    """One flat plank on each level, each shifted by the same step along its length."""
    return tuple(
        BrickSpec(level, ((level - 1) * params.step, 0.0, height(level, size[2])))
        for level in range(1, params.levels + 1)
    )
