"""Splits a scene into islands far apart, each with its own world and clock, and merges them as they approach."""

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
    HandAction,
    HoldAction,
    Moment,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import Updates, WrongEdges

# Split of a timeline into groups of bricks so far apart that they can only affect each other after an approach that the
# runner sees.
#
# In plan, every brick gets a rectangle as large as it may reach by toppling, and somewhat more. A line along x or y
# that crosses no rectangle separates the bricks on either side. Both sides are split further in the same way.


MOST: Final = 8  # islands of a scene; an engine takes 28 MB, and 15 ms to open
ROLLS: Final = 4.0  # reach of a brick beyond its height above the ground, in half diagonals

Stretch = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _Room:
    """The rectangle in plan that a brick may reach by itself."""

    number: int  # of its placement
    along: tuple[Stretch, Stretch]  # x and y [m]


def far_apart(timeline: Timeline) -> list[list[Placement]]:
    """Return the placements of a timeline by island, each in order of time, islands in order of their first ones.

    There is only one island if hands are at work or the ground shakes, as these affect all bricks. Beyond `MOST` the
    last island has all remaining placements.
    """
    placements = timeline.placements
    if any(isinstance(action, HandAction | ShakeAction) for action in timeline.actions) or any(
        placement.arrival is Arrival.BY_HAND for placement in placements
    ):
        return [list(placements)]
    ground = timeline.world.planes[0]
    groups = sorted(_parted([_room(number, each, ground) for number, each in enumerate(placements)]))
    if len(groups) > MOST:
        groups[MOST - 1 :] = [sorted(number for part in groups[MOST - 1 :] for number in part)]
    return [[placements[number] for number in part] for part in groups]


def _room(number: int, placement: Placement, ground: Plane) -> _Room:
    """Return the rectangle around the placement, the start and the aim of a brick, with room to topple."""
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
    """Return the numbers of the rectangles by group, split by lines along both axes."""
    for axis in (0, 1):
        groups = list(_cut(rooms, axis))
        if len(groups) > 1:
            return [part for group in groups for part in _parted(group)]
    return [sorted(room.number for room in rooms)]


def _cut(rooms: Iterable[_Room], axis: int) -> Iterable[list[_Room]]:
    """Yield groups of rectangles that are separated by gaps along an axis."""
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


# The axis-aligned box that bricks have been in, or may reach soon.


# [s] Looks at an island are a SAMPLING apart, those at another may be one behind, and a hit makes bricks faster.
AHEAD = 3.0 * SAMPLING


