"""A shape at a pose: corners, bounds, distances and inertia in W; and scaled copies of shapes."""

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, TypeAlias

from stability.geometry import box_distance
from stability.geometry.box import MIDDLE, Box, OffCentreBox, UnknownShapeError, box_of
from stability.geometry.box_distance import Axes, Block, InBounds, Separation, block, blocks_apart
from stability.geometry.compound import Compound, Part
from stability.geometry.convex_solid import AXES, ConvexSolid
from stability.geometry.round_solid import RoundSolid, scaled_round
from stability.geometry.vectors import add, body_axes, dot, inverse, multiply, rotate, scale, subtract
from stability.model import IDENTITY, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3

if TYPE_CHECKING:
    from typing_extensions import TypeIs

    from stability.geometry.polyhedra import Hull
    from stability.geometry.round_distance import PlacedRound


# Corners, bounding box, highest point and principal axes of a shape at a pose, for all shapes, by the methods of
# `ConvexShape` alone.


UP: Vec3 = (0.0, 0.0, 1.0)


def corners_W(shape: ConvexShape, pose: Pose) -> tuple[Vec3, ...]:
    """Return the corners of a shape [m, W], in its order."""
    return tuple(add(pose.position_W, rotate(pose.orientation, corner)) for corner in shape.corners)


def top_W(shape: ConvexShape, pose: Pose) -> float:
    """Return the height of the highest point of a shape [m, W]."""
    return pose.position_W[2] + reach_W(shape, pose, UP)


def bounds_W(shape: ConvexShape, pose: Pose) -> tuple[Vec3, Vec3]:
    """Return the lowest and the highest corner of the bounding box of a shape [m, W]."""
    if isinstance(shape, RoundSolid):
        highs, lows = ([reach_W(shape, pose, scale(sign, axis)) for axis in AXES] for sign in (1.0, -1.0))
        (px, py, pz), (a, b, c), (d, e, f) = pose.position_W, lows, highs
        return (px - a, py - b, pz - c), (px + d, py + e, pz + f)
    x, y, z = zip(*corners_W(shape, pose), strict=True)
    return (min(x), min(y), min(z)), (max(x), max(y), max(z))


def reach_W(shape: ConvexShape, pose: Pose, direction_W: Vec3) -> float:
    """Return the extent of a shape from its centre of mass along a unit direction [m]."""
    return shape.reach(rotate(inverse(pose.orientation), direction_W))


