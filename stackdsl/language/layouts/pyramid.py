"""The pyramid: rows of planks end to end, each one plank shorter than the row below."""

from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, RowParams, Specs, height, layout
from stackdsl.language.value_types import Levels


class PyramidParams(RowParams):
    """Rows of planks, each one plank shorter than the row below."""

    levels: Levels = Field(description="number of rows, and of planks in the lowest row")

    count: ClassVar[str] = "levels"

    @property
    def bricks_at_most(self) -> int:
        return self.levels * (self.levels + 1) // 2


@layout("pyramid", PyramidParams)
def pyramid(params: PyramidParams, size: Vec3) -> Specs:
    """Rows of planks end to end along x, each plank on the ends of two planks of the row below, up to a single one.

    The top plank gives half of its weight to each of the two planks below. Rows of three planks or more are statically
    indeterminate: symmetry alone does not determine how their contacts share the load.
    """
    length, _, thickness = size
    pitch = length + params.gap_of(length)
    specs = []
    for level in range(1, params.levels + 1):
        count = params.levels + 1 - level
        specs += [
            BrickSpec(level, ((number - (count - 1) / 2) * pitch, 0.0, height(level, thickness)))
            for number in range(count)
        ]
    return tuple(specs)
