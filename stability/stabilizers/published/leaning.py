"""The published leaning model: two contacts with friction that hold a brick which the base model finds unstable."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement, pairwise
from math import dist, hypot

from stability.contact_law import Friction
from stability.contacts.bodies import Solid, convex_solid
from stability.contacts.detection import contact_between, contact_with_plane
from stability.engines.protocol import Engine
from stability.geometry.box_distance import PARALLEL, in_world
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import add_scaled, cross, dot, norm, scale, subtract, unit
from stability.model import BodyId, Brick, ConvexShape, HalfSpace, Plane, Pose, Shape, Vec3, convex
from stability.problem import ZERO, Contact, Placed, Tolerances
from stability.stabilizers.published.support import AS_READ, CarriedLoad, Closest, Readings, Square, may_stand, reach_of

# Source: the stack-stability thesis, sections 3.4 and 3.5; equation numbers below are its own. Its model:
# - Exactly two contacts, at different heights. The brick turns about the lower one, the pivot, under its weight.
# - The force from that torque on the upper contact is perpendicular to the line from the pivot to that contact.
# - The upper contact carries as much weight as its static friction allows; the rest must not slide the pivot away.
#
# Its faults, which are kept:
# - The normal force on the upper contact is a projection where equilibrium would divide: it is too small by sin^2 of
#   the angle for a plank against a wall. Planks that lean flatly stand with hardly any friction.
# - Only magnitudes are compared: an upper contact also holds a brick that falls away from it.
# - The stability of the supporting body is not tested: a plank held by one that itself leans away stands.
# - Leaning bricks pass no weight on: leaning contacts and base contacts are independent.
#
# docs/design/publication.md describes the reading of ambiguous text.


# Least difference in height of two leaning contacts, as a share of the brick's smallest side: in a stack of flat planks
# supports differ by nothing, or by whole planks.
RISE = 0.5


@dataclass(frozen=True, slots=True)
class LeaningArea:
    """Contact area of a brick with a body that may hold it, level or not."""

    on: BodyId
    points_W: tuple[Vec3, ...]  # a point, the ends of a line, or the ordered corners of a convex patch [m]
    normal_W: Vec3  # unit, from the body towards the brick
    friction: float  # Coulomb coefficient

    @property
    def height(self) -> float:
        """Mean height of the points [m]."""
        return height(self.points_W)


@dataclass(frozen=True, slots=True)
class LeaningBrick:
    """Contacts of a leaning brick of the stack."""

    pivot: LeaningArea  # lower contact
    contact: LeaningArea  # upper contact

    @property
    def leans_on(self) -> tuple[BodyId, BodyId]:
        """Both supporting bodies, including the ground."""
        return (self.pivot.on, self.contact.on)


@dataclass(frozen=True, slots=True)
class LeaningForces:
    """Forces of a leaning brick on its two contacts, divided by g as in Eq. 9 [kg]; all in W."""

    normal_at_contact: Vec3  # F_n
    friction_at_contact: Vec3  # F_f, in the direction of the impending slip
    on_pivot: Vec3  # F_p
    normal_at_pivot: Vec3
    sliding_at_pivot: Vec3
    friction_at_pivot: float  # limit of the static friction

    @property
    def hold(self) -> bool:
        """Whether the friction at the pivot exceeds the sliding force."""
        return self.friction_at_pivot > norm(self.sliding_at_pivot)


def height(points_W: Sequence[Vec3]) -> float:
    """Return the mean height of contact points [m]."""
    return sum(z for _, _, z in points_W) / len(points_W)


def differ_in_height(first_W: Sequence[Vec3], second_W: Sequence[Vec3], smallest_side: float) -> bool:
    """Check that two contacts differ so much in height that a brick leans on them instead of resting (section 3.5)."""
    return abs(height(first_W) - height(second_W)) >= RISE * smallest_side


def leaning_brick(areas: Sequence[LeaningArea], smallest_side: float) -> LeaningBrick | None:
    """Return the leaning contacts of a brick with these areas; None unless there are two at different heights."""
    if len(areas) != 2:  # noqa: PLR2004 -- the source: one contact is no leaning, three are too complicated
        return None
    if not differ_in_height(areas[0].points_W, areas[1].points_W, smallest_side):
        return None
    lower, upper = sorted(areas, key=lambda area: area.height)
    return LeaningBrick(lower, upper)


def holds(brick: LeaningBrick, load: CarriedLoad, readings: Readings = AS_READ) -> bool:
    """Check that a leaning brick is stable under its load, itself included (section 3.4.3)."""
    forces = leaning_forces(brick, load, readings)
    return forces is not None and forces.hold


def leaning_forces(brick: LeaningBrick, load: CarriedLoad, readings: Readings = AS_READ) -> LeaningForces | None:
    """Return the forces of section 3.4.3; None if the upper contact lies on the axis of the weight's torque."""
    pressing = _force_on_contact(brick, load, readings)
    if pressing is None:
        return None
    weight = (0.0, 0.0, -load.mass)
    normal = _along(pressing, brick.contact.normal_W)
    sliding = subtract(pressing, normal)
    # Eq. 12; static friction does not exceed the force that it opposes, and changes continuously near 0.
    friction = scale(min(brick.contact.friction * norm(normal), norm(sliding)), _direction(sliding))
    on_pivot = subtract(subtract(weight, normal), friction)  # Eq. 13
    normal_at_pivot = _along(on_pivot, brick.pivot.normal_W)
    return LeaningForces(
        normal,
        friction,
        on_pivot,
        normal_at_pivot,
        sliding_at_pivot=subtract(on_pivot, normal_at_pivot),
        friction_at_pivot=brick.pivot.friction * norm(normal_at_pivot),  # Eq. 12 again
    )


