"""Toppling: a part of a structure turns about an edge as one rigid body until it breaks up or hits something."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations
from math import dist, radians
from typing import TypeAlias

from stability.contacts.bodies import solid
from stability.contacts.detection import contact_between
from stability.dynamics.pendulum import Pendulum
from stability.geometry.box_distance import TOUCHING, reach_between
from stability.geometry.placed_shape import apart, apart_from_plane, corners_W, inertia_times
from stability.geometry.vectors import (
    about,
    add,
    add_scaled,
    cross,
    dot,
    inverse,
    multiply,
    norm,
    rotate,
    scale,
    subtract,
    unit,
)
from stability.model import BodyId, BodyState, Plane, Pose, Vec3
from stability.problem import Contact, Motion, Placed, Problem, Tolerances, Wrench

# Finds the angle up to which a falling part turns as one body: until its bricks slide, lift off or hit something.
#
# A part that begins to turn about an axis goes on as a pendulum: at each angle its speed and its acceleration are
# known. With the forces of inertia among the loads (d'Alembert) it falls as one, and what it turns on stands, if
# contact forces within the friction cones balance every brick: the same proof as for what stands. Contacts between what
# turns and what stands act where the axis goes through them, all others of these have opened.


GapAt: TypeAlias = Callable[[Pose], float]

DOWN: Vec3 = (0.0, 0.0, -1.0)
PITCH = 1e-6  # of the speed: more of it along the axis, and it is a screw
MET = 1e-4  # share of the depth of bodies in contact: less is rounding
ON_AXIS = TOUCHING  # share of the smallest side: nearer points stay where they are
ALONG = 1.0 - 1e-9  # cosine: edges run along the axis
FLAT = 1e-9  # volume that the normals of three faces span: less, and they meet in no corner


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn about a fixed axis."""

    point_W: Vec3  # on the axis [m]
    axis_W: Vec3  # unit, right-handed


@dataclass(frozen=True, slots=True)
class FallingPart:
    """Bricks that turn as one, among others that stand, and the contacts of all of them."""

    problem: Problem  # before the turn; bricks that feel nothing of it may be left out
    moving: Set[BodyId]  # those of the problem that turn
    turn: Turn
    pendulum: Pendulum
    gravity: float  # [m/s2]


def falling_part(problem: Problem, motion: Motion, gravity: float) -> FallingPart | None:
    """The part of a problem that begins to move; None if it is not one turn about one axis."""
    turn = turn_of(problem, motion)
    if turn is None:
        return None
    moving = [problem.bricks[name] for name in sorted(motion.velocity)]
    return FallingPart(problem, motion.velocity.keys(), turn, _pendulum(moving, turn, gravity), gravity)


def turn_of(problem: Problem, motion: Motion) -> Turn | None:
    """The turn about one axis with which all that moves begins; None if it does not."""
    if not motion.velocity or not problem.bricks.keys() >= motion.velocity.keys():
        return None
    first = min(motion.velocity)
    velocity, spin = motion.velocity[first]
    speed = norm(spin)
    fastest = max(norm(v) for v, _ in motion.velocity.values())  # what a solver leaves is a share of that
    if speed == 0.0 or abs(dot(velocity, spin)) > PITCH * speed * fastest:
        return None
    point = add(problem.bricks[first].pose.position_W, scale(1.0 / (speed * speed), cross(spin, velocity)))
    for name, (v, w) in motion.velocity.items():
        expected = cross(spin, subtract(problem.bricks[name].pose.position_W, point))
        if norm(subtract(w, spin)) > PITCH * speed or norm(subtract(v, expected)) > PITCH * fastest:
            return None
    return Turn(point, unit(spin))


def turned_part(part: FallingPart, angle: float) -> dict[BodyId, Placed]:
    """The bricks of a part in their places at an angle [rad]."""
    return {name: _turned(part.problem.bricks[name], part.turn, angle) for name in sorted(part.moving)}


