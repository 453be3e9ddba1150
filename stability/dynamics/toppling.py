"""Toppling: a part of a structure turns about an edge as one rigid body until it breaks up or hits a body."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations
from math import dist, radians
from typing import TypeAlias

from stability.contacts.bodies import convex_solid
from stability.contacts.detection import contact_between
from stability.dynamics.pendulum import Pendulum
from stability.geometry.box_distance import TOUCHING, reach_between
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import apart, apart_from_plane, corners_W, inertia_times
from stability.geometry.round_solid import RoundSolid
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

# Proof that a falling part turns as one body up to an angle: its bricks do not slide, lift off or hit a body.
#
# A part that turns about an axis is a pendulum, whose speed and acceleration at each angle are known. With the inertial
# forces among the loads (d'Alembert), it stays one body and its supports stand if contact forces within the friction
# cones balance every brick: the same proof as for a standing structure. Of the contacts between turning and standing
# bricks only points on the axis act; all others have opened.


GapAt: TypeAlias = Callable[[Pose], float]

DOWN: Vec3 = (0.0, 0.0, -1.0)
PITCH = 1e-6  # largest share of the speed along the axis; a larger share makes it a screw
MET = 1e-4  # share of the largest overlap of a contact: less is rounding
ON_AXIS = TOUCHING  # share of the smallest side: closer points lie on the axis
ALONG = 1.0 - 1e-9  # least cosine of edges along the axis
FLAT = 1e-9  # least volume that the normals of three faces span at a corner


@dataclass(frozen=True, slots=True)
class Turn:
    """Rotation about a fixed axis."""

    point_W: Vec3  # on the axis [m]
    axis_W: Vec3  # unit, right-handed


@dataclass(frozen=True, slots=True)
class FallingPart:
    """Bricks that turn as one body, with standing bricks around them, and all contacts."""

    problem: Problem  # before the rotation; unaffected bricks may be omitted
    moving: Set[BodyId]  # turning bricks
    turn: Turn
    pendulum: Pendulum
    gravity: float  # [m/s2]


def falling_part(problem: Problem, motion: Motion, gravity: float) -> FallingPart | None:
    """Return the moving part of a problem; None unless the motion is one rotation about one axis."""
    turn = turn_of(problem, motion)
    if turn is None:
        return None
    moving = [problem.bricks[name] for name in sorted(motion.velocity)]
    return FallingPart(problem, motion.velocity.keys(), turn, _pendulum(moving, turn, gravity), gravity)


def turn_of(problem: Problem, motion: Motion) -> Turn | None:
    """Return the common rotation of all moving bricks; None if they have none."""
    if not motion.velocity or not problem.bricks.keys() >= motion.velocity.keys():
        return None
    first = min(motion.velocity)
    velocity, spin = motion.velocity[first]
    speed = norm(spin)
    fastest = max(norm(v) for v, _ in motion.velocity.values())  # errors of a solver are relative to it
    if speed == 0.0 or abs(dot(velocity, spin)) > PITCH * speed * fastest:
        return None
    point = add(problem.bricks[first].pose.position_W, scale(1.0 / (speed * speed), cross(spin, velocity)))
    for name, (v, w) in motion.velocity.items():
        expected = cross(spin, subtract(problem.bricks[name].pose.position_W, point))
        if norm(subtract(w, spin)) > PITCH * speed or norm(subtract(v, expected)) > PITCH * fastest:
            return None
    return Turn(point, unit(spin))


def turned_part(part: FallingPart, angle: float) -> dict[BodyId, Placed]:
    """Return the bricks of a part at an angle [rad]."""
    return {name: _turned(part.problem.bricks[name], part.turn, angle) for name in sorted(part.moving)}


def part_in_motion(part: FallingPart, angle: float, speed: float) -> dict[BodyId, BodyState]:
    """Return the states of the bricks of a part at an angle [rad] and an angular speed [rad/s]."""
    spin = scale(speed, part.turn.axis_W)
    return {
        name: BodyState(placed.pose, cross(spin, subtract(placed.pose.position_W, part.turn.point_W)), spin)
        for name, placed in turned_part(part, angle).items()
    }


def holds_together(part: FallingPart, angle: float) -> bool:
    """Check for a proof that a part is one body at an angle [rad] and that its supports stand."""
    from stability.statics.equilibrium import balance  # noqa: PLC0415 -- imports numpy, which proofs of standing rarely need

    return balance(_at_angle(part, angle)).forces is not None


def is_clear(part: FallingPart, angle: float, others: Collection[Placed], planes: Collection[Plane]) -> bool:
    """Check that no brick of a part overlaps another body at an angle [rad].

    A body that it touched initially may overlap as in a contact. Any other body must not overlap, as an engine would
    push overlapping bricks apart and add energy. A body behind a filled gap counts as hit when the gap closes.
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
    """Yield the near bodies, each with the gap of the brick as a function of its pose."""
    shape, pose, around = placed.brick.shape, placed.pose, placed.brick.shape.bounding_radius
    for plane in planes:
        if _height(pose.position_W, plane) < around:
            yield plane.id, lambda pose, plane=plane: apart_from_plane(shape, pose, plane).gap  # type: ignore[misc]
    for other in others:
        if dist(pose.position_W, other.pose.position_W) < around + other.brick.shape.bounding_radius:
            yield other.brick.id, lambda pose, other=other: apart(shape, pose, other.brick.shape, other.pose).gap  # type: ignore[misc]


