"""A second shape, which the library does not know: any convex solid by its corners, worked out from these alone.

Faces are found by trying all planes through three corners; volume, centre of mass and inertia by the divergence
theorem, which here is a sum over the tetrahedra between a point and the triangles of the surface.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from stability.geometry.box import Box
from stability.geometry.vectors import add, cross, dot, norm, scale, subtract, unit
from stability.model import ConvexShape, Face, Quaternion, Vec3
from tests.turn_of_axes import orientation_of

Array = NDArray[np.float64]
FLUSH = 1e-9  # of the largest coordinate: nearer to a plane is in it


@dataclass(frozen=True)
class Polyhedron:
    """A convex solid."""

    corners: tuple[Vec3, ...]
    faces: tuple[Face, ...]
    edges: tuple[tuple[int, int], ...]
    volume: float
    inertia: tuple[Vec3, Vec3, Vec3]  # about the centre of mass, of a density of 1 [m5]

    @property
    def least_thickness(self) -> float:
        sides = [subtract(self.corners[b], self.corners[a]) for a, b in self.edges]
        across = [cross(one, other) for one, other in combinations(sides, 2)]
        normals = [*(face.normal for face in self.faces), *(unit(way) for way in across if norm(way) > 1e-12)]
        return min(self.reach(normal) + self.reach(scale(-1.0, normal)) for normal in normals)

    @property
    def length(self) -> float:
        axes: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        return max(self.reach(axis) + self.reach(scale(-1.0, axis)) for axis in axes)

    @property
    def bounding_radius(self) -> float:
        return max(map(norm, self.corners))

    @property
    def principal_axes(self) -> Quaternion:
        axes = np.linalg.eigh(np.array(self.inertia))[1]
        axes[:, 2] *= np.linalg.det(axes)
        return orientation_of(axes)

    def moments(self, mass: float) -> Vec3:
        a, b, c = (mass / self.volume * float(moment) for moment in np.linalg.eigvalsh(np.array(self.inertia)))
        return (a, b, c)

    def reach(self, direction: Vec3) -> float:
        return dot(self.support(direction), direction)

    def support(self, direction: Vec3) -> Vec3:
        return max(self.corners, key=lambda corner: dot(corner, direction))


def polyhedron(points: Iterable[Vec3]) -> Polyhedron:
    """The solid with these corners, each of them one of its hull, wherever they are: it is centred on its mass."""
    corners = tuple(points)
    faces = tuple(_faces(corners))
    volume, centre, _ = integrals(corners, faces)
    centred = tuple(subtract(corner, centre) for corner in corners)
    edges = {(min(pair), max(pair)) for face in faces for pair in around(face)}
    second = integrals(centred, faces)[2]
    tensor = np.trace(second) * np.eye(3) - second
    x, y, z = ((float(a), float(b), float(c)) for a, b, c in tensor)
    return Polyhedron(centred, faces, tuple(sorted(edges)), volume, (x, y, z))


def around(face: Face) -> Iterator[tuple[int, int]]:
    """The edges of a face, from corner to corner, as it lists them."""
    return pairwise((*face.corners, face.corners[0]))


def integrals(corners: Sequence[Vec3], faces: Iterable[Face]) -> tuple[float, Vec3, Array]:
    """Of a solid by its surface: volume, centre of mass, and the integral of x x^T (3, 3) [m3, m, m5]."""
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for face in faces:
        a = np.array(corners[face.corners[0]])
        for i, j in pairwise(face.corners[1:]):
            b, c = np.array(corners[i]), np.array(corners[j])
            part, total = float(np.dot(a, np.cross(b, c))) / 6.0, a + b + c
            volume += part
            first += part * total / 4.0
            second += part / 20.0 * (sum(np.outer(v, v) for v in (a, b, c)) + np.outer(total, total))
    x, y, z = (float(part) for part in first / volume)
    return volume, (x, y, z), second


def _faces(corners: Sequence[Vec3]) -> Iterator[Face]:
    noise, known = FLUSH * max(abs(part) for corner in corners for part in corner), set()
    for three in combinations(range(len(corners)), 3):
        a, b, c = (corners[number] for number in three)
        across = cross(subtract(b, a), subtract(c, a))
        for normal in (unit(across), scale(-1.0, unit(across))) if norm(across) > 0.0 else ():
            heights = [dot(subtract(corner, a), normal) for corner in corners]
            within = tuple(number for number, height in enumerate(heights) if abs(height) <= noise)
            if max(heights) <= noise and within not in known:
                known.add(within)
                yield Face(normal, _in_order(corners, within, normal))


def _in_order(corners: Sequence[Vec3], within: Sequence[int], normal: Vec3) -> tuple[int, ...]:
    """Counter-clockwise seen from outside, about their mean."""
    middle = scale(1.0 / len(within), _sum(corners[number] for number in within))
    first = unit(subtract(corners[within[0]], middle))
    second = cross(normal, first)
    arms = {number: subtract(corners[number], middle) for number in within}
    return tuple(
        sorted(within, key=lambda n: float(np.arctan2(dot(arms[n], second), dot(arms[n], first))) % (2 * np.pi))
    )


def _sum(vectors: Iterable[Vec3]) -> Vec3:
    total = (0.0, 0.0, 0.0)
    for vector in vectors:
        total = add(total, vector)
    return total


SIZE: Vec3 = (0.12, 0.024, 0.008)  # of a plank [m]
PLANK = Box(SIZE)
# A plank cut along the diagonal of its side, from its lower edge at +x to its upper one at -x.
LOWER_HALF = polyhedron(corner for corner in PLANK.corners if corner[2] < 0.0 or corner[0] < 0.0)
UPPER_HALF = polyhedron(corner for corner in PLANK.corners if corner[2] > 0.0 or corner[0] > 0.0)
TETRAHEDRON = polyhedron([(0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.01, 0.04, 0.0), (0.02, 0.01, 0.03)])
SAME_PLANK = polyhedron(PLANK.corners)  # given by its corners
SHAPES: dict[str, ConvexShape] = {
    "box": PLANK,
    "box by corners": SAME_PLANK,
    "wedge": LOWER_HALF,
    "tetrahedron": TETRAHEDRON,
}
