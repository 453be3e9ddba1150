"""Convex polygons in plan: areas, clipping, convex hulls."""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import dist, hypot, inf
from typing import TypeAlias, TypeVar, cast

# Clipping of convex polygons, lines and cones by half-planes (Sutherland and Hodgman, 1974).


P = TypeVar("P", bound=tuple[float, ...])  # a point or a direction, of any dimension


def between(start: P, end: P, part: float) -> P:
    """Interpolate between two points; `part` is 0 at the first and 1 at the second."""
    return cast(P, tuple([first + part * (second - first) for first, second in zip(start, end, strict=True)]))


def cut(
    corners: Sequence[P],
    depths: Sequence[float],
    slack: float = 0.0,
    crossing: Callable[[P, P, float], P] = between,
) -> list[P]:
    """Clip a convex polygon, a line or a point to the inner side of a line.

    `depths` are the distances of the corners inside the line. A corner within `slack` outside counts as on the line.
    `crossing` computes the corners on the line, always from the inner to the outer corner, so that two polygons with
    a common side get the same result.
    """
    clipped: list[P] = []
    least = -slack
    before, depth_before = corners[-1], depths[-1]
    for corner, depth in zip(corners, depths, strict=True):
        if depth >= least:
            if depth > slack and depth_before < least:
                clipped.append(crossing(corner, before, depth / (depth - depth_before)))
            clipped.append(corner)
        elif depth_before > slack:
            clipped.append(crossing(before, corner, depth_before / (depth_before - depth)))
        before, depth_before = corner, depth
    return clipped


def within_rectangle(corners: Sequence[P], half_x: float, half_y: float) -> Sequence[P]:
    """Clip a polygon, a line or a point by its first two coordinates to a centred rectangle."""
    for axis, limit in ((0, half_x), (1, half_y)):
        along = [corner[axis] for corner in corners]
        if along and min(along) < -limit:
            corners = cut(corners, [limit + value for value in along], crossing=_on_border(axis, -limit))
            along = [corner[axis] for corner in corners]
        if along and max(along) > limit:
            corners = cut(corners, [limit - value for value in along], crossing=_on_border(axis, limit))
    return corners


def _on_border(axis: int, value: float) -> Callable[[P, P, float], P]:
    """Return a function for the crossing with a side of the rectangle, exactly on it in spite of rounding."""
    across = 1 - axis

    def crossing(inner: P, outer: P, part: float) -> P:
        beside = inner[across] + part * (outer[across] - inner[across])
        place = (beside, value) if axis else (value, beside)
        return cast(P, place if len(inner) == len(place) else (*place, *between(inner[2:], outer[2:], part)))

    return crossing


# Convex polygons in plan (the x-y plane of W) for the published models, without corners that are noise.


Point2: TypeAlias = tuple[float, float]
Polygon: TypeAlias = tuple[Point2, ...]  # convex, counter-clockwise seen from above, with distinct corners

# [m] A corner closer than this to the line through its neighbours is noise.
STRAIGHT = 2e-5
# Share of the extent below which two corners coincide, or a corner lies on a line: the rounding of coordinates.
ROUNDING = 1e-12


def extent(points: Sequence[Point2]) -> float:
    """Return the larger side of the bounding rectangle of points [m]."""
    xs, ys = zip(*points, strict=True)
    width, height = max(xs) - min(xs), max(ys) - min(ys)
    return float(width if width > height else height)


def _doubled_area(a: Point2, b: Point2, c: Point2) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def straightened(polygon: Polygon) -> Polygon:
    """Remove the corners of a convex polygon that are noise; return an empty polygon if all are."""
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
    """Return the distance of a corner from the line through its neighbours, or from the nearest of these [m]."""
    nearest = min(dist(corner, a), dist(corner, b))
    length = dist(a, b)
    return min(nearest, abs(_doubled_area(a, b, corner)) / length) if length > STRAIGHT else nearest


def signed_distance(point: Point2, polygon: Polygon) -> float:
    """Return the distance of a point from the border of a polygon [m]: positive inside, negative outside."""
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
    """Return the centroid of a polygon; the mean of its corners if it has no area."""
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


# Convex polygons in plan, fast and without removal of flat corners.
#
# Corners run counter-clockwise seen from above. A result without area is empty.


def with_area(polygon: Polygon) -> Polygon:
    """Remove corners that coincide up to rounding; return an empty polygon if it has no area."""
    if len(polygon) < 3:  # noqa: PLR2004 -- a polygon has three
        return ()
    slack = ROUNDING * extent(polygon)
    distinct: list[Point2] = []
    for corner in polygon:
        if not distinct or abs(corner[0] - distinct[-1][0]) > slack or abs(corner[1] - distinct[-1][1]) > slack:
            distinct.append(corner)
    while (
        len(distinct) > 1
        and abs(distinct[0][0] - distinct[-1][0]) <= slack
        and abs(distinct[0][1] - distinct[-1][1]) <= slack
    ):
        distinct.pop()
    return tuple(distinct) if len(distinct) > 2 and _width(distinct) > slack else ()  # noqa: PLR2004


def _width(corners: Sequence[Point2]) -> float:
    """Return the largest distance of a corner from the line through the first corner and the farthest from it [m]."""
    ax, ay = corners[0]
    bx, by = max(corners, key=lambda corner: (corner[0] - ax) ** 2 + (corner[1] - ay) ** 2)
    dx, dy = bx - ax, by - ay
    length = hypot(dx, dy)
    return max(abs((x - ax) * dy - (y - ay) * dx) for x, y in corners) / length if length > 0.0 else 0.0