def nearest_in_bounds_W(shape: ConvexShape, pose: Pose, point_W: Vec3) -> Vec3:
    """Return the point of the bounding box along the axes of a shape that is nearest to a point [m, W]."""
    x, y, z = rotate(inverse(pose.orientation), subtract(point_W, pose.position_W))
    a, b, c = (shape.reach(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    within = (max(-a, min(a, x)), max(-b, min(b, y)), max(-c, min(c, z)))
    return add(pose.position_W, rotate(pose.orientation, within))


def principal_turn(shape: ConvexShape, orientation: Quaternion) -> Quaternion:
    """Return the rotation from the principal axes of a shape to W, from that of its body axes."""
    axes = shape.principal_axes
    return orientation if axes == IDENTITY else multiply(orientation, axes)


# Distances between two bodies, or a body and a plane. Two boxes use faster code than other shapes.


Convex: TypeAlias = "Block | Hull | PlacedRound"  # convex shape at a pose, with values for fast comparisons


@dataclass(frozen=True, slots=True, eq=False)
class PlacedParts(InBounds):
    """Compound at a pose, as its convex parts."""

    parts: "tuple[Convex, ...]"
    p_WC: Vec3  # centre of mass [m]
    axes_W: Axes  # body axes
    low_W: Vec3  # of the bounding box [m]
    high_W: Vec3
    thickness: float  # least thickness [m]


InPlace: TypeAlias = "Convex | PlacedParts"  # shape at a pose, with values for fast comparisons


def in_place(shape: ConvexShape, pose: Pose) -> InPlace:
    """Prepare a shape at a pose for comparisons."""
    if isinstance(shape, Compound):
        parts = tuple(_convex_in_place(part.shape, part_pose(part, pose)) for part in shape.parts)
        lows, highs = zip(*(part.low_W for part in parts), strict=True), zip(*(p.high_W for p in parts), strict=True)
        (ax, ay, az), (bx, by, bz) = map(min, lows), map(max, highs)
        return PlacedParts(
            parts,
            pose.position_W,
            body_axes(pose.orientation),
            (ax, ay, az),
            (bx, by, bz),
            shape.least_thickness,
        )
    return _convex_in_place(shape, pose)


def _convex_in_place(shape: ConvexShape, pose: Pose) -> Convex:
    if isinstance(shape, Box):
        return block(shape.size, pose)
    if isinstance(shape, RoundSolid):
        from stability.geometry.round_distance import placed_round  # noqa: PLC0415 -- boxes do without numpy

        return placed_round(shape, pose.position_W, body_axes(pose.orientation))
    boxed = box_of(shape)
    if boxed is not None:
        box, middle = boxed
        return block(box.size, middle_pose(middle, pose))
    from stability.geometry.polyhedra import hull  # noqa: PLC0415 -- boxes do without numpy

    return hull(shape, pose.position_W, body_axes(pose.orientation))


def part_pose(part: Part, pose: Pose) -> Pose:
    """Return the pose of a part of a compound at a pose."""
    if part.place == Pose(MIDDLE):
        return pose
    place, turn = part.place, pose.orientation
    if place.orientation != IDENTITY:
        turn = multiply(turn, place.orientation) if turn != IDENTITY else place.orientation
    return Pose(middle_pose(place.position_W, pose).position_W, turn)


def convex_parts(body: InPlace) -> "tuple[Convex, ...]":
    """Return the convex parts of a body: those of a compound, or the body itself."""
    return body.parts if isinstance(body, PlacedParts) else (body,)


def middle_pose(middle: Vec3, pose: Pose) -> Pose:
    """Return the pose of a body with its origin moved to a point, given from the centre of mass in body axes [m]."""
    x, y, z = body_axes(pose.orientation)
    along = add(add(scale(middle[0], x), scale(middle[1], y)), scale(middle[2], z))
    return Pose(add(pose.position_W, along), pose.orientation)


def bodies_apart(a: InPlace, b: InPlace) -> Separation:
    """Return the separation of body a from body b: of compounds, that of the two closest parts."""
    if isinstance(a, PlacedParts) or isinstance(b, PlacedParts):
        pairs = product(convex_parts(a), convex_parts(b))
        return min((bodies_apart(one, other) for one, other in pairs), key=lambda apart: apart.gap)
    if isinstance(a, Block) and isinstance(b, Block):
        return blocks_apart(a, b)
    from stability.geometry import polyhedra, round_distance  # noqa: PLC0415 -- boxes do without numpy

    if is_round(a) or is_round(b):
        return Separation(*round_distance.separation(_as_convex(a), _as_convex(b)))
    return Separation(*polyhedra.separation(_as_hull(a), _as_hull(b)))


def meeting(moving: InPlace, fixed: InPlace, direction_W: Vec3, graze: float) -> tuple[float, float] | None:
    """Return the travel along a unit direction at which a body enters and leaves another [m]; None if it misses it.

    An overlap across the direction of less than `graze` [m] counts as a miss. A compound enters with its first part
    and leaves with its last one.
    """
    if isinstance(moving, PlacedParts) or isinstance(fixed, PlacedParts):
        pairs = product(convex_parts(moving), convex_parts(fixed))
        ways = [way for one, other in pairs if (way := meeting(one, other, direction_W, graze)) is not None]
        return (min(way[0] for way in ways), max(way[1] for way in ways)) if ways else None
    if isinstance(moving, Block) and isinstance(fixed, Block):
        return box_distance.meeting(moving, fixed, direction_W, graze)
    from stability.geometry import polyhedra, round_distance  # noqa: PLC0415 -- boxes do without numpy

    if is_round(moving) or is_round(fixed):
        return round_distance.passage(_as_convex(moving), _as_convex(fixed), direction_W, graze)
    return polyhedra.passage(_as_hull(moving), _as_hull(fixed), direction_W, graze)


def above_plane(body: InPlace, plane: Plane) -> Separation:
    """Return the separation of a body from a half-space."""
    if isinstance(body, PlacedParts):
        return min((above_plane(part, plane) for part in body.parts), key=lambda apart: apart.gap)
    if isinstance(body, Block):
        return box_distance.block_above_plane(body, plane)
    height = dot(subtract(body.p_WC, plane.point_W), plane.normal_W)
    if is_round(body):
        lowest = body.solid.reach(_along(body, scale(-1.0, plane.normal_W)))
        return Separation(height - lowest, plane.normal_W)
    x, y, z = plane.normal_W
    lowest = min((a * x + b * y + c * z for a, b, c in body.corners.tolist()), default=0.0)
    return Separation(height + lowest, plane.normal_W)


def distance_outside(body: InPlace, point_W: Vec3) -> float:
    """Return the largest distance of a point outside the planes of a body's faces [m]; negative inside."""
    if isinstance(body, PlacedParts):
        return min(distance_outside(part, point_W) for part in body.parts)
    if isinstance(body, Block):
        offset = subtract(point_W, body.p_WC)
        sides = zip(body.axes_W, body.half, strict=True)
        return max(abs(dot(offset, axis)) - half for axis, half in sides)
    if is_round(body):
        from stability.geometry import round_distance  # noqa: PLC0415 -- boxes do without numpy

        return round_distance.distance_outside(body, point_W)
    offset = subtract(point_W, body.p_WC)
    sides = zip(body.normals.tolist(), body.mesh.reaches.tolist(), strict=True)
    return max(dot(offset, normal) - reach for normal, reach in sides)


def is_round(body: InPlace) -> "TypeIs[PlacedRound]":
    """Return whether a body is a round solid."""
    return hasattr(body, "solid")


def _along(body: "PlacedRound", direction_W: Vec3) -> Vec3:
    """Return a direction along the axes of a body."""
    x, y, z = (dot(direction_W, axis) for axis in body.axes_W)
    return (x, y, z)


def _as_convex(body: Convex) -> "Hull | PlacedRound":
    return body if is_round(body) else _as_hull(body)


def _as_hull(body: "Block | Hull") -> "Hull":
    from stability.geometry.polyhedra import hull  # noqa: PLC0415 -- boxes do without numpy

    return hull(Box(scale(2.0, body.half)), body.p_WC, body.axes_W) if isinstance(body, Block) else body


def apart(a: ConvexShape, pose_a: Pose, b: ConvexShape, pose_b: Pose) -> Separation:
    """Return the separation of shape a from shape b."""
    return bodies_apart(in_place(a, pose_a), in_place(b, pose_b))


def apart_from_plane(shape: ConvexShape, pose: Pose, plane: Plane) -> Separation:
    """Return the exact separation of a shape from a half-space."""
    if isinstance(shape, RoundSolid):
        height = dot(subtract(pose.position_W, plane.point_W), plane.normal_W)
        return Separation(height - reach_W(shape, pose, scale(-1.0, plane.normal_W)), plane.normal_W)
    corners = corners_W(shape, pose)
    return Separation(min(dot(subtract(c, plane.point_W), plane.normal_W) for c in corners), plane.normal_W)


def inertia_times(brick: Brick, orientation: Quaternion, vector_W: Vec3) -> Vec3:
    """Return the product of a brick's inertia about its centre of mass [kg m2] and a vector, in W."""
    turn = principal_turn(brick.shape, orientation)
    return diagonal_times(brick.shape.moments(brick.mass), turn, vector_W)


def inertia_about_axes(brick: Brick, orientation: Quaternion) -> tuple[Vec3, Vec3, Vec3]:
    """Return the inertia tensor of a brick about its centre of mass along the axes of W [kg m2], by rows."""
    x, y, z = (inertia_times(brick, orientation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    # Restore the symmetry that rounding breaks.
    xy, xz, yz = 0.5 * (x[1] + y[0]), 0.5 * (x[2] + z[0]), 0.5 * (y[2] + z[1])
    return (x[0], xy, xz), (xy, y[1], yz), (xz, yz, z[2])


def diagonal_times(diagonal: Vec3, orientation: Quaternion, vector_W: Vec3) -> Vec3:
    """Return the product in W of a vector and a tensor that is diagonal in axes which `orientation` rotates to W."""
    a, b, c = rotate(inverse(orientation), vector_W)
    return rotate(orientation, (diagonal[0] * a, diagonal[1] * b, diagonal[2] * c))


def scaled(shape: ConvexShape, factor: float) -> ConvexShape:
    """Return a shape with all lengths multiplied by a factor. Raises UnknownShapeError for a foreign shape class."""
    match shape:
        case RoundSolid():
            return scaled_round(shape, factor)
        case Box(size):
            return Box(scale(factor, size))
        case OffCentreBox(size, centre):
            return OffCentreBox(scale(factor, size), scale(factor, centre))
        case ConvexSolid():
            return ConvexSolid(
                tuple(scale(factor, corner) for corner in shape.corners),
                shape.faces,
                scale(factor * factor, shape.unit_moments),
                shape.principal_axes,
                shape.edges,
                factor**3 * shape.volume,
                factor * shape.least_thickness,
                factor * shape.length,
                factor * shape.bounding_radius,
            )
        case Compound():
            return replace(
                shape,
                parts=tuple(
                    Part(scaled(part.shape, factor), Pose(scale(factor, part.place.position_W), part.place.orientation))
                    for part in shape.parts
                ),
                unit_moments=scale(factor * factor, shape.unit_moments),
                corners=tuple(scale(factor, corner) for corner in shape.corners),
                volume=factor**3 * shape.volume,
                least_thickness=factor * shape.least_thickness,
                length=factor * shape.length,
                bounding_radius=factor * shape.bounding_radius,
            )
        case _:
            raise UnknownShapeError("a scaled world", shape)
