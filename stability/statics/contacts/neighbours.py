"""Which bricks are near a brick? A grid of cells in space, so that asking costs the same however many bricks stand."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from math import floor, log
from typing import TypeAlias

from stability.geometry.touching import TOUCHING, reach_between
from stability.model import BodyId, Vec3
from stability.statics.contacts.solids import Solid

Cell: TypeAlias = tuple[int, int, int]
Scale: TypeAlias = tuple[int, int]  # powers of COARSER for the sides in plan and for the height of a cell

COARSER = 4.0  # bricks that are this many times larger than the first live in a grid of larger cells
# Cells are a bit larger than the brick that they are made for, so that a brick in a tidy scene, whose borders lie on
# round numbers, does not reach into one more cell by rounding.
ROOM = 1.07
LEVELS = 2.0  # height of a cell in bricks: planks are flat


@dataclass(slots=True)
class Neighbours:
    """The bricks that stand about, by where they are."""

    gap: float = TOUCHING  # bodies that are this far apart are near; share of the smallest side
    _solids: dict[BodyId, Solid] = field(default_factory=dict)
    _grids: dict[Scale, "_Grid"] = field(default_factory=dict)
    _unit: Vec3 | None = None  # size of a cell for bricks like the first [m]

    def add(self, solid: Solid) -> None:
        """Take in a brick; its name must be new."""
        self._solids[solid.id] = solid
        self._grid_of(solid).add(solid)

    def remove(self, brick: BodyId) -> None:
        """Forget a brick."""
        solid = self._solids.pop(brick)
        self._grid_of(solid).remove(solid)

    def near(self, solid: Solid) -> list[BodyId]:
        """The other bricks whose upright boxes are within the gap tolerance of that of this one, by name."""
        return self.around(solid, reach_between(solid.shortest, share=self.gap))

    def around(self, solid: Solid, reach: float) -> list[BodyId]:
        """The other bricks whose upright boxes come as close as this to that of this one [m], by name."""
        (ax, ay, az), (bx, by, bz) = solid.low_W, solid.high_W
        low, high = (ax - reach, ay - reach, az - reach), (bx + reach, by + reach, bz + reach)
        found = [name for grid in self._grids.values() for name in grid.within(low, high)]
        found.sort()
        if solid.id in self._solids and solid.id in found:
            found.remove(solid.id)
        return found

    def _grid_of(self, solid: Solid) -> "_Grid":
        """The grid for bricks of its extents, or a new one."""
        (ax, ay, az), (bx, by, bz) = solid.low_W, solid.high_W
        across, height = max(bx - ax, by - ay), bz - az
        if self._unit is None:
            self._unit = (ROOM * across, ROOM * across, ROOM * LEVELS * height)
        wide, _, high = self._unit
        scale = (round(log(ROOM * across / wide, COARSER)), round(log(ROOM * LEVELS * height / high, COARSER)))
        grid = self._grids.get(scale)
        if grid is None:
            grid = self._grids[scale] = _Grid(wide * COARSER ** scale[0], high * COARSER ** scale[1])
        return grid


@dataclass(slots=True)
class _Grid:
    wide: float  # sides of a cell in plan [m]
    high: float  # height of a cell [m]
    _cells: dict[Cell, dict[BodyId, Solid]] = field(default_factory=dict)
    _all: dict[BodyId, Solid] = field(default_factory=dict)

    def add(self, solid: Solid) -> None:
        self._all[solid.id] = solid
        for cell in self._covered(solid.low_W, solid.high_W):
            self._cells.setdefault(cell, {})[solid.id] = solid

    def remove(self, solid: Solid) -> None:
        del self._all[solid.id]
        for cell in self._covered(solid.low_W, solid.high_W):
            bricks = self._cells[cell]
            del bricks[solid.id]
            if not bricks:
                del self._cells[cell]

    def within(self, low: Vec3, high: Vec3) -> Iterator[BodyId]:
        """The bricks whose upright boxes overlap this one, in no order."""
        (ax, ay, az), (bx, by, bz) = low, high
        for solid in self._candidates(low, high).values():
            (cx, cy, cz), (dx, dy, dz) = solid.low_W, solid.high_W
            if cz <= bz and az <= dz and cx <= bx and ax <= dx and cy <= by and ay <= dy:
                yield solid.id

    def _candidates(self, low: Vec3, high: Vec3) -> dict[BodyId, Solid]:
        wide, tall = self.wide, self.high
        # A box that is much larger than the bricks here covers more cells than there are bricks to look at.
        cells = (high[0] - low[0] + wide) * (high[1] - low[1] + wide) * (high[2] - low[2] + tall)
        if cells > len(self._all) * wide * wide * tall:
            return self._all
        found: dict[BodyId, Solid] = {}
        for cell in self._covered(low, high):
            found |= self._cells.get(cell, {})
        return found

    def _covered(self, low: Vec3, high: Vec3) -> Iterator[Cell]:
        wide, tall = self.wide, self.high
        return product(
            range(floor(low[0] / wide), floor(high[0] / wide) + 1),
            range(floor(low[1] / wide), floor(high[1] / wide) + 1),
            range(floor(low[2] / tall), floor(high[2] / tall) + 1),
        )