def part_in_motion(part: FallingPart, angle: float, speed: float) -> dict[BodyId, BodyState]:
    """The states of the bricks of a part at an angle [rad] and its speed [rad/s]."""
    spin = scale(speed, part.turn.axis_W)
    return {
        name: BodyState(placed.pose, cross(spin, subtract(placed.pose.position_W, part.turn.point_W)), spin)
        for name, placed in turned_part(part, angle).items()
    }


def holds_together(part: FallingPart, angle: float) -> bool:
    """Whether it is proven to be one body at an angle [rad], and what it turns on to stand."""
    from stability.statics.equilibrium import balance  # noqa: PLC0415 -- it brings numpy, and what stands does without

    return balance(_at_angle(part, angle)).forces is not None


def is_clear(part: FallingPart, angle: float, others: Collection[Placed], planes: Collection[Plane]) -> bool:
    """Whether at an angle [rad] no brick of a part has come to lie in another body.

    What it touched before the turn it may lie in as deep as bodies in contact do; what it meets on the way, not at all:
    an engine that is given bricks inside each other drives them apart, which adds energy. What is near and does not
    touch, as a thin body fills the gap, it meets as that closes.
    """
    touched = {frozenset((contact.lower, contact.upper)) for contact in part.problem.contacts}
    for name, placed in turned_part(part, angle).items():
        own, depth = placed.brick.shape, ON_AXIS * placed.brick.shape.least_thickness
        for other, gap_at in _gaps(placed, others, planes):
            gap = gap_at(placed.pose)
            if gap >= -MET * depth:
                continue
            near = reach_between(own.least_thickness) if frozenset((name, other)) in touched else MET * depth
            if gap < -depth or gap_at(part.problem.bricks[name].pose) > near:
                return False
    return True


def _gaps(placed: Placed, others: Collection[Placed], planes: Collection[Plane]) -> Iterator[tuple[BodyId, GapAt]]:
    """The bodies that are near, and how far a brick is from each, for any pose."""
    shape, pose, around = placed.brick.shape, placed.pose, placed.brick.shape.bounding_radius
    for plane in planes:
        if _height(pose.position_W, plane) < around:
            yield plane.id, lambda pose, plane=plane: apart_from_plane(shape, pose, plane).gap  # type: ignore[misc]
    for other in others:
        if dist(pose.position_W, other.pose.position_W) < around + other.brick.shape.bounding_radius:
            yield other.brick.id, lambda pose, other=other: apart(shape, pose, other.brick.shape, other.pose).gap  # type: ignore[misc]


def reach(part: FallingPart) -> float:
    """The distance of the farthest corner of a part from its axis [m]."""
    corners = (c for name in part.moving for c in _corners(part.problem.bricks[name]))
    return max(norm(subtract(corner, _foot(part.turn, corner))) for corner in corners)


def _corners(placed: Placed) -> tuple[Vec3, ...]:
    return corners_W(placed.brick.shape, placed.pose)


def _height(point_W: Vec3, plane: Plane) -> float:
    return dot(subtract(point_W, plane.point_W), plane.normal_W)


def _turned(placed: Placed, turn: Turn, angle: float) -> Placed:
    around = about(turn.axis_W, angle)
    return Placed(
        placed.brick, Pose(_point(placed.pose.position_W, turn, angle), multiply(around, placed.pose.orientation))
    )


def _point(point_W: Vec3, turn: Turn, angle: float) -> Vec3:
    return add(turn.point_W, _direction(subtract(point_W, turn.point_W), turn, angle))


def _direction(vector_W: Vec3, turn: Turn, angle: float) -> Vec3:
    return rotate(about(turn.axis_W, angle), vector_W)


def _foot(turn: Turn, point_W: Vec3) -> Vec3:
    """The point of the axis that is nearest to a point."""
    return add_scaled(turn.point_W, dot(turn.axis_W, subtract(point_W, turn.point_W)), turn.axis_W)


