"""On what does a brick rest, and at which points?

The engine says which bodies are near. Where both are convex, or the lower one is a half-space, geometry says whether
they touch, from which side, and at which corners (docs/decisions/0003). Only of other shapes, and of bodies that touch
along an edge, the engine's own contact points are used.

The source also disregards contacts that come from impacts. Here that follows: a brick is tested only when it is slow,
and only against bodies that do not move.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from stability.engines.protocol import Engine
from stability.geometry.separation import in_world
from stability.geometry.touching import gap_bridged, reach_between
from stability.model import (
    BodyId,
    BodyState,
    Brick,
    ContactPoint,
    ConvexShape,
    HalfSpace,
    Plane,
    Pose,
    Shape,
    Vec3,
    convex,
)
from stability.published.face_patch import face_patch
from stability.shapes.apart import apart
from stability.shapes.box import Box
from stability.shapes.in_pose import corners_W
from stability.statics.contacts.touch import contact_between, solid
from stability.statics.facts import Placed, Tolerances

# [m] For how thick a body is taken whose shape nobody knows: engines keep their margins around such shapes, and report
# points up to half a millimetre early.
UNKNOWN_THICKNESS = 0.025


@dataclass(frozen=True, slots=True)
class ContactLimits:
    """Which contacts carry weight."""

    # z of the normal towards the carried brick: steeper than 60 deg is a side touch, which the base model leaves out.
    upward: float = 0.5


def reach_of(shape: Shape) -> float:
    """How far away what a brick touches may at most be [m]."""
    known = convex(shape)
    return reach_between(UNKNOWN_THICKNESS if known is None else known.least_thickness)


def resting_points(
    engine: Engine, brick: BodyId, state: BodyState, supports: Collection[BodyId], limits: ContactLimits
) -> Mapping[BodyId, Sequence[Vec3]]:
    """The points at which a brick rests on each of the `supports` that carry it [m, in W]."""
    shape = engine.shape(brick)
    near = [body for body in engine.near(brick, reach_of(shape)) if body in supports]
    states = engine.states(near)
    found: dict[BodyId, Sequence[Vec3]] = {}
    unclear = []
    for body in near:
        points = corners_on(shape, state.pose, engine.shape(body), states[body].pose, limits)
        if points is None:
            unclear.append(body)
        elif points:
            found[body] = points
    return found | _reported(brick, engine.contacts(brick), unclear, reach_of(shape), limits) if unclear else found


def corners_on(upper: Shape, at: Pose, lower: Shape, below: Pose, limits: ContactLimits) -> Sequence[Vec3] | None:
    """The corners of the contact of one body with another below it; empty if it does not rest there.

    None if their shapes alone do not tell.
    """
    match upper, lower:
        case Box(), Box():
            between = apart(upper, at, lower, below)
            reach = reach_between(upper.least_thickness, lower.least_thickness)
            upward = between.normal_BA_W[2]
            if upward < limits.upward or not -reach <= between.gap <= gap_bridged(reach, upward):
                return ()
            return face_patch(upper.size, at, lower.size, below) or None
        case (None | HalfSpace(), _) | (_, None):
            return None
        case _, HalfSpace():
            return _lowest_corners(upper, at, in_world(lower, below), limits)
        case _:
            return _corners_of_patch(upper, at, lower, below, limits)


def _corners_of_patch(
    upper: ConvexShape, at: Pose, lower: ConvexShape, below: Pose, limits: ContactLimits
) -> Sequence[Vec3] | None:
    """Of two solids that are not both boxes; None where they touch along an edge."""
    above = solid(Placed(Brick("upper", upper, 0.0), at))
    contact = contact_between(above, solid(Placed(Brick("lower", lower, 0.0), below)), 0.0, Tolerances())
    if contact is None:
        return ()
    upward = sum(normal[2] for normal in contact.normals_W) / len(contact.normals_W)
    if (upward if contact.upper == "upper" else -upward) < limits.upward:
        return ()
    return contact.points_W if len(contact.points_W) > 2 else None  # noqa: PLR2004 -- a line has two ends


def _lowest_corners(upper: ConvexShape, at: Pose, plane: Plane, limits: ContactLimits) -> Sequence[Vec3]:
    nx, ny, nz = plane.normal_W
    px, py, pz = plane.point_W
    if nz < limits.upward:
        return ()
    heights = {(x, y, z): (x - px) * nx + (y - py) * ny + (z - pz) * nz for x, y, z in corners_W(upper, at)}
    reach = reach_of(upper)
    if min(heights.values()) < -reach:
        return ()
    return [corner for corner, height in heights.items() if height <= gap_bridged(reach, nz)]


def _reported(
    brick: BodyId, contacts: Iterable[ContactPoint], bodies: Collection[BodyId], reach: float, limits: ContactLimits
) -> dict[BodyId, Sequence[Vec3]]:
    """The engine's own contact points with these bodies, where they carry the brick."""
    found: dict[BodyId, list[Vec3]] = {}
    for point in contacts:
        other, upward = (point.b, point.normal_BA_W[2]) if point.a == brick else (point.a, -point.normal_BA_W[2])
        if other in bodies and abs(point.gap) <= reach and upward >= limits.upward:
            found.setdefault(other, []).append(point.position_W)
    return dict(found)
