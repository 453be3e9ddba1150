"""Bricks prepared for contact detection, once per brick, which makes each pair cheap."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from math import hypot
from typing import TYPE_CHECKING, NamedTuple, TypeAlias, Union

from stability.contacts.features import ConvexSolid, Edge, Face, Feature
from stability.geometry.box import Box, UnknownShapeError, box_of
from stability.geometry.box_distance import coordinates, half_extent
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import middle_pose, part_pose
from stability.geometry.polygons import within_rectangle
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import add, add_scaled, body_axes, cross, dot, scale
from stability.model import BodyId, Brick, Pose, Quaternion, Vec3
from stability.problem import Placed

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from stability.contacts.hull_contacts import HullSolid  # boxes do without numpy
    from stability.contacts.round_contacts import RoundBody

# Sine of the angle to the vertical up to which a body axis counts as vertical: rounding.
UPRIGHT = 1e-12
KEPT = 1024  # cache size: most boxes are of few sizes, and many are turned alike

# In plan: the direction of the first side (x, y), then the half lengths of the first and the second side [m].
PlanRectangle: TypeAlias = tuple[float, float, float, float]


class Rectangle(NamedTuple):
    """Border of the face of a box, faster than that of a polygon."""

    half_x: float  # [m]
    half_y: float

    @property
    def corners(self) -> Sequence[tuple[float, float]]:
        x, y = self.half_x, self.half_y
        return ((-x, -y), (x, -y), (x, y), (-x, y))

    def clipped(self, corners: Sequence[Vec3], slack: float = 0.0) -> Sequence[Vec3]:
        return within_rectangle(corners, self.half_x + slack, self.half_y + slack)

    def clamped(self, point: Vec3) -> Vec3:
        half_x, half_y = self.half_x, self.half_y
        return (min(half_x, max(-half_x, point[0])), min(half_y, max(-half_y, point[1])), point[2])

    def has_on_border(self, segment: Sequence[Vec3], slack: float) -> bool:
        return any(
            all(abs(abs(point[axis]) - half) <= slack for point in segment)
            for axis, half in enumerate((self.half_x, self.half_y))
        )


class BoxFeature(NamedTuple):
    """Face, edge or corner of a box."""

    body: "BoxSolid"
    signs: Vec3  # by body axis: 1 or -1 if it points out of the feature along or against the axis, 0 if along it

    @property
    def dimension(self) -> int:
        return self.signs.count(0.0)

    @property
    def direction(self) -> Vec3:
        first, second = self.normals(1.0)
        return cross(first, second)

    def normals(self, sign: float) -> Sequence[Vec3]:
        return [scale(sign * out, axis) for out, axis in zip(self.signs, self.body.axes, strict=True) if out]

    def limits(self, sign: float) -> Sequence[Vec3]:
        return self.normals(-sign)  # the edges at a corner run against its normals

    def corners(self) -> list[Vec3]:
        """Return the corners in order, from the centre of the body, in W [m]."""
        points: list[Vec3] = [(0.0, 0.0, 0.0)]
        for sign, half, axis in zip(self.signs, self.body.half, self.body.axes, strict=True):
            if sign:
                points = [add_scaled(point, sign * half, axis) for point in points]
            else:
                one_side = [add_scaled(point, -half, axis) for point in points]
                points = one_side + [add_scaled(point, half, axis) for point in reversed(points)]
        return points

    def middle(self) -> Vec3:
        """Return the centre of the feature, from the centre of the body, in W [m]."""
        point: Vec3 = (0.0, 0.0, 0.0)
        for sign, half, axis in zip(self.signs, self.body.half, self.body.axes, strict=True):
            point = add_scaled(point, sign * half, axis)
        return point

    def containing(self, points: Sequence[Vec3], up_W: Vec3, slack: float) -> "BoxFeature":
        signs = list(self.signs)
        for index, (axis, half) in enumerate(zip(self.body.axes, self.body.half, strict=True)):
            if not signs[index]:
                along = [dot(point, axis) for point in points]
                if all(abs(half - abs(value)) <= slack for value in along) and min(along) * max(along) > 0:
                    signs[index] = 1.0 if along[0] > 0.0 else -1.0
        return BoxFeature(self.body, (signs[0], signs[1], signs[2]))


@dataclass(frozen=True, slots=True)
class BoxSolid(ConvexSolid):
    """Box at a pose; its faces and edges have the numbers of their axes."""

    size: Vec3  # full lengths along the body axes [m]
    axes: tuple[Vec3, Vec3, Vec3]  # body axes in W
    half: Vec3  # half lengths along the body axes [m]
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

    def extent(self, direction_W: Vec3) -> float:
        return half_extent(self.axes, self.half, direction_W)

    def face(self, number: int, towards_W: Vec3) -> Face:
        """Return the face perpendicular to an axis that faces a direction."""
        sign = 1.0 if dot(towards_W, self.axes[number]) > 0.0 else -1.0
        signs = [0.0, 0.0, 0.0]
        signs[number] = sign
        first, second = (number + 1) % 3, (number + 2) % 3
        return Face(
            self,
            BoxFeature(self, (signs[0], signs[1], signs[2])),
            (self.axes[first], self.axes[second], scale(sign, self.axes[number])),
            sign > 0.0,
            self.half[number],
            Rectangle(self.half[first], self.half[second]),
        )

    def edge(self, number: int, towards_W: Vec3) -> Edge:
        """Return the outermost edge along an axis in a direction."""
        signs = [1.0 if dot(towards_W, axis) > 0.0 else -1.0 for axis in self.axes]
        signs[number] = 0.0
        feature = BoxFeature(self, (signs[0], signs[1], signs[2]))
        return Edge(feature, feature.middle(), self.axes[number], self.half[number])

    def lowest(self, on: Face, p_BO: Vec3, rise: float) -> tuple[Feature, Sequence[Vec3]]:
        """Return the feature nearest to a face, with the axes along which the box rises by less than `rise` [m]."""
        signs = []
        for slope, half in zip(coordinates(on.normal_W, self.axes), self.half, strict=True):
            signs.append(0.0 if 2.0 * half * abs(slope) <= rise else (-1.0 if slope > 0.0 else 1.0))
        feature = BoxFeature(self, (signs[0], signs[1], signs[2]))
        return feature, on.seen([add(p_BO, corner) for corner in feature.corners()])

    def lowest_corners(self, up_W: Vec3, rise: float) -> Sequence[Vec3]:
        """Return the corners of the face that leans least; it contains the lowest edge."""
        rises = [half * abs(slope) for half, slope in zip(self.half, coordinates(up_W, self.axes), strict=True)]
        steepest = max(range(3), key=lambda index: rises[index])
        lowest = self.face(steepest, scale(-1.0, up_W))
        corners = lowest.placed(lowest.outline.corners)
        # Corners that run counter-clockwise seen from outside run clockwise seen from above.
        return corners[::-1] if lowest.is_right_handed else corners


Solid: TypeAlias = Union[BoxSolid, "HullSolid", "RoundBody"]  # a convex one


@dataclass(frozen=True, slots=True)
class CompoundSolid:
    """Compound at a pose, prepared for contact detection as its convex parts."""

    id: BodyId
    pose: Pose
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    shortest: float  # least thickness of all parts [m]
    longest: float  # longest side of the box around the shape along its body axes [m]
    parts: tuple[Solid, ...]


AnySolid: TypeAlias = Solid | CompoundSolid


def convex_parts(body: AnySolid) -> tuple[Solid, ...]:
    """Return the convex parts of a body: those of a compound, or the body itself."""
    return body.parts if isinstance(body, CompoundSolid) else (body,)


def solid(placed: Placed) -> AnySolid:
    """Prepare a placed brick for contact detection."""
    shape, pose = placed.brick.shape, placed.pose
    if not isinstance(shape, Compound):
        return convex_solid(placed)
    name = placed.brick.id
    parts = [convex_solid(Placed(Brick(name, part.shape, 0.0), part_pose(part, pose))) for part in shape.parts]
    lows, highs = zip(*(part.low_W for part in parts), strict=True), zip(*(part.high_W for part in parts), strict=True)
    (ax, ay, az), (bx, by, bz) = map(min, lows), map(max, highs)
    thin = shape.least_thickness
    # All parts have the tolerance of the whole body.
    own = tuple(part if is_round(part) else replace(part, shortest=thin) for part in parts)
    return CompoundSolid(name, pose, (ax, ay, az), (bx, by, bz), thin, shape.length, own)


def convex_solid(placed: Placed) -> Solid:
    """Prepare a placed convex brick for contact detection."""
    brick, pose = placed.brick, placed.pose
    if isinstance(brick.shape, Compound):
        raise UnknownShapeError("a method for convex bodies", brick.shape)
    if isinstance(brick.shape, Box):
        return box_solid(brick.id, brick.shape.size, pose)
    if isinstance(brick.shape, RoundSolid):
        from stability.contacts.round_contacts import round_body  # noqa: PLC0415 -- boxes do without numpy

        return round_body(brick.id, brick.shape, pose)
    boxed = box_of(brick.shape)
    if boxed is None:
        from stability.contacts.hull_contacts import hull_solid  # noqa: PLC0415 -- boxes do without numpy

        return hull_solid(brick.id, brick.shape, pose.position_W, body_axes(pose.orientation))
    box, middle = boxed
    return box_solid(brick.id, box.size, middle_pose(middle, pose))


def box_solid(name: BodyId, size: Vec3, pose: Pose) -> BoxSolid:
    """Prepare a box with the pose of its centre for contact detection."""
    axes, half, plan, (rx, ry, rz), shortest, longest = _turned_box(size, pose.orientation)
    px, py, pz = pose.position_W
    low, high = (px - rx, py - ry, pz - rz), (px + rx, py + ry, pz + rz)
    return BoxSolid(name, pose, low, high, shortest, longest, size, axes, half, plan, rz)


@lru_cache(maxsize=KEPT)
def _turned_box(
    size: Vec3, orientation: Quaternion
) -> tuple[tuple[Vec3, Vec3, Vec3], Vec3, PlanRectangle | None, Vec3, float, float]:
    """Return axes, half lengths, plan, half size of the bounding box, smallest and largest side of a turned box."""
    a, b, c = half = (0.5 * size[0], 0.5 * size[1], 0.5 * size[2])
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = axes = body_axes(orientation)
    rx = a * abs(ux) + b * abs(vx) + c * abs(wx)
    ry = a * abs(uy) + b * abs(vy) + c * abs(wy)
    rz = a * abs(uz) + b * abs(vz) + c * abs(wz)
    return axes, half, _plan(axes, half), (rx, ry, rz), min(size), max(size)


def is_round(body: Solid) -> "TypeIs[RoundBody]":
    """Return whether a body is a round solid."""
    return not isinstance(body, BoxSolid) and hasattr(body, "placed")


def as_hull(body: Solid) -> "HullSolid":
    """Return a body with flat faces as one of any convex shape. Raises TypeError for a round body."""
    if is_round(body):
        raise TypeError(f"{body.id} is round, and has no flat faces only")
    if not isinstance(body, BoxSolid):
        return body
    from stability.contacts.hull_contacts import hull_solid  # noqa: PLC0415 -- boxes do without numpy

    return hull_solid(body.id, Box(body.size), body.pose.position_W, body.axes)


def _plan(axes: tuple[Vec3, Vec3, Vec3], half: Vec3) -> PlanRectangle | None:
    for upright, first, second in ((2, 0, 1), (1, 0, 2), (0, 1, 2)):
        x, y, _ = axes[upright]
        if abs(x) <= UPRIGHT and abs(y) <= UPRIGHT:
            ux, uy, _ = axes[first]
            length = hypot(ux, uy)
            return (ux / length, uy / length, half[first], half[second])
    return None