def _pendulum(bricks: Collection[Placed], turn: Turn, gravity: float) -> Pendulum:
    torque = torque_across = 0.0
    for placed in bricks:
        arm = subtract(placed.pose.position_W, turn.point_W)
        weight = scale(placed.brick.mass * gravity, DOWN)
        torque += dot(turn.axis_W, cross(arm, weight))
        torque_across += dot(turn.axis_W, cross(cross(turn.axis_W, arm), weight))
    return Pendulum(sum(_about(turn, placed) for placed in bricks), torque, torque_across)


def _about(turn: Turn, placed: Placed) -> float:
    """The moment of inertia of a brick about the axis [kg m2]."""
    arm = cross(turn.axis_W, subtract(placed.pose.position_W, turn.point_W))
    return dot(_inertia_times(placed, turn.axis_W), turn.axis_W) + placed.brick.mass * dot(arm, arm)


def _inertia_times(placed: Placed, vector_W: Vec3) -> Vec3:
    return inertia_times(placed.brick, placed.pose.orientation, vector_W)


def _at_angle(part: FallingPart, angle: float) -> Problem:
    """The equilibrium of a part in mid-fall, with the forces of inertia among its loads."""
    moving = turned_part(part, angle)
    omega, alpha = part.pendulum.speed_at(angle), part.pendulum.acceleration_at(angle)
    loads: Mapping[BodyId, Wrench] = {
        name: _load(moving[name], part.turn, part.gravity, omega, alpha) if name in moving else load
        for name, load in part.problem.loads.items()
    }
    contacts = [found for contact in part.problem.contacts if (found := _contact(part, contact, angle)) is not None]
    return Problem({**part.problem.bricks, **moving}, contacts, loads)


def _load(placed: Placed, turn: Turn, gravity: float, omega: float, alpha: float) -> Wrench:
    """The weight of a brick less its mass times acceleration, and less the rate of change of its angular momentum."""
    arm, spin = subtract(placed.pose.position_W, turn.point_W), scale(omega, turn.axis_W)
    acceleration = add(cross(scale(alpha, turn.axis_W), arm), cross(spin, cross(spin, arm)))
    change = add(_inertia_times(placed, scale(alpha, turn.axis_W)), cross(spin, _inertia_times(placed, spin)))
    return Wrench(
        scale(placed.brick.mass, subtract(scale(gravity, DOWN), acceleration)),
        scale(-1.0, change),
    )


def _contact(part: FallingPart, contact: Contact, angle: float) -> Contact | None:
    """A contact in mid-fall. Within the part it turns along; with what stands, only its points on the axis remain."""
    turn, pair = part.turn, {contact.lower, contact.upper}
    turning = pair & part.moving
    if not turning:
        return contact
    normals = tuple(_direction(normal, turn, angle) for normal in contact.normals_W)
    if turning == pair:
        points = tuple(_point(point, turn, angle) for point in contact.points_W)
        return replace(contact, points_W=points, normals_W=normals, gaps=())
    moving = part.problem.bricks[min(turning)]
    found = contact if angle == 0.0 else _edge_contact(part, contact, moving, angle)
    points = _on_axis(part.turn, moving, found.points_W) if found is not None else ()
    return replace(found, points_W=points, gaps=()) if found and points else None


def _on_axis(turn: Turn, moving: Placed, points_W: Collection[Vec3]) -> tuple[Vec3, ...]:
    """Those of the points that lie on the axis: exactly, for beside it by what a solver leaves no forces balance."""
    near = ON_AXIS * moving.brick.shape.least_thickness
    return tuple(foot for point in points_W if norm(subtract(foot := _foot(turn, point), point)) <= near)


