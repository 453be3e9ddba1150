"""The harmonic stack, which leans out furthest."""

from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.value_types import Levels, ShareOfLimit


class HarmonicParams(LayoutParams):
    """The stack that leans out furthest, one plank a level."""

    bricks: Levels = Field(description="how many planks")
    share: ShareOfLimit = default(1.0, "of the overhang at which the stack is on the point of tipping")

    count: ClassVar[str] = "bricks"

    @property
    def bricks_at_most(self) -> int:
        return self.bricks


@layout("harmonic", HarmonicParams)
def harmonic(params: HarmonicParams, size: Vec3) -> Specs:
    """The overhanging stack: from the top, each plank leans out by 1/2, 1/4, 1/6 ... of a length, towards +x.

    The n planks above any joint then have their common centre just over the edge of the plank below, times `share`.
    """
    x, specs = 0.0, []
    for level, overhang in enumerate((*overhangs(params.bricks, size[0], params.share), 0.0), start=1):
        specs.append(BrickSpec(level, (x, 0.0, height(level, size[2]))))
        x += overhang
    return tuple(specs)


def overhangs(bricks: int, length: float, share: float) -> tuple[float, ...]:
    """How far each of so many planks is beyond the one below, from the lowest joint up [m]."""
    return tuple(share * length / (2 * above) for above in range(bricks - 1, 0, -1))
