"""The harmonic stack, with the largest overhang of one plank on each level."""

from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.value_types import Levels, ShareOfLimit


class HarmonicParams(LayoutParams):
    """The stack of largest overhang, one plank on each level."""

    bricks: Levels = Field(description="number of planks")
    share: ShareOfLimit = default(1.0, "overhangs, as a fraction of the overhangs at which the stack begins to tip")

    count: ClassVar[str] = "bricks"

    @property
    def bricks_at_most(self) -> int:
        return self.bricks


@layout("harmonic", HarmonicParams)
def harmonic(params: HarmonicParams, size: Vec3) -> Specs:
    """The overhanging stack: from the top, planks overhang by 1/2, 1/4, 1/6 ... of a length, towards +x.

    With a `share` of 1, the planks above any joint have their common centre just over the edge of the plank below.
    """
    x, specs = 0.0, []
    for level, overhang in enumerate((*overhangs(params.bricks, size[0], params.share), 0.0), start=1):
        specs.append(BrickSpec(level, (x, 0.0, height(level, size[2]))))
        x += overhang
    return tuple(specs)


def overhangs(bricks: int, length: float, share: float) -> tuple[float, ...]:
    """Return the overhang at each joint, from the lowest one up [m]."""
    return tuple(share * length / (2 * above) for above in range(bricks - 1, 0, -1))