def failing_leaning(
    bricks: Mapping[BodyId, LeaningBrick], loads: Mapping[BodyId, CarriedLoad], readings: Readings = AS_READ
) -> tuple[BodyId, ...]:
    """Return the leaning bricks that are not stable under their loads, sorted by name: the stack test."""
    return tuple(name for name in sorted(bricks) if not holds(bricks[name], loads[name], readings))


def _force_on_contact(brick: LeaningBrick, load: CarriedLoad, readings: Readings) -> Vec3 | None:
    """Return the force on the upper contact from the torque of the weight about the pivot."""
    x, y = load.com
    pivot = _nearest_in_plan(brick.pivot.points_W, (x, y), readings.leaning_pivot)
    # The weight is vertical, so the height of the centre of mass has no effect.
    torque = cross(subtract((x, y, 0.0), pivot), (0.0, 0.0, -load.mass))  # Eq. 4
    lever = subtract(_centre(brick.contact.points_W), pivot)
    across = cross(torque, lever)
    if norm(across) <= PARALLEL * norm(torque) * norm(lever):
        return None if norm(torque) > 0.0 else ZERO
    effective = _effective(lever, brick.contact.normal_W, readings.leaning_angle)
    if effective <= PARALLEL * norm(lever):
        return None if norm(torque) > 0.0 else ZERO
    return scale(norm(torque) / effective, _direction(across))  # Eq. 7


def _effective(lever: Vec3, normal_W: Vec3, angle: Square) -> float:
    """Return the length of a lever times the sine of Eq. 7 [m]."""
    match angle:
        case Square.FORCE:
            return norm(lever)
        case Square.GRAVITY:
            return hypot(lever[0], lever[1])
        case Square.NORMAL:
            return norm(cross(lever, normal_W))


def _along(force: Vec3, normal_W: Vec3) -> Vec3:
    """Return the component of a force along a normal, regardless of its sign: a contact may also pull."""
    return scale(dot(force, normal_W), normal_W)


def _direction(vector: Vec3) -> Vec3:
    length = norm(vector)
    return scale(1.0 / length, vector) if length > 0.0 else ZERO


def _nearest_in_plan(points_W: Sequence[Vec3], com: tuple[float, float], closest: Closest) -> Vec3:
    """Return the point or corner of an area that is closest to the centre of mass in plan."""
    corners = closest is Closest.CORNER
    pairs = zip(points_W, points_W, strict=True) if corners else combinations_with_replacement(points_W, 2)
    candidates = [_nearest_on_line(a, b, com) for a, b in pairs]
    return min(candidates, key=lambda point: (dist(point[:2], com), point))


def _nearest_on_line(a: Vec3, b: Vec3, com: tuple[float, float]) -> Vec3:
    ab = subtract(b, a)
    squared = ab[0] ** 2 + ab[1] ** 2
    if squared == 0.0:
        return min(a, b, key=lambda point: point[2])
    along = ((com[0] - a[0]) * ab[0] + (com[1] - a[1]) * ab[1]) / squared
    return add_scaled(a, min(1.0, max(0.0, along)), ab)


