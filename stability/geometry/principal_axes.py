"""The principal axes of a tensor of inertia, to the same digits on every processor.

Cyclic Jacobi: each product of inertia in turn is taken away by the turn of its two axes by at most 45 deg, so that the
axes stay near to those that they began as. Libraries of linear algebra choose signs and last digits by processor, and
how a solid lands in an engine may hang on these.
"""

from collections.abc import Sequence
from math import copysign, hypot, sqrt
from typing import Final

from stability.geometry.rotations import multiply
from stability.model import IDENTITY, Quaternion, Vec3

MOST_SWEEPS: Final = 20  # each squares what is left; five are usual
LEFT: Final = 1e-16  # share of the moments that products of inertia may be left at
# The two axes that are turned, and the one about which, with the sense from the first to the second.
PAIRS: Final = ((0, 1, 2, -1.0), (0, 2, 1, 1.0), (1, 2, 0, -1.0))


def principal_axes(tensor: Sequence[Sequence[float]]) -> tuple[Vec3, Quaternion]:
    """The moments of a symmetric (3, 3) tensor, and the turn from their axes to those that it is written in."""
    left, turn = [[float(part) for part in row] for row in tensor], IDENTITY
    size = sum(abs(left[i][i]) for i in range(3))
    for _ in range(MOST_SWEEPS):
        if max(abs(left[0][1]), abs(left[0][2]), abs(left[1][2])) <= LEFT * size:
            break
        for first, second, axis, sense in PAIRS:
            cosine, sine = _taken_away(left, first, second)
            half = sqrt(0.5 * (1.0 + cosine))
            about = [0.0, 0.0, 0.0]
            about[axis] = sense * 0.5 * sine / half
            turn = multiply(turn, (about[0], about[1], about[2], half))
    return (left[0][0], left[1][1], left[2][2]), turn


def _taken_away(left: list[list[float]], first: int, second: int) -> tuple[float, float]:
    """Turn two axes so that their product of inertia is none; the cosine and the sine of the turn."""
    product = left[first][second]
    if product == 0.0:
        return 1.0, 0.0
    ratio = (left[second][second] - left[first][first]) / (2.0 * product)
    tangent = copysign(1.0, ratio) / (abs(ratio) + hypot(1.0, ratio))
    cosine = 1.0 / hypot(1.0, tangent)
    sine = tangent * cosine
    for row in left:
        row[first], row[second] = cosine * row[first] - sine * row[second], sine * row[first] + cosine * row[second]
    one, other = left[first], left[second]
    left[first] = [cosine * a - sine * b for a, b in zip(one, other, strict=True)]
    left[second] = [sine * a + cosine * b for a, b in zip(one, other, strict=True)]
    left[first][second] = left[second][first] = 0.0
    return cosine, sine
