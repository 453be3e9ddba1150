"""Vectors, rotations and principal axes in plain floats, and checks of input numbers."""

from collections.abc import Iterable, Sequence
from math import atan2, copysign, cos, hypot, isfinite, sin, sqrt
from numbers import Integral, Rational, Real
from typing import Final, TypeGuard, TypeVar

from stability.model import IDENTITY, Pose, Quaternion, Vec3

# Vector arithmetic in plain floats, for single vectors many times faster than arrays.


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


# Rotations as unit quaternions (x, y, z, w).


def rotate(orientation: Quaternion, vector: Vec3) -> Vec3:
    """Rotate a vector."""
    x, y, z, w = orientation
    a, b, c = vector
    # v + 2 u x (u x v + w v), with u the vector part
    p = y * c - z * b + w * a
    q = z * a - x * c + w * b
    r = x * b - y * a + w * c
    return (a + 2.0 * (y * r - z * q), b + 2.0 * (z * p - x * r), c + 2.0 * (x * q - y * p))


def inverse(orientation: Quaternion) -> Quaternion:
    """Return the inverse rotation."""
    x, y, z, w = orientation
    return (-x, -y, -z, w)


def about(axis: Vec3, angle: float) -> Quaternion:
    """Return the rotation about a unit axis by an angle [rad]."""
    return (*scale(sin(0.5 * angle), axis), cos(0.5 * angle))


def multiply(second: Quaternion, first: Quaternion) -> Quaternion:
    """Return the rotation `first` followed by the rotation `second`."""
    x2, y2, z2, w2 = second
    x1, y1, z1, w1 = first
    return (
        w2 * x1 + x2 * w1 + y2 * z1 - z2 * y1,
        w2 * y1 - x2 * z1 + y2 * w1 + z2 * x1,
        w2 * z1 + x2 * y1 - y2 * x1 + z2 * w1,
        w2 * w1 - x2 * x1 - y2 * y1 - z2 * z1,
    )


def turn_between(first: Pose, second: Pose) -> float:
    """Return the angle of the rotation between two orientations [rad]."""
    a, b, c, part = multiply(second.orientation, inverse(first.orientation))
    # Not from the cosine, which does not resolve angles of 1e-8.
    return 2.0 * atan2(hypot(a, b, c), abs(part))


def lean_between(first: Pose, second: Pose) -> float:
    """Return the angle between the vertical and the body axis that was vertical in the first pose [rad]."""
    a, b, c = rotate(second.orientation, rotate(inverse(first.orientation), (0.0, 0.0, 1.0)))
    return atan2(hypot(a, b), c)


def body_axes(orientation: Quaternion) -> tuple[Vec3, Vec3, Vec3]:
    """Return the three body axes in W, normalised."""
    x, y, z, w = orientation
    # The norm of a quaternion is 1 only up to rounding, or to the digits in a file.
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xx, yy, zz, xy, xz, yz = s * x * x, s * y * y, s * z * z, s * x * y, s * x * z, s * y * z
    xw, yw, zw = s * x * w, s * y * w, s * z * w
    return (
        (1.0 - yy - zz, xy + zw, xz - yw),
        (xy - zw, 1.0 - xx - zz, yz + xw),
        (xz + yw, yz - xw, 1.0 - xx - yy),
    )


# Principal axes of an inertia tensor, with the same digits on every processor.
#
# Cyclic Jacobi method: a rotation of two axes by at most 45 deg eliminates each product of inertia in turn, so that the
# axes stay near the initial ones. Linear algebra libraries choose signs and last digits by processor, and the landing
# of a solid in an engine may depend on these.


MOST_SWEEPS: Final = 20  # each squares the remaining products; five are usual
LEFT: Final = 1e-16  # share of the moments: products of inertia that may remain
# The two rotated axes, and the axis of rotation with its sense from the first to the second.
PAIRS: Final = ((0, 1, 2, -1.0), (0, 2, 1, 1.0), (1, 2, 0, -1.0))


def principal_axes(tensor: Sequence[Sequence[float]]) -> tuple[Vec3, Quaternion]:
    """Return the principal moments of a symmetric (3, 3) tensor, and the rotation from their axes to the tensor's."""
    remaining, turn = [[float(part) for part in row] for row in tensor], IDENTITY
    size = sum(abs(remaining[i][i]) for i in range(3))
    for _ in range(MOST_SWEEPS):
        if max(abs(remaining[0][1]), abs(remaining[0][2]), abs(remaining[1][2])) <= LEFT * size:
            break
        for first, second, axis, sense in PAIRS:
            cosine, sine = _eliminate(remaining, first, second)
            half = sqrt(0.5 * (1.0 + cosine))
            about = [0.0, 0.0, 0.0]
            about[axis] = sense * 0.5 * sine / half
            turn = multiply(turn, (about[0], about[1], about[2], half))
    return (remaining[0][0], remaining[1][1], remaining[2][2]), turn


