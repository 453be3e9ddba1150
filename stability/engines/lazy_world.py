"""World that opens an engine only for moving bricks and their neighbourhood."""

from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import dist, hypot
from pkgutil import resolve_name
from typing import TypeVar, cast

from stability.contact_law import GivenFriction
from stability.dynamics.rigid_body import AppliedForce
from stability.engines.bodies import StoredBodies
from stability.engines.protocol import (
    NOTHING_PRESCRIBED,
    EngineSettings,
    FrictionRecord,
    Link,
    MeanLoads,
    OpensWorlds,
    PrescribedMotion,
    RecordsSteps,
    World,
    WrongFriction,
)
from stability.engines.scene_scale import SAMPLING
from stability.geometry.placed_shape import bounds_W
from stability.geometry.spatial_grid import Neighbours
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, ConvexShape, Plane, Pose, Shape, Vec3

# The engine of a world in which most bricks rest contains the moving bricks and those that they may touch soon.
#
# A distant brick has no influence on a motion until something approaches it, and it enters the engine before that. So
# the engine's work and settings depend only on the bricks inside it (docs/design/engines.md).


# [s] Look-ahead of the motion: twice the interval between updates of the maximum speed, as a hit may accelerate a body.
AHEAD = 2.0 * SAMPLING
HEAVIER = 10.0  # a brick heavier than this many times the heaviest expected one reopens the engine


@dataclass(frozen=True, slots=True)
class EngineFactory:
    """Settings and constructor of an engine."""

    scene: EngineSettings  # while nothing moves
    settings_for: Callable[[Collection[Brick]], EngineSettings]  # by the bricks inside the engine
    opened: Callable[[EngineSettings, float], World]  # arguments: settings and largest mass of a brick [kg]


