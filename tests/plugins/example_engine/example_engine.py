"""Engine in a package of its own: bricks fall straight down, and lie flat on the ground or on each other.

No brick tips, slides or turns. The module shows the code that `stackdsl` needs from an engine.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

from stability.contact_law import GivenFriction
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.protocol import NOTHING_PRESCRIBED, EngineSettings, Package, PrescribedMotion, StepClock, World
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import corners_W
from stability.geometry.vectors import add_scaled
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3
from stackdsl.simulation.systems import System


@dataclass(frozen=True, kw_only=True)
class ExampleSettings(EngineSettings):
    """Settings of the example."""

    package: ClassVar[Package] = Package("example_engine", "pip install example-engine")
    world: ClassVar[str] = "example_engine:ExampleWorld"

    bounce: float  # upward speed after landing, as a share of the speed before it

    def numerics(self) -> Iterator[str]:
        yield f"bounces by {self.bounce:g}"


@dataclass
class ExampleWorld(EngineWorld):
    """Bricks over a level ground."""

    settings: ExampleSettings
    gravity: float  # [m/s2]
    clock: StepClock
    own: OwnBodies = field(default_factory=OwnBodies)
    _states: dict[BodyId, BodyState] = field(default_factory=dict)

    @classmethod
    def opened(
        cls, settings: ExampleSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> World:
        return cls(settings, gravity, StepClock(settings))

    def close(self) -> None: ...

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        if prescribed != NOTHING_PRESCRIBED:
            raise NotImplementedError("this engine has no prescribed motions")
        parts = self.clock.pass_step()
        for _ in range(parts):
            for name in sorted(self._states, key=lambda name: self._bounds(name)[2]):
                self._states[name] = self._fallen(name, self.settings.time_step / parts)

    def _fallen(self, name: BodyId, duration: float) -> BodyState:
        before = self._states[name]
        speed = before.velocity_W[2] - self.gravity * duration
        room = self._bounds(name)[2][0] - max(self._tops_below(name))
        if speed * duration >= -room:
            return replace(before, pose=_lifted(before.pose, speed * duration), velocity_W=(0.0, 0.0, speed))
        return replace(before, pose=_lifted(before.pose, -room), velocity_W=(0.0, 0.0, -self.settings.bounce * speed))

    def _tops_below(self, name: BodyId) -> Iterator[float]:
        """Yield the heights of the planes, and of the tops of the bricks below a brick [m]."""
        (x, y, z), reach = self._bounds(name), reach_between(self.own.bricks[name].shape.least_thickness)
        yield from (plane.point_W[2] for plane in self.own.planes.values())
        for u, v, w in map(self._bounds, self._states.keys() - {name}):
            if all(a[0] < b[1] and b[0] < a[1] for a, b in ((x, u), (y, v))) and w[1] <= z[0] + reach:
                yield w[1]

    def _bounds(self, name: BodyId) -> list[tuple[float, float]]:
        """Return the least and the greatest x, y and z of a brick [m]."""
        corners = corners_W(self.own.bricks[name].shape, self._states[name].pose)
        return [(min(values), max(values)) for values in zip(*corners, strict=True)]

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted({*self.own.bricks, *self.own.planes} - {brick})

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        return {body: self._states.get(body) or BodyState(Pose(self.own.planes[body].point_W)) for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return ()  # the engine does not report contacts

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self._states[brick.id] = BodyState(pose, velocity_W)

    def remove_brick(self, brick: BodyId) -> None:
        self.own.remove_brick(brick)
        del self._states[brick]

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        velocity_W = add_scaled(self._states[brick].velocity_W, 1.0 / self.own.masses[brick], impulse_W)
        self._states[brick] = replace(self._states[brick], velocity_W=velocity_W)


def _lifted(pose: Pose, by: float) -> Pose:
    return replace(pose, position_W=add_scaled(pose.position_W, by, (0.0, 0.0, 1.0)))


EXAMPLE = System("example", "bricks that only fall", ExampleSettings(time_step=0.002, bounce=0.0), method=None)
