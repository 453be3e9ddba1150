"""The published base model: contact areas, support polygons, merge cases, and the readings of ambiguous text."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise, product
from math import dist, hypot

from stability.contacts.bodies import convex_solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.engines.protocol import Engine
from stability.geometry.box import Box
from stability.geometry.box_distance import gap_bridged, in_world, reach_between
from stability.geometry.placed_shape import apart, corners_W
from stability.geometry.polygons import (
    STRAIGHT,
    Point2,
    Polygon,
    centroid,
    convex_hull,
    doubled_area,
    signed_distance,
    straightened,
    within_rectangle,
)
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import body_axes, dot, rotate, subtract
from stability.graph import from_the_top
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
from stability.problem import Contact, Placed, Tolerances
from stability.work_limit import LOAD, add_work

# Readings of ambiguous points of the published text. The method runs with one choice of each.
#
# docs/design/publication.md gives the reasons for the defaults, and docs/method.md the effects of the others.


class Closest(Enum):
    """Reading of "the contact point closest to the centre of mass"."""

    CORNER = "corner"  # one of the contact points
    POINT = "point"  # any point of the contact area


class ActsAt(Enum):
    """Point of application of the mass that one of several supports carries."""

    CONTACT = "contact"  # at the centre of its contact area, the end of the lever of Eq. 6
    COM_ABOVE = "com above"  # at com above of the brick that passes it on, by the text of Eq. 1 and Eq. 10


class Merge(Enum):
    """Distribution of a load over two supports neither of which could carry it alone (merge case 3)."""

    TORQUES = "torques"  # by the torque about a pivot on the other support, as published (Eq. 3 to 9)
    LEVER_RULE = "lever rule"  # not published: by the lever rule, which preserves load and moment


class SecondObjects(Enum):
    """Reading of "second impact objects", whose hits are ignored (section 3.6.1)."""

    EVER_STACKED = "ever stacked"  # every brick that was once part of the stack
    NONE = "none"  # no brick: every moving brick hits with its own energy


class Square(Enum):
    """Reference direction of the angle of Eq. 7 for a leaning brick; the sine of the angle divides the force."""

    FORCE = "force"  # the force, which is perpendicular to the lever: the sine is 1
    GRAVITY = "gravity"  # gravity, as in the base model
    NORMAL = "normal"  # the normal of the upper contact


@dataclass(frozen=True, slots=True)
class Readings:
    """Choice of all readings."""

    pivot: Closest = Closest.CORNER  # of merge case 3
    acts_at: ActsAt = ActsAt.CONTACT  # in plan, on two supports: merge case 3, Eq. 10
    equal_acts_at: ActsAt = ActsAt.COM_ABOVE  # in plan, on more than two: merge case 2
    height_acts_at: ActsAt = ActsAt.COM_ABOVE  # height, on two or more; only for the energy of an impact
    merge: Merge = Merge.TORQUES
    second_objects: SecondObjects = SecondObjects.EVER_STACKED
    leaning_pivot: Closest = Closest.POINT
    leaning_angle: Square = Square.FORCE


AS_READ = Readings()


# Contact areas as published: the convex hull in plan of the points at which a brick rests.
#
# Source: the stack-stability thesis, section 3.3.3. There is one area per support, and one over all supports (the main
# contact). Two points are widened to a thin quad, and one to a small diamond, as a line or point has no interior. The
# source orders the engine's points by gift wrapping and tests rays against a mesh over them. This code gives the same
# verdicts without rays (docs/design/contacts.md).


# [m] "a short distance" in the source. Half a millimetre cannot be felt by hand, a tenth of a plank's edge can.
WIDENING = 5e-4


@dataclass(frozen=True, slots=True)
class ContactArea:
    """Contact area of a brick with one support."""

    on: BodyId
    points_W: tuple[Vec3, ...]  # contact points [m]
    polygon: Polygon  # their hull in plan, widened if it has no area
    centre: Point2  # of the polygon [m]


def contact_area(on: BodyId, points_W: Sequence[Vec3]) -> ContactArea:
    """Return the contact area of at least one point with a support."""
    polygon = plan_hull(points_W)
    return ContactArea(on, tuple(points_W), polygon, centroid(polygon))


def main_contact(areas: Iterable[ContactArea]) -> Polygon:
    """Return the hull over all supports."""
    return plan_hull([point for area in areas for point in area.points_W])


def plan_hull(points_W: Sequence[Vec3]) -> Polygon:
    """Return the convex hull in plan, widened if the points coincide or lie on a line."""
    hull = convex_hull((x, y) for x, y, _ in points_W)
    polygon = straightened(hull)
    if polygon:
        return polygon
    first, second = max(product(hull, repeat=2), key=lambda ends: dist(*ends))
    return _thin_quad(first, second) if dist(first, second) > STRAIGHT else _diamond(first)


def _diamond(centre: Point2) -> Polygon:
    x, y = centre
    return ((x - WIDENING, y), (x, y - WIDENING), (x + WIDENING, y), (x, y + WIDENING))


def _thin_quad(a: Point2, b: Point2) -> Polygon:
    dx, dy = b[0] - a[0], b[1] - a[1]
    scale = WIDENING / hypot(dx, dy)
    sx, sy = -dy * scale, dx * scale
    return convex_hull(((a[0] + sx, a[1] + sy), (a[0] - sx, a[1] - sy), (b[0] + sx, b[1] + sy), (b[0] - sx, b[1] - sy)))


# Face patch of two boxes: the corners of the overlap of their faces, from poses and sizes.
#
# Engines keep at most four contact points per pair. In a flush stack edges of both faces coincide, and rounding selects
# the points: PyBullet then reports points within an edge and drops corners. So geometry provides the points.


PARALLEL = 0.9994  # cosine of 2 deg: less parallel faces touch along an edge


def face_patch(upper_size: Vec3, upper: Pose, lower_size: Vec3, lower: Pose) -> tuple[Vec3, ...]:
    """Return the corners of the overlap of the upper box's bottom with the lower box's top, in its plane [m, W].

    They are counter-clockwise seen from above; empty if the faces are not parallel or do not overlap.
    """
    (axis_u, _), (axis_l, sign) = _most_upright(upper), _most_upright(lower)
    axes_u, axes_l = body_axes(upper.orientation), body_axes(lower.orientation)
    if abs(dot(axes_u[axis_u], axes_l[axis_l])) < PARALLEL:
        return ()
    first, second = (axis for axis in range(3) if axis != axis_l)
    top = 0.5 * sign * lower_size[axis_l]
    bottom = sorted(corners_W(Box(upper_size), upper), key=lambda corner: dot(corner, axes_l[axis_l]) * sign)[:4]
    in_face = [_coordinates(corner, lower, (axes_l[first], axes_l[second])) for corner in bottom]
    half = (0.5 * lower_size[first], 0.5 * lower_size[second])
    corners = straightened(tuple(within_rectangle(convex_hull(in_face), *half)))
    placed = [_in_world(corner, lower, (axes_l[first], axes_l[second], axes_l[axis_l]), top) for corner in corners]
    clockwise = bool(placed) and doubled_area([(x, y) for x, y, _ in placed])[0] < 0.0
    return tuple(placed[::-1] if clockwise else placed)


def _most_upright(pose: Pose) -> tuple[int, float]:
    """Return the body axis that is closest to the vertical, and its upward sign."""
    heights = [axis[2] for axis in body_axes(pose.orientation)]
    axis = max(range(3), key=lambda index: abs(heights[index]))
    return axis, 1.0 if heights[axis] > 0.0 else -1.0


def _coordinates(point: Vec3, box: Pose, axes: tuple[Vec3, Vec3]) -> Point2:
    offset = subtract(point, box.position_W)
    return (dot(offset, axes[0]), dot(offset, axes[1]))


def _in_world(point: Point2, box: Pose, axes: tuple[Vec3, Vec3, Vec3], height: float) -> Vec3:
    x, y, z = (
        centre + point[0] * along + point[1] * across + height * up
        for centre, along, across, up in zip(box.position_W, *axes, strict=True)
    )
    return (x, y, z)


# The supports of a brick and its contact points with them.
#
# The engine provides the neighbours. For two convex shapes, or a convex shape on a half-space, geometry decides whether
# they touch, on which side, and at which corners (docs/design/contacts.md). The engine's own contact points are used
# only for other shapes and for contacts along an edge.
#
# The source also ignores contacts from impacts. This follows here, as only slow bricks are tested, and only against
# bodies at rest.


# [m] Assumed thickness of a body of unsupported shape: engines keep margins around such shapes, and report contact
# points at gaps of up to half a millimetre.
UNKNOWN_THICKNESS = 0.025


@dataclass(frozen=True, slots=True)
class ContactLimits:
    """Limits of contacts that carry weight."""

    # Least z component of the normal towards the carried brick: the base model ignores contacts steeper than 60 deg.
    upward: float = 0.5


def reach_of(shape: Shape) -> float:
    """Return the largest gap between a brick and a body that it touches [m]."""
    convex_shape = convex(shape)
    return reach_between(UNKNOWN_THICKNESS if convex_shape is None else convex_shape.least_thickness)


def resting_points(
    engine: Engine, brick: BodyId, state: BodyState, supports: Collection[BodyId], limits: ContactLimits
) -> Mapping[BodyId, Sequence[Vec3]]:
    """Return the contact points of a brick with each of the `supports` that carry it [m, W].

    A round brick on its side has none, as it can roll.
    """
    shape = engine.shape(brick)
    if isinstance(shape, RoundSolid) and not may_stand(shape, state.pose, limits):
        return {}
    near = [body for body in engine.neighbours(brick, reach_of(shape)) if body in supports]
    states = engine.states(near)
    contact_points: dict[BodyId, Sequence[Vec3]] = {}
    undetermined = []
    for body in near:
        points = corners_on(shape, state.pose, engine.shape(body), states[body].pose, limits)
        if points is None:
            undetermined.append(body)
        elif points:
            contact_points[body] = points
    return (
        contact_points | _reported(brick, engine.contacts(brick), undetermined, reach_of(shape), limits)
        if undetermined
        else contact_points
    )


def may_stand(shape: RoundSolid, pose: Pose, limits: ContactLimits = ContactLimits()) -> bool:
    """Return whether a flat end of a round body is as level as a contact that carries weight."""
    return not shape.rounding and abs(rotate(pose.orientation, (0.0, 0.0, 1.0))[2]) >= limits.upward


def corners_on(upper: Shape, at: Pose, lower: Shape, below: Pose, limits: ContactLimits) -> Sequence[Vec3] | None:
    """Return the corners of the contact of one body with another below it; empty if it does not rest on it.

    None if their shapes do not determine the contact.
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
        case RoundSolid(), HalfSpace():
            plane = in_world(lower, below)
            solid = convex_solid(Placed(Brick("upper", upper, 0.0), at))
            contact = contact_with_plane(solid, plane, Tolerances()) if plane.normal_W[2] >= limits.upward else None
            return _corners_of_area(contact, upper) if contact is not None else ()
        case _, HalfSpace():
            return _lowest_corners(upper, at, in_world(lower, below), limits)
        case _:
            return _corners_of_patch(upper, at, lower, below, limits)