def reach(part: FallingPart) -> float:
    """Return the distance of the farthest corner of a part from its axis [m]."""
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
    """Return the point of the axis that is nearest to a point."""
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
    """Return the moment of inertia of a brick about the axis [kg m2]."""
    arm = cross(turn.axis_W, subtract(placed.pose.position_W, turn.point_W))
    return dot(_inertia_times(placed, turn.axis_W), turn.axis_W) + placed.brick.mass * dot(arm, arm)


def _inertia_times(placed: Placed, vector_W: Vec3) -> Vec3:
    return inertia_times(placed.brick, placed.pose.orientation, vector_W)


def _at_angle(part: FallingPart, angle: float) -> Problem:
    """Return the equilibrium problem of a part during its fall, with inertial forces among the loads."""
    moving = turned_part(part, angle)
    omega, alpha = part.pendulum.speed_at(angle), part.pendulum.acceleration_at(angle)
    loads: Mapping[BodyId, Wrench] = {
        name: _load(moving[name], part.turn, part.gravity, omega, alpha) if name in moving else load
        for name, load in part.problem.loads.items()
    }
    contacts = [moved for contact in part.problem.contacts if (moved := _contact(part, contact, angle)) is not None]
    return Problem({**part.problem.bricks, **moving}, contacts, loads)


def _load(placed: Placed, turn: Turn, gravity: float, omega: float, alpha: float) -> Wrench:
    """Return weight minus mass times acceleration, and minus the rate of change of angular momentum, of a brick."""
    arm, spin = subtract(placed.pose.position_W, turn.point_W), scale(omega, turn.axis_W)
    acceleration = add(cross(scale(alpha, turn.axis_W), arm), cross(spin, cross(spin, arm)))
    change = add(_inertia_times(placed, scale(alpha, turn.axis_W)), cross(spin, _inertia_times(placed, spin)))
    return Wrench(
        scale(placed.brick.mass, subtract(scale(gravity, DOWN), acceleration)),
        scale(-1.0, change),
    )


def _contact(part: FallingPart, contact: Contact, angle: float) -> Contact | None:
    """Return a contact during the fall: rotated inside the part; with a standing body only its points on the axis."""
    turn, pair = part.turn, {contact.lower, contact.upper}
    turning = pair & part.moving
    if not turning:
        return contact
    normals = tuple(_direction(normal, turn, angle) for normal in contact.normals_W)
    if turning == pair:
        points = tuple(_point(point, turn, angle) for point in contact.points_W)
        return replace(contact, points_W=points, normals_W=normals, gaps=())
    moving = part.problem.bricks[min(turning)]
    touching = contact if angle == 0.0 else _edge_contact(part, contact, moving, angle)
    points = _on_axis(part.turn, moving, touching.points_W) if touching is not None else ()
    return replace(touching, points_W=points, gaps=()) if touching and points else None


