"""Access to the bodies of a PyBullet client, including one that the caller runs."""

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import sqrt
from typing import Any, Final
from warnings import warn

from stability.engines.pybullet.binding import pybullet
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.vectors import add_scaled, inverse, multiply, norm, scale, subtract
from stability.model import AT_REST, IDENTITY, BodyId, BodyState, ContactPoint, HalfSpace, Pose, Quaternion, Shape, Vec3


@dataclass
class ClientBodies:
    """Bodies of a client by name, in scene units. A body without a name is named by its number as text."""

    client: int
    names: dict[int, BodyId] = field(default_factory=dict)
    scale: float = 1.0  # engine metres per scene metre; its root is engine seconds per scene second
    mass_unit: float = 1.0  # engine kilograms per scene kilogram
    numbers: dict[BodyId, int] = field(default_factory=dict, init=False)
    # Rotation from the axes of a body's shape to its principal axes, which the engine uses, where they differ.
    inertia_turns: dict[BodyId, Quaternion] = field(default_factory=dict, init=False)
    # [engine m] Edge radius by body; it does not apply between two sharp bodies.
    margins: dict[BodyId, float] = field(default_factory=dict, init=False)
    sharp: set[BodyId] = field(default_factory=set, init=False)
    unseen: set[int] = field(default_factory=set, init=False)  # bodies that neighbour queries ignore

    def name_of(self, number: int) -> BodyId:
        """Return the name of a body."""
        return self.names.setdefault(number, str(number))

    def enter(self, name: BodyId, number: int) -> None:
        """Register a new body under a name."""
        self.names[number] = name
        self.numbers[name] = number

    def remove(self, name: BodyId) -> None:
        """Remove a body from the client and free its name."""
        number = self.numbers.pop(name)
        pybullet.removeBody(number, self.client)
        del self.names[number]
        self.inertia_turns.pop(name, None)
        self.margins.pop(name, None)
        self.sharp.discard(name)

    def states(self, names: Iterable[BodyId]) -> dict[BodyId, BodyState]:
        """Return poses and motions, as stored in the engine."""
        rate = 1.0 / sqrt(self.scale)  # scene speed per engine speed: lengths scale by `scale`, times by its root
        states = {}
        for name in names:
            position, orientation = pybullet.getBasePositionAndOrientation(self.numbers[name], self.client)
            if name in self.inertia_turns:
                orientation = multiply(orientation, inverse(self.inertia_turns[name]))
            velocity, angular_velocity = pybullet.getBaseVelocity(self.numbers[name], self.client)
            states[name] = BodyState(
                Pose(scale(1.0 / self.scale, position), orientation),
                scale(rate, velocity),
                scale(1.0 / rate, angular_velocity),
            )
        return states

    def put(self, name: BodyId, pose: Pose) -> None:
        """Move a body to a pose."""
        position, orientation = scale(self.scale, pose.position_W), pose.orientation
        if name in self.inertia_turns:
            orientation = multiply(orientation, self.inertia_turns[name])
        pybullet.resetBasePositionAndOrientation(self.numbers[name], position, orientation, physicsClientId=self.client)

    def set_motion(self, name: BodyId, velocity_W: Vec3, angular_velocity_W: Vec3) -> None:
        """Set the velocity of a body's centre [m/s] and its angular velocity [rad/s]."""
        rate = sqrt(self.scale)
        self.set_raw_motion(name, scale(rate, velocity_W), scale(1.0 / rate, angular_velocity_W))

    def raw_motion(self, name: BodyId) -> tuple[Vec3, Vec3]:
        """Return velocity and angular velocity of a body, in engine metres and seconds."""
        velocity, angular_velocity = pybullet.getBaseVelocity(self.numbers[name], self.client)
        return velocity, angular_velocity

    def set_raw_motion(self, name: BodyId, velocity: Vec3, angular_velocity: Vec3) -> None:
        """Set the velocities of a body, in engine metres and seconds."""
        pybullet.resetBaseVelocity(self.numbers[name], velocity, angular_velocity, physicsClientId=self.client)

    def mass(self, name: BodyId) -> float:
        """Return the current mass of a body [kg]; 0 if it is frozen."""
        return float(pybullet.getDynamicsInfo(self.numbers[name], -1, self.client)[0]) / self.mass_unit

    def hold(self, name: BodyId) -> None:
        """Freeze a body in its pose: it has no mass and still collides."""
        number = self.numbers[name]
        # A body without mass keeps its velocity and would drift forever.
        pybullet.resetBaseVelocity(number, AT_REST, AT_REST, physicsClientId=self.client)
        pybullet.changeDynamics(number, -1, mass=0.0, physicsClientId=self.client)

    def let_go(self, name: BodyId, mass: float) -> None:
        """Restore the mass of a frozen body [kg]."""
        pybullet.changeDynamics(self.numbers[name], -1, mass=mass * self.mass_unit, physicsClientId=self.client)

    def neighbours(self, name: BodyId, within: float) -> set[BodyId]:
        """Return the bodies whose bounding boxes are within a distance [m] of that of a body."""
        low, high = pybullet.getAABB(self.numbers[name], -1, self.client)
        margin = within * self.scale
        return self.around([x - margin for x in low], [x + margin for x in high]) - {name}

    def around(self, low: Sequence[float], high: Sequence[float]) -> set[BodyId]:
        """Return the bodies whose bounding boxes overlap the box from `low` to `high`, in engine metres."""
        overlapping = pybullet.getOverlappingObjects(low, high, physicsClientId=self.client)
        return {self.name_of(number) for number, _ in overlapping or () if number not in self.unseen}

    def raw_contacts(self, name: BodyId) -> Sequence[Sequence[Any]]:
        """Return the contact points of a body in PyBullet's format and units."""
        return pybullet.getContactPoints(bodyA=self.numbers[name], physicsClientId=self.client) or ()

    def contacts(self, name: BodyId) -> list[ContactPoint]:
        """Return the contact points of a body as of the last step."""
        points = self.raw_contacts(name)
        if not points:
            return []
        # With `bodyA` PyBullet swaps points to list that body first, but not their friction, which acts on the body
        # that it stores first. With `bodyB` it swaps nothing.
        stored = pybullet.getContactPoints(bodyB=self.numbers[name], physicsClientId=self.client) or ()
        swapped = {point[1] for point in stored}
        signs = (-1.0 if point[2] in swapped else 1.0 for point in points)
        return [
            self._contact_point(point, self._friction(point, sign)) for point, sign in zip(points, signs, strict=True)
        ]

    def touching(self, name: BodyId) -> list[ContactPoint]:
        """Return the contact points of a body with zero friction, which saves time."""
        return [self._contact_point(point) for point in self.raw_contacts(name)]

    def _friction(self, point: Sequence[Any], sign: float) -> Vec3:
        along, direction, across, cross_direction = point[10:14]
        along, across = sign * along / self.mass_unit, sign * across / self.mass_unit
        return add_scaled(scale(along, direction), across, cross_direction)

    def _contact_point(self, point: Sequence[Any], friction_W: Vec3 = AT_REST) -> ContactPoint:
        _, a, b, _, _, on_a, on_b, normal, gap, force = point[:10]
        a, b = self.name_of(a), self.name_of(b)
        on_b_W = scale(1.0 / self.scale, on_b)
        rounded = (0.0, 0.0) if a in self.sharp and b in self.sharp else (self._rounding(a), self._rounding(b))
        slid = norm(add_scaled(subtract(on_a, on_b), -gap, normal)) / self.scale
        return ContactPoint(a, b, on_b_W, normal, gap / self.scale, force / self.mass_unit, friction_W, rounded, slid)

    def _rounding(self, name: BodyId) -> float:
        return self.margins.get(name, 0.0) / self.scale