def _corners_of_patch(
    upper: ConvexShape, at: Pose, lower: ConvexShape, below: Pose, limits: ContactLimits
) -> Sequence[Vec3] | None:
    """Return the corners of the contact of two solids that are not both boxes; None if they touch along an edge."""
    above = convex_solid(Placed(Brick("upper", upper, 0.0), at))
    contact = contact_between(above, convex_solid(Placed(Brick("lower", lower, 0.0), below)), 0.0, Tolerances())
    if contact is None:
        return ()
    upward = sum(normal[2] for normal in contact.normals_W) / len(contact.normals_W)
    if (upward if contact.upper == "upper" else -upward) < limits.upward:
        return ()
    return _corners_of_area(contact, upper)


def _corners_of_area(contact: Contact, upper: ConvexShape) -> Sequence[Vec3] | None:
    """Return the corners of a contact with an area, within its round borders; None without an area.

    A round body on its side has none either, and contact points of an engine must not support it, as it can roll.
    """
    if contact.patch is not None:
        from stability.statics.round_borders import inscribed_contact  # noqa: PLC0415 -- boxes do without numpy

        contact = inscribed_contact(contact)
    if len(contact.points_W) > 2:  # noqa: PLR2004 -- a line has two ends
        return contact.points_W
    return () if isinstance(upper, RoundSolid) else None


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
    """Return the engine's contact points of a brick with these bodies, as far as they carry it."""
    contact_points: dict[BodyId, list[Vec3]] = {}
    for point in contacts:
        other, upward = (point.b, point.normal_BA_W[2]) if point.a == brick else (point.a, -point.normal_BA_W[2])
        if other in bodies and abs(point.gap) <= reach and upward >= limits.upward:
            contact_points.setdefault(other, []).append(point.position_W)
    return dict(contact_points)


