"""Where a box touches a plane: the corners of its lowest face whose gaps to the plane count as contact."""

from typing import TypeAlias

from stability.geometry.separating_axes import half_extent
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import Plane, Vec3
from stability.statics.contacts.solids import BoxSolid
from stability.statics.facts import UP

# The points of a plane that a body touches, and how high the body is above each [m].
PointsOnPlane: TypeAlias = tuple[tuple[Vec3, ...], tuple[float, ...]]


def points_on_plane(body: BoxSolid, plane: Plane, reach: float, widest: float) -> PointsOnPlane:
    """The points of the plane that it touches, counter-clockwise seen from above the plane; none if it does not.

    What is deeper in it than `reach` [m] does not touch, nor what is further from it than `widest` [m].
    """
    p_PB = subtract(body.pose.position_W, plane.point_W)
    height = dot(p_PB, plane.normal_W)
    gap = height - half_extent(body.axes, body.half, plane.normal_W)
    if gap > widest or gap < -reach:
        return (), ()
    if body.plan is not None and plane.normal_W == UP:
        points = _of_plan(body, body.pose.position_W[2] - height)
        return points, (gap,) * len(points)
    corners = [(corner, dot(corner, plane.normal_W) + height) for corner in _lowest_face(body, plane.normal_W)]
    low = [(corner, above) for corner, above in corners if above <= widest]
    at = body.pose.position_W
    points = tuple(add_scaled(add_scaled(at, 1.0, corner), -above, plane.normal_W) for corner, above in low)
    return points, tuple(above for _, above in low)


def _of_plan(body: BoxSolid, ground: float) -> tuple[Vec3, ...]:
    if body.plan is None:
        return ()
    ux, uy, a, b = body.plan
    x, y, _ = body.pose.position_W
    px, py, qx, qy = a * ux, a * uy, -b * uy, b * ux
    return (
        (x - px - qx, y - py - qy, ground),
        (x + px - qx, y + py - qy, ground),
        (x + px + qx, y + py + qy, ground),
        (x - px + qx, y - py + qy, ground),
    )


def _lowest_face(body: BoxSolid, up: Vec3) -> list[Vec3]:
    """Its corners, from the centre, in W [m]; of all faces, the one that leans least holds the lowest edge too."""
    rises = [half * abs(dot(axis, up)) for half, axis in zip(body.half, body.axes, strict=True)]
    steepest = max(range(3), key=lambda index: rises[index])
    first, second = (steepest + 1) % 3, (steepest + 2) % 3
    down = -1.0 if dot(body.axes[steepest], up) > 0.0 else 1.0
    centre = scale(down * body.half[steepest], body.axes[steepest])
    u, v = scale(body.half[first], body.axes[first]), scale(body.half[second], body.axes[second])
    # Seen from above the plane, the second side is to the left of the first where the third axis points up.
    around = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
    corners = [add_scaled(add_scaled(centre, s, u), t, v) for s, t in around]
    return corners if down < 0.0 else corners[::-1]