def _edge_contact(part: FallingPart, contact: Contact, moving: Placed, angle: float) -> Contact | None:
    """How a brick that turns touches what stands: the normal is that of the face on which an edge of the other lies."""
    other = part.problem.bricks.get(contact.lower if moving.brick.id == contact.upper else contact.upper)
    if other is not None:
        now = _turned(moving, part.turn, angle)
        return contact_between(solid(now), solid(other), contact.law.friction, Tolerances())
    if all(_on_own_edge(part.turn, moving, point) for point in _on_axis(part.turn, moving, contact.points_W)):
        return contact  # as on the ground
    normals = tuple(_direction(normal, part.turn, angle) for normal in contact.normals_W)
    return replace(contact, normals_W=normals, gaps=())


def _on_own_edge(turn: Turn, moving: Placed, point_W: Vec3) -> bool:
    """Whether at a point of the axis an edge of the brick lies along it, or a corner on it."""
    shape, near = moving.brick.shape, ON_AXIS * moving.brick.shape.least_thickness
    back = inverse(moving.pose.orientation)
    point, axis = rotate(back, subtract(point_W, moving.pose.position_W)), rotate(back, turn.axis_W)
    meeting = [face.normal for face in shape.faces if dot(face.normal, point) > shape.reach(face.normal) - near]
    edges = [cross(one, other) for one, other in combinations(meeting, 2)]
    if any(abs(dot(edge, axis)) > ALONG * norm(edge) > 0.0 for edge in edges):
        return True
    return any(abs(dot(cross(one, two), three)) > FLAT for one, two, three in combinations(meeting, 3))


# Toppling: a part turns about an axis as one body, for as long as it is proven to hold together and to hit nothing.


# It is proven that a part holds together at every fifth degree; it is parted at the last at which it does. Later the
# weight turns against the layers, and what reaches farther than 30 deg has hit something in most cases.
STAGE, FURTHEST = radians(5.0), radians(30.0)
ROUNDING = 1e-9  # share of an angle: stages are sums of angles
# A part is looked at so often that no corner of it passes more than this share of the smallest side unseen.
UNSEEN = 0.5


@dataclass
class Toppling:
    """A part that turns about one axis."""

    part: FallingPart
    others: Collection[Placed]  # what it may hit
    planes: Collection[Plane]
    pitch: float  # between the angles at which it is looked at [rad]
    angle: float = 0.0  # [rad]
    speed: float = 0.0  # of the angle [rad/s]
    _clear: float = 0.0  # the angle up to which nothing is hit [rad]
    _stage: float = 0.0  # up to which it is proven to hold together

    def goes_on(self, duration: float) -> bool:
        """Turn for a short time [s]; False, and not at all, if it is not proven that it does as one body."""
        angle, speed = self.part.pendulum.after(self.angle, self.speed, duration)
        while angle > self._clear:
            if not self._looked_further():
                return False
        self.angle, self.speed = angle, speed
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Where its bricks are, and how they move."""
        return part_in_motion(self.part, self.angle, self.speed)

    def take_landed(self) -> Sequence[BodyId]:
        """None: an engine takes over before anything rests again."""
        return ()

    def _looked_further(self) -> bool:
        if self._clear >= self._stage:
            stage = self._stage + STAGE
            if stage > FURTHEST * (1.0 + ROUNDING) or not holds_together(self.part, stage):
                return False
            self._stage = stage
        further = min(self._stage, self._clear + self.pitch)
        if not is_clear(self.part, further, self.others, self.planes):
            return False
        self._clear = further
        return True


def toppling_of(
    problem: Problem, motion: Motion, gravity: float, others: Collection[Placed], planes: Collection[Plane]
) -> Toppling | None:
    """How what begins to move topples; None if it is not one turn about one axis, or not proven to be one body.

    `others` and `planes` are what it may hit, what it turns on included.
    """
    part = falling_part(problem, motion, gravity)
    if part is None or not holds_together(part, 0.0):
        return None
    moving = [problem.bricks[name] for name in sorted(part.moving)]
    smallest = min(placed.brick.shape.least_thickness for placed in (*moving, *others))
    return Toppling(part, others, planes, UNSEEN * smallest / reach(part))