def _centre(points_W: Sequence[Vec3]) -> Vec3:
    """Return the centre of a patch, of a line, or the point itself."""
    first, *others = points_W
    total, centre = 0.0, ZERO
    for a, b in pairwise(others):
        area = norm(cross(subtract(a, first), subtract(b, first)))
        middle = tuple((p + q + r) / 3.0 for p, q, r in zip(first, a, b, strict=True))
        total += area
        centre = add_scaled(centre, area, (middle[0], middle[1], middle[2]))
    if total > 0.0:
        return scale(1.0 / total, centre)
    count = len(points_W)
    x, y, z = (sum(part) / count for part in zip(*points_W, strict=True))
    return (x, y, z)


# Contacts on which a brick may lean, with exact points and normals.
#
# The engine provides the neighbours, and geometry the contact points and normals, as engines give edge contacts a face
# normal (docs/design/publication.md). Only convex solids and half-spaces are supported: near any other shape a brick
# has no leaning contacts and stays with the engine. So does a round brick, and a brick beside a round one on its side:
# the model does not know that these can roll.


NO_MASS = 0.0  # mass has no effect on contacts
# The other body lies on the brick if the z component of the normal towards the brick is smaller, as in the base model.
ON_TOP = -0.5


@dataclass(frozen=True, slots=True)
class LeaningFrictions:
    """Friction of bricks on each other and on fixed bodies."""

    friction: Friction
    planes: Mapping[BodyId, Plane] = field(default_factory=dict)

    def between(self, brick: BodyId, body: BodyId) -> float:
        """Return the Coulomb coefficient of a brick on a body; an unknown body counts as a brick."""
        plane = self.planes.get(body)
        return self.friction.of(brick, body) if plane is None else self.friction.on(brick, plane)


def smallest_side(engine: Engine, brick: BodyId) -> float | None:
    """Return the smallest side of a brick [m]; None if its shape is not convex."""
    shape = convex(engine.shape(brick))
    return None if shape is None else shape.least_thickness


def neighbours(engine: Engine, brick: BodyId) -> Sequence[BodyId]:
    """Return the bodies near enough to touch a brick."""
    return engine.neighbours(brick, reach_of(engine.shape(brick)))


def touching_areas(engine: Engine, brick: BodyId, surfaces: LeaningFrictions) -> Sequence[LeaningArea]:
    """Return the contact areas of a brick with bodies that do not lie on it; none near an unsupported shape."""
    bodies = engine.masses().keys() | engine.fixed()
    shape = engine.shape(brick)
    if isinstance(shape, RoundSolid):
        return ()
    near = neighbours(engine, brick)
    if not bodies.issuperset(near):
        return ()
    states = engine.states([brick, *near])
    solid_of_brick = _solid(brick, shape, states[brick].pose)
    areas = []
    for body in near:
        other, pose = engine.shape(body), states[body].pose
        if solid_of_brick is None or other is None or (isinstance(other, RoundSolid) and not may_stand(other, pose)):
            return ()
        contact = _contact(solid_of_brick, body, other, pose, surfaces.between(brick, body))
        if contact:
            areas.append(_area(contact, brick))
    return [area for area in areas if area.normal_W[2] > ON_TOP]


def _solid(body: BodyId, shape: Shape, pose: Pose) -> Solid | None:
    convex_shape = convex(shape)
    return None if convex_shape is None else convex_solid(Placed(Brick(body, convex_shape, NO_MASS), pose))


def _contact(own: Solid, body: BodyId, shape: ConvexShape | HalfSpace, pose: Pose, friction: float) -> Contact | None:
    if not isinstance(shape, HalfSpace):
        return contact_between(own, convex_solid(Placed(Brick(body, shape, NO_MASS), pose)), friction, Tolerances())
    surface = in_world(shape, pose)
    return contact_with_plane(own, Plane(body, surface.point_W, surface.normal_W, friction), Tolerances())


def _area(contact: Contact, brick: BodyId) -> LeaningArea:
    """Convert a contact to a leaning area of a brick, with the mean of its normals."""
    x, y, z = (sum(parts) for parts in zip(*contact.normals_W, strict=True))
    upper = contact.upper == brick
    normal_W = scale(1.0 if upper else -1.0, unit((x, y, z)))
    return LeaningArea(contact.lower if upper else contact.upper, contact.points_W, normal_W, contact.law.friction)
