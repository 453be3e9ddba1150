"""The upright boxes around all bricks of a world as they are now, for engines that cannot be asked who is near whom."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from stability.geometry.rows import Array
from stability.geometry.spatial_grid import Neighbours
from stability.model import BodyId, Plane


@dataclass(slots=True, eq=False)
class BoundingBoxes:
    """Bricks by rows. Where nobody asks for neighbours, as in most steps, none are sorted into cells."""

    rows: dict[BodyId, int]
    centres_W: Array  # (n, 3) [m]
    reaches: Array  # (n, 3) half lengths along the axes of W [m]
    _neighbours: Neighbours[BodyId] | None = field(default=None, init=False)

    @classmethod
    def around(cls, names: Iterable[BodyId], centres_W: Array, axes_W: Array, halves: Array) -> Self:
        """From the centres (n, 3), the body axes as columns (n, 3, 3) and the half lengths along these (n, 3)."""
        reaches = np.einsum("nij,nj->ni", np.abs(axes_W), halves)
        return cls({name: row for row, name in enumerate(names)}, centres_W, reaches)

    def neighbours(self, brick: BodyId, within: float) -> list[BodyId]:
        """The other bricks whose boxes come as close as this [m], by name."""
        if self._neighbours is None:
            self._neighbours = self._sorted_into_cells()
        return self._neighbours.neighbours(brick, within)

    def _sorted_into_cells(self) -> Neighbours[BodyId]:
        found: Neighbours[BodyId] = Neighbours()
        lows, highs = (self.centres_W - self.reaches).tolist(), (self.centres_W + self.reaches).tolist()
        for name, low, high in zip(self.rows, lows, highs, strict=True):
            found.add(name, tuple(low), tuple(high))
        return found

    def reaches_plane(self, brick: BodyId, plane: Plane, within: float) -> bool:
        """Whether the box around a brick comes as close to a half-space as this [m]."""
        own, normal = self.rows[brick], np.array(plane.normal_W)
        height = (self.centres_W[own] - np.array(plane.point_W)) @ normal - self.reaches[own] @ np.abs(normal)
        return bool(height <= within)