# Loads shared by several supports: merge cases 2 and 3, and the lever rule.
#
# Source: the stack-stability thesis, section 3.3.6; equation numbers are its own.


@dataclass(frozen=True, slots=True)
class Share:
    """Part of a load that one support carries."""

    on: BodyId
    mass: float  # equivalent mass [kg], Eq. 9
    at: Point2  # point of application in plan [m]


def shares_of_two(mass: float, com: Point2, first: ContactArea, second: ContactArea, readings: Readings) -> list[Share]:
    """Distribute a load [kg] over two supports neither of which is below its centre in plan [m]."""
    if readings.merge is Merge.LEVER_RULE:
        return _lever_rule(mass, com, first, second)
    return [
        Share(area.on, mass * _lever(com, area, beside, readings.pivot), _acts_at(area, com, readings.acts_at))
        for area, beside in ((first, second), (second, first))
    ]


def equal_shares(mass: float, com: Point2, areas: Sequence[ContactArea], readings: Readings) -> list[Share]:
    """Distribute a load [kg] equally over more than two supports: merge case 2."""
    return [Share(area.on, mass / len(areas), _acts_at(area, com, readings.equal_acts_at)) for area in areas]


def _acts_at(area: ContactArea, com: Point2, where: ActsAt) -> Point2:
    return area.centre if where is ActsAt.CONTACT else com