# Conversion of the shape of a foreign PyBullet body, if it is a box or a half-space.


ORIGIN: Final = (0.0, 0.0, 0.0)
SUPPORTED_FIXED: Final = "Use a single GEOM_BOX or GEOM_PLANE, or declare the ground with `planes=`"
SUPPORTED_BRICKS: Final = "Use a single GEOM_BOX with its frame and its centre of mass at its centre"


class UnknownShapeWarning(UserWarning):
    """A body has a shape that statics does not support: the engine simulates it and the bricks that touch it."""


def shape_of(parts: Sequence[Sequence[Any]], fixed: bool) -> Shape:
    """Convert the result of `getCollisionShapeData` for a fixed body or a brick; None if it is not supported.

    A fixed box may have its frame anywhere, as in `plane.urdf`: its centre of mass has no effect.
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


def warn_of_unsupported(body: BodyId, shape: str, fixed: bool) -> None:
    """Warn that the shape of a body, given by its description, is not supported."""
    problem = f"unsupported shape of {'fixed body' if fixed else 'brick'} '{body}': {shape}"
    effect = (
        "exact statics leaves it, and the bricks that touch it, to the engine; the published method uses the contact "
        "points of the engine. This warning is shown once for each kind of shape"
    )
    warn(UnknownShapeWarning(f"{problem}; {effect}. {SUPPORTED_FIXED if fixed else SUPPORTED_BRICKS}"), stacklevel=2)


def shape_description(parts: Sequence[Sequence[Any]]) -> str:
    """Describe an unsupported shape of a body."""
    if len(parts) != 1:
        return f"a compound of {len(parts)} shapes" if parts else "no collision shape"
    _, _, kind, _, _, position, orientation = parts[0]
    shape = _names().get(kind, f"shape of type {kind}")
    if orientation != IDENTITY:
        return f"a {shape} rotated in its frame, by collisionFrameOrientation or the inertial frame"
    if position != ORIGIN:
        return f"a {shape} offset from the origin of its frame, by collisionFramePosition or the inertial frame"
    return f"a {shape}"


def _names() -> Mapping[int, str]:
    """Return PyBullet's names of its shape types, by number."""
    kinds = ("BOX", "CAPSULE", "CYLINDER", "HEIGHTFIELD", "MESH", "PLANE", "SPHERE")
    return {getattr(pybullet, f"GEOM_{kind}"): f"GEOM_{kind}" for kind in kinds}


