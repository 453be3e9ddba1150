"""The bodies of a running client, seen and held through the protocol of `stability.engines.protocol`."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.vectors import add_scaled, scale
from stability.model import IDENTITY, BodyId, BodyState, Box, ContactPoint, HalfSpace, Pose, Shape

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
            return Box(scale(1.0 / self.scale, dimensions))
        return HalfSpace(dimensions) if kind == pybullet.GEOM_PLANE else None

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        low, high = pybullet.getAABB(self._bodies[brick], -1, self.client)
        margin = within * self.scale
        return sorted(self._around([x - margin for x in low], [x + margin for x in high]) - {brick})

    def _around(self, low: Sequence[float], high: Sequence[float]) -> set[BodyId]:
        """The bodies whose bounds meet those from `low` to `high`, in engine metres."""
        around = pybullet.getOverlappingObjects(low, high, physicsClientId=self.client)
        return {self.names.setdefault(body, str(body)) for body, _ in around or ()}

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        rate = 1.0 / sqrt(self.scale)  # of speeds: metres grow by scale, seconds by its root
        found = {}
        for body in bodies:
            position, orientation = pybullet.getBasePositionAndOrientation(self._bodies[body], self.client)
            velocity, angular_velocity = pybullet.getBaseVelocity(self._bodies[body], self.client)
            found[body] = BodyState(
                Pose(scale(1.0 / self.scale, position), orientation),
                scale(rate, velocity),
                scale(1.0 / rate, angular_velocity),
            )
        return found

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        points = pybullet.getContactPoints(bodyA=self._bodies[brick], physicsClientId=self.client)
        return [self._contact_point(point) for point in points or ()]

    def _contact_point(self, point: Sequence[Any]) -> ContactPoint:
        a, b = (self.names.setdefault(body, str(body)) for body in point[1:3])
        on_b, normal, gap, force, along, way, across, other_way = point[6:14]
        # PyBullet's friction acts on b; see the test of a sliding brick.
        friction_W = add_scaled(scale(-along / self._mass_unit, way), -across / self._mass_unit, other_way)
        on_b_W = scale(1.0 / self.scale, on_b)
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
        position = scale(self.scale, pose.position_W)
        pybullet.resetBasePositionAndOrientation(
            self._bodies[brick], position, pose.orientation, physicsClientId=self.client
        )
