"""Convex polygons in plan (the x-y plane of W), as the published models use them: corners within noise are dropped."""

from collections.abc import Sequence
from itertools import pairwise
from math import dist, hypot, inf
from typing import TypeAlias

Point2: TypeAlias = tuple[float, float]
Polygon: TypeAlias = tuple[Point2, ...]  # convex, counter-clockwise seen from above, no corner twice

# [m] A corner that sticks out less than this from the line of its neighbours is rounding or noise, not shape.
STRAIGHT = 2e-5
# Share of the extent below which two corners are one, or a corner lies on a line: what rounding does to coordinates.
ROUNDING = 1e-12


def extent(points: Sequence[Point2]) -> float:
    """The larger side of the upright rectangle around points [m]."""
    xs, ys = zip(*points, strict=True)
    width, height = max(xs) - min(xs), max(ys) - min(ys)
    return float(width if width > height else height)


def _doubled_area(a: Point2, b: Point2, c: Point2) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def straightened(polygon: Polygon) -> Polygon:
    """A convex polygon without the corners that are only rounding; empty if it is nowhere wider than that."""
    corners = list(polygon)
    index = 0
    while index < len(corners) > 2:  # noqa: PLR2004 -- a polygon has three
        before, after = corners[index - 1], corners[(index + 1) % len(corners)]
        if _sticks_out(corners[index], before, after) < STRAIGHT:
            del corners[index]
            index = 0
        else:
            index += 1
    return tuple(corners) if len(corners) > 2 else ()  # noqa: PLR2004


def _sticks_out(corner: Point2, a: Point2, b: Point2) -> float:
    """How far a corner is from the line through its neighbours, or from one of them if that is closer [m]."""
    nearest = min(dist(corner, a), dist(corner, b))
    length = dist(a, b)
    return min(nearest, abs(_doubled_area(a, b, corner)) / length) if length > STRAIGHT else nearest


def signed_distance(point: Point2, polygon: Polygon) -> float:
    """Distance from `point` to the border of `polygon` [m]: positive inside, negative outside."""
    if len(polygon) == 1:
        return -dist(point, polygon[0])
    edges = [*pairwise(polygon), (polygon[-1], polygon[0])]
    inside = len(polygon) > 2 and all(_doubled_area(a, b, point) >= 0.0 for a, b in edges)  # noqa: PLR2004 -- has area
    nearest = min((_distance_to_segment(point, a, b) for a, b in edges), default=inf)
    return nearest if inside else -nearest


def _distance_to_segment(point: Point2, a: Point2, b: Point2) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    along = ((point[0] - a[0]) * dx + (point[1] - a[1]) * dy) / (dx * dx + dy * dy)
    along = min(1.0, max(0.0, along))
    return hypot(point[0] - a[0] - along * dx, point[1] - a[1] - along * dy)


def centroid(polygon: Polygon) -> Point2:
    """The centre of the area of a polygon; of its corners if it has no area."""
    ax, ay = polygon[0]
    total = x = y = 0.0
    for b, c in pairwise(polygon[1:]):
        area = _doubled_area(polygon[0], b, c)
        total += area
        x += area * (ax + b[0] + c[0]) / 3.0
        y += area * (ay + b[1] + c[1]) / 3.0
    if total <= 0.0:
        return (sum(p[0] for p in polygon) / len(polygon), sum(p[1] for p in polygon) / len(polygon))
    return (x / total, y / total)
