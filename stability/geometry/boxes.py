"""Corners and heights of boxes in their places."""

from itertools import product

from stability.geometry.rotations import body_axes, rotate
from stability.model import Pose, Vec3


def box_corners(size: Vec3, pose: Pose) -> tuple[Vec3, ...]:
    """The eight corners of a box of full lengths `size`, in W [m]."""
    px, py, pz = pose.position_W
    corners = []
    for sx, sy, sz in product((-0.5, 0.5), repeat=3):
        x, y, z = rotate(pose.orientation, (sx * size[0], sy * size[1], sz * size[2]))
        corners.append((px + x, py + y, pz + z))
    return tuple(corners)


def box_top(size: Vec3, pose: Pose) -> float:
    """The height of the highest corner of a box [m]."""
    upward = (axis[2] for axis in body_axes(pose.orientation))
    return pose.position_W[2] + 0.5 * sum(length * abs(z) for length, z in zip(size, upward, strict=True))
