"""The structure of the published user test that leans until it falls (docs/design/publication.md)."""

from typing import Final

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.four_stack import crossed_pairs
from stackdsl.language.layouts.registry import LayoutParams, Specs, layout
from stackdsl.language.value_types import Levels, PositiveLength

# Shares of the length of a plank. By statics KAPLA planks then fall at level 9, like the slant tower by the method of
# the publication; a millimetre more or less of spacing, or a tenth of a millimetre of step, does not change that.
STEP: Final = 0.11
SPACING: Final = 2 / 3


class LeaningStructureParams(LayoutParams):
    """A four-stack that leans until it falls."""

    levels: Levels = Field(description="number of levels of two planks")
    step: PositiveLength | None = Field(
        None, description="shift of each level along x, relative to the one below; default: 11 % of the length"
    )
    spacing: PositiveLength | None = Field(
        None, description="distance between the centres of the two planks; default: two thirds of the length"
    )

    @property
    def bricks_at_most(self) -> int:
        return 2 * self.levels


@layout("leaning_structure", LeaningStructureParams)
def leaning_structure(params: LeaningStructureParams, size: Vec3) -> Specs:
    """A four-stack whose levels are all shifted the same way, to be built until it falls.

    With a step d and a spacing s of the planks of a level, the leading plank of level 2 and levels 3 to N tip over the
    end of level 1 when their common centre is beyond it:
    ((d + s / 2) / 2 + (N (N - 1) / 2 - 1) d) / (N - 3 / 2) > L / 2. With the first plank of level N alone it is
    ((d + s / 2) / 2 + ((N - 1) (N - 2) / 2 - 1 + (N - 1) / 2) d) / (N - 2).
    """
    step = STEP * size[0] if params.step is None else params.step
    return crossed_pairs(params.levels, step, SPACING * size[0] if params.spacing is None else params.spacing, size)
