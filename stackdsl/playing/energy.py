"""Kinetic and potential energy of all bricks, so that what an engine adds by itself shows.

Exact; of the poses and velocities that the engine has at one time. What is not looked at does not move.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from stability.geometry.vectors import dot, subtract
from stability.mechanics.inertia import inertia_times
from stability.model import BodyId, BodyState, Brick, Plane, Vec3
from stackdsl.trace import Energy


def kinetic_energy(brick: Brick, state: BodyState) -> float:
    """Of translation and rotation [J]."""
    spin_W = state.angular_velocity_W
    rotation = dot(inertia_times(brick, state.pose.orientation, spin_W), spin_W)
    return 0.5 * (brick.mass * dot(state.velocity_W, state.velocity_W) + rotation)


@dataclass
class EnergyMeter:
    """Adds up what is seen of the bricks; the ground is the level that potential energy counts from."""

    gravity: float  # [m/s2], along -z
    ground: Plane
    now: float = 0.0  # kinetic + potential energy of all bricks [J]
    above_ground: float = 0.0  # the same, where each brick counts from the ground below itself [J]
    _of: dict[BodyId, tuple[float, float]] = field(default_factory=dict)  # each brick's part of both
    _since: Energy | None = None

    def see(self, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        for name, state in states.items():
            brick = bricks[name]
            weight = brick.mass * self.gravity
            height = state.pose.position_W[2] - self.ground.point_W[2]
            kinetic, was = kinetic_energy(brick, state), self._of.get(name, (0.0, 0.0))
            own = kinetic + weight * height, kinetic + weight * self._height_above_ground(state.pose.position_W)
            self._of[name] = own
            self.now += own[0] - was[0]
            self.above_ground += own[1] - was[1]

    def _height_above_ground(self, position_W: Vec3) -> float:
        """Straight down, as the ground may be tilted [m]."""
        return dot(self.ground.normal_W, subtract(position_W, self.ground.point_W)) / self.ground.normal_W[2]

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out, and their energy with them."""
        for name in bricks:
            energy, above_ground = self._of.pop(name)
            self.now -= energy
            self.above_ground -= above_ground

    def start(self) -> None:
        """Something was done, and all was seen since: what comes now comes by itself."""
        self._since = Energy(self.now, self.now, self.above_ground)

    def look(self) -> None:
        """All that moves has been seen."""
        if self._since is not None and self.now > self._since.most:
            self._since = Energy(self._since.start, self.now, self._since.above_ground)

    def energy(self) -> Energy | None:
        """What it was after the last action, and has been at most since; None if nothing was ever done."""
        return self._since
