"""The bodies of a client by name, read and written in the units of the scene."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.rotations import inverse, multiply
from stability.geometry.vectors import add_scaled, norm, scale, subtract
from stability.model import AT_REST, BodyId, BodyState, ContactPoint, Pose, Quaternion, Vec3


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

    def near(self, name: BodyId, within: float) -> set[BodyId]:
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
