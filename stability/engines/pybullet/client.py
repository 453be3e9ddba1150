"""Reads and writes the bodies of a PyBullet client that the caller runs."""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import sqrt
from typing import Any, Final
from warnings import warn

from stability.engines.pybullet.binding import pybullet
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.vectors import add_scaled, inverse, multiply, norm, scale, subtract
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, ContactPoint, HalfSpace, Pose, Quaternion, Shape, Vec3

# The bodies of a client by name, read and written in the units of the scene.


@dataclass
class ClientBodies:
    """Which body of a client has which name. Bodies without a name of their own are called by their number as text."""

    client: int
    names: dict[int, BodyId] = field(default_factory=dict)
    scale: float = 1.0  # engine metres per scene metre; seconds go with its root
    mass_unit: float = 1.0  # engine kilograms per scene kilogram
    numbers: dict[BodyId, int] = field(default_factory=dict, init=False)
    # From the axes of a body in the engine, which are those of its inertia, to those of its shape, where they differ.
    inertia_turns: dict[BodyId, Quaternion] = field(default_factory=dict, init=False)
    # [engine m] by which the edges of bodies are rounded; those of two that are sharp only against others.
    margins: dict[BodyId, float] = field(default_factory=dict, init=False)
    sharp: set[BodyId] = field(default_factory=set, init=False)
    unseen: set[int] = field(default_factory=set, init=False)  # bodies that stand beside others, and are no neighbours

    def name_of(self, number: int) -> BodyId:
        """What a body is called."""
        return self.names.setdefault(number, str(number))

    def enter(self, name: BodyId, number: int) -> None:
        """Know a new body by a name."""
        self.names[number] = name
        self.numbers[name] = number

    def remove(self, name: BodyId) -> None:
        """Take a body out of the client; its name is free again."""
        number = self.numbers.pop(name)
        pybullet.removeBody(number, self.client)
        del self.names[number]
        self.inertia_turns.pop(name, None)
        self.margins.pop(name, None)
        self.sharp.discard(name)

    def states(self, names: Iterable[BodyId]) -> dict[BodyId, BodyState]:
        """Poses and motions, as the engine has them."""
        rate = 1.0 / sqrt(self.scale)  # of speeds: metres grow by scale, seconds by its root
        found = {}
        for name in names:
            position, orientation = pybullet.getBasePositionAndOrientation(self.numbers[name], self.client)
            if name in self.inertia_turns:
                orientation = multiply(orientation, inverse(self.inertia_turns[name]))
            velocity, angular_velocity = pybullet.getBaseVelocity(self.numbers[name], self.client)
            found[name] = BodyState(
                Pose(scale(1.0 / self.scale, position), orientation),
                scale(rate, velocity),
                scale(1.0 / rate, angular_velocity),
            )
        return found

    def put(self, name: BodyId, pose: Pose) -> None:
        """Put a body somewhere else."""
        position, orientation = scale(self.scale, pose.position_W), pose.orientation
        if name in self.inertia_turns:
            orientation = multiply(orientation, self.inertia_turns[name])
        pybullet.resetBasePositionAndOrientation(self.numbers[name], position, orientation, physicsClientId=self.client)

    def set_motion(self, name: BodyId, velocity_W: Vec3, angular_velocity_W: Vec3) -> None:
        """Give a body a velocity of its centre [m/s] and an angular velocity [rad/s]."""
        rate = sqrt(self.scale)
        self.set_raw_motion(name, scale(rate, velocity_W), scale(1.0 / rate, angular_velocity_W))

    def raw_motion(self, name: BodyId) -> tuple[Vec3, Vec3]:
        """Velocity and angular velocity of a body, in engine metres and seconds."""
        velocity, angular_velocity = pybullet.getBaseVelocity(self.numbers[name], self.client)
        return velocity, angular_velocity

    def set_raw_motion(self, name: BodyId, velocity: Vec3, angular_velocity: Vec3) -> None:
        """Give a body velocities in engine metres and seconds."""
        pybullet.resetBaseVelocity(self.numbers[name], velocity, angular_velocity, physicsClientId=self.client)

    def mass(self, name: BodyId) -> float:
        """The mass of a body as it is now, 0 if it is held [kg]."""
        return float(pybullet.getDynamicsInfo(self.numbers[name], -1, self.client)[0]) / self.mass_unit

    def hold(self, name: BodyId) -> None:
        """Hold a body where it is: it goes on colliding, without mass."""
        number = self.numbers[name]
        # A body without mass keeps the velocity that it has, and drifts with it for ever.
        pybullet.resetBaseVelocity(number, AT_REST, AT_REST, physicsClientId=self.client)
        pybullet.changeDynamics(number, -1, mass=0.0, physicsClientId=self.client)

    def let_go(self, name: BodyId, mass: float) -> None:
        """Give a body that was held its mass back [kg]."""
        pybullet.changeDynamics(self.numbers[name], -1, mass=mass * self.mass_unit, physicsClientId=self.client)

    def neighbours(self, name: BodyId, within: float) -> set[BodyId]:
        """The bodies whose bounding boxes are so close to that of one [m]."""
        low, high = pybullet.getAABB(self.numbers[name], -1, self.client)
        margin = within * self.scale
        return self.around([x - margin for x in low], [x + margin for x in high]) - {name}

    def around(self, low: Sequence[float], high: Sequence[float]) -> set[BodyId]:
        """The bodies whose bounds meet those from `low` to `high`, in engine metres."""
        found = pybullet.getOverlappingObjects(low, high, physicsClientId=self.client)
        return {self.name_of(number) for number, _ in found or () if number not in self.unseen}

    def raw_contacts(self, name: BodyId) -> Sequence[Sequence[Any]]:
        """The contact points of a body as PyBullet tells them, in units of the engine."""
        return pybullet.getContactPoints(bodyA=self.numbers[name], physicsClientId=self.client) or ()

    def contacts(self, name: BodyId) -> list[ContactPoint]:
        """The contact points of a body as of the last step."""
        points = self.raw_contacts(name)
        if not points:
            return []
        # PyBullet turns a point to be that of the body that is asked for, all but friction: that acts on whichever of
        # both it keeps first. Asked for the second, it turns nothing.
        kept = pybullet.getContactPoints(bodyB=self.numbers[name], physicsClientId=self.client) or ()
        turned = {point[1] for point in kept}
        signs = (-1.0 if point[2] in turned else 1.0 for point in points)
        return [
            self._contact_point(point, self._friction(point, sign)) for point, sign in zip(points, signs, strict=True)
        ]

    def touching(self, name: BodyId) -> list[ContactPoint]:
        """The same points without their friction, which is told as none."""
        return [self._contact_point(point) for point in self.raw_contacts(name)]

    def _friction(self, point: Sequence[Any], sign: float) -> Vec3:
        along, way, across, other_way = point[10:14]
        along, across = sign * along / self.mass_unit, sign * across / self.mass_unit
        return add_scaled(scale(along, way), across, other_way)

    def _contact_point(self, point: Sequence[Any], friction_W: Vec3 = AT_REST) -> ContactPoint:
        _, a, b, _, _, on_a, on_b, normal, gap, force = point[:10]
        a, b = self.name_of(a), self.name_of(b)
        on_b_W = scale(1.0 / self.scale, on_b)
        rounded = (0.0, 0.0) if a in self.sharp and b in self.sharp else (self._rounding(a), self._rounding(b))
        slid = norm(add_scaled(subtract(on_a, on_b), -gap, normal)) / self.scale
        return ContactPoint(a, b, on_b_W, normal, gap / self.scale, force / self.mass_unit, friction_W, rounded, slid)

    def _rounding(self, name: BodyId) -> float:
        return self.margins.get(name, 0.0) / self.scale


