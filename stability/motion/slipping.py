"""How does a plank slip that leans on a wall, and how do two that lean on each other, until something else happens?

Model: an edge of a brick stands on level ground, another leans on an upright wall, and Coulomb friction of both, as
strong as it can be, does not hold it. The foot slides away from the wall and the top down it; both go on touching, so
that one angle says where the brick is. Two bricks that mirror each other lean on a smooth wall half-way between them:
by symmetry they press level. Where it is known that nothing else happens, this is exact, and needs no solver, whose
friction is wrong in its first moments: bricks start to slip askew, late or not at all (docs/moving-part.md).
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import cos, hypot, inf, sin
from typing import NamedTuple

from stability.geometry.rotations import about, body_axes, multiply
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, scale, subtract, unit
from stability.mechanics.integration import runge_kutta
from stability.model import BodyId, BodyState, Plane, Pose, Vec3
from stability.shapes.apart import apart, apart_from_plane
from stability.shapes.in_pose import corners_W, principal_turn
from stability.statics.facts import UP, Contact, Motion, Placed, Problem

ALIKE = 1e-6  # sine of an angle, or share of a brick's longest side: what is closer counts as the same
LINE = 2  # points of a contact along an edge
PAIR = 2  # bricks that lean on each other


class Flat(NamedTuple):
    """A vector in the vertical plane across the wall [m]."""

    x: float  # towards the wall
    z: float  # up


@dataclass(frozen=True, slots=True)
class Pressed:
    """What happens while both ends slide, by mass."""

    angular_acceleration: float  # [rad/s2]
    floor: float  # force of the ground, up [N/kg]
    wall: float  # force of the wall, away from it [N/kg]


@dataclass(frozen=True, slots=True)
class Leaning:
    """A brick on its way down a wall; it turns from upright towards the wall, by an angle from where it was at rest."""

    foot: Flat  # from the centre of mass to the edge on the ground, at rest
    top: Flat  # to the edge on the wall
    inertia: float  # about the centre, by mass [m2]
    floor_friction: float
    wall_friction: float
    gravity: float  # [m/s2]

    def centre(self, turn: float) -> Flat:
        """The vector from where ground and wall meet to the centre of mass."""
        return Flat(-turned_down(self.top, turn).x, -turned_down(self.foot, turn).z)

    def centre_goes(self, turn: float) -> Flat:
        """The derivative of the centre by the angle [m/rad]."""
        return Flat(-turned_down(self.top, turn).z, turned_down(self.foot, turn).x)

    def pressed(self, turn: float, rate: float) -> Pressed:
        """Newton and Euler for floor N and wall W, to the wall, up and about the centre.

        x'' = floor N - W, z'' = N + wall W - g, inertia turn'' = moments; (x, z)'' = goes turn'' - (x, z) rate^2.
        """
        (foot_x, foot_z), (top_x, top_z) = turned_down(self.foot, turn), turned_down(self.top, turn)
        (x, z), (goes_x, goes_z) = self.centre(turn), self.centre_goes(turn)
        floor, wall, square = self.floor_friction, self.wall_friction, rate * rate
        # N = by turn'' + at rest, from the first two; then W from the first, and turn'' from the third.
        both = 1.0 + floor * wall
        by_turning, at_rest = (goes_z + wall * goes_x) / both, (self.gravity - (z + wall * x) * square) / both
        arm, high = foot_x - floor * foot_z, top_z + wall * top_x
        resisting = self.inertia + (arm + floor * high) * by_turning - high * goes_x
        angular_acceleration = -((arm + floor * high) * at_rest + high * x * square) / resisting
        pressing = by_turning * angular_acceleration + at_rest
        return Pressed(angular_acceleration, pressing, x * square - goes_x * angular_acceleration + floor * pressing)

    def after(self, turn: float, rate: float, duration: float) -> tuple[float, float]:
        """Turn [rad] and its rate [rad/s] a short time [s] later."""
        return runge_kutta(lambda at, going: self.pressed(at, going).angular_acceleration, turn, rate, duration)


@dataclass
class Slip:
    """Bricks that slip, all in the same way, each towards its own side."""

    leaning: Leaning
    starts: Mapping[BodyId, Placed]
    towards_W: Mapping[BodyId, Vec3]  # unit, level, to the wall of each
    corners: Sequence[Flat]  # of one of them across the wall, from its centre
    room: float  # nothing else is as near to them [m]
    turn: float = 0.0  # [rad]
    rate: float = 0.0  # [rad/s]

    def goes_on(self, duration: float) -> bool:
        """Slip for a short time [s]; False, and not at all, if something else happens."""
        turn, rate = self.leaning.after(self.turn, self.rate, duration)
        now = self.leaning.pressed(turn, rate)
        if (
            min(now.angular_acceleration, now.floor, now.wall) <= 0.0
            or self._moved(turn) >= self.room
            or not self._on_edges(turn)
        ):
            return False
        self.turn, self.rate = turn, rate
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Where its bricks are, and how they move."""
        before, now = self.leaning.centre(0.0), self.leaning.centre(self.turn)
        goes = self.leaning.centre_goes(self.turn)
        return {
            name: self._state(placed, self.towards_W[name], Flat(now.x - before.x, now.z - before.z), goes)
            for name, placed in self.starts.items()
        }

    def take_landed(self) -> Sequence[BodyId]:
        """None: an engine takes over before anything rests again."""
        return ()

    def _state(self, placed: Placed, towards_W: Vec3, gone: Flat, goes: Flat) -> BodyState:
        axis_W = cross(UP, towards_W)
        position_W = add_scaled(add_scaled(placed.pose.position_W, gone.x, towards_W), gone.z, UP)
        velocity_W = add(scale(self.rate * goes.x, towards_W), scale(self.rate * goes.z, UP))
        pose = Pose(position_W, multiply(about(axis_W, self.turn), placed.pose.orientation))
        return BodyState(pose, velocity_W, scale(self.rate, axis_W))

    def _moved(self, turn: float) -> float:
        """An upper bound on how far any point of a brick has moved [m]."""
        before, now = self.leaning.centre(0.0), self.leaning.centre(turn)
        return hypot(now.x - before.x, now.z - before.z) + turn * max(hypot(*corner) for corner in self.corners)

    def _on_edges(self, turn: float) -> bool:
        """Whether the brick still stands and leans on the edges on which it began to slip."""
        corners = [turned_down(corner, turn) for corner in self.corners]
        foot, top = turned_down(self.leaning.foot, turn), turned_down(self.leaning.top, turn)
        slack = ALIKE * hypot(*self.corners[0])
        return all(corner.z >= foot.z - slack and corner.x <= top.x + slack for corner in corners)