NOT_LOOKED = (-1, -1)  # count and last number of the bodies before the first check


@dataclass
class PyBulletBodies:
    """Engine on a client that the caller runs.

    Single bodies with mass are bricks, single bodies that had no mass when first seen are fixed. Bodies with joints
    are neither. With `only`, the numbers in it are the only bricks. `names` names bodies by number; others are named
    by their number as text. New bodies are detected. The first body of each unsupported shape raises an
    UnknownShapeWarning.
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
    _gravity_W: Vec3 | None = field(default=None, init=False)  # at the first query
    _warned_of: set[tuple[bool, str]] = field(default_factory=set, init=False)  # (fixed, description of the shape)

    def __post_init__(self) -> None:
        if not isinstance(self.client, int):
            raise TypeError(f"expected the client number that p.connect returned, not {self.client!r}")
        if not pybullet.getConnectionInfo(self.client)["isConnected"]:
            raise ValueError(f"client {self.client} is not connected; pass the number that p.connect returned")
        self._bodies = ClientBodies(self.client, self.names)

    def time(self) -> float:
        return self._clock

    def step(self) -> None:
        """Advance the client by one step."""
        pybullet.stepSimulation(self.client)
        self.stepped()

    def stepped(self) -> None:
        """Record that the caller has stepped the client once. Raises ValueError if its gravity has changed."""
        parameters = pybullet.getPhysicsEngineParameters(self.client)
        self._clock += float(parameters["fixedTimeStep"])
        if self._gravity_W is not None and _gravity(parameters) != self._gravity_W:
            change = f"{self._gravity_W} to {_gravity(parameters)} m/s2"
            raise ValueError(f"the gravity of the client has changed from {change}; create a new stabilizer")

    def gravity_W(self) -> Vec3:
        """Return the gravity of the client, which must not change after this call."""
        self._gravity_W = _gravity(pybullet.getPhysicsEngineParameters(self.client))
        return self._gravity_W

    def masses(self) -> Mapping[BodyId, float]:
        self._notice_bodies()
        return self._masses

    def fixed(self) -> Set[BodyId]:
        self._notice_bodies()
        return self._fixed

    def _notice_bodies(self) -> None:
        # Count and last number reveal almost all changes; `holds` detects a body that reuses a number.
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
        """Return the mass of a body [kg]; for a frozen brick, its mass when first seen."""
        if before.get(name) == self._bodies.numbers[name] and (name in self._masses or name in self._fixed):
            return self._masses.get(name, 0.0)
        return self._bodies.mass(name)

    def _sort_out(self, masses: Mapping[BodyId, float]) -> None:
        """Divide the bodies into bricks and fixed bodies by their masses [kg]."""
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
        shape = shape_description(parts)
        if (fixed, shape) not in self._warned_of:
            self._warned_of.add((fixed, shape))
            warn_of_unsupported(body, shape, fixed)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted(self._bodies.neighbours(brick, within))

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return self._bodies.states(bodies)

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self._bodies.contacts(brick)

    def freeze(self, brick: BodyId) -> None:
        self._notice_bodies()  # before freezing sets the mass of a new brick to 0
        self._bodies.hold(brick)

    def holds(self, brick: BodyId) -> bool:
        mass = self._bodies.mass(brick)
        if mass == 0.0:
            return True
        # The caller has given it a mass, or has created another body with the same number.
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
