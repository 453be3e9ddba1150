"""A world that starts an engine only for what moves and what that may touch."""

from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import dist, hypot
from pkgutil import resolve_name
from typing import TypeVar

from stability.contact_law import GivenFriction
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.bodies import PutBodies
from stability.engines.protocol import (
    EngineSettings,
    FrictionRecord,
    OpensWorlds,
    PrescribedMotion,
    TellsFriction,
    World,
)
from stability.engines.scene_scale import SAMPLING
from stability.geometry.placed_shape import bounds_W
from stability.geometry.spatial_grid import Neighbours
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Shape, Vec3

# The engine of a world in which most rests: it knows what moves, what that may touch soon, and nothing else.
#
# What stands elsewhere changes nothing of a motion until something comes near to it, and is let in before that. So an
# engine has no more to do than what moves asks for, and its settings are those of what is there (docs/design/engines.md).


# [s] as far ahead as bodies move until it is said anew how fast they are; twice, since a hit may make one faster.
AHEAD = 2.0 * SAMPLING
HEAVIER = 10.0  # times the heaviest that an engine was opened for, and it is opened again


@dataclass(frozen=True, slots=True)
class Opening:
    """How an engine is opened."""

    scene: EngineSettings  # while nothing moves
    settings_for: Callable[[Collection[Brick]], EngineSettings]  # these bricks
    opened: Callable[[EngineSettings, float], World]  # with these settings, for bricks of up to this mass [kg]