@dataclass
class NearEngine:
    """Engine for the moving bricks; opens on demand, and admits bricks before they can be touched."""

    stored: StoredBodies
    opening: EngineFactory
    frictions: FrictionRecord = field(default_factory=FrictionRecord, init=False)
    clock: float = 0.0  # [s] while no engine is open
    records: bool = False  # whether the engine records its steps
    world: World | None = field(default=None, init=False)
    _inside: dict[BodyId, None] = field(default_factory=dict, init=False)
    _outside: Neighbours[BodyId] | None = field(default=None, init=False)  # frozen bricks, after the first query
    _waiting: dict[BodyId, None] = field(default_factory=dict, init=False)  # released bricks that are not inside yet
    # By released brick: the centre and radius of a sphere in which all bricks are inside.
    _covered: dict[BodyId, tuple[Vec3, float]] = field(default_factory=dict, init=False)
    _groups: dict[BodyId, tuple[BodyId, ...]] = field(default_factory=dict, init=False)  # welded groups, by brick
    _fastest: float = field(default=0.0, init=False)  # maximum speed of the bodies [m/s]
    _heaviest: float = field(default=0.0, init=False)  # largest mass that the engine was opened for [kg]
    _settings: EngineSettings | None = field(default=None, init=False)  # for the released bricks; None if unknown

    @property
    def settings(self) -> EngineSettings:
        """Settings of the open engine, or of the engine that the next step would open."""
        if self.world is not None:
            return self.world.settings
        if not self.stored.loose:
            return self.opening.scene
        if self._settings is None:
            self._settings = self.opening.settings_for([self.stored.own.bricks[name] for name in self.stored.loose])
        return self._settings

    def wrong_friction(self) -> WrongFriction | None:
        """Return the largest friction error of all engines so far."""
        if self.world is not None:
            self.frictions.note(self.world.wrong_friction())
        return self.frictions.worst

    def world_of(self, brick: BodyId) -> World | None:
        """Return the engine's world if it contains a brick."""
        return self.world if brick in self._inside else None

    # --- state changes of bricks --------------------------------------------------------------------------------------

    def on_woken(self, brick: BodyId) -> None:
        """Handle the release of a brick."""
        self._settings = None
        self._waiting[brick] = None
        self._remove_outside(brick)

    def on_frozen(self, brick: BodyId) -> None:
        """Handle the freezing of a brick."""
        self._forget(brick)
        if brick not in self._inside:
            self._add_outside(brick)

    def on_removed(self, brick: BodyId) -> None:
        """Handle the removal of a brick."""
        self._forget(brick)
        self._remove_outside(brick)
        self._inside.pop(brick, None)

    def _forget(self, brick: BodyId) -> None:
        """Drop the records of a moving brick."""
        self._settings = None
        self._waiting.pop(brick, None)
        self._covered.pop(brick, None)
        self.on_unwelded(brick)

    def on_moved(self, brick: BodyId) -> None:
        """Handle a new pose of a frozen brick."""
        if brick not in self._inside:
            self._remove_outside(brick)
            self._add_outside(brick)

    def world_for_group(self, bricks: Collection[BodyId]) -> World:
        """Return a world that contains all of these bricks, and record them as a welded group."""
        world = self.ready(bricks)
        self._groups |= dict.fromkeys(bricks, tuple(bricks))
        return world

    def on_unwelded(self, brick: BodyId) -> None:
        """Handle the end of a brick's welded group."""
        for member in self._groups.get(brick, ()):
            self._groups.pop(member, None)

    def absorb(self, other: "NearEngine") -> None:
        """Take over all bricks, groups and motions of another engine, which ends."""
        was_open, groups = other.world is not None, dict.fromkeys(other._groups.values())
        other.close_engine()
        self.stored.absorb(other.stored)
        for name in other.stored.frozen:
            self._add_outside(name)
        for name in other.stored.loose:
            self.on_woken(name)
        for group in groups:
            self.world_for_group(group).weld(group)
        self._fastest = max(self._fastest, other._fastest)
        self.frictions.note(other.wrong_friction())
        if was_open or self.world is not None:
            self.ready().substep_next_contact()

    def close_engine(self) -> None:
        """Close the engine and keep the states of its bricks."""
        if self.world is None:
            return
        self._take_back(self.world)
        self.world, inside, self._inside = None, self._inside, {}
        for name in inside:
            if name in self.stored.frozen:
                self._add_outside(name)
            else:
                self._waiting[name] = None

    def set_max_speed(self, fastest: float) -> None:
        """Set the maximum speed of the bodies [m/s]; it holds until the next call."""
        self._fastest = fastest
        if self.world is not None:
            self._look_around(self.stored.loose)
            self.world.set_max_speed(fastest)

    # --- admission of bricks ------------------------------------------------------------------------------------------

    def ready(self, also: Collection[BodyId] = ()) -> World:
        """Return the engine's world with all released bricks, the bricks `also`, and the bricks near to these."""
        if self.world is not None and not self._waiting and not also:
            return self.world
        released, self._waiting = [*self._waiting, *also], {}
        entering = dict.fromkeys(brick for brick in released if brick not in self._inside)
        for brick in tuple(entering):
            entering |= dict.fromkeys(
                self._bricks_to_admit(brick, self._reach(brick), self.stored.state(brick).pose.position_W)
            )
        world = self._admit(entering)
        return self._look_around(released) or world

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """Return the bodies that may be within a distance [m] of a brick, sorted.

        A query does not admit a new brick that was not stepped yet: it may be frozen before it moves.
        """
        world = self.world_of(brick)
        if world is not None:
            return (self._look_around([brick], within) or world).neighbours(brick, within)
        centre_W = self.stored.state(brick).pose.position_W
        nearby = {*self._outside_near(brick, within, centre_W), *self.stored.own.planes}
        outside_states = {other: self.stored.state(other) for other in self._waiting}
        if self.world is not None:
            outside_states |= self.world.states(self._inside)
        radius = self._shape(brick).bounding_radius + within
        for other, state in outside_states.items():
            if dist(centre_W, state.pose.position_W) <= radius + self._shape(other).bounding_radius:
                nearby.add(other)
        return sorted(nearby - {brick})

    def _look_around(self, bricks: Collection[BodyId], within: float = 0.0) -> World | None:
        """Admit the bricks that may soon be near to bricks inside; return the world if any was admitted."""
        if not self._outside or self.world is None:
            return None
        inside = [brick for brick in bricks if brick in self._inside]
        states, near = self.world.states(inside), set[BodyId]()
        for brick in inside:
            centre_W, reach = states[brick].pose.position_W, max(within, self._reach(brick))
            covered_from, covered = self._covered.get(brick, (centre_W, -1.0))
            if dist(covered_from, centre_W) + reach > covered:
                near.update(self._bricks_to_admit(brick, reach, centre_W))
        return self._admit(near) if near else None

    def _reach(self, brick: BodyId) -> float:
        """Return the distance [m] within which a brick may soon touch others."""
        speed = max(self._fastest, hypot(*self.stored.state(brick).velocity_W))
        return self._shape(brick).least_thickness + AHEAD * speed

    def _bricks_to_admit(self, brick: BodyId, reach: float, centre_W: Vec3) -> list[BodyId]:
        """Return the bricks outside within a distance of a brick plus a margin, and record the covered sphere."""
        further = reach + self._shape(brick).least_thickness
        outside = self._outside_near(brick, further, centre_W)
        self._covered[brick] = (centre_W, further)
        return outside

    def _outside_near(self, brick: BodyId, reach: float, centre_W: Vec3) -> list[BodyId]:
        """Return the bricks outside within a distance of a brick."""
        if self._outside is None:
            self._outside = Neighbours()
            for name in self.stored.in_order(self.stored.frozen):
                self._add_outside(name)
        radius, (x, y, z) = self._shape(brick).bounding_radius, centre_W
        return self._outside.around((x - radius, y - radius, z - radius), (x + radius, y + radius, z + radius), reach)

    def _admit(self, entering: Collection[BodyId]) -> World:
        """Return the world after adding these bricks, with settings that suit all bricks inside."""
        for brick in entering:
            self._remove_outside(brick)
        bricks_inside = [self.stored.own.bricks[name] for name in (*self._inside, *entering)]
        world = self._suitable_world(bricks_inside) if entering or self.world is None else self.world
        self.stored.enter(world, entering)
        self._inside |= dict.fromkeys(entering)
        return world

    def _suitable_world(self, bricks: Collection[Brick]) -> World:
        """Return the current world if its settings suit these bricks, else a new one."""
        bricks = bricks or self.stored.own.bricks.values()  # with none inside, the settings suit all bricks
        heaviest = max((brick.mass for brick in bricks), default=1.0)
        settings = self.opening.settings_for(bricks) if bricks else self.opening.scene
        if self.world is not None:
            if self.world.settings.suffice_for(settings) and heaviest <= HEAVIER * self._heaviest:
                return self.world
            self._take_back(self.world)
        world, self._heaviest = self.opening.opened(settings, heaviest), heaviest
        for plane in self.stored.own.planes.values():
            world.add_plane(plane)
        world.skip(self.clock)
        if self.records:
            cast("RecordsSteps", world).record_steps()
        self.stored.enter(world, self._inside)
        for group in dict.fromkeys(self._groups.values()):
            world.weld(group)
        if self._inside:
            world.substep_next_contact()
        world.set_max_speed(self._fastest)
        self.world = world
        return world

    def _take_back(self, world: World) -> None:
        """Copy the states and the friction error out of the engine, and close it."""
        self.frictions.note(world.wrong_friction())
        self.clock = world.time()
        for name, state in world.states(self._inside).items():
            if name in self.stored.frozen:
                self.stored.put(name, state.pose)
            else:
                self.stored.set_state(name, state)
        world.close()

    def _add_outside(self, brick: BodyId) -> None:
        if self._outside is not None:
            self._outside.add(brick, *bounds_W(self._shape(brick), self.stored.state(brick).pose))
            self._covered.clear()  # the recorded spheres may contain the new brick

    def _remove_outside(self, brick: BodyId) -> None:
        if self._outside is not None and brick in self._outside:
            self._outside.remove(brick)

    def _shape(self, brick: BodyId) -> ConvexShape:
        return self.stored.own.bricks[brick].shape


