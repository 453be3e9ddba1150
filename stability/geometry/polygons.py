"""Convex polygons in plan, fast and unrounded: no corner is dropped because it sticks out little.

Corners run counter-clockwise seen from above. What has no area is no polygon and comes back empty.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import hypot, inf

from stability.geometry.clipping import cut
from stability.geometry.plan import ROUNDING, Point2, Polygon, extent


def with_area(polygon: Polygon) -> Polygon:
    """The polygon without corners that rounding has doubled; empty if it has no area."""
    if len(polygon) < 3:  # noqa: PLR2004 -- a polygon has three
        return ()
    slack = ROUNDING * extent(polygon)
    kept: list[Point2] = []
    for corner in polygon:
        if not kept or abs(corner[0] - kept[-1][0]) > slack or abs(corner[1] - kept[-1][1]) > slack:
            kept.append(corner)
    while len(kept) > 1 and abs(kept[0][0] - kept[-1][0]) <= slack and abs(kept[0][1] - kept[-1][1]) <= slack:
        kept.pop()
    return tuple(kept) if len(kept) > 2 and _width(kept) > slack else ()  # noqa: PLR2004


def _width(corners: Sequence[Point2]) -> float:
    """How far the corners reach from the line through the first and the one furthest from it [m]."""
    ax, ay = corners[0]
    bx, by = max(corners, key=lambda corner: (corner[0] - ax) ** 2 + (corner[1] - ay) ** 2)
    dx, dy = bx - ax, by - ay
    length = hypot(dx, dy)
    return max(abs((x - ax) * dy - (y - ay) * dx) for x, y in corners) / length if length > 0.0 else 0.0


def depth(point: Point2, polygon: Polygon) -> float:
    """How deep a point lies inside: the distance to the nearest border line [m]; negative outside, -inf of nothing."""
    px, py = point
    least = inf
    ax, ay = polygon[-1] if polygon else point
    for bx, by in polygon:
        dx, dy = bx - ax, by - ay
        length = hypot(dx, dy)
        if length > 0.0:  # a corner may be there twice, where rounding has made one of two
            least = min(least, (dx * (py - ay) - dy * (px - ax)) / length)
        ax, ay = bx, by
    return least if least < inf else -inf


def holds(window: Polygon, points: Sequence[Point2], slack: float) -> bool:
    """Whether no point lies outside a convex polygon by more than `slack` [m]: quicker to say than to clip."""
    if not window:
        return False
    ax, ay = window[-1]
    for bx, by in window:
        dx, dy = bx - ax, by - ay
        least = -slack * (dx if dx > 0.0 else -dx) - slack * (dy if dy > 0.0 else -dy)
        for x, y in points:
            if dx * (y - ay) - dy * (x - ax) < least:
                return False
        ax, ay = bx, by
    return True


def clip(subject: Polygon, window: Polygon) -> Polygon:
    """Part of one convex polygon inside another; empty if it has no area."""
    if not subject or not window:
        return ()
    slack = ROUNDING * extent(window)
    corners: Sequence[Point2] = subject
    for (ax, ay), (bx, by) in pairwise((*window, window[0])):
        dx, dy = bx - ax, by - ay
        on_line = slack * hypot(dx, dy)
        depths = [dx * (y - ay) - dy * (x - ax) for x, y in corners]
        if min(depths) >= -on_line:
            continue
        corners = cut(corners, depths, on_line, _between)
        if len(corners) < 3:  # noqa: PLR2004 -- a polygon has three
            return ()
    return subject if corners is subject else with_area(tuple(corners))


def _between(one: Point2, other: Point2, part: float) -> Point2:
    return (one[0] + part * (other[0] - one[0]), one[1] + part * (other[1] - one[1]))


def inset(polygon: Polygon, distance: float) -> Polygon:
    """The points that lie at least so deep inside; empty if they have no area."""
    if not polygon:
        return ()
    inner: Sequence[Point2] = polygon
    for (ax, ay), (bx, by) in pairwise((*polygon, polygon[0])):
        length = hypot(bx - ax, by - ay)
        nx, ny = -(by - ay) / length, (bx - ax) / length
        inner = cut(inner, [(x - ax) * nx + (y - ay) * ny - distance for x, y in inner], 0.0, _between)
        if len(inner) < 3:  # noqa: PLR2004 -- a polygon has three
            return ()
    return with_area(tuple(inner))


def clip_line(line: Sequence[Point2], window: Polygon, slack: float) -> tuple[Point2, ...]:
    """Part of a line between two points that lies over a convex polygon, or beside it by at most `slack` [m]."""
    points = line if window else ()
    for (ax, ay), (bx, by) in pairwise((*window, *window[:1])):
        dx, dy = bx - ax, by - ay
        depths = [dx * (y - ay) - dy * (x - ax) for x, y in points]
        points = cut(points, depths, slack * max(abs(dx), abs(dy)), _between) if points else ()
    return tuple(dict.fromkeys(points))  # a line goes there and back


def doubled_area(points: Sequence[Point2]) -> tuple[float, float]:
    """Twice the area, positive if counter-clockwise [m2], and how far the points reach from the first one [m]."""
    ox, oy = points[0]  # far from the origin of W the products would lose the area
    area = reach = ax = ay = 0.0
    for x, y in points[1:]:
        bx, by = x - ox, y - oy
        area += ax * by - ay * bx
        reach = max(reach, abs(bx), abs(by))
        ax, ay = bx, by
    return area, reach


def barycentric(point: Point2, polygon: Polygon) -> list[float]:
    """Non-negative weights of the corners whose weighted mean is the point; a point outside counts as on the border.

    Three corners at most carry it: those of the triangle of the fan about the first corner that it lies in.
    """
    weights = [0.0] * len(polygon)
    (ax, ay), (px, py) = polygon[0], point
    best = -inf
    chosen: tuple[int, tuple[float, float, float]] = (1, (1.0, 0.0, 0.0))
    for index in range(1, len(polygon) - 1):
        (bx, by), (cx, cy) = polygon[index], polygon[index + 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area <= 0.0:
            continue
        of_b = ((px - ax) * (cy - ay) - (py - ay) * (cx - ax)) / area
        of_c = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / area
        least = min(of_b, of_c, 1.0 - of_b - of_c)
        if least > best:
            best, chosen = least, (index, (1.0 - of_b - of_c, of_b, of_c))
    index, parts = chosen
    parts = (max(parts[0], 0.0), max(parts[1], 0.0), max(parts[2], 0.0))
    total = sum(parts)
    weights[0], weights[index], weights[index + 1] = (part / total for part in parts)
    return weights