@dataclass
class Space:
    """A box that never shrinks, as a brick may lie wherever one has been."""

    low_W: Vec3 = (inf, inf, inf)
    high_W: Vec3 = (-inf, -inf, -inf)

    def takes(self, brick: Brick, state: BodyState, gravity: float) -> None:
        """Extend the box by the reach of a brick until the next look."""
        shape = brick.shape
        speed = hypot(*state.velocity_W) + AHEAD * gravity
        reach = shape.bounding_radius + shape.least_thickness + AHEAD * speed
        (x, y, z), (ax, ay, az), (bx, by, bz) = state.pose.position_W, self.low_W, self.high_W
        self.low_W = (min(ax, x - reach), min(ay, y - reach), min(az, z - reach))
        self.high_W = (max(bx, x + reach), max(by, y + reach), max(bz, z + reach))

    def follows(self, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState], gravity: float) -> None:
        """Extend the box by the reach of all bricks in `states`."""
        for name, state in states.items():
            self.takes(bricks[name], state, gravity)

    def joins(self, other: "Space") -> None:
        """Extend the box by another one."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        (cx, cy, cz), (dx, dy, dz) = other.low_W, other.high_W
        self.low_W, self.high_W = (min(ax, cx), min(ay, cy), min(az, cz)), (max(bx, dx), max(by, dy), max(bz, dz))

    def meets(self, other: "Space") -> bool:
        """Return whether another box overlaps this one."""
        pairs = zip(self.low_W, other.high_W, strict=True), zip(other.low_W, self.high_W, strict=True)
        return all(low <= high for pair in pairs for low, high in pair)


# Sub-steps by speed: a fast brick would pass through another one within a whole step.


def set_max_speed(world: World, states: Mapping[BodyId, BodyState], gravity: float) -> int:
    """Set the step size of a world by the largest speed until the next look; return the number of sub-steps."""
    fastest = max((hypot(*state.velocity_W) for state in states.values()), default=0.0)
    fastest += SAMPLING * gravity
    world.set_max_speed(fastest)
    return world.settings.parts_for_travel(fastest)


# The bricks that an action concerns, at their poses before it.


def affected_bricks(moment: Moment, present: Mapping[BodyId, TrackedBrick]) -> list[Placed]:
    """Return the bricks that are placed, pushed, shaken, removed or handled at a moment."""
    match moment:
        case Removal() | HoldAction() | ReleaseAction():
            names = moment.bricks
        case PushAction() | MoveAction():
            names = (moment.brick,)
        case ShakeAction():
            names = tuple(name for name, watched in present.items() if not watched.removed)
        case _:
            return [Placed(placement.brick, placement.came or placement.pose) for placement in moment]
    return [Placed(present[name].placement.brick, present[name].last) for name in names]


# An island: bricks far from all others, with their own world, extension and clock.
#
# Actions and motions elsewhere do not affect it. It is stepped, looked at and judged as if there were no others, so its
# result does not depend on them in any digit. Most scenes are one island.


@dataclass(eq=False)
class Island:
    """One island of a scene."""

    world: World
    extension: Stabilizer | None
    scene: FixedWorld
    measures: RunMeasurements
    log: EventLog
    ticks: int = 0  # time steps during which a brick could move
    steps: int = 0  # of these, steps of an engine
    known: int = 0  # of these, steps of a motion without an engine
    splits: int = 1  # sub-steps of each coming step
    hit: bool = False  # whether it was hit
    to_come: deque[tuple[int, float]] = field(default_factory=deque)  # remaining moments: number and time [s]
    seen: Mapping[BodyId, BodyState] = field(default_factory=dict)  # states of moving bricks at the last look
    resting: bool = True  # whether it was idle at the last call of `lags`
    one_by_one: int = 0  # number of bricks that the engine moved one by one at the last look
    space: Space = field(default_factory=Space)

    def __post_init__(self) -> None:
        scene = self.scene
        self.ground = ShakingGround(self.world, scene.gravity)
        self.edges = NormalErrorMonitor(self.world, scene.gravity)
        self.falling = FallingParts(self.world, scene.planes, scene.friction, scene.gravity)
        self.stabilizer = StabilizerDriver(self.extension, self.world, self.measures, self.log, self.falling)
        self.hands = HandMover(self.world, self.measures.watch, self.stabilizer, self.log, scene.planes)

    # --- clock --------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The time of this island [s]; while nothing moves, the clock stands until the next action."""
        return self.world.time()

    @property
    def idle(self) -> bool:
        """Whether nothing in this island can move."""
        return self.stabilizer.nothing_can_move() and not self.hands.steps

    def still_for(self, most: float) -> float:
        """Return for how long an idle island needs no look, at most `most` [s]."""
        return min(most, self.stabilizer.still_for(), self.hands.still_for())

    def lags(self, until: float) -> bool:
        """Return whether this island has to advance before a time [s]."""
        self.resting, left = self.idle, until - self.time
        if left <= 0.0:
            return False
        return self.still_for(left) < left if self.resting else left > 0.5 * self.world.settings.time_step

    def wait(self, until: float) -> None:
        """Let time pass without motion, up to a time [s] if the island is idle until then."""
        left = until - self.time
        if left > 0.0 and self.idle:
            self.world.skip(self.still_for(left))

    def pass_on(self, most: int) -> None:
        """Advance by one time step of the engine, or by at most `most` steps of a motion without one."""
        shaken = self.ground.shake()
        passed = self.falling.advance(most, driven=shaken or self.hands.busy)
        self.ticks += passed or 1
        self.known += passed
        if passed:
            self.stabilizer.landed(self.falling.landed)
            return
        self.hands.guide()
        self.world.step()
        self.steps += 1
        self.stabilizer.judge()

    def look(self, states: Mapping[BodyId, BodyState]) -> None:
        """Update with the states of all moving bricks, and set the step size until the next look."""
        self.stabilizer.ease_in.look(states)
        self.set_max_speed(states)

    def set_max_speed(self, states: Mapping[BodyId, BodyState]) -> None:
        """Set the step size until the next look by the speeds of moving bricks."""
        self.splits = set_max_speed(self.world, states, self.ground.pull)

    # --- actions ------------------------------------------------------------------------------------------------------

    def prepare(self, moment: Moment, time: float) -> None:
        """Prepare for an action at a time [s]."""
        self.wait(time)
        if self.stabilizer.nothing_can_move():
            self.stabilizer.gave_way = None  # an earlier failure has come to rest, and is not the cause of the next one
        self.stabilizer.ease_in.reset()
        self.falling.disturbed(affected_bricks(moment, self.measures.watch.bricks))
        self.hit = self.hit or _hits(moment)

    def add(self, placement: Placement) -> None:
        """Add a brick."""
        came = placement.came or placement.pose
        self.world.add_brick(placement.brick, came, placement.velocity_W)
        self.space.takes(placement.brick, BodyState(came, placement.velocity_W), self.scene.gravity)

    def moving(self) -> Mapping[BodyId, BodyState]:
        """Return the states of all bricks that may move."""
        return self.world.states(self.stabilizer.moving())

    def absorb(self, other: "Island") -> None:
        """Merge another island into this one."""
        self.falling.end()
        other.falling.end()
        if isinstance(self.world, RestingWorld) and isinstance(other.world, RestingWorld):
            self.world.engine.absorb(other.world.engine)
        if isinstance(self.extension, SupportsMerging) and other.extension is not None:
            self.extension.absorb(other.extension)
        self.stabilizer.absorb(other.stabilizer)
        self.steps += other.steps
        self.known += other.known
        self.falling.proven += other.falling.proven
        self.hands.looks += other.hands.looks
        self.hit = self.hit or other.hit
        self.to_come = deque(sorted([*self.to_come, *other.to_come]))
        self.space.joins(other.space)
        self.edges.absorb(other.edges)

    def rest(self) -> None:
        """Close the engine if it is no longer needed."""
        if isinstance(self.world, RestingWorld) and self.resting and not self.to_come:
            self.world.engine.close_engine()


