"""Gaps of two boxes, and the fast path for boxes that stand level, which most do."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot
from typing import TypeAlias

from stability.contacts.bodies import BoxSolid, PlanRectangle
from stability.contacts.convex_contacts import NEARLY_PARALLEL, Closeness, FacePair, PointsOnPlane, SeparatingAxis
from stability.geometry.box_distance import (
    NO_GAP,
    Matrix,
    along_product,
    coordinates,
    cosines,
    edge_products,
    face_gaps,
    gap_bridged,
    transposed,
)
from stability.geometry.polygons import Polygon, within_rectangle
from stability.geometry.vectors import cross, scale, subtract
from stability.model import Plane, Vec3
from stability.problem import UP

# Gaps of two boxes along their separating axes.


@dataclass(frozen=True, slots=True, eq=False)
class BoxCloseness(Closeness):
    """Gaps of two boxes that touch or overlap; faces and edges are numbered by their axes."""

    turn: Matrix  # cosines between the axes of a (rows) and b

    def parallel_faces(self) -> Sequence[FacePair]:
        pairs = []
        for i, row in enumerate(_sines(self.turn)):
            for j, sine in enumerate(row):
                if sine <= NEARLY_PARALLEL:
                    of_a, of_b = self.face_axes[i], self.face_axes[3 + j]
                    pairs.append(FacePair(max(of_a.gap, of_b.gap), i, j, True, sine, of_a.normal_AB_W))
        return pairs


def closeness(a: BoxSolid, b: BoxSolid, reach: float) -> BoxCloseness | None:
    """Compute the gaps of two boxes; None if their gap or overlap exceeds `reach` [m]."""
    p_AB = subtract(b.pose.position_W, a.pose.position_W)
    turn = cosines(a.axes, b.axes)
    along_a, along_b = coordinates(p_AB, a.axes), coordinates(p_AB, b.axes)
    gaps_a = face_gaps(along_a, a.half, b.half, turn)
    gaps_b = face_gaps(along_b, b.half, a.half, transposed(turn))
    largest = max(gaps_a + gaps_b)
    if largest > reach:
        return None
    products = []
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        products.append(((abs(along) - extent) / length, 1.0 if along >= 0.0 else -1.0, i, j, length))
    largest = max([largest, *(product[0] for product in products)])
    if largest > reach or largest < -reach:
        return None
    faces = [SeparatingAxis(gaps_a[i], _towards(along_a[i], a.axes[i]), i, None) for i in range(3)]
    faces += [SeparatingAxis(gaps_b[j], _towards(along_b[j], b.axes[j]), None, j) for j in range(3)]
    edges = [
        SeparatingAxis(gap, scale(sign / length, cross(a.axes[i], b.axes[j])), i, j, length)
        for gap, sign, i, j, length in products
        if gap >= largest - 2.0 * reach
    ]
    return BoxCloseness(a, b, p_AB, largest, faces, edges, turn)


def _sines(turn: Matrix) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = turn
    return (
        (hypot(d, g), hypot(e, h), hypot(f, i)),
        (hypot(a, g), hypot(b, h), hypot(c, i)),
        (hypot(a, d), hypot(b, e), hypot(c, f)),
    )


def _towards(along: float, axis: Vec3) -> Vec3:
    return axis if along >= 0.0 else scale(-1.0, axis)


# Contact of two level boxes. Most pairs are of this kind, so this code is fast.
#
# Both are rectangles in plan, in the frame of the lower one, so that precision does not depend on the position in W.


PARALLEL = 1e-12  # sine of the angle below which sides are parallel: rounding

FLUSH = 0.5 * NO_GAP  # share of the reach up to which level boxes beside each other count as flush in any frame

# Corners of the patch of two boxes in order, its normal, and the gap [m]; no corners if the gap is too large.
BoxPatch: TypeAlias = tuple[tuple[Vec3, ...], Vec3, float]
APART: tuple[Vec3, ...] = ()

# Pose of the upper rectangle in the frame of the lower one: centre [m], cosine and sine of its rotation.
Place: TypeAlias = tuple[float, float, float, float]


def level_patch(lower: BoxSolid, upper: BoxSolid, reach: float, within: float) -> BoxPatch | None:
    """Return the patch on the top of `lower`, with its corners counter-clockwise from above.

    The corners are APART if the gap is too large for a contact with this reach and `within` [m].

    None if this does not decide the contact: if the boxes touch only within `reach` of an edge, or side by side.
    """
    if lower.plan is None or upper.plan is None:
        return None
    ux, uy, _, _ = lower.plan
    (px, py, pz), (qx, qy, qz) = lower.pose.position_W, upper.pose.position_W
    dx, dy = qx - px, qy - py
    x, y = dx * ux + dy * uy, dy * ux - dx * uy
    cosine, sine = ux * upper.plan[0] + uy * upper.plan[1], ux * upper.plan[1] - uy * upper.plan[0]
    place = (x, y, cosine, sine)
    overlap = _level_overlap(place, lower.plan, upper.plan)
    if overlap < -reach:
        return APART, UP, 0.0
    if overlap <= reach:
        return None
    gap = qz - pz - lower.rise - upper.rise
    if gap > reach or gap < -reach or (gap > within and gap > gap_bridged(reach, 1.0, within)):
        return APART, UP, gap
    top = pz + lower.rise
    corners = _common(place, lower.plan, upper.plan)
    return tuple([(px + u * ux - v * uy, py + u * uy + v * ux, top) for u, v in corners]), UP, gap


def side_patch(a: BoxSolid, b: BoxSolid, reach: float, within: float) -> BoxPatch | None:
    """Return the patch on the side of `a` that faces `b`.

    The corners are APART if the gap is too large for a contact, or if only edges touch. None unless both boxes are
    level, their sides are parallel, and they face each other beyond the reach of their edges.
    """
    if a.plan is None or b.plan is None:
        return None
    (ux, uy, half_u, half_v), (px, py, pz), (qx, qy, qz) = a.plan, a.pose.position_W, b.pose.position_W
    vx, vy = b.plan[0], b.plan[1]
    cosine, sine = ux * vx + uy * vy, ux * vy - uy * vx
    if not (-PARALLEL <= sine <= PARALLEL or -PARALLEL <= cosine <= PARALLEL):
        return None
    other_u, other_v = (b.plan[2], b.plan[3]) if -PARALLEL <= sine <= PARALLEL else (b.plan[3], b.plan[2])
    dx, dy, dz = qx - px, qy - py, qz - pz
    x, y = dx * ux + dy * uy, dy * ux - dx * uy
    if half_u + other_u - abs(x) > half_v + other_v - abs(y):  # contact on the second side: rotate the frame
        ux, uy, x, y = -uy, ux, y, -x
        half_u, half_v, other_u, other_v = half_v, half_u, other_v, other_u
    gap = abs(x) - half_u - other_u
    flush = -FLUSH * reach
    if gap >= flush and (abs(y) - half_v - other_v >= flush or abs(dz) - a.rise - b.rise >= flush):
        return APART, (0.0, 0.0, 0.0), gap  # an edge beside an edge transfers no force
    if gap < -reach or half_v + other_v - abs(y) <= reach:
        return None
    if a.rise + b.rise - abs(dz) <= reach:
        return None
    sign = 1.0 if x > 0.0 else -1.0
    if gap > gap_bridged(reach, 0.0, within):
        return APART, (sign * ux, sign * uy, 0.0), gap
    left, right = max(-half_v, sign * y - other_v), min(half_v, sign * y + other_v)
    low, high = max(-a.rise, dz - b.rise), min(a.rise, dz + b.rise)
    ux, uy = sign * ux, sign * uy
    around = ((left, low), (right, low), (right, high), (left, high))
    points = tuple([(px + half_u * ux - v * uy, py + half_u * uy + v * ux, pz + w) for v, w in around])
    return points, (ux, uy, 0.0), gap


def _level_overlap(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> float:
    """Return the penetration depth of two rectangles [m]; negative if they are apart."""
    x, y, cosine, sine = place
    (_, _, a, b), (_, _, c, d) = lower, upper
    along, across = abs(cosine), abs(sine)
    least = min(a + c * along + d * across - abs(x), b + c * across + d * along - abs(y))
    if across <= PARALLEL or along <= PARALLEL:
        return least
    s, t = x * cosine + y * sine, y * cosine - x * sine
    return min(least, c + a * along + b * across - abs(s), d + a * across + b * along - abs(t))


def _common(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> Polygon:
    """Return the intersection of two rectangles, in the frame of the lower one."""
    x, y, cosine, sine = place
    (_, _, a, b), (_, _, c, d) = lower, upper
    if -PARALLEL <= sine <= PARALLEL or -PARALLEL <= cosine <= PARALLEL:
        if -PARALLEL <= cosine <= PARALLEL:
            c, d = d, c
        left, right = max(-a, x - c), min(a, x + c)
        near, far = max(-b, y - d), min(b, y + d)
        return ((left, near), (right, near), (right, far), (left, far))
    p, q, r, s = c * cosine, c * sine, d * sine, d * cosine
    turned = ((x - p + r, y - q - s), (x + p + r, y + q - s), (x + p - r, y + q + s), (x - p - r, y - q + s))
    return tuple(within_rectangle(turned, a, b))


def points_below(body: BoxSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane | None:
    """Return what `points_on_plane` does for a level box on a level plane; None for others."""
    if body.plan is None or plane.normal_W != UP:
        return None
    ux, uy, a, b = body.plan
    x, y, z = body.pose.position_W
    height = z - plane.point_W[2]
    gap = height - body.rise
    if gap > widest or gap < -reach:
        return (), ()
    px, py, qx, qy, ground = a * ux, a * uy, -b * uy, b * ux, z - height
    points = (
        (x - px - qx, y - py - qy, ground),
        (x + px - qx, y + py - qy, ground),
        (x + px + qx, y + py + qy, ground),
        (x - px + qx, y - py + qy, ground),
    )
    return points, (gap,) * len(points)
