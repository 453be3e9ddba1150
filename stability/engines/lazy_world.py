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
    _engine: NearEngine = field(init=False)

    def __post_init__(self) -> None:
        self._put = PutBodies()
        self._engine = NearEngine(self._put, self.opening, self.prescribed, self.frictions)

    @property
    def settings(self) -> EngineSettings:
        return self._engine.settings

    def time(self) -> float:
        return self._engine.clock if self._engine.world is None else self._engine.world.time()

    def step(self) -> None:
        self._engine.ready().step()

    def limit_travel(self, fastest: float) -> None:
        self._engine.limit_travel(fastest)

    def ease_in(self) -> None:
        self._engine.ready().ease_in()

    def skip(self, duration: float) -> None:
        if self._engine.world is None:
            self._engine.clock += duration
        else:
            self._engine.world.skip(duration)

    def add_plane(self, plane: Plane) -> None:
        self._put.own.add_plane(plane)
        if self._engine.world is not None:
            self._engine.world.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._put.add(brick, pose, velocity_W)
        self._engine.loosened(brick.id)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        world = self._engine.has(brick)
        if world is None:
            self._put.set_state(brick, state)
        else:
            self._engine.parted(brick)
            world.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self._engine.ready().push(brick, impulse_W, at_W)

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        self._engine.ready().press(brick, pressed)

    def remove_brick(self, brick: BodyId) -> None:
        world = self._engine.has(brick)
        self._engine.gone(brick)
        self._put.remove(brick)
        if world is not None:
            world.remove_brick(brick)

    def absorb(self, other: "RestingWorld") -> None:
        """Know all bricks of another world as they are and move there, for they come near; that world is over."""
        self._engine.absorb(other._engine)
        if other.frictions.worst is not None:
            self.frictions.note(other.frictions.worst)

    def give_back(self) -> None:
        """Do without an engine, until one is needed again."""
        self._engine.give_back()

    def close(self) -> None:
        if self._engine.world is not None:
            self._engine.world.close()

    def masses(self) -> Mapping[BodyId, float]:
        return self._put.own.masses

    def fixed(self) -> Set[BodyId]:
        return self._put.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self._put.own.shape(body)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self._engine.near(brick, within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        asked = [body for body in bodies if self._engine.has(body) is not None]
        if not asked or self._engine.world is None:
            return {body: self._put.state(body) for body in bodies}
        known = self._engine.world.states(asked)
        return known if len(known) == len(bodies) else {b: known.get(b) or self._put.state(b) for b in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        world = self._engine.has(brick)
        return world.contacts(brick) if world is not None else ()  # none before a first step

    def freeze(self, brick: BodyId) -> None:
        world = self._engine.has(brick)
        if world is not None:
            world.freeze(brick)
            self._put.put(brick, world.states([brick])[brick].pose)
        self._put.freeze(brick)
        self._engine.held(brick)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._put.frozen

    def wake(self, brick: BodyId) -> None:
        self._put.loosen(brick)
        self._engine.loosened(brick)
        world = self._engine.has(brick)
        if world is not None:
            world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._put.put(brick, pose)
        world = self._engine.has(brick)
        if world is not None:
            world.put_at(brick, pose)
        self._engine.moved(brick)

    def join(self, bricks: Collection[BodyId]) -> None:
        world = self._engine.joined(bricks)  # with these bricks frozen
        for brick in bricks:
            self._put.loosen(brick)
        world.join(bricks)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        world = self._engine.ready()  # which may be another one by now, with this brick in its group
        self._engine.parted(brick)
        return world.part(brick)