def _hits(moment: Moment) -> bool:
    """Return whether an action hits the structure."""
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
    """Return the names of the bricks of an action; none if it shakes the ground."""
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
        if much > self._most * work.work_factor():
            raise BlockedPlacementError(self._refused(part, moving, (seconds, by_hand), much))

    def _refused(self, part: "Island", moving: int, ahead: tuple[float, float], much: float) -> Blocked:
        seconds, by_hand = ahead
        many = f"{moving} brick{'s' if moving != 1 else ''} move{'s' if moving == 1 else ''}"
        if by_hand > seconds or (by_hand and not moving):
            many, seconds = "a hand is on its way", by_hand
        said = f"{many} at {part.time:.3g} s" + (f", for {seconds:.3g} s and more" if seconds else "")
        told = (
            f"{much:.2g} steps of a brick in all are estimated, and {self._most * work.work_factor():.2g} are allowed"
        )
        brick = min(part.stabilizer.moving() or part.hands.in_hand or part.measures.watch.present)
        return Blocked(brick, part.time, brick, 0.0, too_much=f"{said}: {told}")

    def _seconds(self, part: "Island", end: float) -> float:
        """For how long what moves will move: shaken, or with nobody who holds it at rest, as long as that goes on."""
        left = max(0.0, end - part.time)
        if part.ground.motion is not None:
            return min(left, max(work.AHEAD, part.ground.motion.ends - part.time))
        return left if part.extension is None else min(left, work.AHEAD)


# All islands of a scene: scheduling, distribution of actions, and merging.


Pieces: TypeAlias = Sequence[tuple[Island, Moment]]  # the part of an action for each island