# A world without an engine as long as nothing in it moves.
#
# It stores planes, bricks and poses itself. The first step imports and opens an engine, which contains the moving
# bricks and their neighbourhood, frozen bricks as fixed bodies.


@dataclass
class RestingWorld(World):
    """World that opens an engine on demand, for the moving part of the scene."""

    opening: EngineFactory
    _stored: StoredBodies = field(init=False)
    engine: NearEngine = field(init=False)  # for the moving bricks; may be closed, or take over that of another world

    def __post_init__(self) -> None:
        self._stored = StoredBodies()
        self.engine = NearEngine(self._stored, self.opening)

    @property
    def settings(self) -> EngineSettings:
        return self.engine.settings

    def time(self) -> float:
        return self.engine.clock if self.engine.world is None else self.engine.world.time()

    def step(self, prescribed: PrescribedMotion = NOTHING_PRESCRIBED) -> None:
        self.engine.ready().step(prescribed)

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
        self._stored.own.add_plane(plane)
        if self.engine.world is not None:
            self.engine.world.add_plane(plane)

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self._stored.add(brick, pose, velocity_W)
        self.engine.on_woken(brick.id)

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        world = self.engine.world_of(brick)
        if world is None:
            self._stored.set_state(brick, state)
        else:
            self.engine.on_unwelded(brick)
            world.set_state(brick, state)

    def push(self, brick: BodyId, impulse_W: Vec3, at_W: Vec3) -> None:
        self.engine.ready().push(brick, impulse_W, at_W)

    def apply_forces(self, brick: BodyId, pressed: Sequence[AppliedForce]) -> None:
        self.engine.ready().apply_forces(brick, pressed)

    def remove_brick(self, brick: BodyId) -> None:
        world = self.engine.world_of(brick)
        self.engine.on_removed(brick)
        self._stored.remove(brick)
        if world is not None:
            world.remove_brick(brick)

    def wrong_friction(self) -> WrongFriction | None:
        return self.engine.wrong_friction()

    def close(self) -> None:
        if self.engine.world is not None:
            self.engine.world.close()

    def masses(self) -> Mapping[BodyId, float]:
        return self._stored.own.masses

    def fixed(self) -> Set[BodyId]:
        return self._stored.own.fixed

    def shape(self, body: BodyId) -> Shape:
        return self._stored.own.shape(body)

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return self.engine.neighbours(brick, within)

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        engine_bodies = [body for body in bodies if self.engine.world_of(body) is not None]
        if not engine_bodies or self.engine.world is None:
            return {body: self._stored.state(body) for body in bodies}
        states = self.engine.world.states(engine_bodies)
        return states if len(states) == len(bodies) else {b: states.get(b) or self._stored.state(b) for b in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        world = self.engine.world_of(brick)
        return world.contacts(brick) if world is not None else ()  # no contacts before the first step

    def freeze(self, brick: BodyId) -> None:
        world = self.engine.world_of(brick)
        if world is not None:
            world.freeze(brick)
            self._stored.put(brick, world.states([brick])[brick].pose)
        self._stored.freeze(brick)
        self.engine.on_frozen(brick)

    def holds(self, brick: BodyId) -> bool:
        return brick in self._stored.frozen

    def wake(self, brick: BodyId) -> None:
        self._stored.release(brick)
        self.engine.on_woken(brick)
        world = self.engine.world_of(brick)
        if world is not None:
            world.wake(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._stored.put(brick, pose)
        world = self.engine.world_of(brick)
        if world is not None:
            world.put_at(brick, pose)
        self.engine.on_moved(brick)

    def weld(self, bricks: Collection[BodyId]) -> None:
        world = self.engine.world_for_group(bricks)  # before their release below, so that they enter frozen
        for brick in bricks:
            self._stored.release(brick)
        world.weld(bricks)

    def record_steps(self) -> None:
        self.engine.records = True

    def hit_duration(self) -> float:
        return self.settings.time_step

    def mean_loads(self) -> MeanLoads:
        return self._recording().mean_loads()

    def undo_step(self) -> None:
        self._recording().undo_step()

    def link(self, links: Sequence[Link]) -> None:
        if links or self.engine.world is not None:
            planes = self._stored.own.planes
            bricks = {name for link in links for name in (link.lower, link.upper) if name not in planes}
            cast("RecordsSteps", self.engine.ready(sorted(bricks))).link(links)

    def _recording(self) -> RecordsSteps:
        """Return the open engine, which records its steps."""
        return cast("RecordsSteps", self.engine.world)

    def unweld(self, brick: BodyId) -> tuple[BodyId, ...]:
        world = self.engine.ready()  # may reopen the engine, which restores the group of this brick
        self.engine.on_unwelded(brick)
        return world.unweld(brick)


# Worlds by their settings. The engine is imported here, at the first step.


Settings = TypeVar("Settings", bound=EngineSettings)


def load_engine(settings: EngineSettings) -> None:
    """Import the engine of these settings."""
    _worlds_of(settings)


def stepped_world(settings: EngineSettings, gravity: float, friction: GivenFriction, heaviest: float) -> World:
    """Open an empty world of the engine of these settings; close it after use.

    Gravity [m/s2] acts along -z, `friction` is that of brick on brick, `heaviest` the largest mass of a brick [kg].
    """
    return _worlds_of(settings).opened(settings, gravity, friction, heaviest)


def _worlds_of(settings: Settings) -> OpensWorlds[Settings]:
    worlds: OpensWorlds[Settings] = resolve_name(settings.world)
    return worlds
