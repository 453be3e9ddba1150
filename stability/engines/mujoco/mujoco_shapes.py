"""The shapes of bricks in a model of MuJoCo: boxes, and hulls of whatever else is convex."""

from collections.abc import Iterable, Mapping, Sequence

from stability.engines.mujoco.mujoco_binding import mujoco
from stability.geometry.vectors import scale
from stability.mechanics.rigid_group import grouped
from stability.model import Brick, ConvexShape, Pose, Quaternion
from stability.shapes.apart import middle_pose
from stability.shapes.off_centre_box import box_of


def add_hulls(spec: mujoco.MjSpec, shapes: Iterable[ConvexShape]) -> dict[ConvexShape, str]:
    """The names of the meshes of all that are no boxes, which are added once each."""
    found: dict[ConvexShape, str] = {}
    for shape in shapes:
        if shape not in found and box_of(shape) is None:
            found[shape] = f"hull {len(found) + 1}"
            spec.add_mesh(name=found[shape], uservert=[part for corner in shape.corners for part in corner])
    return found


def geometry(shape: ConvexShape, place: Pose, hulls: Mapping[ConvexShape, str]) -> Mapping[str, object]:
    """What a shape is in its place in a body."""
    boxed = box_of(shape)
    if boxed is None:
        kind, named = mujoco.mjtGeom.mjGEOM_MESH, {"meshname": hulls[shape]}
        return {"type": kind, **named, "pos": place.position_W, "quat": as_wxyz(place.orientation)}
    box, middle = boxed
    at = middle_pose(middle, place) if any(middle) else place
    return {
        "type": mujoco.mjtGeom.mjGEOM_BOX,
        "size": scale(0.5, box.size),
        "pos": at.position_W,
        "quat": as_wxyz(place.orientation),
    }


def weigh(body: mujoco.MjsBody, bricks: Sequence[tuple[Brick, Pose]], times: float) -> None:
    """Say where the mass of a body is and how it is spread; from shapes, MuJoCo would take it to be filled evenly.

    With so many times the mass of its bricks.
    """
    group = grouped(bricks)
    body.explicitinertial = True
    body.mass = times * group.mass
    body.ipos, body.iquat = group.pose.position_W, as_wxyz(group.pose.orientation)
    body.inertia = scale(times, group.moments)


def as_wxyz(orientation: Quaternion) -> Quaternion:
    """A quaternion in MuJoCo's order."""
    x, y, z, w = orientation
    return (w, x, y, z)
