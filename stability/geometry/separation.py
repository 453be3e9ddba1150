"""How far apart are two boxes, or a box and a plane, and along which direction?

Separating axes of two oriented boxes (Gottschalk, Lin and Manocha, 1996): the largest gap over the 3 + 3 face normals
and 9 products of edges. Where the boxes overlap, it is minus the shortest way out. Where they are apart, it is a lower
bound of the distance, exact when a face is closest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import inf, sqrt

from stability.geometry.rotations import body_axes, rotate
from stability.model import HalfSpace, Plane, Pose, Vec3

PARALLEL = 1e-9  # sine below which two edges give no direction of their own


@dataclass(frozen=True, slots=True)
class Separation:
    """The gap between two bodies, and the way to widen it."""

    gap: float  # [m], negative where they overlap
    normal_BA_W: Vec3  # unit, from the second body towards the first


@dataclass(frozen=True, slots=True)
class Block:
    """A box with what a comparison with many others needs of it."""

    p_WC: Vec3  # its centre [m]
    axes_W: tuple[Vec3, Vec3, Vec3]
    half_edges_W: tuple[Vec3, Vec3, Vec3]  # half of each edge, along its axis [m]
    reach: Vec3  # half of the upright box around it [m]
    thickness: float  # its smallest side [m]

    @property
    def is_level(self) -> bool:
        """Whether its third axis is vertical, as that of a plank that lies flat."""
        return self.axes_W[2] == (0.0, 0.0, 1.0)

    def is_within(self, margin: float, other: "Block") -> bool:
        """Whether the upright boxes around both come as close as a margin [m]; if not, they are farther apart."""
        (ax, ay, az), (bx, by, bz) = self.p_WC, other.p_WC
        (rx, ry, rz), (sx, sy, sz) = self.reach, other.reach
        return (
            abs(az - bz) - rz - sz <= margin and abs(ax - bx) - rx - sx <= margin and abs(ay - by) - ry - sy <= margin
        )


def block(size: Vec3, pose: Pose) -> Block:
    """A box of full lengths `size`, worked out."""
    axes = body_axes(pose.orientation)
    a, b, c = (
        (0.5 * length * x, 0.5 * length * y, 0.5 * length * z) for length, (x, y, z) in zip(size, axes, strict=True)
    )
    reach = (abs(a[0]) + abs(b[0]) + abs(c[0]), abs(a[1]) + abs(b[1]) + abs(c[1]), abs(a[2]) + abs(b[2]) + abs(c[2]))
    return Block(pose.position_W, axes, (a, b, c), reach, min(size))


def boxes_apart(size_a: Vec3, pose_a: Pose, size_b: Vec3, pose_b: Pose) -> Separation:
    """The separation of box a from box b."""
    return blocks_apart(block(size_a, pose_a), block(size_b, pose_b))


def blocks_apart(a: Block, b: Block) -> Separation:
    """The separation of box a from box b."""
    x, y, z = _minus(a.p_WC, b.p_WC)
    best, normal = -inf, (0.0, 0.0, 1.0)
    for axis in _separating_axes(a, b):
        nx, ny, nz = axis
        along = x * nx + y * ny + z * nz
        gap = abs(along) - _half_extent(a.half_edges_W, axis) - _half_extent(b.half_edges_W, axis)
        # Faces come first and win ties: an edge product is never a better normal where a face does.
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else (-nx, -ny, -nz)
    return Separation(best, normal)


def meeting(moving: Block, fixed: Block, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """How far along a unit direction a box goes until it touches another, and until it leaves it; None if it passes.

    Exact: by translation, two boxes meet where they come to overlap along every separating axis. What would touch the
    other by less than `graze` [m] sideways passes by it.
    """
    between = _minus(fixed.p_WC, moving.p_WC)
    enters, leaves = -inf, inf
    for axis in _separating_axes(moving, fixed):
        ahead, speed = _dot(between, axis), _dot(direction_W, axis)
        reach = _half_extent(moving.half_edges_W, axis) + _half_extent(fixed.half_edges_W, axis)
        if abs(speed) > PARALLEL:
            first, last = sorted(((ahead - reach) / speed, (ahead + reach) / speed))
            enters, leaves = max(enters, first), min(leaves, last)
        elif abs(ahead) > reach - graze:
            return None
    return (enters, leaves) if enters < leaves else None


def box_above_plane(size: Vec3, pose: Pose, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    return block_above_plane(block(size, pose), plane)


def block_above_plane(above: Block, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    height = _dot(_minus(above.p_WC, plane.point_W), plane.normal_W)
    return Separation(height - _half_extent(above.half_edges_W, plane.normal_W), plane.normal_W)


def in_world(shape: HalfSpace, pose: Pose) -> Plane:
    """A half-space as the plane that bounds it in W; it knows of no friction."""
    return Plane("", pose.position_W, rotate(pose.orientation, shape.normal), friction=0.0)


def _separating_axes(a: Block, b: Block) -> Sequence[Vec3]:
    if a.is_level and b.is_level:
        return (*a.axes_W, *b.axes_W[:2])  # every product of their edges is one of these again
    return (*a.axes_W, *b.axes_W, *_edge_products(a.axes_W, b.axes_W))


def _edge_products(axes_a: tuple[Vec3, ...], axes_b: tuple[Vec3, ...]) -> list[Vec3]:
    found = []
    for (ax, ay, az), (bx, by, bz) in product(axes_a, axes_b):
        x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        length = sqrt(x * x + y * y + z * z)
        if length > PARALLEL:
            found.append((x / length, y / length, z / length))
    return found


def _half_extent(half_edges: tuple[Vec3, Vec3, Vec3], direction: Vec3) -> float:
    # Written out, as nearly all the time of a comparison is spent here.
    x, y, z = direction
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = half_edges
    return abs(ax * x + ay * y + az * z) + abs(bx * x + by * y + bz * z) + abs(cx * x + cy * y + cz * z)


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _dot(a: Vec3, b: Vec3) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
