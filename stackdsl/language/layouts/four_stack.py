"""The four-stack: two parallel planks on each level, turned by 90 deg from level to level."""

from math import pi

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.value_types import Length, Levels, PositiveLength


class FourStackParams(MortaredParams):
    """Two parallel planks on each level, turned by 90 deg from level to level."""

    levels: Levels = Field(description="number of levels of two planks")
    step: Length = default("0 mm", "shift of each level along x, relative to the one below")
    spacing: PositiveLength | None = Field(
        None,
        description="distance between the centres of the two planks; default: length - width, with flush ends",
    )

    @property
    def bricks_at_most(self) -> int:
        return 2 * self.levels


@layout("four_stack", FourStackParams)
def four_stack(params: FourStackParams, size: Vec3) -> Specs:
    """Two parallel planks on each level, turned by 90 deg from level to level.

    Odd levels run along x and even ones along y; on each, the plank on the negative side comes first.
    """
    spacing = size[0] - size[1] if params.spacing is None else params.spacing
    return crossed_pairs(params.levels, params.step, spacing, size)


def crossed_pairs(levels: int, step: float, spacing: float, size: Vec3) -> Specs:
    """Return the bricks of a four-stack."""
    half, specs = spacing / 2, []
    for level in range(1, levels + 1):
        middle, z = (level - 1) * step, height(level, size[2])
        for side in (-half, half):
            along_x = BrickSpec(level, (middle, side, z))
            along_y = BrickSpec(level, (middle + side, 0.0, z), yaw=pi / 2)
            specs.append(along_x if level % 2 else along_y)
    return tuple(specs)
