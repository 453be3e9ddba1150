"""An engine whose bricks fall straight down, and lie flat where they land. No brick tips, slides or turns."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

from stability.contact_law import GivenFriction
from stability.engines.bodies import EngineWorld, OwnBodies
from stability.engines.protocol import NOTHING_PRESCRIBED, EngineSettings, Package, PrescribedMotion, StepClock, World
from stability.geometry.placed_shape import corners_W
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3
from stackdsl.simulation.systems import System

NEAR = 1e-6  # [m] a brick rests on another one if the gap is smaller


@dataclass(frozen=True, kw_only=True)
class ExampleSettings(EngineSettings):
    package: ClassVar[Package] = Package("example_engine", "pip install example-engine")
    world: ClassVar[str] = "example_engine:ExampleWorld"

    bounce: float  # upward speed after landing, as a share of the speed before it

    def numerics(self) -> Iterator[str]:
        yield f"bounces by {self.bounce:g}"


@dataclass
class ExampleWorld(EngineWorld):
    settings: ExampleSettings
    gravity: float  # [m/s2]
    clock: StepClock
    own: OwnBodies = field(default_factory=OwnBodies)
    bricks: dict[BodyId, BodyState] = field(default_factory=dict)

    @classmethod
    def opened(
        cls, settings: ExampleSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> World:
        return cls(settings, gravity, StepClock(settings))

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        if prescribed != NOTHING_PRESCRIBED:
            raise NotImplementedError("this engine has no prescribed motions")
        parts = self.clock.pass_step()
        for _ in range(parts):
            for name in sorted(self.bricks, key=lambda name: self.extent(name)[2]):  # the lowest brick first
                self.bricks[name] = self.fallen(name, self.settings.time_step / parts)

    def fallen(self, name: BodyId, duration: float) -> BodyState:
        state, (x, y, z) = self.bricks[name], self.bricks[name].pose.position_W
        speed = state.velocity_W[2] - self.gravity * duration
        rise, room = speed * duration, self.extent(name)[2][0] - max(self.tops_below(name))
        if rise < -room:
            rise, speed = -room, -self.settings.bounce * speed
        return BodyState(Pose((x, y, z + rise), state.pose.orientation), (0.0, 0.0, speed))

    def tops_below(self, name: BodyId) -> Iterator[float]:
        yield from (plane.point_W[2] for plane in self.own.planes.values())
        x, y, z = self.extent(name)
        for u, v, w in (self.extent(other) for other in self.bricks if other != name):
            if all(a[0] < b[1] and b[0] < a[1] for a, b in ((x, u), (y, v))) and w[1] <= z[0] + NEAR:
                yield w[1]

    def extent(self, name: BodyId) -> list[tuple[float, float]]:
        corners = corners_W(self.own.bricks[name].shape, self.bricks[name].pose)
        return [(min(values), max(values)) for values in zip(*corners, strict=True)]  # of x, y and z [m]

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self.bricks[brick.id] = BodyState(pose, velocity_W)

    def remove_brick(self, brick: BodyId) -> None:
        self.own.remove_brick(brick)
        del self.bricks[brick]

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        velocity_W = (0.0, 0.0, self.bricks[brick].velocity_W[2] + impulse_W[2] / self.own.masses[brick])
        self.bricks[brick] = replace(self.bricks[brick], velocity_W=velocity_W)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        return {body: self.bricks.get(body) or BodyState(Pose(self.own.planes[body].point_W)) for body in bodies}

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted({*self.bricks, *self.own.planes} - {brick})

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return ()  # this engine does not report contacts

    def close(self) -> None:
        pass


EXAMPLE = System("example", "bricks that only fall", ExampleSettings(time_step=0.002, bounce=0.0), method=None)
