"""The published base model: contact areas, support polygons and merge cases, with every reading of the text."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise, product
from math import dist, hypot

from stability.contacts.bodies import solid
from stability.contacts.detection import contact_between
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
from stability.geometry.vectors import body_axes, dot, subtract
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
from stability.problem import Placed, Tolerances
from stability.work_limit import LOAD, add_work

# The open points of the published text and their readings. The method runs with one choice of each.
#
# docs/design/publication.md say why the defaults are what they are, and docs/method.md what the others come to.


class Closest(Enum):
    """Which point of a contact is "the contact point closest to the centre of mass"."""

    CORNER = "corner"  # one of the contact points
    POINT = "point"  # any point of the contact area


class ActsAt(Enum):
    """Where the mass acts that one of several supports is given."""

    CONTACT = "contact"  # at the centre of its contact area, to which Eq. 6 takes the lever
    COM_ABOVE = "com above"  # at com above of the brick that hands it on, as Eq. 1 and Eq. 10 are written


class Merge(Enum):
    """How a load is shared by two supports neither of which could bear it alone (merge case 3)."""

    TORQUES = "torques"  # by the torque about a pivot on the other support, as published (Eq. 3 to 9)
    LEVER_RULE = "lever rule"  # not published: by the lever rule, so that load and moment are both kept


class SecondObjects(Enum):
    """Which moving bricks are "second impact objects", whose hits count for nothing (section 3.6.1)."""

    EVER_STACKED = "ever stacked"  # every brick that has been part of the stack, also long after it was woken
    NONE = "none"  # none that touches the stack by itself: every moving brick hits, with its own energy


class Square(Enum):
    """What the angle of Eq. 7 is measured against where a brick leans; its sine divides the force."""

    FORCE = "force"  # the force, which is square to the lever: no angle at all
    GRAVITY = "gravity"  # gravity, as in the base model
    NORMAL = "normal"  # the normal of the contact that is leaned on


@dataclass(frozen=True, slots=True)
class Readings:
    """One choice of each."""

    pivot: Closest = Closest.CORNER  # of merge case 3
    acts_at: ActsAt = ActsAt.CONTACT  # in plan, on two supports: merge case 3, Eq. 10
    equal_acts_at: ActsAt = ActsAt.COM_ABOVE  # in plan, on more than two: merge case 2
    height_acts_at: ActsAt = ActsAt.COM_ABOVE  # how high, on two or more; only the energy of an impact asks for it
    merge: Merge = Merge.TORQUES
    second_objects: SecondObjects = SecondObjects.EVER_STACKED
    leaning_pivot: Closest = Closest.POINT
    leaning_angle: Square = Square.FORCE


AS_READ = Readings()


# Contact areas as published: the convex hull, in plan, of the points at which a brick rests.
#
# Source: the stack-stability thesis, section 3.3.3. One area per support, and one over all supports (the main contact).
# Two points are widened sideways into a thin quad, one becomes a small diamond, because a line or a point has no
# inside. The source takes the engine's points, orders them by gift wrapping, and spans a mesh over them that rays can
# meet. What is done here instead decides the same (docs/design/contacts.md).


# [m] "a short distance" in the source. A tenth of a plank's edge is felt by hand, half a millimetre is not.
WIDENING = 5e-4


@dataclass(frozen=True, slots=True)
class ContactArea:
    """Where a brick rests on one support."""

    on: BodyId
    points_W: tuple[Vec3, ...]  # contact points [m], as they were given
    polygon: Polygon  # their hull in plan, widened if it has no area
    centre: Point2  # of the polygon [m]


def contact_area(on: BodyId, points_W: Sequence[Vec3]) -> ContactArea:
    """The area of contact with one support; at least one point is needed."""
    polygon = plan_hull(points_W)
    return ContactArea(on, tuple(points_W), polygon, centroid(polygon))


def main_contact(areas: Iterable[ContactArea]) -> Polygon:
    """The hull over all supports: what the brick stands on as a whole."""
    return plan_hull([point for area in areas for point in area.points_W])


def plan_hull(points_W: Sequence[Vec3]) -> Polygon:
    """The convex hull seen from above, made two-dimensional where the points are one or on a line."""
    hull = convex_hull((x, y) for x, y, _ in points_W)
    polygon = straightened(hull)
    if polygon:
        return polygon
    one, other = max(product(hull, repeat=2), key=lambda ends: dist(*ends))
    return _thin_quad(one, other) if dist(one, other) > STRAIGHT else _diamond(one)


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
# Engines keep at most four contact points a pair, and where edges of the two faces coincide, as they do in every flush
# stack, rounding decides which: PyBullet then reports points in the middle of an edge and drops corners. So the engine
# is asked whether two bricks touch, and geometry where.


PARALLEL = 0.9994  # cosine of 2 deg: faces further apart in direction touch along an edge, not over an area


def face_patch(upper_size: Vec3, upper: Pose, lower_size: Vec3, lower: Pose) -> tuple[Vec3, ...]:
    """The corners of the overlap of the upper box's under side with the lower box's top [m, in W], in its plane.

    Counter-clockwise seen from above; empty if no two such faces are parallel, or if they do not overlap.
    """
    (axis_u, _), (axis_l, sign) = _most_upright(upper), _most_upright(lower)
    axes_u, axes_l = body_axes(upper.orientation), body_axes(lower.orientation)
    if abs(dot(axes_u[axis_u], axes_l[axis_l])) < PARALLEL:
        return ()
    first, second = (axis for axis in range(3) if axis != axis_l)
    top = 0.5 * sign * lower_size[axis_l]
    under_side = sorted(corners_W(Box(upper_size), upper), key=lambda corner: dot(corner, axes_l[axis_l]) * sign)[:4]
    in_face = [_coordinates(corner, lower, (axes_l[first], axes_l[second])) for corner in under_side]
    half = (0.5 * lower_size[first], 0.5 * lower_size[second])
    corners = straightened(tuple(within_rectangle(convex_hull(in_face), *half)))
    placed = [_in_world(corner, lower, (axes_l[first], axes_l[second], axes_l[axis_l]), top) for corner in corners]
    clockwise = bool(placed) and doubled_area([(x, y) for x, y, _ in placed])[0] < 0.0
    return tuple(placed[::-1] if clockwise else placed)


def _most_upright(pose: Pose) -> tuple[int, float]:
    """The body axis that is closest to the vertical, and its sign upwards."""
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
# The engine says which bodies are near. Where both are convex, or the lower one is a half-space, geometry says whether
# they touch, from which side, and at which corners (docs/design/contacts.md). Only of other shapes, and of bodies that
# touch along an edge, the engine's own contact points are used.
#
# The source also disregards contacts that come from impacts. Here that follows: a brick is tested only when it is slow,
# and only against bodies that do not move.


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
    near = [body for body in engine.neighbours(brick, reach_of(shape)) if body in supports]
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


# Supports that share a load which none could bear alone: merge cases 2 and 3, and a rule that keeps moments.
#
# Source: the stack-stability thesis, section 3.3.6; equation numbers are its own.
# `stability.stabilizers.published.support` names what its text leaves open.


@dataclass(frozen=True, slots=True)
class Share:
    """Part of a load that goes to one support."""

    on: BodyId
    mass: float  # equivalent mass [kg], Eq. 9
    at: Point2  # where it acts, in plan [m]


def shares_of_two(mass: float, com: Point2, one: ContactArea, other: ContactArea, readings: Readings) -> list[Share]:
    """What each of two supports is given of a load [kg] whose centre lies above neither, in plan [m]."""
    if readings.merge is Merge.LEVER_RULE:
        return _lever_rule(mass, com, one, other)
    return [
        Share(area.on, mass * _lever(com, area, beside, readings.pivot), _acts_at(area, com, readings.acts_at))
        for area, beside in ((one, other), (other, one))
    ]


def equal_shares(mass: float, com: Point2, areas: Sequence[ContactArea], readings: Readings) -> list[Share]:
    """What each of more than two supports is given of a load [kg]: merge case 2."""
    return [Share(area.on, mass / len(areas), _acts_at(area, com, readings.equal_acts_at)) for area in areas]


def _acts_at(area: ContactArea, com: Point2, where: ActsAt) -> Point2:
    return area.centre if where is ActsAt.CONTACT else com


def _lever(com: Point2, area: ContactArea, other: ContactArea, closest: Closest) -> float:
    """Eq. 3 to 9: which part of the load a force on `area` must hold up, so that nothing turns about `other`.

    |torque| / (|lever| sin theta) with gravity vertical leaves horizontal distances only.
    """
    pivot = _closest(other, com, closest)
    return dist(com, pivot) / dist(area.centre, pivot)


def _closest(area: ContactArea, com: Point2, closest: Closest) -> Point2:
    corners = [(x, y) for x, y, _ in area.points_W]
    if closest is Closest.POINT:
        corners = [_on_segment(a, b, com) for a, b in pairwise((*area.polygon, area.polygon[0]))]
    return min(corners, key=lambda point: (dist(point, com), point))


def _on_segment(a: Point2, b: Point2, com: Point2) -> Point2:
    """The point between a and b that is closest to a centre of mass."""
    along = min(1.0, max(0.0, _along(a, b, com)))
    return (a[0] + along * (b[0] - a[0]), a[1] + along * (b[1] - a[1]))


def _along(a: Point2, b: Point2, com: Point2) -> float:
    """How far along from a to b a centre of mass lies beside, as a share of that way."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return ((com[0] - a[0]) * dx + (com[1] - a[1]) * dy) / (dx * dx + dy * dy)


