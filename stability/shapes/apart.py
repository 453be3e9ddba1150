"""How far apart two shapes are, and a shape and a plane. The one place that knows which shapes can be compared."""

from stability.geometry.separation import Block, Separation, block, blocks_apart
from stability.geometry.vectors import dot, subtract
from stability.model import ConvexShape, Plane, Pose
from stability.shapes.box import as_box
from stability.shapes.in_pose import corners_W


def solid_block(shape: ConvexShape, pose: Pose) -> Block:
    """A shape in its place, worked out for comparison with many others. Raises UnknownShapeError."""
    return block(as_box(shape, "what tells how far apart two bodies are").size, pose)


def apart(a: ConvexShape, pose_a: Pose, b: ConvexShape, pose_b: Pose) -> Separation:
    """The separation of shape a from shape b. Raises UnknownShapeError."""
    return blocks_apart(solid_block(a, pose_a), solid_block(b, pose_b))


def apart_from_plane(shape: ConvexShape, pose: Pose, plane: Plane) -> Separation:
    """The separation of a shape from a half-space: exact, of every shape."""
    corners = corners_W(shape, pose)
    return Separation(min(dot(subtract(c, plane.point_W), plane.normal_W) for c in corners), plane.normal_W)
