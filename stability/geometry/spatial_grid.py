"""Broad phase: a spatial grid that finds the bodies near a body in a time that does not depend on their number.

It compares axis-aligned bounding boxes, before any exact distance.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from math import floor, log
from typing import Generic, TypeAlias, TypeVar

from stability.model import BodyId, Vec3

Key = TypeVar("Key", BodyId, int)  # name of a body; results are sorted by it
Bounds: TypeAlias = tuple[Vec3, Vec3]  # lowest and highest corner of a bounding box, in W [m]
Cell: TypeAlias = tuple[int, int, int]
Scale: TypeAlias = tuple[int, int]  # powers of COARSER for the sides in plan and for the height of a cell

COARSER = 4.0  # ratio of cell sizes between grids; a body is stored in the grid of its size
# Cells are slightly larger than the body that they are made for, so that bodies at round coordinates do not reach into
# another cell by rounding.
ROOM = 1.07
LEVELS = 2.0  # height of a cell in heights of a body: planks are flat


@dataclass(slots=True)
class Neighbours(Generic[Key]):
    """Spatial index of bounding boxes by name."""

    _bounds: dict[Key, Bounds] = field(default_factory=dict)
    _grids: dict[Scale, "_Grid[Key]"] = field(default_factory=dict)
    _unit: Vec3 | None = None  # size of a cell for bodies like the first [m]

    def __contains__(self, name: Key) -> bool:
        """Check that a body is in the index."""
        return name in self._bounds

    def __len__(self) -> int:
        """Return the number of bodies."""
        return len(self._bounds)

    def add(self, name: Key, low_W: Vec3, high_W: Vec3) -> None:
        """Add a body with a new name."""
        bounds = self._bounds[name] = (low_W, high_W)
        self._grid_of(bounds).add(name, bounds)

    def remove(self, name: Key) -> None:
        """Remove a body."""
        self.discard(name, *self._bounds[name])

    def discard(self, name: Key, low_W: Vec3, high_W: Vec3) -> None:
        """Remove a body with these bounds, even if it is not in the index or only partly."""
        bounds = (low_W, high_W)
        self._grid_of(bounds).discard(name, bounds)
        self._bounds.pop(name, None)

    def neighbours(self, name: Key, reach: float) -> list[Key]:
        """Return the other bodies whose boxes are within a distance [m] of that of a body, sorted."""
        names = self.around(*self._bounds[name], reach)
        names.remove(name)
        return names

    def around(self, low_W: Vec3, high_W: Vec3, reach: float) -> list[Key]:
        """Return the bodies whose boxes are within a distance [m] of a box, sorted."""
        (ax, ay, az), (bx, by, bz) = low_W, high_W
        low, high = (ax - reach, ay - reach, az - reach), (bx + reach, by + reach, bz + reach)
        names = [name for grid in self._grids.values() for name in grid.within(low, high)]
        names.sort()
        return names

    def _grid_of(self, bounds: Bounds) -> "_Grid[Key]":
        """Return the grid for bodies of this size."""
        (ax, ay, az), (bx, by, bz) = bounds
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
class _Grid(Generic[Key]):
    wide: float  # sides of a cell in plan [m]
    high: float  # height of a cell [m]
    _cells: dict[Cell, dict[Key, Bounds]] = field(default_factory=dict)
    _all: dict[Key, Bounds] = field(default_factory=dict)

    def add(self, name: Key, bounds: Bounds) -> None:
        self._all[name] = bounds
        for cell in self._covered(*bounds):
            self._cells.setdefault(cell, {})[name] = bounds

    def discard(self, name: Key, bounds: Bounds) -> None:
        self._all.pop(name, None)
        for cell in self._covered(*bounds):
            bodies = self._cells.get(cell, {})
            bodies.pop(name, None)
            if not bodies:
                self._cells.pop(cell, None)

    def within(self, low: Vec3, high: Vec3) -> Iterator[Key]:
        """Yield the bodies whose boxes overlap a box, in no order."""
        (ax, ay, az), (bx, by, bz) = low, high
        for name, ((cx, cy, cz), (dx, dy, dz)) in self._candidates(low, high).items():
            if cz <= bz and az <= dz and cx <= bx and ax <= dx and cy <= by and ay <= dy:
                yield name

    def _candidates(self, low: Vec3, high: Vec3) -> dict[Key, Bounds]:
        wide, tall = self.wide, self.high
        # A box that covers more cells than there are bodies is compared with all of them.
        cells = (high[0] - low[0] + wide) * (high[1] - low[1] + wide) * (high[2] - low[2] + tall)
        if cells > len(self._all) * wide * wide * tall:
            return self._all
        candidates: dict[Key, Bounds] = {}
        for cell in self._covered(low, high):
            candidates |= self._cells.get(cell, {})
        return candidates

    def _covered(self, low: Vec3, high: Vec3) -> Iterator[Cell]:
        wide, tall = self.wide, self.high
        return product(
            range(floor(low[0] / wide), floor(high[0] / wide) + 1),
            range(floor(low[1] / wide), floor(high[1] / wide) + 1),
            range(floor(low[2] / tall), floor(high[2] / tall) + 1),
        )