def _lever(com: Point2, area: ContactArea, other: ContactArea, closest: Closest) -> float:
    """Return the share of the load on `area` that balances the torque about a pivot on `other`: Eq. 3 to 9.

    With vertical gravity |torque| / (|lever| sin theta) depends only on horizontal distances.
    """
    pivot = _closest(other, com, closest)
    return dist(com, pivot) / dist(area.centre, pivot)


def _closest(area: ContactArea, com: Point2, closest: Closest) -> Point2:
    corners = [(x, y) for x, y, _ in area.points_W]
    if closest is Closest.POINT:
        corners = [_on_segment(a, b, com) for a, b in pairwise((*area.polygon, area.polygon[0]))]
    return min(corners, key=lambda point: (dist(point, com), point))


def _on_segment(a: Point2, b: Point2, com: Point2) -> Point2:
    """Return the point between a and b that is closest to a centre of mass."""
    along = min(1.0, max(0.0, _along(a, b, com)))
    return (a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1]))


def _along(a: Point2, b: Point2, com: Point2) -> float:
    """Return the position of a centre of mass projected on the line from a to b, as a share of the distance."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return ((com[0] - a[0]) * dx + (com[1] - a[1]) * dy) / (dx * dx + dy * dy)


def _lever_rule(mass: float, com: Point2, first: ContactArea, second: ContactArea) -> list[Share]:
    """Distribute a load by the lever rule between the centres of both contacts, shifted by com's offset from the line.

    So the shares add up to the load, and have its moment about every axis. Neither is negative.
    """
    part = min(1.0, max(0.0, _along(first.centre, second.centre, com)))
    on_line = _on_segment(first.centre, second.centre, com)
    off = (com[0] - on_line[0], com[1] - on_line[1])
    return [
        Share(area.on, mass * share, (area.centre[0] + off[0], area.centre[1] + off[1]))
        for area, share in ((first, 1.0 - part), (second, part))
    ]


# The published base model: the centre of mass of a brick and its load must lie above its contact.
#
# Source: the stack-stability thesis, sections 3.3.4 to 3.3.6; equation numbers below are its own. Its assumptions:
# - Friction between bricks of the stack is infinite, so only tipping is tested.
# - No brick of the stack stands on a brick that is not in the stack.
# - A brick that one support could carry alone rests on it, even if it touches more (merge case 1). If its centre of
#   mass lies over the joint of several supports, each of which could carry it, these share the load.
# - More than two supports share the weight equally, each part at com above (merge case 2).
# - Of two supports, each share is that with the other support's nearest contact point as pivot (merge case 3). The two
#   shares preserve neither the load nor its moment: supports far apart get less than the load, close ones more, and
#   stacks that lean out lose moment about their tipping edge. The model is kept so.


ON_THE_BORDER = 1e-9  # [m] tolerance outside the contact: the border itself counts as above


@dataclass(frozen=True, slots=True)
class StackedBrick:
    """Brick of the stack with its supports, which were in the stack before it."""

    id: BodyId
    mass: float  # [kg]
    com_W: Vec3  # [m]
    areas: tuple[ContactArea, ...]  # one per support; none for a leaning brick, see `LeaningBrick`
    main: Polygon  # hull over all supports

    @property
    def rests_on(self) -> tuple[BodyId, ...]:
        """The supports, including the ground."""
        return tuple(area.on for area in self.areas)


@dataclass(frozen=True, slots=True)
class CarriedLoad:
    """Load of a brick, itself included: mass above [kg], and com above in plan [m]."""

    mass: float
    com: Point2

    def plus(self, mass: float, at: Point2) -> "CarriedLoad":
        """Return the sum of this load and another one: Eq. 1 and 2, with an equivalent mass Eq. 10 and 11."""
        total = self.mass + mass
        x = (self.com[0] * self.mass + at[0] * mass) / total
        y = (self.com[1] * self.mass + at[1] * mass) / total
        return CarriedLoad(total, (x, y))


def lies_above(com: Point2, contact: Polygon) -> bool:
    """Check that a vertical ray from the centre of mass hits the contact (section 3.3.4)."""
    return signed_distance(com, contact) >= -ON_THE_BORDER


def shares(load: CarriedLoad, areas: tuple[ContactArea, ...], readings: Readings = AS_READ) -> tuple[Share, ...]:
    """Distribute a load over the supports: single branch, or one of the three merge cases of section 3.3.6.

    A leaning brick has no such areas, and passes no load on.
    """
    if len(areas) <= 1:
        return tuple(Share(area.on, load.mass, load.com) for area in areas)
    depths = [signed_distance(load.com, area.polygon) for area in areas]
    if max(depths) >= -ON_THE_BORDER:
        # All supports within the tolerance share, so that the result does not depend on names.
        areas = tuple(a for a, depth in zip(areas, depths, strict=True) if depth >= max(depths) - 2.0 * ON_THE_BORDER)
    if len(areas) == 1:
        return (Share(areas[0].on, load.mass, load.com),)
    if len(areas) > 2:  # noqa: PLR2004 -- merge case 2
        return tuple(equal_shares(load.mass, load.com, areas, readings))
    first, second = areas
    return tuple(shares_of_two(load.mass, load.com, first, second, readings))


def loads_above(stack: Mapping[BodyId, StackedBrick], readings: Readings = AS_READ) -> dict[BodyId, CarriedLoad]:
    """Return mass above and com above of every brick, from the top down, for single, split and merge branches."""
    add_work(LOAD * len(stack))
    loads = {name: CarriedLoad(brick.mass, (brick.com_W[0], brick.com_W[1])) for name, brick in stack.items()}
    for name in from_the_top({name: brick.rests_on for name, brick in stack.items()}):
        for share in shares(loads[name], stack[name].areas, readings):
            if share.on in loads:
                loads[share.on] = loads[share.on].plus(share.mass, share.at)
    return loads


def tipping_margin(brick: StackedBrick, load: CarriedLoad) -> float:
    """Return the distance of com above from the border of the main contact [m]; negative if the brick tips."""
    return signed_distance(load.com, brick.main)


def failing(stack: Mapping[BodyId, StackedBrick], loads: Mapping[BodyId, CarriedLoad]) -> tuple[BodyId, ...]:
    """Return the bricks whose com above is not above their main contact, sorted by name: the test of section 3.3.5."""
    resting = (name for name in sorted(stack) if stack[name].areas)
    return tuple(name for name in resting if not lies_above(loads[name].com, stack[name].main))
