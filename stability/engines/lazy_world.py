"""A world without an engine, as long as nothing in it moves.

It keeps planes, bricks and poses itself. The engine is opened, and imported, when something must be stepped or when an
engine's knowledge is asked for: then the bricks that are frozen come in as fixed bodies, the others with their mass.
"""

from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field

from stability.engines.own_bodies import OwnBodies
from stability.engines.protocol import World
from stability.engines.settings import EngineSettings
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Shape, Vec3


@dataclass
class PutBodies:
    """What was put where, and what of it was let go, put in motion or frozen since."""

    own: OwnBodies = field(default_factory=OwnBodies, init=False)
    frozen: set[BodyId] = field(default_factory=set, init=False)
    _poses: dict[BodyId, Pose] = field(default_factory=dict, init=False)  # of bricks
    _let_go: dict[BodyId, Vec3] = field(default_factory=dict, init=False)  # those that came with a velocity [m/s]
    _moving: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # those put somewhere in motion

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Know a brick from now on, at rest or with a velocity of its centre [m/s]."""
        self.own.add_brick(brick)
        self._poses[brick.id] = pose
        if velocity_W != AT_REST:
            self._let_go[brick.id] = velocity_W

    def remove(self, brick: BodyId) -> None:
        """Forget a brick."""
        self.own.remove_brick(brick)
        del self._poses[brick]
        self._stop(brick)
        self.frozen.discard(brick)

    def put(self, brick: BodyId, pose: Pose) -> None:
        """Put a brick somewhere else; nothing else of it changes."""
        self._poses[brick] = pose

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick somewhere else, in motion."""
        self._poses[brick] = state.pose
        self._let_go.pop(brick, None)
        self._moving[brick] = state

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.frozen.add(brick)
        self._stop(brick)

    def _stop(self, brick: BodyId) -> None:
        self._let_go.pop(brick, None)
        self._moving.pop(brick, None)

    def state(self, body: BodyId) -> BodyState:
        """Pose and motion of a brick or a plane, as it was put."""
        if body in self.own.planes:
            return BodyState(Pose(self.own.planes[body].point_W))
        return self._moving.get(body) or BodyState(self._poses[body], self._let_go.get(body, AT_REST))

    def enter(self, world: World) -> None:
        """Put all of it into a world that is empty."""
        for plane in self.own.planes.values():
            world.add_plane(plane)
        for name, brick in self.own.bricks.items():
            world.add_brick(brick, self._poses[name], self._let_go.get(name, AT_REST))
        for name, state in self._moving.items():
            world.set_state(name, state)
        for name in sorted(self.frozen):
            world.freeze(name)


@dataclass
class RestingWorld:
    """Stands in for a world until one is needed; `opened` makes it."""

    settings: EngineSettings
    opened: Callable[[], World]
    _put: PutBodies = field(default_factory=PutBodies, init=False)
    _clock: float = field(default=0.0, init=False)
    _fastest: float = field(default=0.0, init=False)  # that bodies will be, as was said [m/s]
    _world: World | None = field(default=None, init=False)

    def time(self) -> float:
        return self._clock if self._world is None else self._world.time()

    def step(self) -> None:
        self._engine().step()

    def limit_travel(self, fastest: float) -> None:
        self._fastest = fastest
        if self._world is not None:
            self._world.limit_travel(fastest)

    def ease_in(self) -> None:
        self._engine().ease_in()

    def skip(self, duration: float) -> None:
        if self._world is None:
            self._clock += duration
        else:
            self._world.skip(duration)

    def add_plane(self, plane: Plane) -> None:
        self._put.own.add_plane(plane)
        if self._world is not None:
            self._world.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._put.add(brick, pose, velocity_W)
        if self._world is not None:
            self._world.add_brick(brick, pose, velocity_W)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        if self._world is not None:
            self._world.set_state(brick, state)
        else:
            self._put.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self._engine().push(brick, impulse_W, at_W)

    def remove_brick(self, brick: BodyId) -> None:
        self._put.remove(brick)
        if self._world is not None:
            self._world.remove_brick(brick)

    def close(self) -> None:
        if self._world is not None:
            self._world.close()

    def masses(self) -> Mapping[BodyId, float]:
        return self._put.own.masses

    def fixed(self) -> Set[BodyId]:
        return self._put.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self._put.own.shape(body)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self._engine().near(brick, within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        if self._world is not None:
            return self._world.states(bodies)
        return {body: self._put.state(body) for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self._world.contacts(brick) if self._world is not None else ()  # none before a first step

    def freeze(self, brick: BodyId) -> None:
        self._put.freeze(brick)
        if self._world is not None:
            self._world.freeze(brick)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._put.frozen

    def wake(self, brick: BodyId) -> None:
        self._put.frozen.discard(brick)
        if self._world is not None:
            self._world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._put.put(brick, pose)
        if self._world is not None:
            self._world.put_at(brick, pose)

    def join(self, bricks: Collection[BodyId]) -> None:
        world = self._engine()  # with these bricks frozen
        self._put.frozen.difference_update(bricks)
        world.join(bricks)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self._engine().part(brick)

    def _engine(self) -> World:
        """The world that is stepped; it has been going on since the beginning, as far as anybody can tell."""
        if self._world is None:
            self._world = self.opened()
            self._put.enter(self._world)
            self._world.skip(self._clock)
            self._world.limit_travel(self._fastest)
        return self._world
