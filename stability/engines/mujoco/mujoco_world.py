"""A MuJoCo world of one's own; bricks can be joined in it, to move as one rigid body."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Self

from stability.engines.mujoco.mujoco_model import Model
from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.mujoco.remade_bodies import RemadeBodies
from stability.engines.own_bodies import OwnBodies
from stability.engines.prescribed import PrescribedMotion
from stability.engines.pressing import Presses
from stability.engines.step_clock import StepClock
from stability.friction_law import GivenFriction
from stability.mechanics.impulse import pushed
from stability.mechanics.rubbing import Pressed
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3


@dataclass
class MuJoCoWorld:
    """A world of its own for bricks and planes; `opened` makes it."""

    settings: MuJoCoSettings
    own: OwnBodies
    bodies: RemadeBodies
    clock: StepClock
    prescribed: PrescribedMotion = field(default_factory=PrescribedMotion, init=False)
    presses: Presses = field(default_factory=Presses, init=False)
    _stepped: Model | None = field(default=None, init=False)  # the one that took the last step

    @classmethod
    def opened(
        cls, settings: MuJoCoSettings, gravity: float, friction: GivenFriction, heaviest: float | None = None
    ) -> Self:
        """A new, empty world with gravity [m/s2] along -z; whatever the masses, they are in kilograms."""
        own = OwnBodies()
        return cls(settings, own, RemadeBodies(settings, gravity, friction, own), StepClock(settings))

    def close(self) -> None:
        self.bodies.take_over()
        self._stepped = None

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
        self.bodies.carry({name for name, each in self.prescribed.guided.items() if each.carried})
        self._stepped = self.bodies.model()
        self._stepped.pull(self.bodies.gravity, self.prescribed.acceleration_W)
        parts = self.clock.pass_step()
        self._stepped.step(self.settings.time_step, parts, self.presses, self.prescribed.guided)

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {body: self.bodies.state(body) for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        points = self._stepped.contacts(brick) if self._stepped is not None else ()
        there = self.own.bricks.keys() | self.own.planes.keys()
        return [point for point in points if point.a in there and point.b in there]

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        boxes, fellows = self.bodies.model().bounds(planes=len(self.own.planes)), self.bodies.fellows(brick)
        return [other for other in self.own.near(brick, boxes, within) if other not in fellows]

    def add_plane(self, plane: Plane) -> None:
        self.bodies.take_over()
        self.own.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.own.add_brick(brick)
        self.bodies.add(brick, BodyState(pose, velocity_W))

    def remove_brick(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self.bodies.remove(brick)
        self.own.remove_brick(brick)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.set_state(brick, pushed(self.bodies.state(brick), self.own.bricks[brick], impulse_W, at_W))

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        self.presses.press(self.own.bricks[brick], self.bodies.state(brick), pressed)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        self.bodies.part_from_others(brick)
        self.bodies.put(brick, state, held=False)

    def freeze(self, brick: BodyId) -> None:
        self.presses.leave(brick)
        self.bodies.part_from_others(brick)
        self.bodies.put(brick, BodyState(self.bodies.state(brick).pose), held=True)

    def holds(self, brick: BodyId) -> bool:
        return self.bodies.holds(brick)

    def wake(self, brick: BodyId) -> None:
        self.bodies.put(brick, self.bodies.state(brick), held=False)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bodies.put(brick, BodyState(pose), held=True)

    def join(self, bricks: Collection[BodyId]) -> None:
        for brick in bricks:
            self.presses.leave(brick)
        self.bodies.join(bricks)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self.bodies.part(brick)