@dataclass
class NearEngine:
    """Opens an engine when something must be stepped, and lets in bricks before they matter."""

    put: PutBodies
    opening: Opening
    prescribed: PrescribedMotion = field(default_factory=PrescribedMotion)
    frictions: FrictionRecord = field(default_factory=FrictionRecord)
    clock: float = 0.0  # [s] while there is no engine
    world: World | None = field(default=None, init=False)
    _inside: dict[BodyId, None] = field(default_factory=dict, init=False)
    _outside: Neighbours[BodyId] | None = field(default=None, init=False)  # what is held, once an engine was asked for
    _waiting: dict[BodyId, None] = field(default_factory=dict, init=False)  # loose, and not inside yet
    # Around each brick that is loose: from where, and up to how far all is inside.
    _seen: dict[BodyId, tuple[Vec3, float]] = field(default_factory=dict, init=False)
    _groups: dict[BodyId, tuple[BodyId, ...]] = field(default_factory=dict, init=False)  # that were joined
    _fastest: float = field(default=0.0, init=False)  # that bodies will be, as was said [m/s]
    _heaviest: float = field(default=0.0, init=False)  # that the engine was opened for [kg]
    _settings: EngineSettings | None = field(default=None, init=False)  # for what is loose; None: to be worked out

    @property
    def settings(self) -> EngineSettings:
        """How what moves is stepped, or would be."""
        if self.world is not None:
            return self.world.settings
        if not self.put.loose:
            return self.opening.scene
        if self._settings is None:
            self._settings = self.opening.settings_for([self.put.own.bricks[name] for name in self.put.loose])
        return self._settings

    def has(self, brick: BodyId) -> World | None:
        """The world that knows a brick, if there is one."""
        return self.world if brick in self._inside else None

    # --- what becomes of bricks ---------------------------------------------------------------------------------------

    def on_woken(self, brick: BodyId) -> None:
        """Hear that a brick may move from now on."""
        self._settings = None
        self._waiting[brick] = None
        self._leave_outside(brick)

    def held(self, brick: BodyId) -> None:
        """Hear that a brick is held from now on."""
        self._forget(brick)
        if brick not in self._inside:
            self._stand_outside(brick)

    def gone(self, brick: BodyId) -> None:
        """Hear that a brick is gone."""
        self._forget(brick)
        self._leave_outside(brick)
        self._inside.pop(brick, None)

    def _forget(self, brick: BodyId) -> None:
        """What is known of a brick that moves."""
        self._settings = None
        self._waiting.pop(brick, None)
        self._seen.pop(brick, None)
        self.parted(brick)

    def moved(self, brick: BodyId) -> None:
        """Hear that a brick that is held was put elsewhere."""
        if brick not in self._inside:
            self._leave_outside(brick)
            self._stand_outside(brick)

    def joined(self, bricks: Collection[BodyId]) -> World:
        """A world that knows all of these, which are joined in it; they may move from now on."""
        world = self.ready(bricks)
        self._groups |= dict.fromkeys(bricks, tuple(bricks))
        return world

    def parted(self, brick: BodyId) -> None:
        """Hear that a brick moves by itself, and so does all that it was joined to."""
        for member in self._groups.get(brick, ()):
            self._groups.pop(member, None)

    def absorb(self, other: "NearEngine") -> None:
        """Know all that another one knows, which moves on here; that one is over."""
        moved, groups = other.world is not None, dict.fromkeys(other._groups.values())
        other.give_back()
        self.put.absorb(other.put)
        for name in other.put.frozen:
            self._stand_outside(name)
        for name in other.put.loose:
            self.on_woken(name)
        for group in groups:
            self.joined(group).weld(group)
        self._fastest = max(self._fastest, other._fastest)
        if other.frictions.worst is not None:
            self.frictions.note(other.frictions.worst)
        if moved or self.world is not None:
            self.ready().substep_next_contact()

    def give_back(self) -> None:
        """Do without an engine, until one is needed again."""
        if self.world is None:
            return
        self._take_back(self.world)
        self.world, inside, self._inside = None, self._inside, {}
        for name in inside:
            if name in self.put.frozen:
                self._stand_outside(name)
            else:
                self._waiting[name] = None

    def set_max_speed(self, fastest: float) -> None:
        """Say how fast bodies are at most until it is said anew [m/s]."""
        self._fastest = fastest
        if self.world is not None:
            self._look_around(self.put.loose)
            self.world.set_max_speed(fastest)

    # --- who is let in ------------------------------------------------------------------------------------------------

    def ready(self, also: Collection[BodyId] = ()) -> World:
        """The world that is stepped, with all that may move, these bricks too, and with what is near to that."""
        if self.world is not None and not self._waiting and not also:
            return self.world
        moving, self._waiting = [*self._waiting, *also], {}
        coming = dict.fromkeys(brick for brick in moving if brick not in self._inside)
        for brick in tuple(coming):
            coming |= dict.fromkeys(self._coming(brick, self._reach(brick), self.put.state(brick).pose.position_W))
        world = self._let_in(coming)
        return self._look_around(moving) or world

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m], in order.

        What was set down and not stepped yet is not let in only to be asked about: it may be held before it moves.
        """
        world = self.has(brick)
        if world is not None:
            return (self._look_around([brick], within) or world).neighbours(brick, within)
        centre_W = self.put.state(brick).pose.position_W
        found = {*self._about(brick, within, centre_W), *self.put.own.planes}
        loose = {other: self.put.state(other) for other in self._waiting}
        if self.world is not None:
            loose |= self.world.states(self._inside)
        radius = self._shape(brick).bounding_radius + within
        for other, state in loose.items():
            if dist(centre_W, state.pose.position_W) <= radius + self._shape(other).bounding_radius:
                found.add(other)
        return sorted(found - {brick})

    def _look_around(self, bricks: Collection[BodyId], within: float = 0.0) -> World | None:
        """Let in what may be near soon to bricks that are inside; returns the world if that took something."""
        if not self._outside or self.world is None:
            return None
        inside = [brick for brick in bricks if brick in self._inside]
        states, near = self.world.states(inside), set[BodyId]()
        for brick in inside:
            centre_W, reach = states[brick].pose.position_W, max(within, self._reach(brick))
            seen_from, seen = self._seen.get(brick, (centre_W, -1.0))
            if dist(seen_from, centre_W) + reach > seen:
                near.update(self._coming(brick, reach, centre_W))
        return self._let_in(near) if near else None

    def _reach(self, brick: BodyId) -> float:
        """How far around a brick something may matter soon [m]."""
        speed = max(self._fastest, hypot(*self.put.state(brick).velocity_W))
        return self._shape(brick).least_thickness + AHEAD * speed

    def _coming(self, brick: BodyId, reach: float, centre_W: Vec3) -> list[BodyId]:
        """Who stands outside, as near to a brick as this, and a little further, which holds for a while."""
        further = reach + self._shape(brick).least_thickness
        found = self._about(brick, further, centre_W)
        self._seen[brick] = (centre_W, further)
        return found

    def _about(self, brick: BodyId, reach: float, centre_W: Vec3) -> list[BodyId]:
        """Who stands outside, as near to a brick as this."""
        if self._outside is None:
            self._outside = Neighbours()
            for name in self.put.in_order(self.put.frozen):
                self._stand_outside(name)
        radius, (x, y, z) = self._shape(brick).bounding_radius, centre_W
        return self._outside.around((x - radius, y - radius, z - radius), (x + radius, y + radius, z + radius), reach)

    def _let_in(self, coming: Collection[BodyId]) -> World:
        """The world, with these bricks in it, with settings that suit all that are."""
        for brick in coming:
            self._leave_outside(brick)
        known = [self.put.own.bricks[name] for name in (*self._inside, *coming)]
        world = self._suited(known) if coming or self.world is None else self.world
        self.put.enter(world, coming)
        self._inside |= dict.fromkeys(coming)
        return world

    def _suited(self, bricks: Collection[Brick]) -> World:
        """The world as it is, if it suits these bricks, or a new one."""
        bricks = bricks or self.put.own.bricks.values()  # of nothing that is near, all are alike
        heaviest = max((brick.mass for brick in bricks), default=1.0)
        settings = self.opening.settings_for(bricks) if bricks else self.opening.scene
        if self.world is not None:
            if self.world.settings.suffice_for(settings) and heaviest <= HEAVIER * self._heaviest:
                return self.world
            self._take_back(self.world)
        world, self._heaviest = self.opening.opened(settings, heaviest), heaviest
        world.prescribed = self.prescribed
        if isinstance(world, TellsFriction):
            world.frictions = self.frictions
        for plane in self.put.own.planes.values():
            world.add_plane(plane)
        world.skip(self.clock)
        self.put.enter(world, self._inside)
        for group in dict.fromkeys(self._groups.values()):
            world.weld(group)
        if self._inside:
            world.substep_next_contact()
        world.set_max_speed(self._fastest)
        self.world = world
        return world

    def _take_back(self, world: World) -> None:
        """Know again what only the engine knew, and close it."""
        self.clock = world.time()
        for name, state in world.states(self._inside).items():
            if name in self.put.frozen:
                self.put.put(name, state.pose)
            else:
                self.put.set_state(name, state)
        world.close()

    def _stand_outside(self, brick: BodyId) -> None:
        if self._outside is not None:
            self._outside.add(brick, *bounds_W(self._shape(brick), self.put.state(brick).pose))
            self._seen.clear()  # there is more to see

    def _leave_outside(self, brick: BodyId) -> None:
        if self._outside is not None and brick in self._outside:
            self._outside.remove(brick)

    def _shape(self, brick: BodyId) -> ConvexShape:
        return self.put.own.bricks[brick].shape


# A world without an engine, as long as nothing in it moves.
#
# It keeps planes, bricks and poses itself. An engine is opened, and imported, when something must be stepped or when an
# engine's knowledge is asked for: then what moves comes in, and what is near to that, frozen bricks as fixed bodies.


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

    def set_max_speed(self, fastest: float) -> None:
        self.engine.set_max_speed(fastest)

    def substep_next_contact(self) -> None:
        self.engine.ready().substep_next_contact()

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
        self.engine.on_woken(brick.id)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        world = self.engine.has(brick)
        if world is None:
            self._put.set_state(brick, state)
        else:
            self.engine.parted(brick)
            world.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.engine.ready().push(brick, impulse_W, at_W)

    def apply_forces(self, brick: BodyId, pressed: Sequence[AppliedForce]) -> None:
        self.engine.ready().apply_forces(brick, pressed)

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

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.engine.neighbours(brick, within)

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
        self.engine.on_woken(brick)
        world = self.engine.has(brick)
        if world is not None:
            world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._put.put(brick, pose)
        world = self.engine.has(brick)
        if world is not None:
            world.put_at(brick, pose)
        self.engine.moved(brick)

    def weld(self, bricks: Collection[BodyId]) -> None:
        world = self.engine.joined(bricks)  # with these bricks frozen
        for brick in bricks:
            self._put.loosen(brick)
        world.weld(bricks)

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        world = self.engine.ready()  # which may be another one by now, with this brick in its group
        self.engine.parted(brick)
        return world.unweld(brick)


# A world of the engine that settings are of. The engine is imported here, when something must be stepped.


Settings = TypeVar("Settings", bound=EngineSettings)


def load_engine(settings: EngineSettings) -> None:
    """Import the engine that these are settings of."""
    _worlds_of(settings)


def stepped_world(settings: EngineSettings, gravity: float, friction: GivenFriction, heaviest: float) -> World:
    """An empty world of the engine that these are settings of; close it after use.

    Gravity [m/s2] is along -z, friction that of brick on brick, `heaviest` the mass of the heaviest brick to come [kg].
    """
    return _worlds_of(settings).opened(settings, gravity, friction, heaviest)


def _worlds_of(settings: Settings) -> OpensWorlds[Settings]:
    worlds: OpensWorlds[Settings] = resolve_name(settings.world)
    return worlds
