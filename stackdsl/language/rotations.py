"""Rotations of bricks about the axes of the scene, with digits on which all processors agree."""

from math import cos, sin

from stability.geometry.vectors import multiply
from stability.model import Quaternion, Vec3


def about_z(angle: float) -> Quaternion:
    """Return the rotation by an angle about the vertical [rad]."""
    sine, cosine = half_turn(angle)
    return (0.0, 0.0, sine, cosine)


def half_turn(angle: float) -> tuple[float, float]:
    """Return the sine and cosine of half an angle, rounded to digits on which all processors agree."""
    return round(sin(angle / 2.0), 15), round(cos(angle / 2.0), 15)


def about_axes(angles: Vec3) -> Quaternion:
    """Return the rotation about the scene axes x, then y, then z [rad]."""
    (sin_x, cos_x), (sin_y, cos_y) = half_turn(angles[0]), half_turn(angles[1])
    return multiply(about_z(angles[2]), multiply((0.0, sin_y, 0.0, cos_y), (sin_x, 0.0, 0.0, cos_x)))