def _eliminate(tensor: list[list[float]], first: int, second: int) -> tuple[float, float]:
    """Rotate two axes so that their product of inertia becomes 0; return cosine and sine of the angle."""
    product = tensor[first][second]
    if product == 0.0:
        return 1.0, 0.0
    ratio = (tensor[second][second] - tensor[first][first]) / (2.0 * product)
    tangent = copysign(1.0, ratio) / (abs(ratio) + hypot(1.0, ratio))
    cosine = 1.0 / hypot(1.0, tangent)
    sine = tangent * cosine
    for row in tensor:
        row[first], row[second] = cosine * row[first] - sine * row[second], sine * row[first] + cosine * row[second]
    first_row, second_row = tensor[first], tensor[second]
    tensor[first] = [cosine * a - sine * b for a, b in zip(first_row, second_row, strict=True)]
    tensor[second] = [sine * a + cosine * b for a, b in zip(first_row, second_row, strict=True)]
    tensor[first][second] = tensor[second][first] = 0.0
    return cosine, sine


# Checks of input numbers and lists, with errors that state the expected value.


Given = TypeVar("Given")

SHORTEST, LONGEST = 1e-9, 1e9  # [m] range of lengths: beyond it, squares and products lose digits
LONGEST_REPR: Final = 80  # [characters] of a value in a message


def is_number(value: object) -> TypeGuard[float]:
    """Check for a number of Python or numpy; False for booleans and fractions."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return isinstance(value, Integral) or not isinstance(value, Rational)


def is_finite(value: float) -> bool:
    """Check that a number is finite and fits a double, which large Python integers do not."""
    try:
        return isfinite(value)
    except OverflowError:
        return False


def short_repr(value: object) -> str:
    """Format a value as in source code, shortened."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python writes
        text = f"a number of {value.bit_length()} bits" if isinstance(value, int) else f"a {type(value).__name__}"
    if text.startswith("<"):  # a default repr, which only contains the memory address
        text = type(value).__name__
    return text if len(text) <= LONGEST_REPR else f"{text[: LONGEST_REPR - 1]}…"


def admit_number(subject: str, value: object, remedy: str) -> None:
    """Raise TypeError for a value that is no number; `subject` begins the message, as in `brick 'a' has the mass`."""
    if not is_number(value):
        raise TypeError(f"{subject} {short_repr(value)}; {remedy}")


def admit_in_range(subject: str, value: object, least: float, most: float, remedy: str) -> None:
    """Raise TypeError for a value that is no number, and ValueError for a number out of range."""
    admit_number(subject, value, remedy)
    assert is_number(value)
    if not least <= value <= most:  # also for NaN
        raise ValueError(f"{subject} {short_repr(value)}; {remedy}")


def admit_numbers(subject: str, value: object, count: int, remedy: str) -> None:
    """Raise TypeError for a value that is no sequence of numbers, ValueError unless it has `count` finite ones."""
    parts = _parts(value)
    if parts is None or not all(map(is_number, parts)):
        raise TypeError(f"{subject} {short_repr(value)}; {remedy}, as {count} numbers")
    if len(parts) != count or not all(map(is_finite, parts)):
        raise ValueError(f"{subject} {short_repr(tuple(parts))}; {remedy}")


def _parts(value: object) -> Sequence[float] | None:
    """Return the items of a sequence; None for other values, such as a text."""
    if isinstance(value, str | bytes | dict | set) or not (hasattr(value, "__len__") and hasattr(value, "__iter__")):
        return None
    try:
        return list(value)
    except TypeError:  # a numpy array without dimensions
        return None


def listed(values: Iterable[Given], items: str) -> tuple[Given, ...]:
    """Return all items of an iterable. Raises TypeError with the expected `items` for other values."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise TypeError(f"expected a collection of {items}, not {short_repr(values)}")
    try:
        return tuple(values)
    except TypeError as error:  # a numpy array without dimensions
        raise TypeError(f"expected a collection of {items}, not {short_repr(values)}") from error
