r"""The corbelled opening: two stacks that lean towards each other, every plank further in than the one below.

   _________   _________        at most by 1 / 2, 1 / 4, 1 / 6 ... of a length, counted from the top: then the planks
 _________       _________      above any joint have their common centre over the end of the plank below
_________         _________
"""

from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.harmonic import overhangs
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.value_types import Levels, PositiveLength, ShareOfLimit


class CorbelParams(MortaredParams):
    """Two stacks that lean towards each other."""

    levels: Levels = Field(description="number of planks on each side")
    share: ShareOfLimit = default(1.0, "overhangs, as a fraction of the overhangs at which a side begins to tip")
    gap: PositiveLength | None = Field(
        None, description="gap between the two uppermost planks; default: the thickness of a plank"
    )

    count: ClassVar[str] = "levels"

    @property
    def bricks_at_most(self) -> int:
        return 2 * self.levels


@layout("corbel", CorbelParams)
def corbel(params: CorbelParams, size: Vec3) -> Specs:
    """Two stacks that lean towards each other by harmonic overhangs.

    With n planks on each side, the opening is 1 + 1 / 2 + ... + 1 / (n - 1) lengths wide at the limit of tipping,
    besides the gap at the top. The sides do not touch, so each stands by itself up to a share of 1. On each level the
    plank at -x comes first.
    """
    steps = overhangs(params.levels, size[0], params.share)
    half_gap = 0.5 * (size[2] if params.gap is None else params.gap)
    top = -half_gap - 0.5 * size[0]  # the middle of the uppermost plank at -x
    places = [top - sum(steps[level:]) for level in range(params.levels)]
    return tuple(
        BrickSpec(level, (side * x, 0.0, height(level, size[2])))
        for level, x in enumerate(places, start=1)
        for side in (1.0, -1.0)
    )
