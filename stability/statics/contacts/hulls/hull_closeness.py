"""Along which directions are two hulls apart, or least deep in each other, and how far off their places may they be?"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from stability.geometry.polyhedra import Array, EdgePairs, Hull, between, edge_pairs, face_gaps, vector
from stability.geometry.rows import cross_rows
from stability.model import Vec3
from stability.statics.contacts.axes import NEARLY_PARALLEL, NOISE_RATIO, NOISY_TILT

ALIKE = 0.5  # cosine above which two directions are worth a closer look

# Two faces that look at each other: number of that of a and of b, and sine of the angle between them.
FacePair: TypeAlias = tuple[int, int, float]


@dataclass(frozen=True, slots=True, eq=False)
class HullCloseness:
    """How two hulls stand to each other that touch or overlap."""

    a: Hull
    b: Hull
    p_AB: Array  # between their centres [m]
    gap: float  # the largest of all directions [m]
    gaps_a: Array  # by face of a [m]
    gaps_b: Array
    edges: EdgePairs
    facing: list[FacePair]  # nearly parallel

    def apart(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along each normal of a face, and of edges that cross [m], and that normal; as of boxes."""
        yield from self.faces()
        edges = self.edges
        sines = np.linalg.norm(cross_rows(self.a.ways[edges.of_a], self.b.ways[edges.of_b]), axis=1)
        cross = sines > NOISY_TILT
        yield from zip(edges.gaps[cross].tolist(), map(vector, edges.normals_AB[cross]), strict=True)

    def faces(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along the normal of each face of both [m], and that normal from a to b."""
        yield from zip(self.gaps_a.tolist(), map(vector, self.a.normals), strict=True)
        yield from zip(self.gaps_b.tolist(), map(vector, -self.b.normals), strict=True)

    def gap_along(self, normal_AB: Array) -> float:
        """The gap along a unit direction that leads from a to b [m]."""
        between_both = self.b.heights(normal_AB).min() - self.a.heights(normal_AB).max()
        return float(self.p_AB @ normal_AB + between_both)


def closeness(a: Hull, b: Hull, reach: float) -> HullCloseness | None:
    """How two hulls stand to each other; None if they are further than `reach` apart, or deeper in each other."""
    p_AB = between(a, b)
    gaps_a, gaps_b = face_gaps(a, b, p_AB), face_gaps(b, a, -p_AB)
    largest = max(float(gaps_a.max()), float(gaps_b.max()))
    if largest > reach:
        return None
    edges = edge_pairs(a, b, p_AB)
    largest = max(largest, float(edges.gaps.max(initial=-np.inf)))
    if largest > reach or largest < -reach:
        return None
    return HullCloseness(a, b, p_AB, largest, gaps_a, gaps_b, edges, _facing(a, b))


def _facing(a: Hull, b: Hull) -> list[FacePair]:
    cosines = a.normals @ b.normals.T
    pairs = np.argwhere(cosines < -ALIKE)
    if not len(pairs):
        return []
    sines = np.linalg.norm(cross_rows(a.normals[pairs[:, 0]], b.normals[pairs[:, 1]]), axis=1)
    close = sines <= NEARLY_PARALLEL
    return [(int(i), int(j), float(sine)) for (i, j), sine in zip(pairs[close], sines[close], strict=True)]


def disturbance(close: HullCloseness, reach: float) -> float:
    """How far the two may be from the places that were meant [m], at most `reach`: read off the pair itself.

    As of boxes (`stability.statics.contacts.axes.disturbance`), by the normals of faces in place of body axes.
    """
    a, b = close.a, close.b
    alike = [(int(i), int(j)) for i, j in np.argwhere(np.abs(a.normals @ b.normals.T) > ALIKE)]
    one, other = [i for i, _ in alike], [j for _, j in alike]
    sines = np.linalg.norm(cross_rows(a.normals[one], b.normals[other]), axis=1) if alike else np.zeros(0)
    common = [i for i, sine in zip(one, sines.tolist(), strict=True) if sine <= NOISY_TILT]
    if common:
        ways = a.normals[common]
        same_way = np.linalg.norm(cross_rows(ways, np.broadcast_to(ways[0], ways.shape)), axis=1) <= NOISY_TILT
        if same_way.all() and max(close.gap_along(ways[0]), close.gap_along(-ways[0])) < -reach:
            return reach
    gaps: list[float] = [abs(gap) for gap in (*close.gaps_a.tolist(), *close.gaps_b.tolist()) if abs(gap) <= reach]
    tilts: list[float] = [sine for sine in sines.tolist() if sine <= NOISY_TILT]
    longest = max(a.length, b.length)
    noise = min([abs(close.gap), *gaps]) + min(tilts, default=0.0) * longest
    return min(reach, NOISE_RATIO * noise)
