"""Turns in space, as unit quaternions (x, y, z, w)."""

from math import atan2, cos, hypot, sin

from stability.geometry.vectors import scale
from stability.model import Pose, Quaternion, Vec3


def rotate(orientation: Quaternion, vector: Vec3) -> Vec3:
    """`vector` after the turn `orientation`."""
    x, y, z, w = orientation
    a, b, c = vector
    # v + 2 u x (u x v + w v), with u the vector part
    p = y * c - z * b + w * a
    q = z * a - x * c + w * b
    r = x * b - y * a + w * c
    return (a + 2.0 * (y * r - z * q), b + 2.0 * (z * p - x * r), c + 2.0 * (x * q - y * p))


def inverse(orientation: Quaternion) -> Quaternion:
    """The turn that undoes another."""
    x, y, z, w = orientation
    return (-x, -y, -z, w)


def about(axis: Vec3, angle: float) -> Quaternion:
    """The turn about a unit axis by an angle [rad]."""
    return (*scale(sin(0.5 * angle), axis), cos(0.5 * angle))


def multiply(second: Quaternion, first: Quaternion) -> Quaternion:
    """The turn `first` followed by the turn `second`."""
    x2, y2, z2, w2 = second
    x1, y1, z1, w1 = first
    return (
        w2 * x1 + x2 * w1 + y2 * z1 - z2 * y1,
        w2 * y1 - x2 * z1 + y2 * w1 + z2 * x1,
        w2 * z1 + x2 * y1 - y2 * x1 + z2 * w1,
        w2 * w1 - x2 * x1 - y2 * y1 - z2 * z1,
    )


def turn_between(one: Pose, other: Pose) -> float:
    """The angle of the turn from one orientation to another [rad]."""
    a, b, c, part = multiply(other.orientation, inverse(one.orientation))
    # Not by the cosine, which cannot tell a turn of 1e-8 from none.
    return 2.0 * atan2(hypot(a, b, c), abs(part))


def lean_between(one: Pose, other: Pose) -> float:
    """The angle by which what was upright in one pose leans in another [rad]: a turn about the vertical is none."""
    a, b, c = rotate(other.orientation, rotate(inverse(one.orientation), (0.0, 0.0, 1.0)))
    return atan2(hypot(a, b), c)


def body_axes(orientation: Quaternion) -> tuple[Vec3, Vec3, Vec3]:
    """The three body axes in W, of unit length whatever that of the quaternion."""
    x, y, z, w = orientation
    # A unit quaternion is one to rounding only, or to the digits that an author wrote.
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xx, yy, zz, xy, xz, yz = s * x * x, s * y * y, s * z * z, s * x * y, s * x * z, s * y * z
    xw, yw, zw = s * x * w, s * y * w, s * z * w
    return (
        (1.0 - yy - zz, xy + zw, xz - yw),
        (xy - zw, 1.0 - xx - zz, yz + xw),
        (xz + yw, yz - xw, 1.0 - xx - yy),
    )
