"""Outlines of upright boxes seen from above, and by how much two of them overlap."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import cos, hypot, radians, sin
from typing import Final

from stability.geometry.neighbours import Neighbours
from stability.model import Vec3
from stackdsl.importing.load import ImportedBox

RIGHT_ANGLE: Final = 90  # [deg]


@dataclass(frozen=True, slots=True)
class Outline:
    """A rectangle in plan: centre, half its sides, and the direction of the first of them."""

    centre: tuple[Fraction, Fraction]  # [m]
    half: tuple[Fraction, Fraction]  # [m]
    axis: tuple[float, float] | None  # None if sides are along x and y


def outline(box: ImportedBox) -> Outline:
    """The outline of an upright box."""
    length, width, _ = (side / 2 for side in box.size)
    yaw = box.turn[2]
    centre = box.centre[:2]
    if yaw % RIGHT_ANGLE == 0:
        return Outline(centre, (length, width) if yaw % (2 * RIGHT_ANGLE) == 0 else (width, length), None)
    return Outline(centre, (length, width), (cos(radians(yaw)), sin(radians(yaw))))


def overlap_in_plan(one: Outline, other: Outline) -> Fraction:
    """How far one would have to move to lie beside the other [m]; not more than zero if it does."""
    if one.axis is None and other.axis is None:
        return min(one.half[i] + other.half[i] - abs(one.centre[i] - other.centre[i]) for i in (0, 1))
    apart = [float(one.centre[i] - other.centre[i]) for i in (0, 1)]
    overlaps = []
    for x, y in (*_axes(one), *_axes(other)):
        overlaps.append(_reach(one, x, y) + _reach(other, x, y) - abs(apart[0] * x + apart[1] * y))
    return Fraction(min(overlaps))


def close_in_plan(outlines: Sequence[Outline]) -> Iterator[tuple[int, int]]:
    """The pairs whose bounds overlap in plan, by number, each once: a superset of those that overlap."""
    there: Neighbours[int] = Neighbours()
    for number, one in enumerate(outlines):
        low, high = _bounds(one)
        yield from ((other, number) for other in there.around(low, high, 0.0))
        there.add(number, low, high)


def _bounds(one: Outline) -> tuple[Vec3, Vec3]:
    x, y = (float(part) for part in one.centre)
    along_x, along_y = _reach(one, 1.0, 0.0), _reach(one, 0.0, 1.0)
    return (x - along_x, y - along_y, 0.0), (x + along_x, y + along_y, along_x)  # all at one height


def _axes(one: Outline) -> tuple[tuple[float, float], tuple[float, float]]:
    x, y = one.axis or (1.0, 0.0)
    return (x, y), (-y, x)


def _reach(one: Outline, x: float, y: float) -> float:
    """How far an outline reaches from its centre along a direction."""
    return sum(
        float(half) * abs(x * ax + y * ay) / hypot(x, y) for half, (ax, ay) in zip(one.half, _axes(one), strict=True)
    )
