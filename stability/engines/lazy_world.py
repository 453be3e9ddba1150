"""A world without an engine, as long as nothing in it moves.

It keeps planes, bricks and poses itself. An engine is opened, and imported, when something must be stepped or when an
engine's knowledge is asked for: then what moves comes in, and what is near to that, frozen bricks as fixed bodies.
"""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field

from stability.engines.friction_told import FrictionRecord
from stability.engines.near_engine import NearEngine, Opening
from stability.engines.prescribed import PrescribedMotion
from stability.engines.put_bodies import PutBodies
from stability.engines.settings import EngineSettings
from stability.mechanics.rubbing import Pressed
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3


@dataclass
class RestingWorld:
    """Stands in for a world until one is needed, and then for the part of it that matters."""

    opening: Opening
    prescribed: PrescribedMotion = field(default_factory=PrescribedMotion, init=False)
    frictions: FrictionRecord = field(default_factory=FrictionRecord, init=False)
    _put: PutBodies = field(init=False)
    engine: NearEngine = field(init=False)  # of what moves; it may be given back, and take over that of another world

    def __post_init__(self) -> None:
        self._put = PutBodies()
        self.engine = NearEngine(self._put, self.opening, self.prescribed, self.frictions)

    @property
    def settings(self) -> EngineSettings:
        return self.engine.settings

    def time(self) -> float:
        return self.engine.clock if self.engine.world is None else self.engine.world.time()

    def step(self) -> None:
        self.engine.ready().step()

    def limit_travel(self, fastest: float) -> None:
        self.engine.limit_travel(fastest)

    def ease_in(self) -> None:
        self.engine.ready().ease_in()

    def skip(self, duration: float) -> None:
        if self.engine.world is None:
            self.engine.clock += duration
        else:
            self.engine.world.skip(duration)

    def add_plane(self, plane: Plane) -> None:
        self._put.own.add_plane(plane)
        if self.engine.world is not None:
            self.engine.world.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._put.add(brick, pose, velocity_W)
        self.engine.loosened(brick.id)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        world = self.engine.has(brick)
        if world is None:
            self._put.set_state(brick, state)
        else:
            self.engine.parted(brick)
            world.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.engine.ready().push(brick, impulse_W, at_W)

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        self.engine.ready().press(brick, pressed)

    def remove_brick(self, brick: BodyId) -> None:
        world = self.engine.has(brick)
        self.engine.gone(brick)
        self._put.remove(brick)
        if world is not None:
            world.remove_brick(brick)

    def close(self) -> None:
        if self.engine.world is not None:
            self.engine.world.close()

    def masses(self) -> Mapping[BodyId, float]:
        return self._put.own.masses

    def fixed(self) -> Set[BodyId]:
        return self._put.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self._put.own.shape(body)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.engine.near(brick, within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        asked = [body for body in bodies if self.engine.has(body) is not None]
        if not asked or self.engine.world is None:
            return {body: self._put.state(body) for body in bodies}
        known = self.engine.world.states(asked)
        return known if len(known) == len(bodies) else {b: known.get(b) or self._put.state(b) for b in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        world = self.engine.has(brick)
        return world.contacts(brick) if world is not None else ()  # none before a first step

    def freeze(self, brick: BodyId) -> None:
        world = self.engine.has(brick)
        if world is not None:
            world.freeze(brick)
            self._put.put(brick, world.states([brick])[brick].pose)
        self._put.freeze(brick)
        self.engine.held(brick)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._put.frozen

    def wake(self, brick: BodyId) -> None:
        self._put.loosen(brick)
        self.engine.loosened(brick)
        world = self.engine.has(brick)
        if world is not None:
            world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._put.put(brick, pose)
        world = self.engine.has(brick)
        if world is not None:
            world.put_at(brick, pose)
        self.engine.moved(brick)

    def join(self, bricks: Collection[BodyId]) -> None:
        world = self.engine.joined(bricks)  # with these bricks frozen
        for brick in bricks:
            self._put.loosen(brick)
        world.join(bricks)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        world = self.engine.ready()  # which may be another one by now, with this brick in its group
        self.engine.parted(brick)
        return world.part(brick)