def _lever_rule(mass: float, com: Point2, one: ContactArea, other: ContactArea) -> list[Share]:
    """Between the centres of both contacts by the lever rule, both moved by as much as com lies off that line.

    So the shares add up to the load, and have its moment about every axis. Neither is negative.
    """
    part = min(1.0, max(0.0, _along(one.centre, other.centre, com)))
    on_line = _on_segment(one.centre, other.centre, com)
    off = (com[0] - on_line[0], com[1] - on_line[1])
    return [
        Share(area.on, mass * share, (area.centre[0] + off[0], area.centre[1] + off[1]))
        for area, share in ((one, 1.0 - part), (other, part))
    ]


# The published base model: does the centre of mass of a brick and of all that it carries lie above its contact?
#
# Source: the stack-stability thesis, sections 3.3.4 to 3.3.6; equation numbers below are its own. Its assumptions:
# - Friction between bricks of the stack is infinite, so only tipping is tested.
# - Nothing in the stack stands on a brick that is not in the stack.
# - A brick that could rest wholly on one support does, even if it touches more (merge case 1). Where it could rest on
#   any of several alike, for its centre of mass lies over the joint between them, none is that one, and these share.
# - Over more than two supports the weight is shared equally, each part at com above (merge case 2).
# - Over two supports, each share is found as if the other support's nearest contact point were a pivot (merge case 3).
#   The two shares keep neither the load nor its moment: supports far apart are given less than it, close together more,
#   and stacks that lean out lose moment about the edge that they tip over. The model is kept so.


