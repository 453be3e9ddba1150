"""How far does a falling part turn as one body, before its bricks slide on each other, lift off, or hit something?

A part that begins to turn about an axis goes on as a pendulum. At an angle its speed follows from the height lost, its
acceleration from the torque of the weights. With the forces of inertia among the loads (d'Alembert) each brick is at
rest within the part if contact forces within the friction cones balance the loads: the same proof as for what stands.
Contacts with what does not move act where the axis goes through them, all others have opened.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import cos, sin, sqrt

from stability.geometry import box_corners, composed, turned
from stability.impulse import moments
from stability.model import BodyId, Plane, Pose, Vec3
from stability.separation import boxes_apart
from stability.statics.facts import Contact, Motion, Placed, Problem, Tolerances, Wrench
from stability.statics.programmes.equilibrium import balance
from stability.vectors import cross, dot, minus, moved, norm, plus, times, unit

DOWN: Vec3 = (0.0, 0.0, -1.0)
PITCH = 1e-6  # of the speed: more of it along the axis, and it is a screw
ON_AXIS = Tolerances().gap  # share of the smallest side: nearer points stay where they are


@dataclass(frozen=True, slots=True)
class Turn:
    """A turn about a fixed axis."""

    point_W: Vec3  # on the axis [m]
    axis_W: Vec3  # unit, right-handed


@dataclass(frozen=True, slots=True)
class FallingPart:
    """Bricks that begin to turn as one, their contacts with each other and with what does not move, and gravity."""

    problem: Problem
    turn: Turn
    gravity: float  # [m/s2]


def turn_of(problem: Problem, motion: Motion) -> Turn | None:
    """The turn about one axis that all bricks of a problem begin with; None if they do not."""
    if not problem.bricks or set(motion.velocity) != set(problem.bricks):
        return None
    first = min(motion.velocity)
    velocity, spin = motion.velocity[first]
    speed = norm(spin)
    if speed == 0.0 or abs(dot(velocity, spin)) > PITCH * speed * norm(velocity):
        return None
    point = plus(problem.bricks[first].pose.position_W, times(1.0 / (speed * speed), cross(spin, velocity)))
    for name, (v, w) in motion.velocity.items():
        expected = cross(spin, minus(problem.bricks[name].pose.position_W, point))
        if norm(minus(w, spin)) > PITCH * speed or norm(minus(v, expected)) > PITCH * norm(v):
            return None
    return Turn(point, unit(spin))


def turns_as_one_until(
    part: FallingPart, angles: Sequence[float], others: Collection[Placed], planes: Collection[Plane]
) -> float | None:
    """The last of some growing angles [rad] up to which a part is proven to hold together and hits nothing."""
    last = None
    for angle in angles:
        bricks = {name: _turned(placed, part.turn, angle) for name, placed in part.problem.bricks.items()}
        if _hits(bricks, others, planes) or balance(_at_angle(part, bricks, angle)).forces is None:
            break
        last = angle
    return last


def _turned(placed: Placed, turn: Turn, angle: float) -> Placed:
    around = (*times(sin(0.5 * angle), turn.axis_W), cos(0.5 * angle))
    return Placed(
        placed.brick, Pose(_point(placed.pose.position_W, turn, angle), composed(around, placed.pose.orientation))
    )


def _point(point_W: Vec3, turn: Turn, angle: float) -> Vec3:
    return plus(turn.point_W, _direction(minus(point_W, turn.point_W), turn, angle))


def _direction(vector_W: Vec3, turn: Turn, angle: float) -> Vec3:
    return turned((*times(sin(0.5 * angle), turn.axis_W), cos(0.5 * angle)), vector_W)


def _hits(bricks: Mapping[BodyId, Placed], others: Collection[Placed], planes: Collection[Plane]) -> bool:
    """Whether a brick lies deeper in something than what touches does."""
    for placed in bricks.values():
        size, pose = placed.brick.size, placed.pose
        depth = ON_AXIS * min(size)
        corners = box_corners(size, pose)
        if any(min(dot(minus(c, plane.point_W), plane.normal_W) for c in corners) < -depth for plane in planes):
            return True
        if any(boxes_apart(size, pose, other.brick.size, other.pose).gap < -depth for other in others):
            return True
    return False


def _foot(turn: Turn, point_W: Vec3) -> Vec3:
    """The nearest point of the axis."""
    return moved(turn.point_W, dot(turn.axis_W, minus(point_W, turn.point_W)), turn.axis_W)


def _at_angle(part: FallingPart, bricks: Mapping[BodyId, Placed], angle: float) -> Problem:
    """The part in mid-fall, with the forces of inertia."""
    turn = part.turn
    inertia = sum(_about(turn, placed) for placed in bricks.values())
    lost = sum(
        placed.brick.mass * (part.problem.bricks[name].pose.position_W[2] - placed.pose.position_W[2])
        for name, placed in bricks.items()
    )
    weights = [
        cross(minus(placed.pose.position_W, turn.point_W), times(placed.brick.mass * part.gravity, DOWN))
        for placed in bricks.values()
    ]
    alpha = sum(dot(torque, turn.axis_W) for torque in weights) / inertia
    omega = sqrt(max(0.0, 2.0 * part.gravity * lost / inertia))
    loads = {name: _load(placed, turn, part.gravity, omega, alpha) for name, placed in bricks.items()}
    contacts = [found for contact in part.problem.contacts if (found := _contact(part, contact, angle)) is not None]
    return Problem(bricks, contacts, loads)


def _about(turn: Turn, placed: Placed) -> float:
    """The moment of inertia of a brick about the axis [kg m2]."""
    arm = cross(turn.axis_W, minus(placed.pose.position_W, turn.point_W))
    return dot(_inertia_times(placed, turn.axis_W), turn.axis_W) + placed.brick.mass * dot(arm, arm)


def _inertia_times(placed: Placed, vector_W: Vec3) -> Vec3:
    """The inertia of a brick about its centre, times a vector."""
    x, y, z, w = placed.pose.orientation
    a, b, c = turned((-x, -y, -z, w), vector_W)
    one, two, three = moments(placed.brick.size, placed.brick.mass)
    return turned(placed.pose.orientation, (one * a, two * b, three * c))


def _load(placed: Placed, turn: Turn, gravity: float, omega: float, alpha: float) -> Wrench:
    """The weight of a brick, less mass times acceleration; and less the change of its spin."""
    arm, spin = minus(placed.pose.position_W, turn.point_W), times(omega, turn.axis_W)
    acceleration = plus(cross(times(alpha, turn.axis_W), arm), cross(spin, cross(spin, arm)))
    change = plus(_inertia_times(placed, times(alpha, turn.axis_W)), cross(spin, _inertia_times(placed, spin)))
    return Wrench(
        times(placed.brick.mass, minus(times(gravity, DOWN), acceleration)),
        times(-1.0, change),
    )


def _contact(part: FallingPart, contact: Contact, angle: float) -> Contact | None:
    """A contact in mid-fall: turned with the part; with what does not move, where it lies on the axis, if anywhere."""
    turn, bricks = part.turn, part.problem.bricks
    normals = tuple(_direction(normal, turn, angle) for normal in contact.normals_W)
    if contact.lower in bricks and contact.upper in bricks:
        points = tuple(_point(point, turn, angle) for point in contact.points_W)
        return Contact(contact.lower, contact.upper, points, normals, contact.friction)
    moving = bricks[contact.upper if contact.upper in bricks else contact.lower]
    near = ON_AXIS * min(moving.brick.size)
    # On the axis, exactly: beside it by what a solver leaves, no forces would balance to the last digits.
    points = tuple(p for point in contact.points_W if norm(minus(p := _foot(turn, point), point)) <= near)
    if not points:
        return None
    # An edge on a face: the normal of the face, and that may be of the body that turns or of the other one.
    both = contact.normals_W if angle == 0.0 else (*contact.normals_W, *normals)
    return Contact(contact.lower, contact.upper, points, both, contact.friction)
