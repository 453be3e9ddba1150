"""The shortest turn from one direction to another, by which a plane is turned to its normal."""

from math import sqrt

from stability.geometry.vectors import cross, dot
from stability.model import Quaternion, Vec3

OPPOSITE = -1.0 + 1e-12  # cosine below which any turn by 180 deg is the shortest


def shortest_turn(before: Vec3, after: Vec3) -> Quaternion:
    """The shortest turn that takes one unit vector to another."""
    cosine = dot(before, after)
    if cosine < OPPOSITE:
        x, y, z = before
        return _half_turn_about((0.0, -z, y) if abs(x) < abs(z) else (-y, x, 0.0))
    half = sqrt(2.0 * (1.0 + cosine))
    x, y, z = cross(before, after)
    return (x / half, y / half, z / half, half / 2.0)


def _half_turn_about(axis: Vec3) -> Quaternion:
    length = sqrt(dot(axis, axis))
    return (axis[0] / length, axis[1] / length, axis[2] / length, 0.0)