@dataclass
class Islands:
    """The islands of one run; close them after use."""

    timeline: Timeline
    system: System
    measures: RunMeasurements
    log: EventLog
    found: list[Island] = field(default_factory=list, init=False)  # not merged into another one, by first brick
    _coming: dict[tuple[float, BodyId], Island] = field(default_factory=dict, init=False)  # by time and brick to place
    _of: dict[BodyId, Island] = field(default_factory=dict, init=False)  # by placed brick
    _acted: list[Island] = field(default_factory=list, init=False)  # islands of the last action
    _reached: float = field(default=0.0, init=False)  # time up to which all islands were idle [s]

    def __post_init__(self) -> None:
        # Only a system with proofs holds bricks without an engine.
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
        """Schedule the moments of each island."""
        of: dict[BodyId, Island] = {}
        for number, moment in enumerate(self.timeline.moments()):
            if isinstance(moment, tuple):
                of |= {each.brick.id: self._coming[each.time, each.brick.id] for each in moment}
            for part in {id(of[name]): of[name] for name in names_of(moment) if name in of}.values():
                part.to_come.append((number, time_of(moment)))

    def close(self) -> None:
        """Close the worlds of all islands."""
        for part in self.found:
            part.world.close()

    @property
    def several(self) -> bool:
        """Whether there is more than one island."""
        return len(self.found) > 1

    @property
    def extension(self) -> "Stabilizer | CombinedStabilizer | None":
        """The extension of the whole scene; None without one."""
        if not self.several:
            return self.found[0].extension
        every, acted = (
            [part.extension for part in some if part.extension is not None] for some in (self.found, self._acted)
        )
        return CombinedStabilizer(lambda name: self._of[name].extension, every, acted)

    def of(self, brick: BodyId) -> Island:
        """Return the island of a brick."""
        return self._of[brick] if self.several else self.found[0]

    # --- time ---------------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """The time of the island that is farthest ahead [s]."""
        return max(self._reached, *(part.time for part in self.found)) if self.several else self.found[0].time

    def behind(self, until: float) -> Island | None:
        """Return the island that is farthest behind, of those that have to advance before a time [s]."""
        lagging = [part for part in self.found if part.lags(until)]
        if self.several:
            for part in self.found:
                part.rest()
        return min(lagging, key=lambda part: part.time, default=None)

    def bound(self, part: Island, until: float, end: float) -> float:
        """Return the time up to which an island may advance [s]: its next action, or the end of the run."""
        if not self.several:
            return until
        return max(until, part.to_come[0][1] if part.to_come else end)

    def reached(self, until: float) -> None:
        """Note that no island has to advance before a time [s]."""
        if not self.several:
            self.found[0].wait(until)
        elif all(part.idle for part in self.found):
            self._reached = until

    # --- actions ------------------------------------------------------------------------------------------------------

    def pieces(self, moment: Moment) -> Pieces:
        """Return the part of an action for each island that it concerns."""
        self._acted = []
        if not self.several:
            self._acted = self.found[:1]
            return [(self.found[0], moment)]
        if isinstance(moment, tuple):
            for each in moment:
                self._of[each.brick.id] = self._coming[each.time, each.brick.id]
        islands = {id(self._of[name]): self._of[name] for name in names_of(moment)}
        self._acted = list(islands.values())
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
        """Remove the moment of this number from the schedules; it is over, whether it took place or not."""
        for part in self.found:
            while part.to_come and part.to_come[0][0] <= number:
                part.to_come.popleft()

    def __iter__(self) -> Iterator[Island]:
        """Iterate over the islands, without those that are merged meanwhile."""
        return (part for part in tuple(self.found) if part in self.found)

    # --- merging ------------------------------------------------------------------------------------------------------

    def look(self, part: Island, states: Mapping[BodyId, BodyState]) -> None:
        """Update the reach of an island, and merge those that it may touch soon.

        Raises BlockedPlacementError if the motion needs too much work.
        """
        self.effort.look(self.found, part, self.timeline.end)
        if not self.several or part not in self.found:
            return
        part.space.follows(self.measures.watch.bodies, states, self.timeline.world.gravity)
        while (other := self._met(part)) is not None:
            self._merge(part, other)

    def _met(self, part: Island) -> Island | None:
        return next((other for other in self.found if other is not part and other.space.meets(part.space)), None)

    def _merge(self, part: Island, other: Island) -> None:
        """Merge two islands, after their clocks agree to within half a step."""
        self._keep_step(part, other)
        self.found.remove(other)
        part.absorb(other)
        self._coming |= {key: part for key, at in self._coming.items() if at is other}
        self._of |= {name: part for name, at in self._of.items() if at is other}
        self._acted = list(dict.fromkeys(part if at is other else at for at in self._acted))

    @staticmethod
    def _keep_step(part: Island, other: Island) -> None:
        """Advance the island that is behind to the time of the other."""
        for behind, ahead in ((part, other), (other, part)):
            if not ahead.idle:
                while behind.lags(ahead.time) and not behind.idle:
                    behind.pass_on(1)
                behind.wait(ahead.time)

    # --- results of all islands ---------------------------------------------------------------------------------------

    def edges(self) -> WrongEdges | None:
        """Return the wrong contact normals of all islands."""
        monitor = NormalErrorMonitor(self.found[0].world, self.timeline.world.gravity)
        for part in self.found:
            monitor.absorb(part.edges)
        return monitor.wrong()

    def friction(self) -> WrongFriction | None:
        """Return the wrong friction with the largest error of all islands."""
        errors = filter(None, (wrong_friction_of(part.world) for part in self.found))
        return max(errors, key=lambda wrong: wrong.error, default=None)

    @property
    def undecided(self) -> bool:
        """Whether bricks that were set down are not proven to stand."""
        return any(part.stabilizer.unproven() for part in self.found)

    def seen(self, part: Island) -> Mapping[BodyId, BodyState]:
        """Return the states of all moving bricks at their last looks, after a look at `part`."""
        if not self.several:
            return part.seen
        return {name: state for each in self.found if not each.resting for name, state in each.seen.items()}

    @property
    def steps(self) -> int:
        """Number of time steps of all engines."""
        return sum(part.steps for part in self.found)

    @property
    def judgements(self) -> int:
        """Number of passes of all extensions."""
        return sum(part.stabilizer.judgements for part in self.found)

    def updates(self) -> Updates | None:
        """Return the wall time of the updates of all islands."""
        clock = UpdateClock()
        for part in self.found:
            clock.absorb(part.stabilizer.clock)
        return clock.updates()
