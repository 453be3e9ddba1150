"""A world without an engine, as long as nothing in it moves.

It keeps planes, bricks and poses itself. The engine is opened, and imported, when something must be stepped or when an
engine's knowledge is asked for: then the bricks that are frozen come in as fixed bodies, the others with their mass.
"""

from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from types import MappingProxyType

from stability.engines.protocol import World
from stability.engines.settings import EngineSettings
from stability.model import AT_REST, BodyId, BodyState, Box, Brick, ContactPoint, HalfSpace, Plane, Pose, Shape, Vec3


@dataclass
class RestingWorld:
    """Stands in for a world until one is needed; `opened` makes it."""

    settings: EngineSettings
    opened: Callable[[], World]
    _clock: float = field(default=0.0, init=False)
    _planes: dict[BodyId, Plane] = field(default_factory=dict, init=False)
    _fixed: frozenset[BodyId] = field(default=frozenset(), init=False)
    _bricks: dict[BodyId, tuple[Brick, Pose]] = field(default_factory=dict, init=False)
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)
    _masses_view: Mapping[BodyId, float] = field(default_factory=dict, init=False)  # what `masses` answers with
    _let_go: dict[BodyId, Vec3] = field(default_factory=dict, init=False)  # those that came with a velocity [m/s]
    _moving: dict[BodyId, BodyState] = field(default_factory=dict, init=False)  # those put somewhere in motion
    _frozen: set[BodyId] = field(default_factory=set, init=False)
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
        self._planes[plane.id] = plane
        self._fixed = frozenset(self._planes)
        if self._world is not None:
            self._world.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._bricks[brick.id] = (brick, pose)
        if velocity_W != AT_REST:
            self._let_go[brick.id] = velocity_W
        self._masses[brick.id] = brick.mass
        self._masses_view = MappingProxyType(self._masses)  # another object says that a brick has come
        if self._world is not None:
            self._world.add_brick(brick, pose, velocity_W)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        if self._world is not None:
            self._world.set_state(brick, state)
            return
        self._bricks[brick] = (self._bricks[brick][0], state.pose)
        self._let_go.pop(brick, None)
        self._moving[brick] = state

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self._engine().push(brick, impulse_W, at_W)

    def remove_brick(self, brick: BodyId) -> None:
        del self._bricks[brick], self._masses[brick]
        self._stops(brick)
        self._frozen.discard(brick)
        self._masses_view = MappingProxyType(self._masses)
        if self._world is not None:
            self._world.remove_brick(brick)

    def close(self) -> None:
        if self._world is not None:
            self._world.close()

    def masses(self) -> Mapping[BodyId, float]:
        return self._masses_view

    def fixed(self) -> Set[BodyId]:
        return self._fixed

    def shape(self, body: BodyId) -> Shape:
        return HalfSpace(self._planes[body].normal_W) if body in self._planes else Box(self._bricks[body][0].size)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self._engine().near(brick, within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        if self._world is not None:
            return self._world.states(bodies)
        return {body: self._moving.get(body) or self._at(body) for body in bodies}

    def _at(self, body: BodyId) -> BodyState:
        return BodyState(self._pose(body), self._let_go.get(body, AT_REST))

    def _pose(self, body: BodyId) -> Pose:
        return Pose(self._planes[body].point_W) if body in self._planes else self._bricks[body][1]

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self._world.contacts(brick) if self._world is not None else ()  # none before a first step

    def freeze(self, brick: BodyId) -> None:
        self._frozen.add(brick)
        self._stops(brick)
        if self._world is not None:
            self._world.freeze(brick)

    def _stops(self, brick: BodyId) -> None:
        self._let_go.pop(brick, None)
        self._moving.pop(brick, None)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._frozen

    def wake(self, brick: BodyId) -> None:
        self._frozen.discard(brick)
        if self._world is not None:
            self._world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._bricks[brick] = (self._bricks[brick][0], pose)
        if self._world is not None:
            self._world.put_at(brick, pose)

    def join(self, bricks: Collection[BodyId]) -> None:
        world = self._engine()  # with these bricks frozen
        self._frozen.difference_update(bricks)
        world.join(bricks)

    def part(self, brick: BodyId) -> tuple[BodyId, ...]:
        return self._engine().part(brick)

    def _engine(self) -> World:
        """The world that is stepped; it has been going on since the beginning, as far as anybody can tell."""
        if self._world is None:
            self._world = self.opened()
            for plane in self._planes.values():
                self._world.add_plane(plane)
            for brick, pose in self._bricks.values():
                self._world.add_brick(brick, pose, self._let_go.get(brick.id, AT_REST))
            for name, state in self._moving.items():
                self._world.set_state(name, state)
            for name in sorted(self._frozen):
                self._world.freeze(name)
            self._world.skip(self._clock)
            self._world.limit_travel(self._fastest)
        return self._world