ON_THE_BORDER = 1e-9  # [m] a centre of mass this close outside still counts as above: the limit itself is neutral


@dataclass(frozen=True, slots=True)
class StackedBrick:
    """A brick of the stack and what it stands on. Its supports were in the stack before it."""

    id: BodyId
    mass: float  # [kg]
    com_W: Vec3  # [m]
    areas: tuple[ContactArea, ...]  # one a support; none if it leans, for what it leans on is kept elsewhere
    main: Polygon  # hull over all supports

    @property
    def rests_on(self) -> tuple[BodyId, ...]:
        """The supports, the ground included."""
        return tuple(area.on for area in self.areas)


@dataclass(frozen=True, slots=True)
class CarriedLoad:
    """What a brick carries, itself included: mass above [kg] and com above, in plan [m]."""

    mass: float
    com: Point2

    def plus(self, mass: float, at: Point2) -> "CarriedLoad":
        """This load and another one: Eq. 1 and 2, and with an equivalent mass Eq. 10 and 11."""
        total = self.mass + mass
        x = (self.com[0] * self.mass + at[0] * mass) / total
        y = (self.com[1] * self.mass + at[1] * mass) / total
        return CarriedLoad(total, (x, y))


def lies_above(com: Point2, contact: Polygon) -> bool:
    """Section 3.3.4: does a ray from the centre of mass straight down hit the contact?"""
    return signed_distance(com, contact) >= -ON_THE_BORDER


def shares(load: CarriedLoad, areas: tuple[ContactArea, ...], readings: Readings = AS_READ) -> tuple[Share, ...]:
    """How a load is distributed over the supports: single branch, or one of the three merge cases of section 3.3.6.

    A brick that leans has no areas of this kind, and passes nothing on.
    """
    if len(areas) <= 1:
        return tuple(Share(area.on, load.mass, load.com) for area in areas)
    depths = [signed_distance(load.com, area.polygon) for area in areas]
    if max(depths) >= -ON_THE_BORDER:
        # No name decides: within the border on both sides of a joint, either support could bear it.
        areas = tuple(a for a, depth in zip(areas, depths, strict=True) if depth >= max(depths) - 2.0 * ON_THE_BORDER)
    if len(areas) == 1:
        return (Share(areas[0].on, load.mass, load.com),)
    if len(areas) > 2:  # noqa: PLR2004 -- merge case 2
        return tuple(equal_shares(load.mass, load.com, areas, readings))
    one, other = areas
    return tuple(shares_of_two(load.mass, load.com, one, other, readings))


def loads_above(stack: Mapping[BodyId, StackedBrick], readings: Readings = AS_READ) -> dict[BodyId, CarriedLoad]:
    """Mass above and com above of every brick, from the top down (single, split and merge branches alike)."""
    add_work(LOAD * len(stack))
    loads = {name: CarriedLoad(brick.mass, (brick.com_W[0], brick.com_W[1])) for name, brick in stack.items()}
    for name in from_the_top({name: brick.rests_on for name, brick in stack.items()}):
        for share in shares(loads[name], stack[name].areas, readings):
            if share.on in loads:
                loads[share.on] = loads[share.on].plus(share.mass, share.at)
    return loads


def tipping_margin(brick: StackedBrick, load: CarriedLoad) -> float:
    """How far com above lies inside the main contact [m]; negative if it tips."""
    return signed_distance(load.com, brick.main)


def failing(stack: Mapping[BodyId, StackedBrick], loads: Mapping[BodyId, CarriedLoad]) -> tuple[BodyId, ...]:
    """The stack test of section 3.3.5: every brick whose com above is not above its main contact, by name."""
    resting = (name for name in sorted(stack) if stack[name].areas)
    return tuple(name for name in resting if not lies_above(loads[name].com, stack[name].main))
