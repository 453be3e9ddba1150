"""How far apart are two boxes, or a box and a plane, and along which direction?

It is the largest gap over the separating axes. Where the boxes overlap, it is minus the shortest way out. Where they
are apart, it is a lower bound of the distance, exact when a face is closest.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

from stability.geometry.rotations import body_axes, rotate
from stability.geometry.separating_axes import (
    PARALLEL,
    Axes,
    along_product,
    coordinates,
    cosines,
    edge_products,
    face_gaps,
    half_extent,
    transposed,
)
from stability.geometry.vectors import add, cross, dot, scale, subtract
from stability.model import HalfSpace, Plane, Pose, Vec3

ORIGIN: Vec3 = (0.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)
UNTURNED: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP)


@dataclass(frozen=True, slots=True)
class Separation:
    """The gap between two bodies, and the way to widen it."""

    gap: float  # [m], negative where they overlap
    normal_BA_W: Vec3  # unit, from the second body towards the first


@dataclass(frozen=True, slots=True)
class Block:
    """A box with what a comparison with many others needs of it."""

    p_WC: Vec3  # its centre [m]
    axes_W: Axes
    half: Vec3  # half lengths along these axes [m]
    half_edges_W: tuple[Vec3, Vec3, Vec3]  # half of each edge, along its axis [m]
    reach: Vec3  # half of the upright box around it [m]
    thickness: float  # its smallest side [m]

    @property
    def is_level(self) -> bool:
        """Whether its third axis is vertical, as that of a plank that lies flat."""
        return self.axes_W[2] == UP

    @property
    def middle_W(self) -> Vec3:
        """The middle of the upright box around it [m]."""
        return self.p_WC

    @property
    def low_W(self) -> Vec3:
        """The lowest corner of the upright box around it [m]."""
        return subtract(self.p_WC, self.reach)

    @property
    def high_W(self) -> Vec3:
        """The highest corner of it [m]."""
        return add(self.p_WC, self.reach)


def block(size: Vec3, pose: Pose) -> Block:
    """A box of full lengths `size`, worked out."""
    axes = body_axes(pose.orientation)
    half = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2])
    a, b, c = ((length * x, length * y, length * z) for length, (x, y, z) in zip(half, axes, strict=True))
    reach = (abs(a[0]) + abs(b[0]) + abs(c[0]), abs(a[1]) + abs(b[1]) + abs(c[1]), abs(a[2]) + abs(b[2]) + abs(c[2]))
    return Block(pose.position_W, axes, half, (a, b, c), reach, min(size))


def boxes_apart(size_a: Vec3, pose_a: Pose, size_b: Vec3, pose_b: Pose) -> Separation:
    """The separation of box a from box b."""
    return blocks_apart(block(size_a, pose_a), block(size_b, pose_b))


def blocks_apart(a: Block, b: Block) -> Separation:
    """The separation of box a from box b."""
    p_BA = subtract(a.p_WC, b.p_WC)
    if a.axes_W == b.axes_W == UNTURNED:
        return _untouched_by_turns(p_BA, a.half, b.half)
    along_a, along_b = coordinates(p_BA, a.axes_W), coordinates(p_BA, b.axes_W)
    turn = cosines(a.axes_W, b.axes_W)
    gaps = (*face_gaps(along_a, a.half, b.half, turn), *face_gaps(along_b, b.half, a.half, transposed(turn)))
    best, normal = -inf, UP
    for gap, along, axis in zip(gaps, (*along_a, *along_b), (*a.axes_W, *b.axes_W), strict=True):
        # Faces come first and win ties: an edge product is never a better normal where a face does.
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    if a.is_level and b.is_level:  # every product of their edges is a face normal again
        return Separation(best, normal)
    for i, j, c, s, length, extent in edge_products(turn, a.half, b.half):
        along = along_product(along_a, i, c, s)
        gap = (abs(along) - extent) / length
        if gap > best + PARALLEL:
            best, normal = gap, scale((1.0 if along >= 0.0 else -1.0) / length, cross(a.axes_W[i], b.axes_W[j]))
    return Separation(best, normal)


def _untouched_by_turns(p_BA: Vec3, half_a: Vec3, half_b: Vec3) -> Separation:
    """The same of boxes that are not turned, by the same sums to the last bit: most are so, and it takes a quarter."""
    best, normal = -inf, UP
    for along, a, b, axis in zip(p_BA, half_a, half_b, UNTURNED, strict=True):
        gap = abs(along) - a - b
        if gap > best + PARALLEL:
            best, normal = gap, axis if along >= 0.0 else scale(-1.0, axis)
    return Separation(best, normal)


def meeting(moving: Block, fixed: Block, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """How far along a unit direction a box goes until it touches another, and until it leaves it; None if it passes.

    Exact: by translation, two boxes meet where they come to overlap along every separating axis. What would touch the
    other by less than `graze` [m] sideways passes by it.
    """
    enters, leaves = -inf, inf
    for ahead, speed, reach in _along_all_axes(moving, fixed, direction_W):
        if abs(speed) > PARALLEL:
            first, last = sorted(((ahead - reach) / speed, (ahead + reach) / speed))
            enters, leaves = max(enters, first), min(leaves, last)
        elif abs(ahead) > reach - graze:
            return None
    return (enters, leaves) if enters < leaves else None


def _along_all_axes(a: Block, b: Block, direction_W: Vec3) -> Iterator[tuple[float, float, float]]:
    """Along each separating axis: how far b is ahead of a [m], a unit of the direction, and how far both reach [m]."""
    p_AB, turn = subtract(b.p_WC, a.p_WC), cosines(a.axes_W, b.axes_W)
    ahead_a, speed_a = coordinates(p_AB, a.axes_W), coordinates(direction_W, a.axes_W)
    reach_a = (-gap for gap in face_gaps(ORIGIN, a.half, b.half, turn))
    yield from zip(ahead_a, speed_a, reach_a, strict=True)
    reach_b = (-gap for gap in face_gaps(ORIGIN, b.half, a.half, transposed(turn)))
    yield from zip(coordinates(p_AB, b.axes_W), coordinates(direction_W, b.axes_W), reach_b, strict=True)
    if not (a.is_level and b.is_level):
        for i, _, c, s, length, extent in edge_products(turn, a.half, b.half):
            yield along_product(ahead_a, i, c, s) / length, along_product(speed_a, i, c, s) / length, extent / length


def box_above_plane(size: Vec3, pose: Pose, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    return block_above_plane(block(size, pose), plane)


def block_above_plane(above: Block, plane: Plane) -> Separation:
    """The separation of a box from a half-space."""
    height = dot(subtract(above.p_WC, plane.point_W), plane.normal_W)
    return Separation(height - half_extent(above.axes_W, above.half, plane.normal_W), plane.normal_W)


def in_world(shape: HalfSpace, pose: Pose) -> Plane:
    """A half-space as the plane that bounds it in W; it knows of no friction."""
    return Plane("", pose.position_W, rotate(pose.orientation, shape.normal), friction=0.0)
