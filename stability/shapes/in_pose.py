"""Where a shape is in a pose: its corners, the box around it, its highest point, its principal axes in W.

It asks shapes only what every shape promises, so that it holds of all of them.
"""

from stability.geometry.rotations import inverse, multiply, rotate
from stability.geometry.vectors import add
from stability.model import IDENTITY, ConvexShape, Pose, Quaternion, Vec3

UP: Vec3 = (0.0, 0.0, 1.0)


def corners_W(shape: ConvexShape, pose: Pose) -> tuple[Vec3, ...]:
    """Its corners [m, in W], in the order of the shape."""
    return tuple(add(pose.position_W, rotate(pose.orientation, corner)) for corner in shape.corners)


def top_W(shape: ConvexShape, pose: Pose) -> float:
    """The height of its highest point [m, in W]."""
    return pose.position_W[2] + reach_W(shape, pose, UP)


def bounds_W(shape: ConvexShape, pose: Pose) -> tuple[Vec3, Vec3]:
    """The lowest and the highest corner of the upright box around it [m, in W]."""
    x, y, z = zip(*corners_W(shape, pose), strict=True)
    return (min(x), min(y), min(z)), (max(x), max(y), max(z))


def reach_W(shape: ConvexShape, pose: Pose, direction_W: Vec3) -> float:
    """How far it extends from its centre of mass along a unit direction [m]."""
    return shape.reach(rotate(inverse(pose.orientation), direction_W))


def principal_turn(shape: ConvexShape, orientation: Quaternion) -> Quaternion:
    """The turn from its principal axes of inertia to W, when this is the turn from its body axes."""
    axes = shape.principal_axes
    return orientation if axes == IDENTITY else multiply(orientation, axes)