def depth(point: Point2, polygon: Polygon) -> float:
    """Return the distance of a point inside the nearest border line [m]; negative outside, -inf without a polygon."""
    px, py = point
    least = inf
    ax, ay = polygon[-1] if polygon else point
    for bx, by in polygon:
        dx, dy = bx - ax, by - ay
        length = hypot(dx, dy)
        if length > 0.0:  # rounding may have made two corners equal
            least = min(least, (dx * (py - ay) - dy * (px - ax)) / length)
        ax, ay = bx, by
    return least if least < inf else -inf


def holds(window: Polygon, points: Sequence[Point2], slack: float) -> bool:
    """Check that all points lie within `slack` [m] of a convex polygon, which is faster than clipping."""
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
    """Return the intersection of two convex polygons; empty if it has no area."""
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


def _between(start: Point2, end: Point2, part: float) -> Point2:
    return (start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]))


def inset(polygon: Polygon, distance: float) -> Polygon:
    """Return the part of a polygon at least a distance [m] inside its border; empty if it has no area."""
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
    """Clip a line between two points to a convex polygon, extended by `slack` [m]."""
    points = line if window else ()
    for (ax, ay), (bx, by) in pairwise((*window, *window[:1])):
        dx, dy = bx - ax, by - ay
        depths = [dx * (y - ay) - dy * (x - ax) for x, y in points]
        points = cut(points, depths, slack * max(abs(dx), abs(dy)), _between) if points else ()
    return tuple(dict.fromkeys(points))  # clipping treats a line as a polygon with two equal sides


def doubled_area(points: Sequence[Point2]) -> tuple[float, float]:
    """Return twice the area, positive if counter-clockwise [m2], and the extent of the points from the first [m]."""
    ox, oy = points[0]  # relative to a corner, as far from the origin of W the products lose digits
    area = reach = ax = ay = 0.0
    for x, y in points[1:]:
        bx, by = x - ox, y - oy
        area += ax * by - ay * bx
        reach = max(reach, abs(bx), abs(by))
        ax, ay = bx, by
    return area, reach


def barycentric(point: Point2, polygon: Polygon) -> list[float]:
    """Return non-negative weights of the corners whose weighted mean is the point, or a border point if it is outside.

    At most three are not 0: those of the triangle of the fan about the first corner that contains the point.
    """
    weights = [0.0] * len(polygon)
    (ax, ay), (px, py) = polygon[0], point
    best = -inf
    best_triangle: tuple[int, tuple[float, float, float]] = (1, (1.0, 0.0, 0.0))
    for index in range(1, len(polygon) - 1):
        (bx, by), (cx, cy) = polygon[index], polygon[index + 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area <= 0.0:
            continue
        of_b = ((px - ax) * (cy - ay) - (py - ay) * (cx - ax)) / area
        of_c = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / area
        least = min(of_b, of_c, 1.0 - of_b - of_c)
        if least > best:
            best, best_triangle = least, (index, (1.0 - of_b - of_c, of_b, of_c))
    index, parts = best_triangle
    parts = (max(parts[0], 0.0), max(parts[1], 0.0), max(parts[2], 0.0))
    total = sum(parts)
    weights[0], weights[index], weights[index + 1] = (part / total for part in parts)
    return weights


# Convex hull of points in plan, exact or up to rounding: monotone chain (Andrew, 1979).


def convex_hull(points: Iterable[Point2]) -> Polygon:
    """Return the exact corners of the convex hull; two points if all lie on a line, one if all coincide."""
    return _corners(points, exact=True)


def hull(points: Iterable[Point2]) -> Polygon:
    """Return the convex hull without corners that are rounding; empty if all points lie on a line up to rounding."""
    corners = _corners(points, exact=False)
    return corners if len(corners) > 2 else ()  # noqa: PLR2004 -- a polygon has three corners


def _corners(points: Iterable[Point2], exact: bool) -> Polygon:
    """Return the corners counter-clockwise; an exact hull has all extreme points, which a tolerance would drop."""
    ordered = sorted(set(points))
    if len(ordered) <= 2:  # noqa: PLR2004 -- a point or a line has no inside
        return tuple(ordered)
    slack = ROUNDING * extent(ordered)
    lower = _chain(ordered, slack, exact)
    ordered.reverse()
    upper = _chain(ordered, slack, exact)
    return (*lower[:-1], *upper[:-1])


def _chain(ordered: Sequence[Point2], slack: float, exact: bool) -> list[Point2]:
    chain = [ordered[0], ordered[1]]
    for point in ordered[2:]:
        x, y = point
        while len(chain) > 1:
            (ox, oy), (ax, ay) = chain[-2], chain[-1]
            dx, dy = x - ox, y - oy
            turn, unclear = (ax - ox) * dy - (ay - oy) * dx, slack * (abs(dx) + abs(dy))
            # Within this distance of the line, rounding may decide the side.
            if turn > unclear or (exact and turn >= -unclear and _turns_left(chain[-2], chain[-1], point)):
                break
            chain.pop()
        chain.append(point)
    return chain


def _turns_left(a: Point2, b: Point2, c: Point2) -> bool:
    """Check in exact arithmetic that a, b, c run counter-clockwise."""
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cy - ay) > (by - ay) * (cx - ax)