def turned_down(vector: Flat, turn: float) -> Flat:
    """A vector that turns from upright towards the wall, by an angle [rad]."""
    x, z = vector
    return Flat(x * cos(turn) + z * sin(turn), z * cos(turn) - x * sin(turn))


def slip_of(
    problem: Problem, motion: Motion, gravity: float, others: Collection[Placed], planes: Collection[Plane]
) -> Slip | None:
    """How what begins to move slips; None if it is nothing that leans as described, or does not slip.

    `others` and `planes` are what it may hit, what it leans on included.
    """
    names = sorted(motion.velocity)
    contacts = [contact for contact in problem.contacts if {contact.lower, contact.upper} & set(names)]
    found = [_leaning(problem.bricks[name], contacts, problem, gravity) for name in names if name in problem.bricks]
    leans = [one for one in found if one is not None]
    if not leans or len(leans) != len(names) or not (_against_a_wall(leans) or _against_each_other(leans)):
        return None
    first, now = leans[0], leans[0].leaning.pressed(0.0, 0.0)
    if min(now.angular_acceleration, now.floor, now.wall) <= 0.0:
        return None
    bricks = {name: problem.bricks[name] for name in names}
    touched = {body for contact in contacts for body in (contact.lower, contact.upper)}
    room = _room(bricks.values(), others, [plane for plane in planes if plane.id not in touched])
    towards_W = {name: one.towards_W for name, one in zip(names, leans, strict=True)}
    return Slip(first.leaning, bricks, towards_W, _corners(bricks[names[0]], first.towards_W), room)


@dataclass(frozen=True, slots=True)
class _Leans:
    """How one brick leans."""

    leaning: Leaning
    mass: float  # [kg]
    towards_W: Vec3  # unit, level
    against: Contact
    on_brick: bool  # not on what never moves