# Converts the shape of a foreign PyBullet body, if it is a box or a convex hull.


ORIGIN: Final = (0.0, 0.0, 0.0)
KNOWN_FIXED: Final = "Known are one GEOM_BOX and a GEOM_PLANE: give it such a shape, or name all ground by `planes=`"
KNOWN_BRICKS: Final = "Known is one GEOM_BOX with its frame, and the centre of its mass, in the middle"


class UnknownShapeWarning(UserWarning):
    """A body has a shape on which statics is silent: it, and all that touches it, is left to the engine."""


def shape_of(parts: Sequence[Sequence[Any]], fixed: bool) -> Shape:
    """The shape that `getCollisionShapeData` tells of a body, fixed or a brick; None if none is known here.

    A fixed box may have its frame anywhere, as that of `plane.urdf` has: nobody weighs it.
    """
    if len(parts) != 1:
        return None
    _, _, kind, dimensions, _, position, orientation = parts[0]
    if orientation != IDENTITY or (position != ORIGIN and not fixed):
        return None
    if kind == pybullet.GEOM_BOX:
        x, y, z = position
        return Box(dimensions) if position == ORIGIN else OffCentreBox(dimensions, (-x, -y, -z))
    return HalfSpace(dimensions) if kind == pybullet.GEOM_PLANE and position == ORIGIN else None


