"""The engine of a world in which most rests: it knows what moves, what that may touch soon, and nothing else.

What stands elsewhere changes nothing of a motion until something comes near to it, and is let in before that. So an
engine has no more to do than what moves asks for, and its settings are those of what is there (docs/decisions/0028).
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from math import dist, hypot

from stability.engines.friction_told import FrictionRecord, TellsFriction
from stability.engines.prescribed import PrescribedMotion
from stability.engines.protocol import World
from stability.engines.put_bodies import PutBodies
from stability.engines.scene_scale import SAMPLING
from stability.engines.settings import EngineSettings
from stability.geometry.neighbours import Neighbours
from stability.model import BodyId, Brick, ConvexShape, Vec3
from stability.shapes.in_pose import bounds_W

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

    def loosened(self, brick: BodyId) -> None:
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
            self.loosened(name)
        for group in groups:
            self.joined(group).join(group)
        self._fastest = max(self._fastest, other._fastest)
        if other.frictions.worst is not None:
            self.frictions.note(other.frictions.worst)
        if moved or self.world is not None:
            self.ready().ease_in()

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

    def limit_travel(self, fastest: float) -> None:
        """Say how fast bodies are at most until it is said anew [m/s]."""
        self._fastest = fastest
        if self.world is not None:
            self._look_around(self.put.loose)
            self.world.limit_travel(fastest)

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

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """The bodies that may be as close to a brick as this [m], in order.

        What was set down and not stepped yet is not let in only to be asked about: it may be held before it moves.
        """
        world = self.has(brick)
        if world is not None:
            return (self._look_around([brick], within) or world).near(brick, within)
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
            world.join(group)
        if self._inside:
            world.ease_in()
        world.limit_travel(self._fastest)
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
