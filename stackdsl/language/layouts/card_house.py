r"""The card house: planks lean on each other in pairs, and the next storey stands on flat planks on their peaks.

With planks of length L and thickness t at an angle a, the upper edges of the inner faces of a V meet above its middle,
at a height of L sin a, and their lower edges are L cos a to either side of it. The outer faces reach up to
L sin a + t cos a, at t sin a to either side, where the flat planks lie.

          ______________     ______________          two flat planks on the peaks of three Vs
         /\             /\            /\
        /  \           /  \          /  \
"""

from math import cos, degrees, sin, tan
from typing import Final

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import Levels, PositiveLength, Slope
from stackdsl.wording import mm

SHARE_OF_ROOM: Final = 0.25  # default place of the spacing in its range; nearer to the lower end

ROUNDING: Final = 1e-9  # share of a length, so that rounding leaves no room at exactly 60 deg


class CardHouseParams(LayoutParams):
    """A pyramid of leaning pairs of planks."""

    levels: Levels = Field(
        description="number of inverted Vs in the lowest storey; each storey has one V less than the storey below"
    )
    angle: Slope = default("70 deg", "angle between the leaning planks and the horizontal")
    spacing: PositiveLength | None = Field(
        None,
        description="distance between the centres of neighbouring Vs; default: at a quarter of its range",
    )

    @property
    def bricks_at_most(self) -> int:
        return self.levels * (self.levels + 1) + self.levels * (self.levels - 1) // 2


@layout("card_house", CardHouseParams)
def card_house(params: CardHouseParams, size: Vec3) -> Specs:
    """Inverted Vs of two planks; flat planks on neighbouring peaks carry the next storey, up to a single V.

    Odd levels have Vs, whose two planks are set down at the same time, and even levels flat planks. Each is built from
    -x to +x, and its middle is above the origin.
    """
    length, _, thickness = size
    _reject_fallen(params.angle, size)
    pitch = _pitch(params, size)
    c, s = cos(params.angle), sin(params.angle)
    out, up = (length * c + thickness * s) / 2, (length * s + thickness * c) / 2
    specs: list[BrickSpec] = []
    ground = 0.0
    for storey in range(params.levels):
        level, count = 2 * storey + 1, params.levels - storey
        for x in _row(count, pitch):
            specs.append(BrickSpec(level, (x - out, 0.0, ground + up), lean=-params.angle))
            specs.append(BrickSpec(level, (x + out, 0.0, ground + up), lean=params.angle, together=True))
        peak = ground + 2 * up
        specs += [BrickSpec(level + 1, (x, 0.0, peak + thickness / 2)) for x in _row(count - 1, pitch)]
        ground = peak + thickness
    return tuple(specs)


def _row(count: int, pitch: float) -> list[float]:
    """Return `count` positions with a pitch, centred on 0 [m]."""
    return [(number - (count - 1) / 2) * pitch for number in range(count)]


def _reject_fallen(angle: float, size: Vec3) -> None:
    """Raise InputError if the centre of a plank is beyond its foot, so that it falls outwards."""
    length, _, thickness = size
    if angle <= 0.0 or tan(angle) >= length / thickness:
        message = f"at {_deg(angle)} the planks do not lean on each other"
        raise InputError("SD104", message, "write, for example, 70 deg")


def _pitch(params: CardHouseParams, size: Vec3) -> float:
    """Return the distance from V to V [m]. Raises InputError.

    Feet and flat planks must not touch each other, and every flat plank must lie on two peaks. A V reaches
    L cos a + t sin a to either side, so Vs are apart at a pitch of twice that, and flat planks at L. A flat plank
    reaches the near edges of two peaks up to a pitch of L + 2 t sin a. Within these limits the Vs on it, whose feet are
    2 L cos a apart, stand on it with both feet.
    """
    (length, _, thickness), c, s = size, cos(params.angle), sin(params.angle)
    least, most = max(length, 2 * (length * c + thickness * s)), length + 2 * thickness * s
    if params.levels > 1 and least >= most * (1.0 - ROUNDING):
        message = f"at {_deg(params.angle)} the Vs are too wide for flat planks on their peaks"
        raise InputError("SD104", message, "write an angle greater than 60 deg")
    if params.spacing is None:
        return least + SHARE_OF_ROOM * (most - least)
    if params.levels > 1 and not least <= params.spacing < most:
        hint = f"write at least {mm(least)}, and less than {mm(most)}"
        problem = "overlap each other" if params.spacing < least else "are too far apart for flat planks on the peaks"
        raise InputError("SD104", f"at a spacing of {mm(params.spacing)}, the Vs {problem}", hint)
    return params.spacing


def _deg(angle: float) -> str:
    return f"{degrees(angle):.4g} deg"