def warn_of_unknown(body: BodyId, what: str, fixed: bool) -> None:
    """Warn that a body with such a shape, in words, is left to the engine."""
    told = f"body '{body}', {'which is fixed' if fixed else 'a brick'}, is {what}: no shape that is known here"
    left = (
        "exact statics leaves it to the engine, and all that touches it; the published method takes the engine's "
        "contact points for it. Of others like it nothing will be said"
    )
    warn(UnknownShapeWarning(f"{told}; {left}. {KNOWN_FIXED if fixed else KNOWN_BRICKS}"), stacklevel=2)


def in_words(parts: Sequence[Sequence[Any]]) -> str:
    """What the shape of a body is called that is none of those that are known here."""
    if len(parts) != 1:
        return f"a compound of {len(parts)} shapes" if parts else "without a collision shape"
    _, _, kind, _, _, position, orientation = parts[0]
    called = _names().get(kind, f"of the kind {kind}")
    if orientation != IDENTITY:
        return f"a {called} that is turned in its frame (collisionFrameOrientation, or that of the inertia)"
    if position != ORIGIN:
        return f"a {called} off the middle of its frame (collisionFramePosition, or that of the inertia)"
    return f"a {called}"


def _names() -> Mapping[int, str]:
    """By number, what PyBullet calls its kinds of shapes."""
    kinds = ("BOX", "CAPSULE", "CYLINDER", "HEIGHTFIELD", "MESH", "PLANE", "SPHERE")
    return {getattr(pybullet, f"GEOM_{kind}"): f"GEOM_{kind}" for kind in kinds}


# The bodies of a client that somebody else runs, through the protocol of `stability.engines.protocol`.


NOT_LOOKED = (-1, -1)  # in the place of the count and the last number of the bodies


