"""LEGO bricks and plates: sizes in studs and plates, masses, and the numbers of their LDraw parts.

Lengths are nominal: a real brick is 0.2 mm shorter and narrower than its studs times the pitch, so that it fits between
its neighbours.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from stability.model import Vec3

PITCH: Final = Fraction(8, 1000)  # [m] from stud to stud
PLATE: Final = Fraction(32, 10_000)  # [m] of height
PLATES: Final = 3  # in the height of a brick


@dataclass(frozen=True, slots=True)
class LegoPart:
    """A brick, a plate, or a tile, which is a plate without studs on top."""

    studs: tuple[int, int]  # length and width
    plates: int  # of height
    mass: Fraction  # [kg]
    ldraw: tuple[str, ...]  # its numbers without `.dat`; the first one is written
    smooth: bool = False  # whether it has no studs on top

    @property
    def exact_size(self) -> tuple[Fraction, Fraction, Fraction]:
        """Return length, width and height [m]."""
        return self.studs[0] * PITCH, self.studs[1] * PITCH, self.plates * PLATE

    @property
    def size(self) -> Vec3:
        """Return length, width and height [m]."""
        length, width, height = map(float, self.exact_size)
        return length, width, height


# Masses of bricks [g] from the library of StableLego (Liu et al., 2024); those of 1x3, 2x3, of plates and of tiles as
# weighed for BrickMesh (Dornbach, 2016). A plate of 1x2 is interpolated between 1x1 and 1x3, since the weighed one is
# of another mould, and a brick of 2x8 extrapolated from 2x4 and 2x6.
_BRICKS: Final = (
    ((1, 1), 0.43, ("3005",)),
    ((2, 1), 0.81, ("3004",)),
    ((3, 1), 1.20, ("3622",)),
    ((4, 1), 1.57, ("3010",)),
    ((6, 1), 2.28, ("3009",)),
    ((8, 1), 3.03, ("3008",)),
    ((2, 2), 1.15, ("3003",)),
    ((3, 2), 1.71, ("3002",)),
    ((4, 2), 2.16, ("3001",)),
    ((6, 2), 3.23, ("2456", "44237")),
    ((8, 2), 4.30, ("3007",)),
)
_PLATES: Final = (
    ((1, 1), 0.22, ("3024",)),
    ((2, 1), 0.36, ("3023", "3023b")),
    ((3, 1), 0.50, ("3623",)),
    ((4, 1), 0.65, ("3710",)),
    ((6, 1), 0.99, ("3666",)),
    ((8, 1), 1.30, ("3460",)),
    ((2, 2), 0.60, ("3022",)),
    ((3, 2), 0.895, ("3021",)),
    ((4, 2), 1.15, ("3020",)),
    ((6, 2), 1.715, ("3795",)),
    ((8, 2), 2.235, ("3034",)),
    ((4, 4), 2.24, ("3031",)),
    ((6, 4), 3.28, ("3032",)),
    ((8, 4), 4.27, ("3035",)),
)
_TILES: Final = (
    ((1, 1), 0.144, ("3070b", "3070a", "3070")),
    ((2, 1), 0.25, ("3069b", "3069a", "3069")),
    ((3, 1), 0.405, ("63864",)),
    ((4, 1), 0.535, ("2431",)),
    ((6, 1), 0.775, ("6636",)),
    ((8, 1), 1.05, ("4162",)),
    ((2, 2), 0.49, ("3068b", "3068a", "3068")),
    ((4, 2), 0.93, ("87079",)),
)

# By name; the smaller number of studs comes first in a name, as in shops.
LEGO: Final[Mapping[str, LegoPart]] = {
    f"{prefix}{width}x{length}": LegoPart((length, width), plates, Fraction(repr(grams)) / 1000, ldraw, parts is _TILES)
    for prefix, plates, parts in (("lego_", PLATES, _BRICKS), ("lego_plate_", 1, _PLATES), ("lego_tile_", 1, _TILES))
    for (length, width), grams, ldraw in parts
}

_SIZE: Final = re.compile(
    r"(?:lego)?[-_ ]?(?:brick)?(?P<form>plate|tile)?[-_ ]?(?P<one>\d{1,2})\s?x\s?(?P<other>\d{1,2})", re.IGNORECASE
)


def meant_lego(text: str) -> str:
    """Return the remedy for another spelling of a brick, such as `2x4` or `lego plate 4x2`; empty for other texts."""
    match = _SIZE.fullmatch(text.strip())
    if match is None:
        return ""
    prefix = f"lego_{match['form'].lower()}_" if match["form"] else "lego_"
    one, other = sorted((int(match["one"]), int(match["other"])))
    if f"{prefix}{one}x{other}" in LEGO:
        return f"did you mean '{prefix}{one}x{other}'?"
    return f"choose from: {', '.join(name for name in LEGO if re.fullmatch(rf'{prefix}[0-9x]+', name))}"
