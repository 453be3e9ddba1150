"""PyBullet behind the Engine protocol: the one file that imports it.

`PyBulletBodies` attaches to a client that somebody else runs. `PyBulletWorld` runs one of its own, with every setting
that matters made explicit, because `contactBreakingThreshold` belongs to the whole process and outlives its client.
"""

import os
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import ceil, log10, sqrt
from typing import Any

from stability.contact import TOUCHING
from stability.engine_settings import EngineSettings
from stability.impulse import pushed
from stability.model import (
    AT_REST,
    IDENTITY,
    BodyId,
    BodyState,
    Box,
    Brick,
    ContactPoint,
    HalfSpace,
    Plane,
    Pose,
    Shape,
    Vec3,
)
from stability.vectors import moved


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """PyBullet greets with its build time, from C, into whatever its user is printing."""
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


with _silent_stderr():
    import pybullet

# Combined friction is the product of two bodies' own; this stands for "none" where a partner must still reach its own.
FRICTIONLESS = 1e-6
# Half the side of the box that stands for a half-space [m]. A box, because PyBullet gives a box on a plane one contact
# point a step, and a box on a box all four at once.
HALF_SPACE = 1e5
# [engine m/s], for bodies as well as joints. By default PyBullet clamps speeds at 100, which is 10 m/s at scale 100.
TOP_SPEED = 1e4
# [engine kg] for the heaviest brick: far above the thresholds, and even ten thousand press far below the cap of 1e10.
HEAVIEST = 1e4
ORIGIN = (0.0, 0.0, 0.0)
NOT_LOOKED = (-1, -1)  # in the place of the count and the last number of the bodies


@dataclass
class PyBulletBodies:
    """The bodies of a running client: single bodies with mass are bricks, those without (at first sight) are fixed.

    Bodies with joints are neither, and with `only` nor is any body whose number is not in it. Bodies are called by name
    if they are in `names`, else by their number as text. New ones are noticed by themselves.
    """

    client: int
    only: Set[int] | None = None
    names: dict[int, BodyId] = field(default_factory=dict)
    scale: float = field(default=1.0, init=False)  # engine metres per scene metre
    _mass_unit: float = field(default=1.0, init=False)  # engine kilograms per scene kilogram
    _clock: float = field(default=0.0, init=False)
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)
    _fixed: frozenset[BodyId] = field(default=frozenset(), init=False)
    _bodies: dict[BodyId, int] = field(default_factory=dict, init=False)
    _shapes: dict[BodyId, Shape] = field(default_factory=dict, init=False)
    _noticed: tuple[int, int] = field(default=NOT_LOOKED, init=False)

    def time(self) -> float:
        return self._clock

    def step(self) -> None:
        """Step the client once."""
        pybullet.stepSimulation(self.client)
        self.stepped()

    def stepped(self) -> None:
        """Say that the owner has stepped the client once."""
        self._clock += float(pybullet.getPhysicsEngineParameters(self.client)["fixedTimeStep"])

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
        numbers = [pybullet.getBodyUniqueId(index, self.client) for index in range(count)]
        bodies = {self.names.setdefault(number, str(number)): number for number in numbers}
        masses = {name: self._mass(name, number) for name, number in bodies.items()}
        single = {name for name, number in bodies.items() if pybullet.getNumJoints(number, self.client) == 0}
        self._bodies = bodies
        self._masses = {
            name: mass
            for name, mass in masses.items()
            if mass > 0.0 and name in single and (self.only is None or bodies[name] in self.only)
        }
        self._fixed = frozenset(name for name, mass in masses.items() if mass == 0.0 and name in single)
        self._shapes = {name: shape for name, shape in self._shapes.items() if name in bodies}

    def _mass(self, name: BodyId, number: int) -> float:
        """The mass of a body [kg]; of a brick that is frozen by now, what it was at first sight."""
        if self._bodies.get(name) == number and (name in self._masses or name in self._fixed):
            return self._masses.get(name, 0.0)
        return float(pybullet.getDynamicsInfo(number, -1, self.client)[0]) / self._mass_unit

    def shape(self, body: BodyId) -> Shape:
        if body not in self._shapes:
            self._shapes[body] = self._shape(pybullet.getCollisionShapeData(self._bodies[body], -1, self.client))
        return self._shapes[body]

    def _shape(self, parts: Sequence[Sequence[Any]]) -> Shape:
        if len(parts) != 1:
            return None
        _, _, kind, dimensions, _, position, orientation = parts[0]
        if position != ORIGIN or orientation != IDENTITY:
            return None
        if kind == pybullet.GEOM_BOX:
            return Box(_scaled(dimensions, 1.0 / self.scale))
        return HalfSpace(dimensions) if kind == pybullet.GEOM_PLANE else None

    def near(self, brick: BodyId, within: float = TOUCHING) -> Sequence[BodyId]:
        low, high = pybullet.getAABB(self._bodies[brick], -1, self.client)
        margin = within * self.scale
        around = pybullet.getOverlappingObjects(
            [x - margin for x in low], [x + margin for x in high], physicsClientId=self.client
        )
        return sorted({self.names.setdefault(body, str(body)) for body, _ in around or ()} - {brick})

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        rate = 1.0 / sqrt(self.scale)  # of speeds: metres grow by scale, seconds by its root
        found = {}
        for body in bodies:
            position, orientation = pybullet.getBasePositionAndOrientation(self._bodies[body], self.client)
            velocity, turning = pybullet.getBaseVelocity(self._bodies[body], self.client)
            found[body] = BodyState(
                Pose(_scaled(position, 1.0 / self.scale), orientation),
                _scaled(velocity, rate),
                _scaled(turning, 1.0 / rate),
            )
        return found

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        points = pybullet.getContactPoints(bodyA=self._bodies[brick], physicsClientId=self.client)
        return [self._contact_point(point) for point in points or ()]

    def _contact_point(self, point: Sequence[Any]) -> ContactPoint:
        a, b = (self.names.setdefault(body, str(body)) for body in point[1:3])
        on_b, normal, gap, force, along, way, across, other_way = point[6:14]
        # PyBullet's friction acts on b; see the test of a sliding brick.
        friction_W = moved(_scaled(way, -along / self._mass_unit), -across / self._mass_unit, other_way)
        on_b_W = _scaled(on_b, 1.0 / self.scale)
        return ContactPoint(a, b, on_b_W, normal, gap / self.scale, force / self._mass_unit, friction_W)

    def freeze(self, brick: BodyId) -> None:
        self._notice_bodies()  # while the mass of a new brick can still be seen
        body = self._bodies[brick]
        # A body without mass keeps the velocity that it has, and drifts with it for ever.
        pybullet.resetBaseVelocity(body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), physicsClientId=self.client)
        pybullet.changeDynamics(body, -1, mass=0.0, physicsClientId=self.client)

    def holds(self, brick: BodyId) -> bool:
        mass = float(pybullet.getDynamicsInfo(self._bodies[brick], -1, self.client)[0])
        if mass == 0.0:
            return True
        # The owner has given it a mass, or has put another body in its place, under the same number.
        self._masses = {**self._masses, brick: mass / self._mass_unit}
        self._shapes.pop(brick, None)
        return False

    def wake(self, brick: BodyId) -> None:
        mass = self._masses[brick] * self._mass_unit
        pybullet.changeDynamics(self._bodies[brick], -1, mass=mass, physicsClientId=self.client)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        position = _scaled(pose.position_W, self.scale)
        pybullet.resetBasePositionAndOrientation(
            self._bodies[brick], position, pose.orientation, physicsClientId=self.client
        )


