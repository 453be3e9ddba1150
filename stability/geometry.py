"""Convex polygons in plan (the x-y plane of W) and turns in space: the little geometry that the models stand on."""

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import pairwise, product
from math import atan2, dist, hypot, inf
from typing import TypeAlias

from stability.model import Pose, Quaternion, Vec3

Point2: TypeAlias = tuple[float, float]
Polygon: TypeAlias = tuple[Point2, ...]  # convex, counter-clockwise seen from above, no corner twice

# [m] A corner that sticks out less than this from the line of its neighbours is rounding or noise, not shape.
STRAIGHT = 2e-5
ROUNDING = 1e-14  # share of a squared length below which rounding may decide on which side of a line a point lies


def turned(orientation: Quaternion, vector: Vec3) -> Vec3:
    """`vector` after the turn `orientation`."""
    x, y, z, w = orientation
    a, b, c = vector
    # v + 2 u x (u x v + w v), with u the vector part
    p = y * c - z * b + w * a
    q = z * a - x * c + w * b
    r = x * b - y * a + w * c
    return (a + 2.0 * (y * r - z * q), b + 2.0 * (z * p - x * r), c + 2.0 * (x * q - y * p))


def composed(second: Quaternion, first: Quaternion) -> Quaternion:
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
    x, y, z, w = one.orientation
    a, b, c, part = composed(other.orientation, (-x, -y, -z, w))
    # Not by the cosine, which cannot tell a turn of 1e-8 from none.
    return 2.0 * atan2(hypot(a, b, c), abs(part))


def lean_between(one: Pose, other: Pose) -> float:
    """The angle by which what was upright in one pose leans in another [rad]: a turn about the vertical is none."""
    x, y, z, w = one.orientation
    a, b, c = turned(other.orientation, turned((-x, -y, -z, w), (0.0, 0.0, 1.0)))
    return atan2(hypot(a, b), c)


def body_axes(orientation: Quaternion) -> tuple[Vec3, Vec3, Vec3]:
    """The three body axes in W."""
    return (
        turned(orientation, (1.0, 0.0, 0.0)),
        turned(orientation, (0.0, 1.0, 0.0)),
        turned(orientation, (0.0, 0.0, 1.0)),
    )


def box_corners(size: Vec3, pose: Pose) -> tuple[Vec3, ...]:
    """The eight corners of a box of full lengths `size`, in W [m]."""
    px, py, pz = pose.position_W
    corners = []
    for sx, sy, sz in product((-0.5, 0.5), repeat=3):
        x, y, z = turned(pose.orientation, (sx * size[0], sy * size[1], sz * size[2]))
        corners.append((px + x, py + y, pz + z))
    return tuple(corners)


def box_top(size: Vec3, pose: Pose) -> float:
    """The height of the highest corner of a box [m]."""
    upward = (axis[2] for axis in body_axes(pose.orientation))
    return pose.position_W[2] + 0.5 * sum(length * abs(z) for length, z in zip(size, upward, strict=True))


def convex_hull(points: Iterable[Point2]) -> Polygon:
    """The corners of the convex hull, exactly; two points if all lie on a line, one if all coincide."""
    ordered = sorted(set(points))
    if len(ordered) <= 2:  # noqa: PLR2004 -- a point or a line has no inside
        return tuple(ordered)
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return tuple(lower[:-1] + upper[:-1])


def _chain(ordered: Sequence[Point2]) -> list[Point2]:
    chain: list[Point2] = []
    for point in ordered:
        while len(chain) > 1 and not _turns_left(chain[-2], chain[-1], point):
            chain.pop()
        chain.append(point)
    return chain


def _turns_left(a: Point2, b: Point2, c: Point2) -> bool:
    """Whether a, b, c run counter-clockwise. Exact: a tolerance here, or rounding, would drop extreme corners."""
    area = _doubled_area(a, b, c)
    if abs(area) > ROUNDING * (dist(a, b) + dist(b, c)) ** 2:
        return area > 0.0
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cy - ay) > (by - ay) * (cx - ax)


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
