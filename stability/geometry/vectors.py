"""Vectors, rotations and principal axes in plain floats, and checks of given numbers."""

from collections.abc import Iterable, Sequence
from math import atan2, copysign, cos, hypot, isfinite, sin, sqrt
from numbers import Integral, Rational, Real
from typing import Final, TypeGuard, TypeVar

from stability.model import IDENTITY, Pose, Quaternion, Vec3

# Arithmetic of vectors in space, in plain floats: for single vectors many times faster than arrays.


def dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec3, b: Vec3) -> Vec3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def subtract(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add_scaled(point: Vec3, distance: float, direction: Vec3) -> Vec3:
    return (point[0] + distance * direction[0], point[1] + distance * direction[1], point[2] + distance * direction[2])


def scale(factor: float, a: Vec3) -> Vec3:
    return (factor * a[0], factor * a[1], factor * a[2])


def norm(a: Vec3) -> float:
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


def unit(a: Vec3) -> Vec3:
    return scale(1.0 / norm(a), a)


# Turns in space, as unit quaternions (x, y, z, w).


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


# The principal axes of a tensor of inertia, to the same digits on every processor.
#
# Cyclic Jacobi: each product of inertia in turn is taken away by the turn of its two axes by at most 45 deg, so that
# the axes stay near to those that they began as. Libraries of linear algebra choose signs and last digits by processor,
# and how a solid lands in an engine may hang on these.


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


# Checks numbers and lists that a caller gives: each error says what was expected.


Given = TypeVar("Given")

SHORTEST, LONGEST = 1e-9, 1e9  # [m] of sides and distances: beyond, their squares and products lose their digits
TOLD: Final = 80  # [characters] of a value in a message


def is_number(value: object) -> TypeGuard[float]:
    """True for a number of Python or numpy; False for booleans and fractions."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return isinstance(value, Integral) or not isinstance(value, Rational)


def is_finite(value: float) -> bool:
    """Whether a number is finite, and a double can hold it, which not every integer of Python fits."""
    try:
        return isfinite(value)
    except OverflowError:
        return False


def told(value: object) -> str:
    """A value as its author would write it, shortened."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python writes
        text = f"a number of {value.bit_length()} bits" if isinstance(value, int) else f"a {type(value).__name__}"
    if text.startswith("<"):  # what says no more than where it is in memory
        text = type(value).__name__
    return text if len(text) <= TOLD else f"{text[: TOLD - 1]}…"


def admit_number(what: str, value: object, remedy: str) -> None:
    """Raise TypeError for what is no number; `what` is what has it, such as `brick 'a' has the mass`."""
    if not is_number(value):
        raise TypeError(f"{what} {told(value)}; {remedy}")


def admit_in_range(what: str, value: object, least: float, most: float, remedy: str) -> None:
    """Raise TypeError for what is not a number, and ValueError for a number out of range."""
    admit_number(what, value, remedy)
    assert is_number(value)
    if not least <= value <= most:  # nor is what is no number
        raise ValueError(f"{what} {told(value)}; {remedy}")


def admit_numbers(what: str, value: object, count: int, remedy: str) -> None:
    """Raise TypeError for what is no sequence of numbers, and ValueError for other than so many finite ones."""
    parts = _parts(value)
    if parts is None or not all(map(is_number, parts)):
        raise TypeError(f"{what} {told(value)}; {remedy}, as {count} numbers")
    if len(parts) != count or not all(map(is_finite, parts)):
        raise ValueError(f"{what} {told(tuple(parts))}; {remedy}")


def _parts(value: object) -> Sequence[float] | None:
    """The parts of what can be gone through in order; None of anything else, such as a text."""
    if isinstance(value, str | bytes | dict | set) or not (hasattr(value, "__len__") and hasattr(value, "__iter__")):
        return None
    try:
        return list(value)
    except TypeError:  # an array of numpy without an axis
        return None


def listed(given: Iterable[Given], what: str) -> tuple[Given, ...]:
    """All items of an iterable. Raises TypeError, with what was expected, for anything else."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise TypeError(f"expected a collection of {what}, not {told(given)}")
    try:
        return tuple(given)
    except TypeError as error:  # an array of numpy without an axis
        raise TypeError(f"expected a collection of {what}, not {told(given)}") from error