def _scaled(vector: Vec3, by: float) -> Vec3:
    x, y, z = vector
    return (x * by, y * by, z * by)


@dataclass
class PyBulletWorld(PyBulletBodies):
    """A world of its own for bricks and planes; close it after use."""

    settings: EngineSettings = field(kw_only=True)
    friction: float = field(kw_only=True)  # Coulomb coefficient of brick on brick
    _parts: int = field(default=1, init=False)  # engine steps in one step
    _box_numbers: dict[Vec3, int] = field(default_factory=dict, init=False)

    @classmethod
    def opened(
        cls, settings: EngineSettings, gravity: float, friction: float, heaviest: float | None = None
    ) -> "PyBulletWorld":
        """A new, empty world with gravity [m/s2] along -z.

        Nothing depends on the unit of mass but the solver's absolute thresholds and its cap on impulses, so with scaled
        settings it is chosen by the mass of the heaviest brick to come [kg].
        """
        client = pybullet.connect(pybullet.DIRECT)
        if client < 0:
            raise RuntimeError("PyBullet accepts no more clients in this process")
        world = cls(client, settings=settings, friction=friction)
        world.scale = settings.scale
        if heaviest is not None and settings.scale != 1.0:
            world._mass_unit = 10.0 ** round(log10(HEAVIEST / heaviest))
        pybullet.setGravity(0.0, 0.0, -gravity, client)
        pybullet.setPhysicsEngineParameter(**engine_parameters(settings), physicsClientId=client)
        return world

    def close(self) -> None:
        """End the world; nothing of it is left."""
        pybullet.disconnect(self.client)

    def step(self) -> None:
        for _ in range(self._parts):
            pybullet.stepSimulation(self.client)
        self._clock += self.settings.time_step

    def limit_travel(self, fastest: float) -> None:
        """Split the coming steps so that a body of this speed [m/s] gets no further in one than the settings allow."""
        if self.settings.most_travel is None:
            return
        parts = max(1, ceil(fastest * self.settings.time_step / self.settings.most_travel))
        if parts != self._parts:
            self._parts = parts
            engine_step = self.settings.time_step * sqrt(self.scale) / parts
            pybullet.setPhysicsEngineParameter(fixedTimeStep=engine_step, physicsClientId=self.client)

    def skip(self, duration: float) -> None:
        """Let time pass in which nothing can move."""
        self._clock += duration

    def add_plane(self, plane: Plane) -> None:
        """Put up the ground or a wall."""
        depth = HALF_SPACE * self.scale
        shape = self._box((depth, depth, depth))
        nx, ny, nz = plane.normal_W
        px, py, pz = _scaled(plane.point_W, self.scale)
        centre = (px - nx * depth, py - ny * depth, pz - nz * depth)
        body = pybullet.createMultiBody(
            baseMass=0.0,
            baseCollisionShapeIndex=shape,
            basePosition=centre,
            baseOrientation=_turning_z_to(plane.normal_W),
            physicsClientId=self.client,
        )
        self._name(body, plane.id, plane.friction / self._own_friction())

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""
        a, b, c = _scaled(brick.size, 0.5 * self.scale)
        body = pybullet.createMultiBody(
            baseMass=brick.mass * self._mass_unit,
            baseCollisionShapeIndex=self._box((a, b, c)),
            basePosition=_scaled(pose.position_W, self.scale),
            baseOrientation=pose.orientation,
            physicsClientId=self.client,
        )
        self._name(body, brick.id, self._own_friction())
        if velocity_W != AT_REST:
            self._set_motion(body, velocity_W, AT_REST)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        """Give a brick that is not frozen an impulse [N s] at a point [m]."""
        shape = self.shape(brick)
        if not isinstance(shape, Box):
            raise TypeError(f"'{brick}' is no box")
        after = pushed(self.states([brick])[brick], shape.size, self.masses()[brick], impulse_W, at_W)
        self._set_motion(self._bodies[brick], after.velocity_W, after.angular_velocity_W)

    def _set_motion(self, body: int, velocity_W: Vec3, angular_velocity_W: Vec3) -> None:
        rate = sqrt(self.scale)
        pybullet.resetBaseVelocity(
            body, _scaled(velocity_W, rate), _scaled(angular_velocity_W, 1.0 / rate), physicsClientId=self.client
        )

    def remove_brick(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again."""
        body = self._bodies.pop(brick)
        pybullet.removeBody(body, self.client)
        del self.names[body]
        self._shapes.pop(brick, None)
        self._masses = {name: mass for name, mass in self._masses.items() if name != brick}
        # The engine gives the number to the next body, so that count and last number might be what they were.
        self._noticed = NOT_LOOKED

    def _own_friction(self) -> float:
        return max(sqrt(self.friction), FRICTIONLESS)

    def _box(self, half_extents: Vec3) -> int:
        if half_extents not in self._box_numbers:
            self._box_numbers[half_extents] = pybullet.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half_extents, physicsClientId=self.client
            )
        return self._box_numbers[half_extents]

    def _name(self, body: int, name: BodyId, own_friction: float) -> None:
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=own_friction,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=0.0,
            linearDamping=self.settings.linear_damping,
            angularDamping=self.settings.angular_damping,
            maxJointVelocity=TOP_SPEED,
            frictionAnchor=int(self.settings.friction_anchor),
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self.client,
        )
        # Looking at all bodies for each that comes would take minutes for ten thousand; `masses` looks for itself.
        self.names[body] = name
        self._bodies[name] = body


def engine_parameters(settings: EngineSettings) -> dict[str, float]:
    """All that `setPhysicsEngineParameter` must be told: each belongs to the client or, worse, to the process."""
    return {
        "fixedTimeStep": settings.time_step * sqrt(settings.scale),
        "numSolverIterations": settings.iterations,
        "numSubSteps": 0,
        "contactERP": settings.contact_erp,
        "erp": settings.contact_erp,
        "frictionERP": 0.2,
        "contactBreakingThreshold": settings.breaking_threshold * settings.scale,
        "contactSlop": 1e-5,
        "solverResidualThreshold": settings.residual_threshold,
        "restitutionVelocityThreshold": 0.2,
        "globalCFM": 0.0,
        "enableConeFriction": 1,
        "deterministicOverlappingPairs": 1,
        "constraintSolverType": pybullet.CONSTRAINT_SOLVER_LCP_SI,
    }


def _turning_z_to(normal_W: Vec3) -> tuple[float, float, float, float]:
    """The shortest turn that takes the z axis to a unit vector."""
    nx, ny, nz = normal_W
    if nz <= -1.0 + 1e-12:
        return (1.0, 0.0, 0.0, 0.0)
    half = sqrt(2.0 * (1.0 + nz))
    return (-ny / half, nx / half, 0.0, half / 2.0)
