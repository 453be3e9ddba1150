"""Where a box with a level top carries another that lies on it: most pairs of most scenes, so this is the fast way.

Both are seen as rectangles in plan, in the frame of the lower one, so that what is far from the origin is as exact.
"""

from typing import TypeAlias

from stability.geometry.clipping import within_rectangle
from stability.geometry.plan import Polygon
from stability.geometry.touching import gap_bridged
from stability.model import Vec3
from stability.statics.contacts.solids import BoxSolid, PlanRectangle

PARALLEL = 1e-12  # sine below which sides are parallel: rounding

APART: tuple[Vec3, ...] = ()

# Of the upper rectangle in the frame of the lower one: its centre [m], and cosine and sine of its turn.
Place: TypeAlias = tuple[float, float, float, float]


def level_patch(lower: BoxSolid, upper: BoxSolid, reach: float, within: float) -> tuple[tuple[Vec3, ...], float] | None:
    """The corners of the patch on the top of `lower`, counter-clockwise from above, and the gap there [m].

    The corners are APART if they do not touch, because no gap so wide counts with this reach and `within` [m].

    None where that is not the whole story: the two touch at most within `reach` of an edge, or side by side.
    """
    if lower.plan is None or upper.plan is None:
        return None
    ux, uy, _, _ = lower.plan
    (px, py, pz), (qx, qy, qz) = lower.pose.position_W, upper.pose.position_W
    dx, dy = qx - px, qy - py
    x, y = dx * ux + dy * uy, dy * ux - dx * uy
    cosine, sine = ux * upper.plan[0] + uy * upper.plan[1], ux * upper.plan[1] - uy * upper.plan[0]
    place = (x, y, cosine, sine)
    overlap = _overlap(place, lower.plan, upper.plan)
    if overlap < -reach:
        return APART, 0.0
    if overlap <= reach:
        return None
    gap = qz - pz - lower.rise - upper.rise
    if gap > reach or gap < -reach or (gap > within and gap > gap_bridged(reach, 1.0, within)):
        return APART, gap
    top = pz + lower.rise
    corners = _common(place, lower.plan, upper.plan)
    return tuple([(px + u * ux - v * uy, py + u * uy + v * ux, top) for u, v in corners]), gap


def side_patch(a: BoxSolid, b: BoxSolid, reach: float, within: float) -> tuple[tuple[Vec3, ...], Vec3, float] | None:
    """The corners of the patch on the side of `a` that `b` stands beside, the normal of that side, and the gap [m].

    The corners are APART if the gap beside it is too wide for contact. None unless both are level, their sides are
    parallel, and they face each other well away from their edges.
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
    if half_u + other_u - abs(x) > half_v + other_v - abs(y):  # they touch across the second side: turn the frame
        ux, uy, x, y = -uy, ux, y, -x
        half_u, half_v, other_u, other_v = half_v, half_u, other_v, other_u
    gap = abs(x) - half_u - other_u
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


def _overlap(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> float:
    """How far two rectangles must be moved to be apart [m]; negative if they are."""
    x, y, cosine, sine = place
    (_, _, a, b), (_, _, c, d) = lower, upper
    along, across = abs(cosine), abs(sine)
    least = min(a + c * along + d * across - abs(x), b + c * across + d * along - abs(y))
    if across <= PARALLEL or along <= PARALLEL:
        return least
    s, t = x * cosine + y * sine, y * cosine - x * sine
    return min(least, c + a * along + b * across - abs(s), d + a * across + b * along - abs(t))


def _common(place: Place, lower: PlanRectangle, upper: PlanRectangle) -> Polygon:
    """What two rectangles have in common, in the frame of the lower one."""
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