@dataclass
class PyBulletBodies:
    """The bodies of a running client: single bodies with mass are bricks, those without (at first sight) are fixed.

    Bodies with joints are neither, and with `only` nor is any body whose number is not in it. Bodies are called by name
    if they are in `names`, else by their number as text. New ones are noticed by themselves. The first body of each
    shape that is not known here is told by an UnknownShapeWarning.
    """

    client: int
    only: Set[int] | None = None
    names: dict[int, BodyId] = field(default_factory=dict)
    _bodies: ClientBodies = field(init=False)
    _clock: float = field(default=0.0, init=False)
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)
    _fixed: frozenset[BodyId] = field(default=frozenset(), init=False)
    _shapes: dict[BodyId, Shape] = field(default_factory=dict, init=False)
    _noticed: tuple[int, int] = field(default=NOT_LOOKED, init=False)
    _gravity_W: Vec3 | None = field(default=None, init=False)  # as it was when somebody asked
    _warned_of: set[tuple[bool, str]] = field(default_factory=set, init=False)  # fixed or not, and what shape

    def __post_init__(self) -> None:
        if not isinstance(self.client, int):
            raise TypeError(f"expected the number of a client, as p.connect gives it, not {self.client!r}")
        if not pybullet.getConnectionInfo(self.client)["isConnected"]:
            raise ValueError(f"there is no client {self.client}: p.connect gives the number of one")
        self._bodies = ClientBodies(self.client, self.names)

    def time(self) -> float:
        return self._clock

    def step(self) -> None:
        """Step the client once."""
        pybullet.stepSimulation(self.client)
        self.stepped()

    def stepped(self) -> None:
        """Say that the owner has stepped the client once. Raises ValueError if its gravity is no longer as it was."""
        parameters = pybullet.getPhysicsEngineParameters(self.client)
        self._clock += float(parameters["fixedTimeStep"])
        if self._gravity_W is not None and _gravity(parameters) != self._gravity_W:
            now = f"{self._gravity_W} to {_gravity(parameters)} m/s2"
            raise ValueError(f"the gravity of the client has changed from {now}: make the extension anew")

    def gravity_W(self) -> Vec3:
        """The gravity of the client; from now on it must stay."""
        self._gravity_W = _gravity(pybullet.getPhysicsEngineParameters(self.client))
        return self._gravity_W

    def masses(self) -> Mapping[BodyId, float]:
        self._notice_bodies()
        return self._masses

    def fixed(self) -> Set[BodyId]:
        self._notice_bodies()
        return self._fixed

    def _notice_bodies(self) -> None:
        # Count and last number tell of almost all changes; `holds` finds a body that took over a number.
        count = pybullet.getNumBodies(self.client)
        last = pybullet.getBodyUniqueId(count - 1, self.client) if count else -1
        if (count, last) == self._noticed:
            return
        self._noticed = (count, last)
        before = self._bodies.numbers
        numbers = [pybullet.getBodyUniqueId(index, self.client) for index in range(count)]
        self._bodies.numbers = {self._bodies.name_of(number): number for number in numbers}
        self._sort_out({name: self._mass(name, before) for name in self._bodies.numbers})

    def _mass(self, name: BodyId, before: Mapping[BodyId, int]) -> float:
        """The mass of a body [kg]; of a brick that is frozen by now, what it was at first sight."""
        if before.get(name) == self._bodies.numbers[name] and (name in self._masses or name in self._fixed):
            return self._masses.get(name, 0.0)
        return self._bodies.mass(name)

    def _sort_out(self, masses: Mapping[BodyId, float]) -> None:
        """Tell bricks from what is fixed, by the masses of all bodies [kg]."""
        numbers = self._bodies.numbers
        single = {name for name, number in numbers.items() if pybullet.getNumJoints(number, self.client) == 0}
        self._masses = {
            name: mass
            for name, mass in masses.items()
            if mass > 0.0 and name in single and (self.only is None or numbers[name] in self.only)
        }
        self._fixed = frozenset(name for name, mass in masses.items() if mass == 0.0 and name in single)
        self._shapes = {name: shape for name, shape in self._shapes.items() if name in numbers}

    def shape(self, body: BodyId) -> Shape:
        if body not in self._shapes:
            parts = pybullet.getCollisionShapeData(self._bodies.numbers[body], -1, self.client)
            self._shapes[body] = shape_of(parts, body in self._fixed)
            if self._shapes[body] is None:
                self._warn(body, parts)
        return self._shapes[body]

    def _warn(self, body: BodyId, parts: Sequence[Sequence[object]]) -> None:
        fixed = body in self._fixed
        what = in_words(parts)
        if (fixed, what) not in self._warned_of:
            self._warned_of.add((fixed, what))
            warn_of_unknown(body, what, fixed)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted(self._bodies.neighbours(brick, within))

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return self._bodies.states(bodies)

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self._bodies.contacts(brick)

    def freeze(self, brick: BodyId) -> None:
        self._notice_bodies()  # while the mass of a new brick can still be seen
        self._bodies.hold(brick)

    def holds(self, brick: BodyId) -> bool:
        mass = self._bodies.mass(brick)
        if mass == 0.0:
            return True
        # The owner has given it a mass, or has put another body in its place, under the same number.
        self._masses = {**self._masses, brick: mass}
        self._shapes.pop(brick, None)
        return False

    def wake(self, brick: BodyId) -> None:
        self._bodies.let_go(brick, self._masses[brick])

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._bodies.put(brick, pose)


def _gravity(parameters: Mapping[str, float]) -> Vec3:
    x, y, z = (float(parameters[f"gravityAcceleration{axis}"]) for axis in "XYZ")
    return x, y, z
