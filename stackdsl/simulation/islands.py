"""Splits a scene into parts far apart, each with its own world and clock, and merges them as they approach."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from math import hypot, inf
from typing import Final, TypeAlias

from stability.engines.lazy_world import RestingWorld
from stability.engines.protocol import World, WrongFriction, wrong_friction_of
from stability.engines.scene_scale import SAMPLING
from stability.geometry.vectors import add_scaled, dot, subtract
from stability.model import BodyId, BodyState, Brick, Plane, Vec3
from stability.problem import Placed
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer, SupportsMerging
from stability.work_limit import work_done
from stackdsl import work
from stackdsl.simulation.after_collapse import time_of
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError, CombinedStabilizer, EventLog, TrackedBrick
from stackdsl.simulation.hands import HandMover, ShakingGround
from stackdsl.simulation.measurements import NormalErrorMonitor, RunMeasurements
from stackdsl.simulation.stabilizer_calls import StabilizerDriver, UpdateClock
from stackdsl.simulation.systems import Method, System
from stackdsl.simulation.worlds import extension_for, opened_world
from stackdsl.timeline import (
    Arrival,
    FixedWorld,
    Handled,
    HoldAction,
    LetGo,
    Moment,
    MoveAction,
    Placement,
    PushAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import Updates, WrongEdges

# Which bricks of a timeline are so far apart that each others' motion cannot matter before somebody would see it come?
#
# Seen from above, every brick is given room for as far as it may get by toppling, and somewhat more. Where a line along
# x or y runs through no room of any, it parts those on either side, and these are parted further likewise.


MOST: Final = 8  # parts of a scene; an engine takes 28 MB, and 15 ms to open
ROLLS: Final = 4.0  # times its half diagonal that a brick may go beyond its height above the ground

Stretch = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _Room:
    """Where a brick may get by itself, in plan."""

    number: int  # of its placement
    along: tuple[Stretch, Stretch]  # x and y [m]


def far_apart(timeline: Timeline) -> list[list[Placement]]:
    """The placements of a timeline in parts, each in the order of time, and the parts in that of their first ones.

    All are one part where hands are at work or the ground shakes, which concerns all. Beyond `MOST` the last part has
    what is left, however far apart that is.
    """
    placements = timeline.placements
    if any(isinstance(action, Handled | ShakeAction) for action in timeline.actions) or any(
        placement.arrival is Arrival.BY_HAND for placement in placements
    ):
        return [list(placements)]
    ground = timeline.world.planes[0]
    found = sorted(_parted([_room(number, each, ground) for number, each in enumerate(placements)]))
    if len(found) > MOST:
        found[MOST - 1 :] = [sorted(number for part in found[MOST - 1 :] for number in part)]
    return [[placements[number] for number in part] for part in found]


def _room(number: int, placement: Placement, ground: Plane) -> _Room:
    """Where a brick stands, or comes from, or is thrown to, and how far it may topple from there."""
    radius = placement.brick.shape.bounding_radius
    came = placement.came or placement.pose
    aim_W = add_scaled(came.position_W, placement.flight, placement.velocity_W)
    places = [_about(position_W, radius, ground) for position_W in (placement.pose.position_W, came.position_W, aim_W)]
    (low_x, high_x), (low_y, high_y) = (
        (min(place[axis][0] for place in places), max(place[axis][1] for place in places)) for axis in (0, 1)
    )
    return _Room(number, ((low_x, high_x), (low_y, high_y)))


def _about(position_W: Vec3, radius: float, ground: Plane) -> tuple[Stretch, Stretch]:
    height = max(0.0, dot(subtract(position_W, ground.point_W), ground.normal_W))
    reach = height + (1.0 + ROLLS) * radius
    x, y, _ = position_W
    return (x - reach, x + reach), (y - reach, y + reach)


def _parted(rooms: Sequence[_Room]) -> list[list[int]]:
    """The numbers of those that no line parts, in order."""
    for axis in (0, 1):
        groups = list(_cut(rooms, axis))
        if len(groups) > 1:
            return [part for group in groups for part in _parted(group)]
    return [sorted(room.number for room in rooms)]


def _cut(rooms: Iterable[_Room], axis: int) -> Iterable[list[_Room]]:
    """Those between gaps along an axis."""
    group: list[_Room] = []
    until = 0.0
    for room in sorted(rooms, key=lambda room: room.along[axis]):
        low, high = room.along[axis]
        if group and low > until:
            yield group
            group = []
        until = max(until, high) if group else high
        group.append(room)
    if group:
        yield group


# The upright box in which bricks have been, and may be soon.


# [s] Looks at what moves are a SAMPLING apart, those at others may be one behind, and a hit makes something faster.
AHEAD = 3.0 * SAMPLING


@dataclass
class Space:
    """Grows, and never shrinks: where something has been, something may lie."""

    low_W: Vec3 = (inf, inf, inf)
    high_W: Vec3 = (-inf, -inf, -inf)

    def takes(self, brick: Brick, state: BodyState, gravity: float) -> None:
        """Reach as far as a brick may get before it is seen again."""
        shape = brick.shape
        speed = hypot(*state.velocity_W) + AHEAD * gravity
        reach = shape.bounding_radius + shape.least_thickness + AHEAD * speed
        (x, y, z), (ax, ay, az), (bx, by, bz) = state.pose.position_W, self.low_W, self.high_W
        self.low_W = (min(ax, x - reach), min(ay, y - reach), min(az, z - reach))
        self.high_W = (max(bx, x + reach), max(by, y + reach), max(bz, z + reach))

    def follows(self, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState], gravity: float) -> None:
        """Reach as far as bricks may get, of all by name."""
        for name, state in states.items():
            self.takes(bricks[name], state, gravity)

    def joins(self, other: "Space") -> None:
        """Reach as far as another one, too."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        (cx, cy, cz), (dx, dy, dz) = other.low_W, other.high_W
        self.low_W, self.high_W = (min(ax, cx), min(ay, cy), min(az, cz)), (max(bx, dx), max(by, dy), max(bz, dz))

    def meets(self, other: "Space") -> bool:
        """Whether another one comes into it."""
        pairs = zip(self.low_W, other.high_W, strict=True), zip(other.low_W, self.high_W, strict=True)
        return all(low <= high for pair in pairs for low, high in pair)


