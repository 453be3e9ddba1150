"""Flat contact patches with round borders, between an inscribed and a circumscribed polygon.

A patch is the intersection of discs and at most one convex polygon. The inner polygon has corners on its border, the
outer one also has those where the tangents at these meet. Forces at corners of the inner polygon act inside the patch;
a slip that no force at a corner of the outer polygon resists, no force inside the patch resists. More angles on an arc
bring both polygons as close together as needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import acos, atan2, ceil, cos, dist, hypot, pi, sin
from typing import Final

from stability.geometry.polygons import Point2, convex_hull
from stability.geometry.vectors import add_scaled
from stability.model import Vec3

FIRST_SIDES: Final = 16  # of a full circle before any refinement
ROUNDING: Final = 1e-12  # share of a radius
SAME_ANGLE: Final = 1e-9  # [rad] between distinct angles
KEPT: Final = 4096  # cache size

TURN: Final = 2.0 * pi


@dataclass(frozen=True, slots=True)
class Disc:
    """Disc in the plane of a patch."""

    x: float  # [m]
    y: float
    radius: float

    def at(self, angle: float) -> Point2:
        """Return a point of its border."""
        return (self.x + self.radius * cos(angle), self.y + self.radius * sin(angle))

    def over(self, start: float, end: float) -> Point2:
        """Return the point in which the tangents at two angles meet."""
        middle, reach = 0.5 * (start + end), self.radius / cos(0.5 * (end - start))
        return (self.x + reach * cos(middle), self.y + reach * sin(middle))

    def has(self, point: Point2) -> bool:
        """Return whether it holds a point, up to rounding."""
        return hypot(point[0] - self.x, point[1] - self.y) <= self.radius * (1.0 + ROUNDING)


@dataclass(frozen=True, slots=True)
class RoundPatch:
    """Intersection of discs and a polygon in a plane, with the angles at which its arcs have a corner."""

    origin_W: Vec3  # of the frame of the plane [m]
    axes_W: tuple[Vec3, Vec3]  # x and y of the frame
    discs: tuple[Disc, ...]
    polygon: tuple[Point2, ...] = ()  # counter-clockwise; empty if discs alone bound the patch
    angles: tuple[tuple[float, ...], ...] = ()  # additional ones, by disc, from 0 to 2 pi
    gap: tuple[float, float, float] = (0.0, 0.0, 0.0)  # at the origin [m], and its rise along x and y

    @property
    def inner(self) -> tuple[Point2, ...]:
        """The corners of the inscribed polygon, counter-clockwise; empty if the patch is empty."""
        return _polygons(self)[0]

    @property
    def outer(self) -> tuple[Point2, ...]:
        """The corners of the circumscribed polygon, counter-clockwise."""
        return _polygons(self)[1]

    @property
    def flat(self) -> tuple[Point2, ...]:
        """The corners of the polygon that are corners of the patch."""
        return tuple(corner for corner in self.polygon if all(disc.has(corner) for disc in self.discs))

    @property
    def spans(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """The parts of the arcs of each disc between neighbouring corners of the inner polygon, as angles."""
        return tuple(_spans(self, number) for number in range(len(self.discs)))

    @property
    def arcs(self) -> tuple[tuple[tuple[float, float], ...], ...]:
        """The arcs of each disc on the border of the patch, as angles; the second may exceed 2 pi."""
        return tuple(_arcs(self, number) for number in range(len(self.discs)))

    @property
    def area(self) -> float:
        """The area of the patch [m2]: of its inner polygon, and of the segments between its sides and the arcs."""
        inner = self.inner
        polygon = 0.5 * sum(ax * by - bx * ay for (ax, ay), (bx, by) in pairwise((*inner, *inner[:1])))
        segments = (
            0.5 * disc.radius**2 * ((end - start) - sin(end - start))
            for disc, spans in zip(self.discs, self.spans, strict=True)
            for start, end in spans
        )
        return polygon + sum(segments)

    def with_sides(self, count: int) -> "RoundPatch":
        """Return the patch with evenly spaced corners, `count` on a full circle, beside those that it has."""
        angles = tuple(TURN * side / count for side in range(count))
        return self.refined((angles,) * len(self.discs))

    def placed(self, points: tuple[Point2, ...]) -> tuple[Vec3, ...]:
        """Return points of the plane in W [m]."""
        u, w = self.axes_W
        return tuple(add_scaled(add_scaled(self.origin_W, x, u), y, w) for x, y in points)

    def gap_at(self, point: Point2) -> float:
        """Return the gap of the two bodies at a point [m]."""
        at, along_x, along_y = self.gap
        return at + along_x * point[0] + along_y * point[1]

    def is_same_as(self, other: "RoundPatch") -> bool:
        """Return whether two patches differ in their additional angles at most."""
        return replace(self, angles=()) == replace(other, angles=())

    def refined(self, angles: tuple[tuple[float, ...], ...]) -> "RoundPatch":
        """Return the patch with more angles, by disc; the same one if all are known."""
        known = self.angles or ((),) * len(self.discs)
        more = tuple(tuple(sorted({*own, *new})) for own, new in zip(known, angles, strict=True))
        return replace(self, angles=more)


@lru_cache(maxsize=KEPT)
def _polygons(patch: RoundPatch) -> tuple[tuple[Point2, ...], tuple[Point2, ...]]:
    inner, outer = list(patch.flat), list(patch.flat)
    for disc, spans in zip(patch.discs, patch.spans, strict=True):
        ends = dict.fromkeys(angle for span in spans for angle in span if angle < TURN or spans[0][0] > 0.0)
        inner += [disc.at(angle) for angle in ends]
        outer += [disc.at(angle) for angle in ends] + [disc.over(*span) for span in spans]
    slack = ROUNDING * max((disc.radius for disc in patch.discs), default=0.0)
    return _distinct(convex_hull(inner), slack), _distinct(convex_hull(outer), slack)


def _distinct(corners: Sequence[Point2], slack: float) -> tuple[Point2, ...]:
    """Return corners without those that coincide with the one before: crossings of two borders are on both."""
    return tuple(corner for number, corner in enumerate(corners) if dist(corner, corners[number - 1]) > slack)


@lru_cache(maxsize=KEPT)
def _spans(patch: RoundPatch, number: int) -> tuple[tuple[float, float], ...]:
    more = patch.angles[number] if patch.angles else ()
    spans: list[tuple[float, float]] = []
    for start, end in _arcs(patch, number):
        count = max(1, ceil((end - start) / TURN * FIRST_SIDES - ROUNDING))
        angles = [start + (end - start) * part / count for part in range(count + 1)]
        angles += [turned for angle in more if start < (turned := start + (angle - start) % TURN) < end]
        angles.sort()
        spans += [(a, b) for a, b in pairwise(angles) if b - a > SAME_ANGLE]
    return tuple(spans)


@lru_cache(maxsize=KEPT)
def _arcs(patch: RoundPatch, number: int) -> tuple[tuple[float, float], ...]:
    disc = patch.discs[number]
    crossings = sorted(
        angle % TURN
        for angle in (
            *(angle for other in patch.discs if other is not disc for angle in _crossings(disc, other)),
            *(angle for side in pairwise((*patch.polygon, *patch.polygon[:1])) for angle in _on_line(disc, *side)),
        )
    )
    if not crossings:
        return ((0.0, TURN),) if _inside(patch, disc, disc.at(0.0)) else ()
    spans = zip(crossings, (*crossings[1:], crossings[0] + TURN), strict=True)
    return tuple(
        (start, end)
        for start, end in spans
        if end - start > SAME_ANGLE and _inside(patch, disc, disc.at(0.5 * (start + end)))
    )


def _inside(patch: RoundPatch, own: Disc, point: Point2) -> bool:
    sides = pairwise((*patch.polygon, *patch.polygon[:1]))
    return all(other is own or other.has(point) for other in patch.discs) and all(
        (bx - ax) * (point[1] - ay) - (by - ay) * (point[0] - ax) >= 0.0 for (ax, ay), (bx, by) in sides
    )


def _crossings(disc: Disc, other: Disc) -> list[float]:
    """Return the angles of a disc at which another border crosses its own."""
    dx, dy = other.x - disc.x, other.y - disc.y
    apart = hypot(dx, dy)
    if apart == 0.0:
        return []
    cosine = (disc.radius**2 + apart**2 - other.radius**2) / (2.0 * disc.radius * apart)
    if abs(cosine) >= 1.0:
        return []
    middle, half = atan2(dy, dx), acos(cosine)
    return [middle - half, middle + half]


def _on_line(disc: Disc, start: Point2, end: Point2) -> list[float]:
    """Return the angles of a disc at which the line through two points crosses its border."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = hypot(dx, dy)
    nx, ny = dy / length, -dx / length  # outwards
    cosine = ((start[0] - disc.x) * nx + (start[1] - disc.y) * ny) / disc.radius
    if abs(cosine) >= 1.0:
        return []
    middle, half = atan2(ny, nx), acos(cosine)
    return [middle - half, middle + half]


def smallest_discs(discs: list[Disc], slack: float) -> tuple[Disc, ...]:
    """Return the discs without those that hold another one, up to `slack` [m]."""
    kept: list[Disc] = []
    for disc in sorted(discs, key=lambda each: (each.radius, each.x, each.y)):
        if not any(dist((disc.x, disc.y), (other.x, other.y)) + other.radius <= disc.radius + slack for other in kept):
            kept.append(disc)
    return tuple(kept)
