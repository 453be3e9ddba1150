"""Contact areas as published: the convex hull, in plan, of the points at which a brick rests.

Source: the stack-stability thesis, section 3.3.3. One area per support, and one over all supports (the main contact).
Two points are widened sideways into a thin quad, one becomes a small diamond, because a line or a point has no inside.
The source takes the engine's points, orders them by gift wrapping, and spans a mesh over them that rays can meet. What
is done here instead decides the same (docs/decisions/0030).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from math import dist, hypot

from stability.geometry.hulls import convex_hull
from stability.geometry.plan import STRAIGHT, Point2, Polygon, centroid, straightened
from stability.model import BodyId, Vec3

# [m] "a short distance" in the source. A tenth of a plank's edge is felt by hand, half a millimetre is not.
WIDENING = 5e-4


@dataclass(frozen=True, slots=True)
class ContactArea:
    """Where a brick rests on one support."""

    on: BodyId
    points_W: tuple[Vec3, ...]  # contact points [m], as they were given
    polygon: Polygon  # their hull in plan, widened if it has no area
    centre: Point2  # of the polygon [m]


def contact_area(on: BodyId, points_W: Sequence[Vec3]) -> ContactArea:
    """The area of contact with one support; at least one point is needed."""
    polygon = plan_hull(points_W)
    return ContactArea(on, tuple(points_W), polygon, centroid(polygon))


def main_contact(areas: Iterable[ContactArea]) -> Polygon:
    """The hull over all supports: what the brick stands on as a whole."""
    return plan_hull([point for area in areas for point in area.points_W])


def plan_hull(points_W: Sequence[Vec3]) -> Polygon:
    """The convex hull seen from above, made two-dimensional where the points are one or on a line."""
    hull = convex_hull((x, y) for x, y, _ in points_W)
    polygon = straightened(hull)
    if polygon:
        return polygon
    one, other = max(product(hull, repeat=2), key=lambda ends: dist(*ends))
    return _thin_quad(one, other) if dist(one, other) > STRAIGHT else _diamond(one)


def _diamond(centre: Point2) -> Polygon:
    x, y = centre
    return ((x - WIDENING, y), (x, y - WIDENING), (x + WIDENING, y), (x, y + WIDENING))


def _thin_quad(a: Point2, b: Point2) -> Polygon:
    dx, dy = b[0] - a[0], b[1] - a[1]
    scale = WIDENING / hypot(dx, dy)
    sx, sy = -dy * scale, dx * scale
    return convex_hull(((a[0] + sx, a[1] + sy), (a[0] - sx, a[1] - sy), (b[0] + sx, b[1] + sy), (b[0] - sx, b[1] - sy)))
