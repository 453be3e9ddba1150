"""The round, hollow tower of rings of planks."""

from math import cos, pi, sin, tan
from typing import Annotated

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, MortaredParams, Specs, height, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_BRICKS, Levels, ShareOfLimit


class TowerParams(MortaredParams):
    """A round, hollow tower of rings of planks."""

    levels: Levels = Field(description="number of rings")
    bricks: Annotated[int, Field(strict=True, ge=3, le=MAX_BRICKS)] = Field(description="number of planks in a ring")
    overlap: ShareOfLimit = default("40 %", "fraction of the plank length that rests on each of the two planks below")

    @property
    def bricks_at_most(self) -> int:
        return self.levels * self.bricks


@layout("tower", TowerParams)
def tower(params: TowerParams, size: Vec3) -> Specs:
    """Rings of planks, each ring turned by half a pitch, so that every plank bridges two of the ring below.

    The planks are chords: the middle of each is at a distance R from the axis, with its length along the tangent. The
    first of level 1 lies towards +x, and even levels are turned by half a pitch, a = pi / n. Seen from above, two
    neighbours in successive rings are mirror images about the radius between them, so their centre lines cross on it,
    R tan(a / 2) from the middle of each. Forces through these points, each half of the load, balance every plank, up
    from below and down from above, for a tower of any height.
    """
    half_pitch, radius = pi / params.bricks, _ring_radius(params, size)
    specs = []
    for level in range(1, params.levels + 1):
        for number in range(params.bricks):
            bearing = (2 * number + (level % 2 == 0)) * half_pitch
            position = (radius * cos(bearing), radius * sin(bearing), height(level, size[2]))
            specs.append(BrickSpec(level, position, yaw=bearing + pi / 2))
    return tuple(specs)


def _ring_radius(params: TowerParams, size: Vec3) -> float:
    """Return the radius of the circle of the middles of the planks [m]. Raises InputError.

    The end face of a plank below cuts the centre line of a plank at (R sin a - L / 2) / cos a from its middle, and
    `overlap` of its length L is beyond. Neighbours of one ring, 2 a apart, do not touch as long as their inner corners
    stay on their side of the radius between them: L / 2 <= (R - w / 2) tan a.
    """
    (length, width, _), half_pitch = size, pi / params.bricks
    most = (1 / cos(half_pitch) - width / length * tan(half_pitch)) / 2
    if not 0 < params.overlap < most:
        problem = "misses the planks below" if params.overlap <= 0 else "overlaps its neighbours in the ring"
        message = (
            f"with {params.bricks} planks per ring and an overlap of {100 * params.overlap:.4g} %, each plank {problem}"
        )
        raise InputError("SD104", message, f"write an overlap greater than 0 % and less than {100 * most:.3g} %")
    return (length / 2 + (0.5 - params.overlap) * length * cos(half_pitch)) / sin(half_pitch)
