"""Bricks prepared for contact detection, once per brick, which makes each pair cheap."""

from dataclasses import dataclass
from itertools import product
from math import hypot, sqrt
from typing import TYPE_CHECKING, TypeAlias

from stability.geometry.box import Box, box_of
from stability.geometry.placed_shape import middle_pose
from stability.geometry.vectors import add, body_axes
from stability.model import BodyId, Pose, Vec3
from stability.problem import Placed

if TYPE_CHECKING:
    from stability.geometry.polyhedra import Hull  # boxes do without numpy

# Sine of the angle to the vertical up to which a body axis counts as vertical: rounding.
UPRIGHT = 1e-12

# In plan: the direction of the first side (x, y), then the half lengths of the first and the second side [m].
PlanRectangle: TypeAlias = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class BoxSolid:
    """Box at a pose."""

    id: BodyId
    size: Vec3  # full lengths along the body axes [m]
    pose: Pose  # of its centre
    axes: tuple[Vec3, Vec3, Vec3]  # body axes in W
    half: Vec3  # half lengths along the body axes [m]
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    shortest: float  # shortest side [m]
    longest: float  # longest side [m]
    plan: PlanRectangle | None  # None unless a body axis is vertical
    rise: float  # height of the top above the centre [m]

    @property
    def flat(self) -> bool:
        """Whether the top is level."""
        return self.plan is not None

    @property
    def corners_W(self) -> tuple[Vec3, ...]:
        """The eight corners [m]."""
        (px, py, pz), (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = self.pose.position_W, *self.axes
        return tuple(
            (px + u * ux + v * vx + w * wx, py + u * uy + v * vy + w * wy, pz + u * uz + v * vz + w * wz)
            for u, v, w in product(*((-length, length) for length in self.half))
        )


@dataclass(frozen=True, slots=True, eq=False)
class HullSolid:
    """Convex solid other than a box at a pose."""

    id: BodyId
    hull: "Hull"

    @property
    def pose(self) -> Pose:
        """The position of the centre of mass, without rotation, as the hull is in W."""
        return Pose(self.hull.p_WC)

    @property
    def low_W(self) -> Vec3:
        """The lowest corner of the bounding box [m]."""
        return self.hull.low_W

    @property
    def high_W(self) -> Vec3:
        """The highest corner of the bounding box [m]."""
        return self.hull.high_W

    @property
    def shortest(self) -> float:
        """The least thickness [m]."""
        return self.hull.thickness

    @property
    def longest(self) -> float:
        """The longest side of the box around the shape along its body axes [m]."""
        return self.hull.length

    @property
    def corners_W(self) -> tuple[Vec3, ...]:
        """The corners [m]."""
        return tuple(add(self.hull.p_WC, (x, y, z)) for x, y, z in self.hull.corners.tolist())


Solid: TypeAlias = BoxSolid | HullSolid


def solid(placed: Placed) -> Solid:
    """Prepare a placed brick for contact detection."""
    brick, pose = placed.brick, placed.pose
    if isinstance(brick.shape, Box):
        return box_solid(brick.id, brick.shape.size, pose)
    boxed = box_of(brick.shape)
    if boxed is None:
        from stability.geometry.polyhedra import hull  # noqa: PLC0415 -- boxes do without numpy

        return HullSolid(brick.id, hull(brick.shape, pose.position_W, body_axes(pose.orientation)))
    box, middle = boxed
    return box_solid(brick.id, box.size, middle_pose(middle, pose))


def box_solid(name: BodyId, size: Vec3, pose: Pose) -> BoxSolid:
    """Prepare a box with the pose of its centre for contact detection."""
    a, b, c = half = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2])
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes = body_axes(pose.orientation)
    rx = a * abs(ux) + b * abs(vx) + c * abs(wx)
    ry = a * abs(uy) + b * abs(vy) + c * abs(wy)
    rz = a * abs(uz) + b * abs(vz) + c * abs(wz)
    px, py, pz = pose.position_W
    plan = _plan(axes, half)
    low, high = (px - rx, py - ry, pz - rz), (px + rx, py + ry, pz + rz)
    return BoxSolid(name, size, pose, axes, half, low, high, min(size), max(size), plan, rz)


def as_hull(body: Solid) -> "Hull":
    """Return the hull of a body."""
    if isinstance(body, HullSolid):
        return body.hull
    from stability.geometry.polyhedra import hull  # noqa: PLC0415 -- boxes do without numpy

    return hull(Box(body.size), body.pose.position_W, body.axes)


def _plan(axes: tuple[Vec3, Vec3, Vec3], half: Vec3) -> PlanRectangle | None:
    for upright, first, second in ((2, 0, 1), (1, 0, 2), (0, 1, 2)):
        x, y, _ = axes[upright]
        if abs(x) <= UPRIGHT and abs(y) <= UPRIGHT:
            ux, uy, _ = axes[first]
            length = hypot(ux, uy)
            return (ux / length, uy / length, half[first], half[second])
    return None


def rounding(a: Solid, b: Solid) -> float:
    """Return the rounding error of the distance of two bodies [m], from their sizes and positions."""
    (ax, ay, az), (bx, by, bz) = a.pose.position_W, b.pose.position_W
    far = sqrt(ax * ax + ay * ay + az * az) + sqrt(bx * bx + by * by + bz * bz)
    return 1e-12 * min(a.longest, b.longest) + 1e-15 * (far + max(a.longest, b.longest))
