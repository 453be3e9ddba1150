"""Bounding boxes of all bricks of a world, for engines without a neighbour query."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from stability.geometry.rows import Array
from stability.geometry.spatial_grid import Neighbours
from stability.model import BodyId, Plane


@dataclass(slots=True, eq=False)
class BoundingBoxes:
    """Axis-aligned bounding boxes by rows. The first neighbour query builds the grid, which most steps do not need."""

    rows: dict[BodyId, int]
    centres_W: Array  # (n, 3) [m]
    reaches: Array  # (n, 3) half lengths along the axes of W [m]
    _neighbours: Neighbours[BodyId] | None = field(default=None, init=False)

    @classmethod
    def around(cls, names: Iterable[BodyId], centres_W: Array, axes_W: Array, halves: Array) -> Self:
        """Create from centres (n, 3), body axes as columns (n, 3, 3), and half lengths along these (n, 3)."""
        reaches = np.einsum("nij,nj->ni", np.abs(axes_W), halves)
        return cls({name: row for row, name in enumerate(names)}, centres_W, reaches)

    def neighbours(self, brick: BodyId, within: float) -> list[BodyId]:
        """Return the other bricks whose boxes are within a distance [m], sorted by name."""
        if self._neighbours is None:
            self._neighbours = self._grid()
        return self._neighbours.neighbours(brick, within)

    def _grid(self) -> Neighbours[BodyId]:
        grid: Neighbours[BodyId] = Neighbours()
        lows, highs = (self.centres_W - self.reaches).tolist(), (self.centres_W + self.reaches).tolist()
        for name, low, high in zip(self.rows, lows, highs, strict=True):
            grid.add(name, tuple(low), tuple(high))
        return grid

    def reaches_plane(self, brick: BodyId, plane: Plane, within: float) -> bool:
        """Check that the box of a brick is within a distance [m] of a half-space."""
        own, normal = self.rows[brick], np.array(plane.normal_W)
        height = (self.centres_W[own] - np.array(plane.point_W)) @ normal - self.reaches[own] @ np.abs(normal)
        return bool(height <= within)
