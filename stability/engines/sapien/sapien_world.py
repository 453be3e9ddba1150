"""A SAPIEN world of one's own; every brick moves by itself."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Self

from stability.engines.own_bodies import OwnBodies
from stability.engines.prescribed import PrescribedMotion
from stability.engines.sapien.sapien_settings import SapienSettings
from stability.engines.sapien.scene_bodies import SceneBodies
from stability.engines.step_clock import StepClock
from stability.friction_law import GivenFriction
from stability.mechanics.impulse import pushed
from stability.mechanics.rubbing import Pressed
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3


@dataclass
class SapienWorld:
    """A world of its own for bricks and planes; `opened` makes it."""

    settings: SapienSettings
    own: OwnBodies
    bodies: SceneBodies
    clock: StepClock
    prescribed: PrescribedMotion = field(default_factory=PrescribedMotion, init=False)

    @classmethod
    def opened(
        cls, settings: SapienSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> Self:
        """A new, empty world with gravity [m/s2] along -z; whatever the masses, they are in kilograms."""
        return cls(settings, OwnBodies(), SceneBodies.opened(settings, gravity, friction), StepClock(settings))

    def close(self) -> None:
        self.bodies.close()

    def time(self) -> float:
        return self.clock.time

    def skip(self, duration: float) -> None:
        self.clock.time += duration

    def limit_travel(self, fastest: float) -> None:
        self.clock.limit_travel(fastest)

    def ease_in(self) -> None:
        """No step is split for it: the settings were chosen without."""

    def masses(self) -> Mapping[BodyId, float]:
        return self.own.masses

    def fixed(self) -> Set[BodyId]:
        return self.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self.own.shape(body)

    def step(self) -> None:
        self.bodies.step(self.clock.pass_step(), self.prescribed)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        planes = self.own.planes
        return {b: BodyState(Pose(planes[b].point_W)) if b in planes else self.bodies.state(b) for b in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self.bodies.contacts(brick)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.own.near(brick, self.bodies.boxes(self.own.bricks.values()), within)

    def add_plane(self, plane: Plane) -> None:
        self.own.add_plane(plane)
        self.bodies.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self.bodies.add_brick(brick, pose, velocity_W)

    def remove_brick(self, brick: BodyId) -> None:
        self.own.remove_brick(brick)
        self.bodies.remove(brick)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.set_state(brick, pushed(self.bodies.state(brick), self.own.bricks[brick], impulse_W, at_W))

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.bodies.set_state(brick, state)

    def freeze(self, brick: BodyId) -> None:
        self.bodies.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        return self.bodies.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.bodies.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bodies.put_at(brick, pose)

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        raise NotImplementedError("nothing presses on bricks in SAPIEN but bricks; give an extension no presser")

    def join(self, bricks: Collection[BodyId]) -> None:
        raise NotImplementedError("bricks cannot be joined in SAPIEN; give an extension no joiner")

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        raise NotImplementedError("bricks cannot be joined in SAPIEN; give an extension no joiner")