def _leaning(placed: Placed, contacts: Sequence[Contact], problem: Problem, gravity: float) -> _Leans | None:
    name = placed.brick.id
    own = [contact for contact in contacts if name in (contact.lower, contact.upper)]
    floors = [contact for contact in own if contact.lower not in problem.bricks and contact.normals_W == (UP,)]
    walls = [contact for contact in own if contact not in floors]
    if len(floors) != 1 or len(walls) != 1 or any(len(contact.points_W) != LINE for contact in own):
        return None
    floor, wall = floors[0], walls[0]
    foot_W, top_W = (subtract(scale(0.5, add(*c.points_W)), placed.pose.position_W) for c in (floor, wall))
    along_W = unit(subtract(floor.points_W[1], floor.points_W[0]))
    across_W = cross(along_W, UP)
    towards_W = across_W if dot(subtract(top_W, foot_W), across_W) > 0.0 else scale(-1.0, across_W)
    on_brick = wall.lower in problem.bricks
    aside = max(abs(dot(foot_W, along_W)), abs(dot(top_W, along_W)))
    if aside > ALIKE * placed.brick.shape.length or not _is_upright(placed, wall, along_W):
        return None
    if not on_brick and norm(add(wall.normals_W[0], towards_W)) > ALIKE:
        return None
    foot, top = (Flat(dot(vector_W, towards_W), vector_W[2]) for vector_W in (foot_W, top_W))
    friction = 0.0 if on_brick else wall.friction
    leaning = Leaning(foot, top, _inertia(placed, along_W), floor.friction, friction, gravity)
    return _Leans(leaning, placed.brick.mass, towards_W, wall, on_brick)


def _is_upright(placed: Placed, wall: Contact, along_W: Vec3) -> bool:
    """Whether the edge that leans and the brick are square to the plane across the edge that stands."""
    edge_W = subtract(wall.points_W[1], wall.points_W[0])
    axes_W = _principal_axes_W(placed)
    return all(
        min(norm(cross(direction_W, along_W)) for direction_W in directions_W) <= ALIKE
        for directions_W in ((unit(edge_W),), axes_W)
    )


def _principal_axes_W(placed: Placed) -> tuple[Vec3, Vec3, Vec3]:
    return body_axes(principal_turn(placed.brick.shape, placed.pose.orientation))


def _inertia(placed: Placed, along_W: Vec3) -> float:
    axes_W = _principal_axes_W(placed)
    which = max(range(3), key=lambda axis: abs(dot(axes_W[axis], along_W)))
    return placed.brick.shape.moments(placed.brick.mass)[which] / placed.brick.mass


def _against_a_wall(leans: Sequence[_Leans]) -> bool:
    return len(leans) == 1 and not leans[0].on_brick


def _against_each_other(leans: Sequence[_Leans]) -> bool:
    """Whether two bricks lean on each other, and mirror each other."""
    if len(leans) != PAIR or leans[0].against is not leans[1].against or leans[0].mass != leans[1].mass:
        return False
    first, second = (one.leaning for one in leans)
    ends = ((first.foot, second.foot), (first.top, second.top))
    apart = max(hypot(a.x - b.x, a.z - b.z) for a, b in ends)
    alike = max(apart / hypot(*first.foot), abs(second.inertia / first.inertia - 1.0)) <= ALIKE
    facing = norm(add(leans[0].towards_W, leans[1].towards_W)) <= ALIKE
    return alike and facing and first.floor_friction == second.floor_friction


def _corners(placed: Placed, towards_W: Vec3) -> list[Flat]:
    from_centre = (subtract(corner, placed.pose.position_W) for corner in corners_W(placed.brick.shape, placed.pose))
    return [Flat(dot(corner, towards_W), corner[2]) for corner in from_centre]


def _room(bricks: Collection[Placed], others: Collection[Placed], planes: Collection[Plane]) -> float:
    return min(_gaps(bricks, others, planes), default=inf)


def _gaps(bricks: Collection[Placed], others: Collection[Placed], planes: Collection[Plane]) -> Iterator[float]:
    for placed in bricks:
        shape, pose = placed.brick.shape, placed.pose
        for other in others:
            yield apart(shape, pose, other.brick.shape, other.pose).gap
        for plane in planes:
            yield apart_from_plane(shape, pose, plane).gap
