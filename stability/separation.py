"""How far apart are two boxes, or a box and a plane, and along which direction?

Separating axes of two oriented boxes (Gottschalk, Lin and Manocha, 1996): the largest gap over the 3 + 3 face normals
and 9 products of edges. Where the boxes overlap, it is minus the shortest way out. Where they are apart, it is a lower
bound of the distance, exact when a face is closest.
"""

from dataclasses import dataclass
from itertools import product
from math import inf, sqrt

from stability.geometry import body_axes, box_corners, turned
from stability.model import HalfSpace, Plane, Pose, Vec3

PARALLEL = 1e-9  # sine below which two edges give no direction of their own


@dataclass(frozen=True, slots=True)
class Separation:
    """The gap between two bodies, and the way to widen it."""

    gap: float  # [m], negative where they overlap
    normal_BA_W: Vec3  # unit, from the second body towards the first


def boxes_apart(size_a: Vec3, pose_a: Pose, size_b: Vec3, pose_b: Pose) -> Separation:
    """The separation of box a from box b."""
    axes_a, axes_b = body_axes(pose_a.orientation), body_axes(pose_b.orientation)
    p_BA = _minus(pose_a.position_W, pose_b.position_W)
    best = Separation(-inf, (0.0, 0.0, 1.0))
    for axis in (*axes_a, *axes_b, *_edge_products(axes_a, axes_b)):
        along = _dot(p_BA, axis)
        reach = _half_extent(size_a, axes_a, axis) + _half_extent(size_b, axes_b, axis)
        gap = abs(along) - reach
        # Faces come first and win ties: an edge product is never a better normal where a face does.
        if gap > best.gap + PARALLEL:
            best = Separation(gap, axis if along >= 0.0 else (-axis[0], -axis[1], -axis[2]))
    return best


def box_above_plane(size: Vec3, pose: Pose, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    gaps = (_dot(_minus(corner, plane.point_W), plane.normal_W) for corner in box_corners(size, pose))
    return Separation(min(gaps), plane.normal_W)


def in_world(shape: HalfSpace, pose: Pose) -> Plane:
    """A half-space as the plane that bounds it in W; it knows of no friction."""
    return Plane("", pose.position_W, turned(pose.orientation, shape.normal), friction=0.0)


def _edge_products(axes_a: tuple[Vec3, ...], axes_b: tuple[Vec3, ...]) -> list[Vec3]:
    found = []
    for (ax, ay, az), (bx, by, bz) in product(axes_a, axes_b):
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        length = sqrt(x * x + y * y + z * z)
        if length > PARALLEL:
            found.append((x / length, y / length, z / length))
    return found


def _half_extent(size: Vec3, axes: tuple[Vec3, ...], direction: Vec3) -> float:
    return 0.5 * sum(length * abs(_dot(axis, direction)) for length, axis in zip(size, axes, strict=True))


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
