"""Where two boxes lie face on face: the corners of the overlap of the two faces, from poses and sizes alone.

Engines keep at most four contact points a pair, and where edges of the two faces coincide, as they do in every flush
stack, rounding decides which: PyBullet then reports points in the middle of an edge and drops corners. So the engine is
asked whether two bricks touch, and geometry where.
"""

from stability.geometry.clipping import within_rectangle
from stability.geometry.hulls import convex_hull
from stability.geometry.plan import Point2, straightened
from stability.geometry.polygons import doubled_area
from stability.geometry.rotations import body_axes
from stability.geometry.vectors import dot, subtract
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
    if abs(dot(axes_u[axis_u], axes_l[axis_l])) < PARALLEL:
        return ()
    first, second = (axis for axis in range(3) if axis != axis_l)
    top = 0.5 * sign * lower_size[axis_l]
    under_side = sorted(corners_W(Box(upper_size), upper), key=lambda corner: dot(corner, axes_l[axis_l]) * sign)[:4]
    in_face = [_coordinates(corner, lower, (axes_l[first], axes_l[second])) for corner in under_side]
    half = (0.5 * lower_size[first], 0.5 * lower_size[second])
    corners = straightened(tuple(within_rectangle(convex_hull(in_face), *half)))
    placed = [_in_world(corner, lower, (axes_l[first], axes_l[second], axes_l[axis_l]), top) for corner in corners]
    clockwise = bool(placed) and doubled_area([(x, y) for x, y, _ in placed])[0] < 0.0
    return tuple(placed[::-1] if clockwise else placed)


def _most_upright(pose: Pose) -> tuple[int, float]:
    """The body axis that is closest to the vertical, and its sign upwards."""
    heights = [axis[2] for axis in body_axes(pose.orientation)]
    axis = max(range(3), key=lambda index: abs(heights[index]))
    return axis, 1.0 if heights[axis] > 0.0 else -1.0


def _coordinates(point: Vec3, box: Pose, axes: tuple[Vec3, Vec3]) -> Point2:
    offset = subtract(point, box.position_W)
    return (dot(offset, axes[0]), dot(offset, axes[1]))


def _in_world(point: Point2, box: Pose, axes: tuple[Vec3, Vec3, Vec3], height: float) -> Vec3:
    x, y, z = (
        centre + point[0] * along + point[1] * across + height * up
        for centre, along, across, up in zip(box.position_W, *axes, strict=True)
    )
    return (x, y, z)
