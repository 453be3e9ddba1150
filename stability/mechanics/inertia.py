"""The inertia of a brick, whatever its shape, as it acts on vectors of W."""

from stability.geometry.rotations import inverse, rotate
from stability.model import Brick, Quaternion, Vec3
from stability.shapes.in_pose import principal_turn


def inertia_times(brick: Brick, orientation: Quaternion, vector_W: Vec3) -> Vec3:
    """The inertia of a brick about its centre of mass [kg m2], times a vector."""
    turn = principal_turn(brick.shape, orientation)
    return diagonal_times(brick.shape.moments(brick.mass), turn, vector_W)


def inertia_about_axes(brick: Brick, orientation: Quaternion) -> tuple[Vec3, Vec3, Vec3]:
    """The inertia of a brick about its centre of mass [kg m2], by rows, along the axes of W."""
    x, y, z = (inertia_times(brick, orientation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    # Rounding alone makes it other than symmetric.
    xy, xz, yz = 0.5 * (x[1] + y[0]), 0.5 * (x[2] + z[0]), 0.5 * (y[2] + z[1])
    return (x[0], xy, xz), (xy, y[1], yz), (xz, yz, z[2])


def diagonal_times(diagonal: Vec3, orientation: Quaternion, vector_W: Vec3) -> Vec3:
    """A tensor that is diagonal in axes which `orientation` turns to W, times a vector, in W."""
    a, b, c = rotate(inverse(orientation), vector_W)
    return rotate(orientation, (diagonal[0] * a, diagonal[1] * b, diagonal[2] * c))
