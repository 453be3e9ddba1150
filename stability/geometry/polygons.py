"""Convex polygons in plan: areas, clipping, hulls."""

from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise
from math import dist, hypot, inf
from typing import TypeAlias, TypeVar, cast

# Cutting convex polygons, lines and cones by half-planes: the one clipper (Sutherland and Hodgman, 1974).


P = TypeVar("P", bound=tuple[float, ...])  # a point or a direction, of any dimension


def between(one: P, other: P, part: float) -> P:
    """The point on the line from one to the other, at this part of it."""
    return cast(P, tuple([a + part * (b - a) for a, b in zip(one, other, strict=True)]))


def cut(
    corners: Sequence[P],
    depths: Sequence[float],
    slack: float = 0.0,
    crossing: Callable[[P, P, float], P] = between,
) -> list[P]:
    """The part of a convex polygon on the inner side of a line; two corners, or one, count as a polygon.

    `depths` says how far inside each corner is. What is no further outside than `slack` lies on the line, and stays.
    Where the border crosses the line, `crossing` makes the corner, always from the inner one to the outer one, so that
    two polygons that share a side get the same.
    """
    kept: list[P] = []
    least = -slack
    before, depth_before = corners[-1], depths[-1]
    for corner, depth in zip(corners, depths, strict=True):
        if depth >= least:
            if depth > slack and depth_before < least:
                kept.append(crossing(corner, before, depth / (depth - depth_before)))
            kept.append(corner)
        elif depth_before > slack:
            kept.append(crossing(before, corner, depth_before / (depth_before - depth)))
        before, depth_before = corner, depth
    return kept


def within_rectangle(corners: Sequence[P], half_x: float, half_y: float) -> Sequence[P]:
    """The part whose first two coordinates are within these limits: of a polygon, of a line, or of a point."""
    for axis, limit in ((0, half_x), (1, half_y)):
        along = [corner[axis] for corner in corners]
        if along and min(along) < -limit:
            corners = cut(corners, [limit + each for each in along], crossing=_on_border(axis, -limit))
            along = [corner[axis] for corner in corners]
        if along and max(along) > limit:
            corners = cut(corners, [limit - each for each in along], crossing=_on_border(axis, limit))
    return corners


def _on_border(axis: int, value: float) -> Callable[[P, P, float], P]:
    """The crossing with a side of the rectangle: exactly on it, whatever rounding says."""
    across = 1 - axis

    def crossing(inner: P, outer: P, part: float) -> P:
        beside = inner[across] + part * (outer[across] - inner[across])
        place = (beside, value) if axis else (value, beside)
        return cast(P, place if len(inner) == len(place) else (*place, *between(inner[2:], outer[2:], part)))

    return crossing


# Convex polygons in plan (the x-y plane of W), as the published models use them: corners within noise are dropped.


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


# Convex polygons in plan, fast and unrounded: no corner is dropped because it sticks out little.
#
# Corners run counter-clockwise seen from above. What has no area is no polygon and comes back empty.


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


# The convex hull of points in plan: the one algorithm, exact or to rounding. Monotone chain (Andrew, 1979).


def convex_hull(points: Iterable[Point2]) -> Polygon:
    """The corners of the convex hull, exactly; two points if all lie on a line, one if all coincide."""
    return _corners(points, exact=True)


def hull(points: Iterable[Point2]) -> Polygon:
    """The convex hull without corners that stick out by rounding only; empty if all lie on a line to rounding."""
    corners = _corners(points, exact=False)
    return corners if len(corners) > 2 else ()  # noqa: PLR2004 -- a polygon has three corners


def _corners(points: Iterable[Point2], exact: bool) -> Polygon:
    """Counter-clockwise. Exact, none is missing, however little it sticks out: a tolerance would drop extreme ones."""
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
            # So close to the line, rounding may decide on which side of it a corner lies.
            if turn > unclear or (exact and turn >= -unclear and _turns_left(chain[-2], chain[-1], point)):
                break
            chain.pop()
        chain.append(point)
    return chain


def _turns_left(a: Point2, b: Point2, c: Point2) -> bool:
    """Whether a, b, c run counter-clockwise, in exact arithmetic."""
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cy - ay) > (by - ay) * (cx - ax)
