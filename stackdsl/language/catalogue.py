"""Bricks that scenarios know by name."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from stability.model import Vec3


@dataclass(frozen=True, slots=True)
class CatalogueBrick:
    """A brick that can be bought, or an idealised one."""

    size: Vec3  # length, width, thickness; lying flat [m]
    density: float  # [kg/m3]


PINE: Final = 557.0  # [kg/m3], of a KAPLA plank of nominal size and 11.9 g

CATALOGUE: Final[Mapping[str, CatalogueBrick]] = {
    "kapla": CatalogueBrick((0.1176, 0.0234, 0.0078), PINE),
    # Sides of exactly 1:3:15, the plank of the published method. Of the same wood, so the same density and not the same
    # mass: what a structure does does not depend on a density that all of its bricks share.
    "kapla-ideal": CatalogueBrick((0.120, 0.024, 0.008), PINE),
}
