"""Along which directions are two boxes apart, or least deep in each other?

Bodies that touch do so along the separating axis of the largest gap.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import hypot

from stability.geometry.separating_axes import (
    Matrix,
    along_product,
    coordinates,
    cosines,
    edge_products,
    face_gaps,
    half_extent,
    transposed,
)
from stability.geometry.vectors import cross, dot, scale, subtract
from stability.model import Vec3
from stability.statics.contacts.solids import BoxSolid

# Sine of the angle up to which two faces can be meant to lie on each other: ten times what engines leave, and the
# steepest at which the gap tolerance, a fiftieth of the shortest side, can bridge a face.
NEARLY_PARALLEL = 0.02
# Sine of the angle up to which two axes can be off by noise alone: what engines leave to each of two bodies. Axes that
# are further from parallel were meant to be.
NOISY_TILT = 3e-3
# How many times more than the least of the gaps and tilts that a pair shows it may be off its place. Large, since that
# least may be small by chance; what is aligned to rounding stays so.
NOISE_RATIO = 30.0


@dataclass(frozen=True, slots=True)
class Axis:
    """A direction in which two boxes, a and b, may be apart."""

    gap: float  # [m], negative where they overlap
    normal_AB_W: Vec3  # unit, from a towards b
    of_a: int | None  # the axis of a that it is normal to the face of, or the edge of a in a product of edges
    of_b: int | None

    @property
    def is_face(self) -> bool:
        return self.of_a is None or self.of_b is None


@dataclass(frozen=True, slots=True)
class Closeness:
    """How two boxes stand to each other that touch or overlap."""

    gap: float  # the largest of all axes [m]
    faces_a: Sequence[Axis]  # by axis of a
    faces_b: Sequence[Axis]
    edges: Sequence[Axis]  # the products along which they are least deep in each other
    sines: Matrix  # of the angles between the axes of a (rows) and b

    def apart(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along each normal of a face, and of edges that cross [m], and that normal.

        Of edges that are parallel but for noise, noise gives the direction.
        """
        for axis in (*self.faces_a, *self.faces_b, *self.edges):
            if axis.of_a is None or axis.of_b is None or self.sines[axis.of_a][axis.of_b] > NOISY_TILT:
                yield axis.gap, axis.normal_AB_W

    def faces(self) -> Iterator[tuple[float, Vec3]]:
        """The gap along the normal of each face that looks at the other box [m], and that normal from a to b."""
        for axis in (*self.faces_a, *self.faces_b):
            yield axis.gap, axis.normal_AB_W


def closeness(a: BoxSolid, b: BoxSolid, reach: float) -> Closeness | None:
    """How two boxes stand to each other; None if they are further than `reach` apart, or deeper in each other."""
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    turn = cosines(a.axes, b.axes)
    along_a, along_b = coordinates(p_AB, a.axes), coordinates(p_AB, b.axes)
    gaps_a = face_gaps(along_a, a.half, b.half, turn)
    gaps_b = face_gaps(along_b, b.half, a.half, transposed(turn))
    largest = max(gaps_a + gaps_b)
    if largest > reach:
        return None
    products = []
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        products.append(((abs(along) - extent) / length, (1.0 if along >= 0.0 else -1.0) / length, i, j))
    largest = max([largest, *(gap for gap, _, _, _ in products)])
    if largest > reach or largest < -reach:
        return None
    edges = [
        Axis(gap, scale(share, cross(a.axes[i], b.axes[j])), i, j)
        for gap, share, i, j in products
        if gap >= largest - 2.0 * reach
    ]
    faces_a = [Axis(gaps_a[i], _towards(along_a[i], a.axes[i]), i, None) for i in range(3)]
    faces_b = [Axis(gaps_b[j], _towards(along_b[j], b.axes[j]), None, j) for j in range(3)]
    return Closeness(largest, faces_a, faces_b, edges, _sines(turn))


def _sines(turn: Matrix) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = turn
    return (
        (hypot(d, g), hypot(e, h), hypot(f, i)),
        (hypot(a, g), hypot(b, h), hypot(c, i)),
        (hypot(a, d), hypot(b, e), hypot(c, f)),
    )


def _towards(along: float, axis: Vec3) -> Vec3:
    return axis if along >= 0.0 else scale(-1.0, axis)


def gap_along(direction: Vec3, a: BoxSolid, b: BoxSolid) -> float:
    """The gap along a unit direction that leads from a to b [m]."""
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    return dot(p_AB, direction) - half_extent(a.axes, a.half, direction) - half_extent(b.axes, b.half, direction)


def disturbance(close: Closeness, longest: float, reach: float) -> float:
    """How far the two may be from the places that were meant [m], at most `reach`: read off the pair itself.

    Scenes that are written down touch and align to rounding. What an engine has settled shows gaps and tilts in every
    direction, so the least of them is taken: one alone may be meant. `longest` is the longest side of both [m].
    Two that have but one direction in common and lie beside each other across it, as planks that lean on one another,
    share no faces on which a hair's breadth could be meant: there an edge is always taken to meet an edge.
    """
    common = [i for i, row in enumerate(close.sines) if min(row) <= NOISY_TILT]
    if len(common) == 1 and close.faces_a[common[0]].gap < -reach:
        return reach
    gaps = [abs(axis.gap) for axis in (*close.faces_a, *close.faces_b) if abs(axis.gap) <= reach]
    tilts = [sine for row in close.sines for sine in row if sine <= NOISY_TILT]
    return min(reach, NOISE_RATIO * (min([abs(close.gap), *gaps]) + min(tilts, default=0.0) * longest))