# How far may what moves travel in one step of an engine? What is fast would pass through something otherwise.


def set_max_speed(world: World, states: Mapping[BodyId, BodyState], gravity: float) -> int:
    """Let the world step finely enough for what moves now, as fast as it may get until the next look.

    Returns into how many parts it splits a step for that.
    """
    fastest = max((hypot(*state.velocity_W) for state in states.values()), default=0.0)
    fastest += SAMPLING * gravity
    world.set_max_speed(fastest)
    return world.settings.parts_for_travel(fastest)


# Which bricks something is done with, where each is as that is done.


def affected_bricks(moment: Moment, present: Mapping[BodyId, TrackedBrick]) -> list[Placed]:
    """The bricks that come at a moment, or are pushed, shaken, pulled out or in a hand, of those that are there."""
    match moment:
        case Removal() | HoldAction() | LetGo():
            names = moment.bricks
        case PushAction() | MoveAction():
            names = (moment.brick,)
        case ShakeAction():
            names = tuple(name for name, watched in present.items() if not watched.removed)
        case _:
            return [Placed(placement.brick, placement.came or placement.pose) for placement in moment]
    return [Placed(present[name].placement.brick, present[name].last) for name in names]


# A part of a scene: bricks that are far from all others, with a world, an extension and a clock of their own.
#
# What is done elsewhere, and what moves there, asks nothing of it: it is stepped, looked at and judged as if it were
# all there is, so that not a digit of it depends on others. Most scenes are one part.


