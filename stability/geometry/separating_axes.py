"""The separating axes of two boxes (Gottschalk, Lin and Manocha, 1996): 3 + 3 face normals and 9 products of edges.

How far apart two boxes are, how they touch, and where one that moves meets the other are all read off these. A box is
given by its axes in W and its half lengths along them; `turn` holds the cosines between the axes of a (rows) and of b.
"""

from collections.abc import Iterator
from math import hypot
from typing import TypeAlias

from stability.model import Vec3

Axes: TypeAlias = tuple[Vec3, Vec3, Vec3]
Matrix: TypeAlias = tuple[Vec3, Vec3, Vec3]
# One product of edges: the number of the edge of a and of b, the cosine and sine that `along_product` takes, its length
# as a vector, and how far both boxes reach along it, in so many times that length.
EdgeProduct: TypeAlias = tuple[int, int, float, float, float, float]

PARALLEL = 1e-9  # sine below which two edges give no direction of their own


def coordinates(vector_W: Vec3, axes: Axes) -> Vec3:
    """A vector along three axes."""
    # Written out, as much of the time of a comparison is spent here.
    x, y, z = vector_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    return (x * ux + y * uy + z * uz, x * vx + y * vy + z * vz, x * wx + y * wy + z * wz)


def cosines(axes_a: Axes, axes_b: Axes) -> Matrix:
    """Between the axes of a (rows) and those of b."""
    u, v, w = axes_a
    return (coordinates(u, axes_b), coordinates(v, axes_b), coordinates(w, axes_b))


def transposed(m: Matrix) -> Matrix:
    """Rows for columns."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))


def face_gaps(along: Vec3, half: Vec3, other: Vec3, turn: Matrix) -> Vec3:
    """The gaps along the three face normals of a box, for centres so far apart along them [m].

    Rows of `turn` are the cosines of these normals with the axes of the other box.
    """
    a, b, c = other
    (u0, u1, u2), (v0, v1, v2), (w0, w1, w2) = turn
    return (
        abs(along[0]) - half[0] - a * abs(u0) - b * abs(u1) - c * abs(u2),
        abs(along[1]) - half[1] - a * abs(v0) - b * abs(v1) - c * abs(v2),
        abs(along[2]) - half[2] - a * abs(w0) - b * abs(w1) - c * abs(w2),
    )


def edge_products(turn: Matrix, half_a: Vec3, half_b: Vec3) -> Iterator[EdgeProduct]:
    """The products of edges that are not parallel."""
    for i in range(3):
        row, next_row, last_row = turn[i], turn[i - 2], turn[i - 1]
        half_next, half_last = half_a[i - 2], half_a[i - 1]
        for j, k, m in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            # In the frame of a, with axis i first, the product of edges i and j is (0, -s, c).
            c, s = next_row[j], last_row[j]
            length = hypot(c, s)
            if length > PARALLEL:
                extent = half_next * abs(s) + half_last * abs(c) + half_b[k] * abs(row[m]) + half_b[m] * abs(row[k])
                yield i, j, c, s, length, extent


def along_product(along_a: Vec3, i: int, c: float, s: float) -> float:
    """A vector, given by its coordinates along the axes of a, along a product of edges, in so many times its length."""
    return along_a[i - 1] * c - along_a[i - 2] * s


def half_extent(axes: Axes, half: Vec3, direction_W: Vec3) -> float:
    """How far a box reaches from its centre along a unit direction [m]."""
    x, y, z = direction_W
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes
    a, b, c = half
    return a * abs(ux * x + uy * y + uz * z) + b * abs(vx * x + vy * y + vz * z) + c * abs(wx * x + wy * y + wz * z)
