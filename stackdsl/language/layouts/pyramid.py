"""The pyramid: rows of planks end to end, each one plank shorter than the row below."""

from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import Levels, NonNegativeLength
from stackdsl.wording import mm


class PyramidParams(LayoutParams):
    """Rows of planks, each one plank shorter than the row below."""

    levels: Levels = Field(description="number of rows, and of planks in the lowest row")
    gap: NonNegativeLength = default("0.2 mm", "gap between the ends of neighbours")

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
    if params.gap >= length:
        hint = "write a shorter gap, such as 0.2 mm"
        raise InputError("SD104", f"the gap must be shorter than a plank of {mm(length, 6)}", hint)
    pitch = length + params.gap
    specs = []
    for level in range(1, params.levels + 1):
        count = params.levels + 1 - level
        specs += [
            BrickSpec(level, ((number - (count - 1) / 2) * pitch, 0.0, height(level, thickness)))
            for number in range(count)
        ]
    return tuple(specs)
