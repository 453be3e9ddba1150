"""Convex polygons in plan, fast and unrounded: no corner is dropped because it sticks out little.

Corners run counter-clockwise seen from above. What has no area is no polygon and comes back empty.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import hypot, inf

from stability.geometry.plan import Point2, Polygon

# Share of the extent below which two corners are one, or a corner lies on a line: what rounding does to coordinates.
ROUNDING = 1e-12


def hull(points: Iterable[Point2]) -> Polygon:
    """The convex hull, without corners that stick out by rounding only; empty if the points lie on a line to rounding.

    Monotone chain (Andrew, 1979).
    """
    ordered = sorted(set(points))
    if len(ordered) < 3:  # noqa: PLR2004 -- a polygon has three corners
        return ()
    slack = ROUNDING * extent(ordered)
    lower = _chain(ordered, slack)
    ordered.reverse()
    upper = _chain(ordered, slack)
    corners = (*lower[:-1], *upper[:-1])
    return corners if len(corners) > 2 else ()  # noqa: PLR2004


def _chain(ordered: Sequence[Point2], slack: float) -> list[Point2]:
    chain = [ordered[0], ordered[1]]
    for point in ordered[2:]:
        x, y = point
        while len(chain) > 1:
            (ox, oy), (ax, ay) = chain[-2], chain[-1]
            dx, dy = x - ox, y - oy
            if (ax - ox) * dy - (ay - oy) * dx > slack * (abs(dx) + abs(dy)):
                break
            chain.pop()
        chain.append(point)
    return chain


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


def extent(polygon: Sequence[Point2]) -> float:
    """The larger side of the upright rectangle around it [m]."""
    xs, ys = zip(*polygon, strict=True)
    width, height = max(xs) - min(xs), max(ys) - min(ys)
    return float(width if width > height else height)


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
        distance = (dx * (py - ay) - dy * (px - ax)) / hypot(dx, dy)
        least = min(least, distance)
        ax, ay = bx, by
    return least if polygon else -inf


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
    """Part of one convex polygon inside another (Sutherland and Hodgman, 1974); empty if it has no area."""
    if not subject or not window:
        return ()
    slack = ROUNDING * extent(window)
    corners: Sequence[Point2] = subject
    cut = False
    for (ax, ay), (bx, by) in pairwise((*window, window[0])):
        dx, dy = bx - ax, by - ay
        least = -slack * hypot(dx, dy)
        sides = [dx * (y - ay) - dy * (x - ax) for x, y in corners]
        if min(sides) >= least:
            continue
        corners = _kept(corners, sides, least)
        cut = True
        if len(corners) < 3:  # noqa: PLR2004 -- a polygon has three
            return ()
    return with_area(tuple(corners)) if cut else subject


def _kept(corners: Sequence[Point2], sides: Sequence[float], least: float) -> list[Point2]:
    """The corners on the inner side of a line, and the points where the border crosses it."""
    kept: list[Point2] = []
    before, side_before = corners[-1], sides[-1]
    for corner, side in zip(corners, sides, strict=True):
        if (side >= least) != (side_before >= least):
            part = min(1.0, max(0.0, side_before / (side_before - side)))  # both may lie on the line, to rounding
            kept.append((before[0] + part * (corner[0] - before[0]), before[1] + part * (corner[1] - before[1])))
        if side >= least:
            kept.append(corner)
        before, side_before = corner, side
    return kept


def inset(polygon: Polygon, distance: float) -> Polygon:
    """The points that lie at least so deep inside; empty if they have no area."""
    if not polygon:
        return ()
    inner = polygon
    for (ax, ay), (bx, by) in pairwise((*polygon, polygon[0])):
        length = hypot(bx - ax, by - ay)
        nx, ny = -(by - ay) / length, (bx - ax) / length
        sides = [(x - ax) * nx + (y - ay) * ny - distance for x, y in inner]
        inner = tuple(_kept(inner, sides, 0.0))
        if len(inner) < 3:  # noqa: PLR2004 -- a polygon has three
            return ()
    return with_area(inner)


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
