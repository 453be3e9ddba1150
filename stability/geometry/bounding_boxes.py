"""The upright boxes around all bricks of a world, in arrays: who may be near whom, for engines that cannot be asked."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from stability.model import BodyId, Plane

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class BoundingBoxes:
    """Bricks by rows, in the order of `names`."""

    names: tuple[BodyId, ...]
    rows: dict[BodyId, int]
    centres_W: Array  # (n, 3) [m]
    reaches: Array  # (n, 3) half lengths along the axes of W [m]

    @classmethod
    def around(cls, names: Iterable[BodyId], centres_W: Array, axes_W: Array, halves: Array) -> Self:
        """From the centres (n, 3), the body axes as columns (n, 3, 3) and the half lengths along these (n, 3)."""
        names = tuple(names)
        reaches = np.einsum("nij,nj->ni", np.abs(axes_W), halves)
        return cls(names, {name: row for row, name in enumerate(names)}, centres_W, reaches)

    def near(self, brick: BodyId, within: float) -> list[BodyId]:
        """The other bricks whose boxes come as close as this [m]."""
        own = self.rows[brick]
        gaps = np.abs(self.centres_W - self.centres_W[own]) - self.reaches - self.reaches[own]
        return [self.names[row] for row in np.flatnonzero(gaps.max(axis=1) <= within) if row != own]

    def reaches_plane(self, brick: BodyId, plane: Plane, within: float) -> bool:
        """Whether the box around a brick comes as close to a half-space as this [m]."""
        own, normal = self.rows[brick], np.array(plane.normal_W)
        height = (self.centres_W[own] - np.array(plane.point_W)) @ normal - self.reaches[own] @ np.abs(normal)
        return bool(height <= within)
