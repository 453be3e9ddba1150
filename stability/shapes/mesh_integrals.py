"""Volume, centre and second moments of a solid by its surface: closed forms of the tetrahedra under its triangles.

The divergence theorem makes an integral over a solid one over its surface. With flat faces it is a sum over triangles,
each with the apex in a point of one's choice; signs take care of apexes outside.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stability.model import Vec3

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MeshIntegrals:
    """Integrals over a homogeneous solid."""

    volume: float  # [m3]; negative if its faces look inwards
    centre: Vec3  # of its volume [m]
    second: Array  # of x x^T about the centre, (3, 3) [m5]

    @property
    def inertia(self) -> Array:
        """About the centre, at a density of 1, (3, 3) [m5]."""
        tensor: Array = np.trace(self.second) * np.eye(3) - self.second
        return tensor


def integrals(corners: Sequence[Vec3], loops: Iterable[Sequence[int]]) -> MeshIntegrals:
    """Of the solid that these flat faces bound, each its corners counter-clockwise seen from outside."""
    points = np.array(corners)
    apex = points.mean(axis=0)  # far from the origin, the products would lose the volume
    fans = [(loop[0], one, other) for loop in loops for one, other in pairwise(loop[1:])]
    a, b, c = (points[[fan[n] for fan in fans]] - apex for n in range(3))
    parts = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = a + b + c
    volume = float(parts.sum())
    first = np.einsum("i,ij->j", parts, total) / 4.0
    second = sum(np.einsum("i,ij,ik->jk", parts, v, v) for v in (a, b, c, total)) / 20.0
    centre = first / volume if volume else np.zeros(3)
    x, y, z = (float(part) for part in apex + centre)
    return MeshIntegrals(volume, (x, y, z), second - volume * np.outer(centre, centre))
