"""Where a box touches a plane: the corners of its lowest face that are within the tolerance of the plane."""

from stability.geometry.separating_axes import half_extent
from stability.geometry.touching import gap_bridged
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import Plane, Vec3
from stability.statics.contacts.solids import BoxSolid
from stability.statics.facts import UP


def points_on_plane(body: BoxSolid, plane: Plane, reach: float) -> tuple[Vec3, ...]:
    """The points of the plane that it touches, counter-clockwise seen from above the plane; none if it does not."""
    p_PB = subtract(body.pose.position_W, plane.point_W)
    height = dot(p_PB, plane.normal_W)
    gap = height - half_extent(body.axes, body.half, plane.normal_W)
    if gap > gap_bridged(reach, plane.normal_W[2]) or gap < -reach:
        return ()
    if body.plan is not None and plane.normal_W == UP:
        return _of_plan(body, body.pose.position_W[2] - height)
    return tuple(
        add_scaled(add_scaled(body.pose.position_W, 1.0, corner), -height - rise, plane.normal_W)
        for corner in _lowest_face(body, plane.normal_W)
        if (rise := dot(corner, plane.normal_W)) + height <= reach
    )


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