def _on_axis(turn: Turn, moving: Placed, points_W: Collection[Vec3]) -> tuple[Vec3, ...]:
    """Return the points that are near the axis, projected onto it.

    Without the projection, the rounding errors of the solver would leave small torques that no forces balance.
    """
    near = ON_AXIS * moving.brick.shape.least_thickness
    return tuple(foot for point in points_W if norm(subtract(foot := _foot(turn, point), point)) <= near)


def _edge_contact(part: FallingPart, contact: Contact, moving: Placed, angle: float) -> Contact | None:
    """Return the contact of a turning brick with a standing body: an edge on a face, with the normal of the face."""
    other = part.problem.bricks.get(contact.lower if moving.brick.id == contact.upper else contact.upper)
    if other is not None:
        now = _turned(moving, part.turn, angle)
        return contact_between(convex_solid(now), convex_solid(other), contact.law.friction, Tolerances())
    if all(_on_own_edge(part.turn, moving, point) for point in _on_axis(part.turn, moving, contact.points_W)):
        return contact  # the normal of the other body
    normals = tuple(_direction(normal, part.turn, angle) for normal in contact.normals_W)
    return replace(contact, normals_W=normals, gaps=())


def _on_own_edge(turn: Turn, moving: Placed, point_W: Vec3) -> bool:
    """Check that at a point of the axis the brick has an edge along the axis, or a corner."""
    shape, near = moving.brick.shape, ON_AXIS * moving.brick.shape.least_thickness
    back = inverse(moving.pose.orientation)
    point, axis = rotate(back, subtract(point_W, moving.pose.position_W)), rotate(back, turn.axis_W)
    meeting = [face.normal for face in shape.faces if dot(face.normal, point) > shape.reach(face.normal) - near]
    edges = [cross(first, second) for first, second in combinations(meeting, 2)]
    if any(abs(dot(edge, axis)) > ALONG * norm(edge) > 0.0 for edge in edges):
        return True
    return any(abs(dot(cross(first, second), third)) > FLAT for first, second, third in combinations(meeting, 3))


# The cohesion of a part is proven at every fifth degree, and the motion ends at the last angle with a proof. Later the
# weight acts against the layers, and most parts have hit a body before 30 deg.
STAGE, FURTHEST = radians(5.0), radians(30.0)
ROUNDING = 1e-9  # share of an angle: stages are sums of angles
# Largest travel of a corner between two collision checks, as a share of the smallest side.
UNSEEN = 0.5


@dataclass
class Toppling:
    """Motion of a part that turns about one axis."""

    part: FallingPart
    others: Collection[Placed]  # bricks that it may hit
    planes: Collection[Plane]
    pitch: float  # angle between two collision checks [rad]
    angle: float = 0.0  # [rad]
    speed: float = 0.0  # angular speed [rad/s]
    _clear: float = 0.0  # angle up to which no collision occurs [rad]
    _stage: float = 0.0  # angle up to which cohesion is proven [rad]

    def advance(self, duration: float) -> bool:
        """Advance by a short time [s]; return False, without advancing, unless the part provably turns as one body."""
        angle, speed = self.part.pendulum.after(self.angle, self.speed, duration)
        while angle > self._clear:
            if not self._check_further():
                return False
        self.angle, self.speed = angle, speed
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Return the current states of the bricks."""
        return part_in_motion(self.part, self.angle, self.speed)

    def take_landed(self) -> Sequence[BodyId]:
        """Return no bricks: an engine takes over before any comes to rest."""
        return ()

    def _check_further(self) -> bool:
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
    """Return the toppling of the moving bricks; None unless it is one rotation about one axis of a proven single body.

    None also with compounds, whose edges on the axis may lie within a face, and with round bodies, which touch the axis
    at one point of a rim.
    `others` and `planes` are the bodies that they may hit, including their supports.
    """
    bodies = [*problem.bricks.values(), *others]
    if any(isinstance(placed.brick.shape, Compound | RoundSolid) for placed in bodies):
        return None
    part = falling_part(problem, motion, gravity)
    if part is None or not holds_together(part, 0.0):
        return None
    moving = [problem.bricks[name] for name in sorted(part.moving)]
    smallest = min(placed.brick.shape.least_thickness for placed in (*moving, *others))
    return Toppling(part, others, planes, UNSEEN * smallest / reach(part))
