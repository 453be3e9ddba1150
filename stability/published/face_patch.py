"""Where two boxes lie face on face: the corners of the overlap of the two faces, from poses and sizes alone.

Engines keep at most four contact points a pair, and where edges of the two faces coincide, as they do in every flush
stack, rounding decides which: PyBullet then reports points in the middle of an edge and drops corners. So the engine is
asked whether two bricks touch, and geometry where.
"""

from stability.geometry.plan import Point2, Polygon, convex_hull, straightened
from stability.geometry.rotations import body_axes
from stability.model import Pose, Vec3
from stability.shapes.box import Box
from stability.shapes.in_pose import corners_W

PARALLEL = 0.9994  # cosine of 2 deg: faces further apart in direction touch along an edge, not over an area


def face_patch(upper_size: Vec3, upper: Pose, lower_size: Vec3, lower: Pose) -> tuple[Vec3, ...]:
    """The corners of the overlap of the upper box's under side with the lower box's top [m, in W], in its plane.

    Counter-clockwise seen from above; empty if no two such faces are parallel, or if they do not overlap.
    """
    (axis_u, _), (axis_l, sign) = _most_upright(upper), _most_upright(lower)
    axes_u, axes_l = body_axes(upper.orientation), body_axes(lower.orientation)
    if abs(_dot(axes_u[axis_u], axes_l[axis_l])) < PARALLEL:
        return ()
    first, second = (axis for axis in range(3) if axis != axis_l)
    top = 0.5 * sign * lower_size[axis_l]
    under_side = sorted(corners_W(Box(upper_size), upper), key=lambda corner: _dot(corner, axes_l[axis_l]) * sign)[:4]
    in_face = [_coordinates(corner, lower, (axes_l[first], axes_l[second])) for corner in under_side]
    half = (0.5 * lower_size[first], 0.5 * lower_size[second])
    corners = straightened(clipped(convex_hull(in_face), half))
    placed = [_in_world(corner, lower, (axes_l[first], axes_l[second], axes_l[axis_l]), top) for corner in corners]
    return tuple(placed) if _is_counter_clockwise(placed) else tuple(placed[::-1])


def clipped(polygon: Polygon, half: Point2) -> Polygon:
    """Part of a convex polygon inside the rectangle of half lengths `half` about the origin (Sutherland-Hodgman)."""
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            polygon = _cut(polygon, axis, sign, half[axis])
    return polygon


def _cut(polygon: Polygon, axis: int, sign: float, limit: float) -> Polygon:
    kept: list[Point2] = []
    for here, there in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        inside, inside_next = limit - sign * here[axis], limit - sign * there[axis]
        if inside >= 0.0:
            kept.append(here)
        if inside * inside_next < 0.0:
            part = inside / (inside - inside_next)
            kept.append((here[0] + part * (there[0] - here[0]), here[1] + part * (there[1] - here[1])))
    return tuple(kept)


def _most_upright(pose: Pose) -> tuple[int, float]:
    """The body axis that is closest to the vertical, and its sign upwards."""
    heights = [axis[2] for axis in body_axes(pose.orientation)]
    axis = max(range(3), key=lambda index: abs(heights[index]))
    return axis, 1.0 if heights[axis] > 0.0 else -1.0


def _coordinates(point: Vec3, box: Pose, axes: tuple[Vec3, Vec3]) -> Point2:
    offset = (point[0] - box.position_W[0], point[1] - box.position_W[1], point[2] - box.position_W[2])
    return (_dot(offset, axes[0]), _dot(offset, axes[1]))


def _in_world(point: Point2, box: Pose, axes: tuple[Vec3, Vec3, Vec3], height: float) -> Vec3:
    x, y, z = (
        centre + point[0] * along + point[1] * across + height * up
        for centre, along, across, up in zip(box.position_W, *axes, strict=True)
    )
    return (x, y, z)


def _is_counter_clockwise(corners: list[Vec3]) -> bool:
    area = 0.0
    for (ax, ay, _), (bx, by, _) in zip(corners, corners[1:] + corners[:1], strict=True):
        area += ax * by - ay * bx
    return area >= 0.0


def _dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