@dataclass(eq=False)
class Island:
    """One part, and what is known of how it moves."""

    world: World
    extension: Stabilizer | None
    scene: FixedWorld
    measures: RunMeasurements
    log: EventLog
    ticks: int = 0  # time steps that passed while something could move
    steps: int = 0  # of them, those that an engine took
    known: int = 0  # and those of a motion that is known without one
    splits: int = 1  # into how many parts the coming steps are split for what is fast
    hit: bool = False  # whether something has hit it
    to_come: deque[tuple[int, float]] = field(default_factory=deque)  # what is done with it: which moment, and when [s]
    seen: Mapping[BodyId, BodyState] = field(default_factory=dict)  # what moved when that was looked at last
    resting: bool = True  # whether it was idle when that was asked last
    one_by_one: int = 0  # bricks that the engine moved one by one then
    space: Space = field(default_factory=Space)  # in which it has moved, and moves soon

    def __post_init__(self) -> None:
        scene = self.scene
        self.ground = ShakingGround(self.world, scene.gravity)
        self.edges = NormalErrorMonitor(self.world, scene.gravity)
        self.falling = FallingParts(self.world, scene.planes, scene.friction, scene.gravity)
        self.answers = StabilizerDriver(self.extension, self.world, self.measures, self.log, self.falling)
        self.hands = HandMover(self.world, self.measures.watch, self.answers, self.log, scene.planes)

    # --- its clock ----------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """What time it is here [s]; where nothing moves, the clock stands until something is done."""
        return self.world.time()

    @property
    def idle(self) -> bool:
        """Whether nothing here can move."""
        return self.answers.nothing_can_move() and not self.hands.steps

    def still_for(self, most: float) -> float:
        """For how much of a time nothing here needs to be looked at, as long as it is idle [s]."""
        return min(most, self.answers.still_for(), self.hands.still_for())

    def lags(self, until: float) -> bool:
        """Whether something happens here before a time [s]."""
        self.resting, left = self.idle, until - self.time
        if left <= 0.0:
            return False
        return self.still_for(left) < left if self.resting else left > 0.5 * self.world.settings.time_step

    def wait(self, until: float) -> None:
        """Let time pass in which nothing moves, up to a time [s] if it is idle until then."""
        left = until - self.time
        if left > 0.0 and self.idle:
            self.world.skip(self.still_for(left))

    def pass_on(self, most: int) -> None:
        """Let a time step pass, or up to so many while what moves needs no engine."""
        shaken = self.ground.shake()
        passed = self.falling.advance(most, driven=shaken or self.hands.busy)
        self.ticks += passed or 1
        self.known += passed
        if passed:
            self.answers.landed(self.falling.landed)
            return
        self.hands.guide()
        self.world.step()
        self.steps += 1
        self.answers.judge()

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves here, as it moves now, and step it as finely as that asks for until the next look."""
        self.answers.beginnings.look(states)
        self.set_max_speed(states)

    def set_max_speed(self, states: Mapping[BodyId, BodyState]) -> None:
        """Let it be stepped as finely as what moves asks for, until the next look."""
        self.splits = set_max_speed(self.world, states, self.ground.pull)

    # --- what is done with it -----------------------------------------------------------------------------------------

    def prepare(self, moment: Moment, time: float) -> None:
        """Something is about to be done with it at a time [s]."""
        self.wait(time)
        if self.answers.nothing_can_move():
            self.answers.gave_way = None  # what failed before has come to rest again, and is not what fails now
        self.answers.beginnings.done()
        self.falling.disturbed(affected_bricks(moment, self.measures.watch.bricks))
        self.hit = self.hit or _hits(moment)

    def add(self, placement: Placement) -> None:
        """A brick comes."""
        came = placement.came or placement.pose
        self.world.add_brick(placement.brick, came, placement.velocity_W)
        self.space.takes(placement.brick, BodyState(came, placement.velocity_W), self.scene.gravity)

    def moving(self) -> Mapping[BodyId, BodyState]:
        """All that may move, as it moves now."""
        return self.world.states(self.answers.moving())

    def absorb(self, other: "Island") -> None:
        """Take in another part that has come near."""
        self.falling.end()
        other.falling.end()
        if isinstance(self.world, RestingWorld) and isinstance(other.world, RestingWorld):
            self.world.engine.absorb(other.world.engine)
        if isinstance(self.extension, SupportsMerging) and other.extension is not None:
            self.extension.absorb(other.extension)
        self.answers.absorb(other.answers)
        self.steps += other.steps
        self.known += other.known
        self.falling.proven += other.falling.proven
        self.hands.looks += other.hands.looks
        self.hit = self.hit or other.hit
        self.to_come = deque(sorted([*self.to_come, *other.to_come]))
        self.space.joins(other.space)
        self.edges.absorb(other.edges)

    def rest(self) -> None:
        """Give its engine back if it is not needed any more."""
        if isinstance(self.world, RestingWorld) and self.resting and not self.to_come:
            self.world.engine.close_engine()


def _hits(moment: Moment) -> bool:
    """Whether what is done strikes the structure."""
    match moment:
        case PushAction() | ShakeAction():
            return True
        case MoveAction():
            return not moment.lowers
        case tuple():
            return any(placement.hits for placement in moment)
        case _:
            return False


def names_of(moment: Moment) -> Sequence[BodyId]:
    """The bricks that something is done with; none where that is the ground."""
    match moment:
        case PushAction() | MoveAction():
            return [moment.brick]
        case ShakeAction():
            return []
        case tuple():
            return [placement.brick.id for placement in moment]
        case _:
            return moment.bricks


# What the steps of a run take, by counts, and whether what is ahead of it is more than a run may take.


@dataclass(frozen=True, slots=True)
class StepCounts:
    """What has been done, in counts that only grow."""

    steps: int = 0  # of an engine
    known: int = 0  # steps of motions that are known without one
    looks: int = 0  # at bricks that hands lower
    landings: int = 0

    @classmethod
    def by(cls, parts: "list[Island]") -> "StepCounts":
        """By these parts."""
        each = ((part.steps, part.known, part.hands.looks, part.falling.proven) for part in parts)
        return cls(*map(sum, zip(*each, strict=True)))

    def since(self, before: "StepCounts") -> "StepCounts":
        """What was done since then."""
        return StepCounts(*(now - then for now, then in zip(astuple(self), astuple(before), strict=True)))


@dataclass
class Effort:
    """Counted in units of one moving brick in one step."""

    system: System
    done: float = 0.0
    _before: StepCounts = StepCounts()

    def __post_init__(self) -> None:
        proven = self.system.method is Method.PROVEN
        self._most, self._step = (work.MOST_STEPS, work.STEP) if proven else (work.MOST_STEPS_BARE, work.STEP_BARE)
        self._dearer = self._most / work.MOST_STEPS  # what is not a step of an engine takes as long on every system

    def look(self, parts: "list[Island]", part: "Island", end: float) -> None:
        """Count what was done since the last look, and refuse what is ahead up to a time [s].

        Raises BlockedPlacementError, before so many bricks have moved for long.
        """
        now = StepCounts.by(parts)
        new, self._before = now.since(self._before), now
        moving = sum(each.one_by_one for each in parts)
        each_step = self._step + moving + self._dearer * (part.splits - 1) * (work.SPLIT + work.SPLIT_MOVING * moving)
        beside = work.KNOWN * new.known + work.LOOK * new.looks + work.LANDING * new.landings
        self.done += new.steps * each_step + self._dearer * beside
        by_hand = part.hands.busy_for()
        seconds = max(self._seconds(part, end) if moving and now.steps else 0.0, by_hand if part.hands.steps else 0.0)
        # How fast it is, and so how finely it is stepped, soon changes: ahead it counts as if it were slow.
        steady = self._step + moving
        ahead = seconds / part.world.settings.time_step * steady + self._dearer * work.LOOK * by_hand / SAMPLING
        much = self.done + ahead + self._dearer * work_done() / work.STEP_WORK
        if much > self._most * work.allowed():
            raise BlockedPlacementError(self._refused(part, moving, (seconds, by_hand), much))

    def _refused(self, part: "Island", moving: int, ahead: tuple[float, float], much: float) -> Blocked:
        seconds, by_hand = ahead
        many = f"{moving} brick{'s' if moving != 1 else ''} move{'s' if moving == 1 else ''}"
        if by_hand > seconds or (by_hand and not moving):
            many, seconds = "a hand is on its way", by_hand
        said = f"{many} at {part.time:.3g} s" + (f", for {seconds:.3g} s and more" if seconds else "")
        told = f"{much:.2g} steps of a brick in all are estimated, and {self._most * work.allowed():.2g} are allowed"
        brick = min(part.answers.moving() or part.hands.in_hand or part.measures.watch.present)
        return Blocked(brick, part.time, brick, 0.0, too_much=f"{said}: {told}")

    def _seconds(self, part: "Island", end: float) -> float:
        """For how long what moves will move: shaken, or with nobody who holds it at rest, as long as that goes on."""
        left = max(0.0, end - part.time)
        if part.ground.motion is not None:
            return min(left, max(work.AHEAD, part.ground.motion.ends - part.time))
        return left if part.extension is None else min(left, work.AHEAD)


# All parts of a scene: whose turn it is, with which of them something is done, and who comes near to whom.


Pieces: TypeAlias = Sequence[tuple[Island, Moment]]  # what is done with each part


@dataclass
class Islands:
    """The parts of one run; close them after use."""

    timeline: Timeline
    system: System
    measures: RunMeasurements
    log: EventLog
    found: list[Island] = field(default_factory=list, init=False)  # those that are left, by their first bricks
    _coming: dict[tuple[float, BodyId], Island] = field(default_factory=dict, init=False)  # who comes where
    _of: dict[BodyId, Island] = field(default_factory=dict, init=False)  # where each is that has come
    _acted: list[Island] = field(default_factory=list, init=False)  # those with which something was done last
    _reached: float = field(default=0.0, init=False)  # up to when all has been idle [s]

    def __post_init__(self) -> None:
        # Only what a system proves is held, and known to go without an engine where it is.
        apart = self.system.method is Method.PROVEN and self.timeline.watched and self.system.modification.size == 1.0
        split = far_apart(self.timeline) if apart else [list(self.timeline.placements)]
        try:
            for placements in split:
                self._open(placements)
        except BaseException:
            self.close()
            raise
        self.effort = Effort(self.system)
        self.split = self.several
        if self.split:
            self._tell_when()

    def _open(self, placements: Sequence[Placement]) -> None:
        whole = len(placements) == len(self.timeline.placements)
        own = self.timeline if whole else replace(self.timeline, actions=tuple(placements))
        world = opened_world(own, self.system)
        part = Island(world, extension_for(own, self.system, world), own.world, self.measures, self.log)
        self.found.append(part)
        self._coming |= {(each.time, each.brick.id): part for each in placements}

    def _tell_when(self) -> None:
        """Tell each part when something is to be done with it."""
        of: dict[BodyId, Island] = {}
        for number, moment in enumerate(self.timeline.moments()):
            if isinstance(moment, tuple):
                of |= {each.brick.id: self._coming[each.time, each.brick.id] for each in moment}
            for part in {id(of[name]): of[name] for name in names_of(moment) if name in of}.values():
                part.to_come.append((number, time_of(moment)))

    def close(self) -> None:
        """End all of them."""
        for part in self.found:
            part.world.close()

    @property
    def several(self) -> bool:
        """Whether there is more than one."""
        return len(self.found) > 1

    @property
    def extension(self) -> "Stabilizer | CombinedStabilizer | None":
        """What is held, and why, of the whole scene."""
        if not self.several:
            return self.found[0].extension
        every, acted = (
            [part.extension for part in some if part.extension is not None] for some in (self.found, self._acted)
        )
        return CombinedStabilizer(lambda name: self._of[name].extension, every, acted)

    def of(self, brick: BodyId) -> Island:
        """The part that has a brick."""
        return self._of[brick] if self.several else self.found[0]

    # --- time ---------------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """What time it is, in the part that has come farthest [s]."""
        return max(self._reached, *(part.time for part in self.found)) if self.several else self.found[0].time

    def behind(self, until: float) -> Island | None:
        """The part whose turn it is, of those in which something happens before a time [s]."""
        lagging = [part for part in self.found if part.lags(until)]
        if self.several:
            for part in self.found:
                part.rest()
        return min(lagging, key=lambda part: part.time, default=None)

    def bound(self, part: Island, until: float, end: float) -> float:
        """Up to when a part goes on by itself, whatever is done elsewhere at a time, before the run ends [s]."""
        if not self.several:
            return until
        return max(until, part.to_come[0][1] if part.to_come else end)

    def reached(self, until: float) -> None:
        """All has happened that happens before a time [s]."""
        if not self.several:
            self.found[0].wait(until)
        elif all(part.idle for part in self.found):
            self._reached = until

    # --- what is done -------------------------------------------------------------------------------------------------

    def pieces(self, moment: Moment) -> Pieces:
        """What is done with each part."""
        self._acted = []
        if not self.several:
            self._acted = self.found[:1]
            return [(self.found[0], moment)]
        if isinstance(moment, tuple):
            for each in moment:
                self._of[each.brick.id] = self._coming[each.time, each.brick.id]
        affected_bricks = {id(self._of[name]): self._of[name] for name in names_of(moment)}
        self._acted = list(affected_bricks.values())
        return [(part, self._piece(moment, part)) for part in self._acted]

    def _piece(self, moment: Moment, part: Island) -> Moment:
        match moment:
            case Removal():
                return replace(moment, bricks=tuple(name for name in moment.bricks if self._of[name] is part))
            case tuple():
                return tuple(each for each in moment if self._of[each.brick.id] is part)
            case _:
                return moment

    def done(self, number: int) -> None:
        """A moment of this number is over, whether it took place or not."""
        for part in self.found:
            while part.to_come and part.to_come[0][0] <= number:
                part.to_come.popleft()

    def __iter__(self) -> Iterator[Island]:
        """Those that are left when it is their turn."""
        return (part for part in tuple(self.found) if part in self.found)

    # --- who meets whom -----------------------------------------------------------------------------------------------

    def look(self, part: Island, states: Mapping[BodyId, BodyState]) -> None:
        """See where a part may be soon, and let it take in those that it may come near to.

        Raises BlockedPlacementError where what moves takes too much work.
        """
        self.effort.look(self.found, part, self.timeline.end)
        if not self.several or part not in self.found:
            return
        part.space.follows(self.measures.watch.made_of, states, self.timeline.world.gravity)
        while (other := self._met(part)) is not None:
            self._merge(part, other)

    def _met(self, part: Island) -> Island | None:
        return next((other for other in self.found if other is not part and other.space.meets(part.space)), None)

    def _merge(self, part: Island, other: Island) -> None:
        """Let a part take in another one; clocks agree to within half a step by then."""
        self._keep_step(part, other)
        self.found.remove(other)
        part.absorb(other)
        self._coming |= {key: part for key, at in self._coming.items() if at is other}
        self._of |= {name: part for name, at in self._of.items() if at is other}
        self._acted = list(dict.fromkeys(part if at is other else at for at in self._acted))

    @staticmethod
    def _keep_step(part: Island, other: Island) -> None:
        """Let the one that is behind catch up."""
        for behind, ahead in ((part, other), (other, part)):
            if not ahead.idle:
                while behind.lags(ahead.time) and not behind.idle:
                    behind.pass_on(1)
                behind.wait(ahead.time)

    # --- what is told of all ------------------------------------------------------------------------------------------

    def edges(self) -> WrongEdges | None:
        """What was seen of wrong normals in all of them."""
        seen = NormalErrorMonitor(self.found[0].world, self.timeline.world.gravity)
        for part in self.found:
            seen.absorb(part.edges)
        return seen.wrong()

    def friction(self) -> WrongFriction | None:
        """The worst friction that any of them has had."""
        told = filter(None, (wrong_friction_of(part.world) for part in self.found))
        return max(told, key=lambda wrong: wrong.error, default=None)

    @property
    def undecided(self) -> bool:
        """Whether something that was set down is not proven to stand."""
        return any(part.answers.only_an_engine_knows_more() for part in self.found)

    def seen(self, part: Island) -> Mapping[BodyId, BodyState]:
        """All that moves, as it was seen last, once that of one part was."""
        if not self.several:
            return part.seen
        return {name: state for each in self.found if not each.resting for name, state in each.seen.items()}

    @property
    def steps(self) -> int:
        """How many time steps engines took."""
        return sum(part.steps for part in self.found)

    @property
    def judgements(self) -> int:
        """How often extensions were asked."""
        return sum(part.answers.judgements for part in self.found)

    def updates(self) -> Updates | None:
        """What the updates of all of them took."""
        clock = UpdateClock()
        for part in self.found:
            clock.absorb(part.answers.clock)
        return clock.updates()
