"""Where a brick is let go that falls onto another: straight above its middle, by as much as it is to fall."""

from math import atan2, sqrt

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add_scaled
from stability.model import Pose, Quaternion
from stability.shapes.apart import in_place, meeting
from stackdsl.compiling.fitting import OVERLAP
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import (
    MissError,
    Scene,
    Standing,
    aimed_at,
    keep_out_of_planes,
    middle_of,
    on_the_way,
)
from stackdsl.compiling.site import turned_pose
from stackdsl.compiling.written_bricks import about_axes, about_z
from stackdsl.language.impacts.drop import Drop
from stackdsl.timeline import Arrival, Placement


@actions_of.register
def dropped(drop: Drop, scene: Scene) -> tuple[Placement, ...]:
    """The brick where it is let go. Raises MissError."""
    brick = scene.missile
    assert brick is not None  # the kind says that it has one
    below = aimed_at(drop.onto, scene, "onto")
    orientation = _along(below[0]) if drop.rotate is None else about_axes(drop.rotate)
    down = rotate(inverse(scene.tilt), (0.0, 0.0, -1.0))  # in the frame of the scene
    middle = middle_of(below)
    falling = in_place(brick.shape, Pose(middle, orientation))
    ways = [(other, meeting(falling, other.shape, down, OVERLAP)) for other in on_the_way(falling, down, scene)]
    met = {other.name: way for other, way in ways if way is not None}
    # From the middle of what is below; less than zero is above.
    lands = min((met[other.name][0] for other in below if other.name in met), default=None)
    if lands is None:
        hint = "turn it by `rotate`, or name a brick"
        raise MissError("onto", "SD207", f"brick '{brick.id}' falls past what it is dropped onto", hint)
    for name, (enters, leaves) in met.items():
        if enters < lands - OVERLAP and leaves > lands - drop.height + OVERLAP:
            hint = f"drop it onto '{name}', from lower down, or turned by `rotate`"
            raise MissError("onto", "SD207", f"brick '{name}' is in the way of brick '{brick.id}'", hint)
    start = Pose(add_scaled(middle, lands - drop.height, down), orientation)
    keep_out_of_planes(brick, start, scene, "height")
    pose, flight = turned_pose(start, scene.tilt), sqrt(2.0 * drop.height / scene.gravity)
    return (Placement(scene.moment.time, brick, 0, pose, Arrival.DROPPED, flight=flight),)


def _along(brick: Standing) -> Quaternion:
    """Flat, with its length over that of a brick; along x over one that stands on end."""
    x, y, _ = brick.shape.axes_W[0]
    return about_z(atan2(y, x) if abs(x) + abs(y) > OVERLAP else 0.0)
