"""Splits a scene into islands far apart, each with its own world and clock, and merges them as they approach."""

from collections import deque
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import dist, hypot, inf
from typing import Final, TypeAlias

from stability.engines.lazy_world import RestingWorld
from stability.engines.protocol import PrescribedMotion, World, WrongFriction
from stability.engines.scene_scale import SAMPLING
from stability.geometry.placed_shape import bodies_apart, in_place, meeting, nearest_in_bounds_W
from stability.geometry.vectors import add_scaled, dot, scale, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3, convex
from stability.name_order import in_order
from stability.problem import Placed
from stability.stabilizers.known_motion import FallingParts
from stability.stabilizers.protocol import Stabilizer
from stability.statics.assembly import Assembly
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
    JointsAction,
    LoadsAction,
    Moment,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
)
from stackdsl.trace import Event, EventKind, Updates, WrongEdges
from stackdsl.wording import and_text

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
        groups[MOST - 1 :] = [sorted(number for group in groups[MOST - 1 :] for number in group)]
    return [[placements[number] for number in group] for group in groups]


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
            return [numbers for group in groups for numbers in _parted(group)]
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
class GrowingBox:
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

    def joins(self, other: "GrowingBox") -> None:
        """Extend the box by another one."""
        (ax, ay, az), (bx, by, bz) = self.low_W, self.high_W
        (cx, cy, cz), (dx, dy, dz) = other.low_W, other.high_W
        self.low_W, self.high_W = (min(ax, cx), min(ay, cy), min(az, cz)), (max(bx, dx), max(by, dy), max(bz, dz))

    def meets(self, other: "GrowingBox") -> bool:
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
        case Removal() | JointsAction() | LoadsAction() | HoldAction() | ReleaseAction():
            names = moment.bricks
        case PushAction() | MoveAction():
            names = (moment.brick,)
        case ShakeAction():
            names = tuple(name for name, watched in present.items() if not watched.removed)
        case _:
            return [Placed(placement.brick, placement.came or placement.pose) for placement in moment]
    return [Placed(present[name].placement.brick, present[name].last) for name in names]


# The first contact of each thrown or dropped brick. The stabilizer wakes bricks before a hit, and misses hits on bricks
# that move already, so only the contacts of the engine tell in which step a hit takes place. Within this step, a fast
# body may bounce off, or reach further bricks. So the paths of the solids from the poses before the step tell which
# bricks it touches first.


AT_ONCE: Final = 1e-4  # [m] bodies hit within this distance of the first one are hit together
ASLANT = 1.02  # ratio of the speed of a body to that into a face from which both are told
GRAZE: Final = 1e-6  # [m] least overlap across the path of a hit


@dataclass(frozen=True, slots=True)
class _Flight:
    """A flying brick, and the bodies near it, before a step of the engine."""

    state: BodyState
    near: Mapping[BodyId, BodyState]


@dataclass(frozen=True, slots=True)
class _Touch:
    """A body that a flying brick reaches."""

    after: float  # the poses of the flight [s]
    speed: float  # along the normal [m/s]
    off_centre: float  # distance from the centre of the flying brick [m]


@dataclass
class FirstContacts:
    """Logs the first contact of each flying brick, after the step of the engine in which it changes the motion."""

    world: World
    log: EventLog
    gravity: float  # [m/s2]
    planes: Container[BodyId]
    _flights: dict[BodyId, _Flight] = field(default_factory=dict)
    _looked: float = 0.0  # time of the last look [s]

    def add(self, brick: BodyId, came: BodyState) -> None:
        """Follow a thrown or dropped brick until it touches another body."""
        self._flights[brick] = _Flight(came, {})

    def stepped(self) -> None:
        """Look at the contacts after a step of the engine."""
        if not self._flights:
            return
        step = self.world.time() - self._looked
        for brick, state in self.world.states(list(self._flights)).items():
            if reason := self._hit_text(brick, self._flights[brick], state, step):
                del self._flights[brick]
                self.log.add(Event(self.world.time(), EventKind.HIT, (brick,), reason))
        self.moved()

    def moved(self) -> None:
        """Take the poses of the flying bricks and of all near them, for the next step."""
        self._looked = self.world.time()
        for brick, state in self.world.states(list(self._flights)).items() if self._flights else ():
            reach = 2.0 * self.world.settings.time_step * hypot(*state.velocity_W)
            near = [other for other in self.world.neighbours(brick, reach) if other not in self.planes]
            self._flights[brick] = _Flight(state, self.world.states(near))

    def _hit_text(self, brick: BodyId, flight: _Flight, state: BodyState, step: float) -> str:
        """Return which bodies a brick hits, those before its centre first, and how fast; empty if it hits none."""
        before_W = flight.state.velocity_W
        # A body that has bounced off within the step presses no longer.
        bounced = dist(state.velocity_W, before_W) > 2.0 * self.gravity * self.world.settings.time_step
        points = self.world.contacts(brick)
        pressed = [point for point in points if point.normal_force > 0.0]
        if not pressed and not bounced:
            return ""
        found = {name: touch for name in flight.near if (touch := self._reached(brick, flight, name, step))}
        first = min((touch.after for touch in found.values()), default=0.0)
        together = first + AT_ONCE / max(hypot(*before_W), AT_ONCE)
        hit = {name: touch for name, touch in found.items() if touch.after <= together}
        least = min((point.gap for point in points), default=0.0)
        for point in pressed or [point for point in points if point.gap <= least + AT_ONCE]:
            name = _other(brick, point)
            if not found or name in self.planes:
                hit[name] = _Touch(first, _speed_onto(brick, point, before_W), inf)
        if not hit:
            return ""
        nearest = min(touch.off_centre for touch in hit.values())
        before_centre = [name for name in in_order(hit) if hit[name].off_centre <= nearest + AT_ONCE]
        others = and_text(in_order(hit.keys() - before_centre))
        speed = max(touch.speed for touch in hit.values())
        whole = max(hypot(*self._fallen_on(before_W, first)), speed)  # what it hits may come towards it
        text = f"{brick} hits {and_text(before_centre)}{', with ' * bool(others)}{others} at {whole:.3g} m/s"
        # A body that comes aslant hits with a part of its speed.
        return f"{text}, {speed:.3g} m/s of it into the face" if whole > ASLANT * speed else text

    def _reached(self, brick: BodyId, flight: _Flight, other: BodyId, step: float) -> _Touch | None:
        """Return when and how a flying brick reaches a body within a step [s]; None if it does not.

        The brick may have reached the body before: with coarse steps, an engine reports a contact one step late.
        """
        shape, target = convex(self.world.shape(brick)), convex(self.world.shape(other))
        before, there = flight.state, flight.near[other]
        onto_W = subtract(before.velocity_W, there.velocity_W)
        speed = hypot(*onto_W)
        if shape is None or target is None or speed == 0.0:
            return None
        along_W = scale(1.0 / speed, onto_W)
        still = in_place(target, there.pose)
        met = meeting(in_place(shape, before.pose), still, along_W, GRAZE)
        if met is None or met[1] <= 0.0 or met[0] > step * speed + AT_ONCE:
            return None
        centre_W = add_scaled(before.pose.position_W, met[0] - AT_ONCE, along_W)
        normal_W = bodies_apart(in_place(shape, Pose(centre_W, before.pose.orientation)), still).normal_BA_W
        off_centre = dist(centre_W, nearest_in_bounds_W(target, there.pose, centre_W))
        after = met[0] / speed
        arriving_W = onto_W if other in self._flights else self._fallen_on(onto_W, after)
        return _Touch(after, max(0.0, -dot(arriving_W, normal_W)), off_centre)

    def _fallen_on(self, velocity_W: Vec3, time: float) -> Vec3:
        """Return a velocity after falling on for a time [s]."""
        return add_scaled(velocity_W, -self.gravity * time, (0.0, 0.0, 1.0))

    def removed(self, bricks: Iterable[BodyId]) -> None:
        """Follow removed bricks no longer."""
        for brick in bricks:
            self._flights.pop(brick, None)

    def absorb(self, other: "FirstContacts") -> None:
        """Follow the flying bricks of another island, which are now in this world."""
        self._flights |= other._flights


def _other(brick: BodyId, point: ContactPoint) -> BodyId:
    return point.b if point.a == brick else point.a


def _speed_onto(brick: BodyId, point: ContactPoint, velocity_W: Vec3) -> float:
    """Return the speed of a brick along the normal of a contact, towards the other body [m/s]."""
    away = dot(velocity_W, point.normal_BA_W)
    return max(0.0, -away if point.a == brick else away)


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
    space: GrowingBox = field(default_factory=GrowingBox)

    def __post_init__(self) -> None:
        scene = self.scene
        self.ground = ShakingGround(self.world, scene.gravity)
        self.edges = NormalErrorMonitor(self.world, scene.gravity)
        self.falling = FallingParts(self.world, scene.planes, scene.friction, scene.gravity)
        self.stabilizer = StabilizerDriver(self.extension, self.world, self.measures, self.log, self.falling)
        self.first_contacts = FirstContacts(self.world, self.log, scene.gravity, [plane.id for plane in scene.planes])
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
        acceleration_W = self.ground.acceleration_W()
        driven = acceleration_W is not None or self.hands.busy or self.stabilizer.needs_engine()
        passed = self.falling.advance(most, driven=driven)
        self.ticks += passed or 1
        self.known += passed
        if passed:
            self.stabilizer.moved_without_engine()
            self.stabilizer.landed(self.falling.landed)
            self.first_contacts.moved()
            return
        self.stabilizer.about_to_step()
        prescribed = PrescribedMotion(acceleration_W or AT_REST, self.hands.guided())
        self.world.step(prescribed)
        while self.stabilizer.opened():
            self.world.step(prescribed)
        self.steps += 1
        self.first_contacts.stepped()
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
        if placement.hits:
            self.first_contacts.add(placement.brick.id, BodyState(came, placement.velocity_W))
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
        if self.extension is not None and other.extension is not None:
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
        self.first_contacts.absorb(other.first_contacts)

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


# The work of a run, estimated from counts, and its limit.


@dataclass(frozen=True, slots=True)
class StepCounts:
    """Counts of work, which only increase."""

    steps: int = 0  # of an engine
    known: int = 0  # steps of motions without an engine
    looks: int = 0  # at bricks that hands lower
    landings: int = 0

    @classmethod
    def by(cls, islands: "list[Island]") -> "StepCounts":
        """Return the sums over islands."""
        return cls(
            sum(each.steps for each in islands),
            sum(each.known for each in islands),
            sum(each.hands.looks for each in islands),
            sum(each.falling.proven for each in islands),
        )

    def since(self, before: "StepCounts") -> "StepCounts":
        """Return the difference from earlier counts."""
        return StepCounts(
            self.steps - before.steps,
            self.known - before.known,
            self.looks - before.looks,
            self.landings - before.landings,
        )


@dataclass
class RunWork:
    """The work of a run, in units of one moving brick in one step."""

    system: System
    done: float = 0.0
    _before: StepCounts = StepCounts()

    def __post_init__(self) -> None:
        proven = self.system.method is Method.PROVEN
        self._most, self._step = (work.MOST_STEPS, work.STEP) if proven else (work.MOST_STEPS_BARE, work.STEP_BARE)
        self._dearer = self._most / work.MOST_STEPS  # scales work outside of the engine, equal on every system

    def look(self, islands: "list[Island]", island: "Island", end: float) -> None:
        """Count the work since the last look, and estimate the work up to a time [s].

        Raises BlockedPlacementError if both exceed the limit, before the bricks have moved for long.
        """
        now = StepCounts.by(islands)
        new, self._before = now.since(self._before), now
        moving = sum(each.one_by_one for each in islands)
        each_step = self._step + moving + self._dearer * (island.splits - 1) * (work.SPLIT + work.SPLIT_MOVING * moving)
        other_work = work.KNOWN * new.known + work.LOOK * new.looks + work.LANDING * new.landings
        self.done += new.steps * each_step + self._dearer * other_work
        hand_seconds = island.hands.busy_for()
        seconds = max(
            self._seconds(island, end) if moving and now.steps else 0.0, hand_seconds if island.hands.steps else 0.0
        )
        # The speed, and with it the number of sub-steps, soon changes, so the estimate assumes slow motion.
        steady = self._step + moving
        ahead = seconds / island.world.settings.time_step * steady + self._dearer * work.LOOK * hand_seconds / SAMPLING
        total = self.done + ahead
        if total > self._most * work.work_factor():
            raise BlockedPlacementError(self._refused(island, moving, (seconds, hand_seconds), total))

    def _refused(self, island: "Island", moving: int, ahead: tuple[float, float], total: float) -> Blocked:
        seconds, hand_seconds = ahead
        cause = f"{moving} brick{'s' if moving != 1 else ''} move{'s' if moving == 1 else ''}"
        if hand_seconds > seconds or (hand_seconds and not moving):
            cause, seconds = "a hand moves a brick", hand_seconds
        motion = f"{cause} at {island.time:.3g} s" + (f", for at least {seconds:.3g} s" if seconds else "")
        limit = (
            f"the estimated work of {total:.2g} brick steps exceeds the limit of {self._most * work.work_factor():.2g}"
        )
        brick = min(island.stabilizer.moving() or island.hands.in_hand or island.measures.watch.present)
        return Blocked(brick, island.time, brick, 0.0, too_much=f"{motion}: {limit}")

    def _seconds(self, island: "Island", end: float) -> float:
        """Return the expected time of further motion [s]; without an extension, up to the end of the run."""
        left = max(0.0, end - island.time)
        if island.ground.motion is not None:
            return min(left, max(work.AHEAD, island.ground.motion.ends - island.time))
        return left if island.extension is None else min(left, work.AHEAD)


# All islands of a scene: scheduling, distribution of actions, and merging.


Pieces: TypeAlias = Sequence[tuple[Island, Moment]]  # the part of an action for each island


@dataclass
class Islands:
    """The islands of one run; call `close` after use."""

    timeline: Timeline
    system: System
    measures: RunMeasurements
    log: EventLog
    islands: list[Island] = field(default_factory=list, init=False)  # not merged into another one, by first brick
    _coming: dict[tuple[float, BodyId], Island] = field(default_factory=dict, init=False)  # by time and brick to place
    _of: dict[BodyId, Island] = field(default_factory=dict, init=False)  # by placed brick
    _acted: list[Island] = field(default_factory=list, init=False)  # islands of the last action
    _reached: float = field(default=0.0, init=False)  # time up to which all islands were idle [s]

    def __post_init__(self) -> None:
        # Only a system with proofs holds bricks without an engine.
        apart = self.system.method is Method.PROVEN and self.timeline.watched and self.system.modification.size == 1.0
        apart = apart and not self.timeline.world.has_joints  # which may reach from one to another
        split = far_apart(self.timeline) if apart else [list(self.timeline.placements)]
        try:
            for placements in split:
                self._open(placements)
        except BaseException:
            self.close()
            raise
        self.effort = RunWork(self.system)
        self.split = self.several
        if self.split:
            self._tell_when()

    def _open(self, placements: Sequence[Placement]) -> None:
        whole = len(placements) == len(self.timeline.placements)
        own = self.timeline if whole else replace(self.timeline, actions=tuple(placements))
        world = opened_world(own, self.system)
        island = Island(world, extension_for(own, self.system, world), own.world, self.measures, self.log)
        self.islands.append(island)
        self._coming |= {(each.time, each.brick.id): island for each in placements}

    def _tell_when(self) -> None:
        """Schedule the moments of each island."""
        of: dict[BodyId, Island] = {}
        for number, moment in enumerate(self.timeline.moments()):
            if isinstance(moment, tuple):
                of |= {each.brick.id: self._coming[each.time, each.brick.id] for each in moment}
            for island in {id(of[name]): of[name] for name in names_of(moment) if name in of}.values():
                island.to_come.append((number, time_of(moment)))

    def close(self) -> None:
        """Close the worlds of all islands."""
        for island in self.islands:
            island.world.close()

    @property
    def several(self) -> bool:
        """Whether there is more than one island."""
        return len(self.islands) > 1

    @property
    def extension(self) -> "Stabilizer | CombinedStabilizer | None":
        """The extension of the whole scene; None without one."""
        if not self.several:
            return self.islands[0].extension
        every, acted = (
            [island.extension for island in some if island.extension is not None]
            for some in (self.islands, self._acted)
        )
        return CombinedStabilizer(lambda name: self._of[name].extension, every, acted)

    def of(self, brick: BodyId) -> Island:
        """Return the island of a brick."""
        return self._of[brick] if self.several else self.islands[0]

    # --- time ---------------------------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """The time of the island that is farthest ahead [s]."""
        return max(self._reached, *(island.time for island in self.islands)) if self.several else self.islands[0].time

    def behind(self, until: float) -> Island | None:
        """Return the island that is farthest behind, of those that have to advance before a time [s]."""
        lagging = [island for island in self.islands if island.lags(until)]
        if self.several:
            for island in self.islands:
                island.rest()
        return min(lagging, key=lambda island: island.time, default=None)

    def bound(self, island: Island, until: float, end: float) -> float:
        """Return the time up to which an island may advance [s]: its next action, or the end of the run."""
        if not self.several:
            return until
        return max(until, island.to_come[0][1] if island.to_come else end)

    def reached(self, until: float) -> None:
        """Note that no island has to advance before a time [s]."""
        if not self.several:
            self.islands[0].wait(until)
        elif all(island.idle for island in self.islands):
            self._reached = until

    # --- actions ------------------------------------------------------------------------------------------------------

    def pieces(self, moment: Moment) -> Pieces:
        """Return the part of an action for each island that it concerns."""
        self._acted = []
        if not self.several:
            self._acted = self.islands[:1]
            return [(self.islands[0], moment)]
        if isinstance(moment, tuple):
            for each in moment:
                self._of[each.brick.id] = self._coming[each.time, each.brick.id]
        islands = {id(self._of[name]): self._of[name] for name in names_of(moment)}
        self._acted = list(islands.values())
        return [(island, self._piece(moment, island)) for island in self._acted]

    def _piece(self, moment: Moment, island: Island) -> Moment:
        match moment:
            case Removal():
                return replace(moment, bricks=tuple(name for name in moment.bricks if self._of[name] is island))
            case tuple():
                return tuple(each for each in moment if self._of[each.brick.id] is island)
            case _:
                return moment

    def done(self, number: int) -> None:
        """Remove the moment of this number from the schedules; it is over, whether it took place or not."""
        for island in self.islands:
            while island.to_come and island.to_come[0][0] <= number:
                island.to_come.popleft()

    def __iter__(self) -> Iterator[Island]:
        """Iterate over the islands, without those that are merged meanwhile."""
        return (island for island in tuple(self.islands) if island in self.islands)

    # --- merging ------------------------------------------------------------------------------------------------------

    def look(self, island: Island, states: Mapping[BodyId, BodyState]) -> None:
        """Update the reach of an island, and merge those that it may touch soon.

        Raises BlockedPlacementError if the motion needs too much work.
        """
        self.effort.look(self.islands, island, self.timeline.end)
        if not self.several or island not in self.islands:
            return
        island.space.follows(self.measures.watch.bodies, states, self.timeline.world.gravity)
        while (other := self._met(island)) is not None:
            self._merge(island, other)

    def _met(self, island: Island) -> Island | None:
        return next((other for other in self.islands if other is not island and other.space.meets(island.space)), None)

    def _merge(self, island: Island, other: Island) -> None:
        """Merge two islands, after their clocks agree to within half a step."""
        self._keep_step(island, other)
        self.islands.remove(other)
        island.absorb(other)
        self._coming |= {key: island for key, at in self._coming.items() if at is other}
        self._of |= {name: island for name, at in self._of.items() if at is other}
        self._acted = list(dict.fromkeys(island if at is other else at for at in self._acted))

    @staticmethod
    def _keep_step(island: Island, other: Island) -> None:
        """Advance the island that is behind to the time of the other."""
        for behind, ahead in ((island, other), (other, island)):
            if not ahead.idle:
                while behind.lags(ahead.time) and not behind.idle:
                    behind.pass_on(1)
                behind.wait(ahead.time)

    # --- results of all islands ---------------------------------------------------------------------------------------

    def edges(self) -> WrongEdges | None:
        """Return the wrong contact normals of all islands."""
        monitor = NormalErrorMonitor(self.islands[0].world, self.timeline.world.gravity)
        for island in self.islands:
            monitor.absorb(island.edges)
        return monitor.wrong()

    def assembly(self) -> Assembly | None:
        """Return the assembly of the frozen bricks; None without proofs, or if each of several islands has its own."""
        extension = self.islands[0].extension
        return extension.proven() if extension is not None and len(self.islands) == 1 else None

    def friction(self) -> WrongFriction | None:
        """Return the wrong friction with the largest error of all islands."""
        errors = filter(None, (island.world.wrong_friction() for island in self.islands))
        return max(errors, key=lambda wrong: wrong.error, default=None)

    @property
    def undecided(self) -> bool:
        """Whether bricks that were set down are not proven to stand."""
        return any(island.stabilizer.unproven() for island in self.islands)

    def seen(self, island: Island) -> Mapping[BodyId, BodyState]:
        """Return the states of all moving bricks at their last looks, after a look at `part`."""
        if not self.several:
            return island.seen
        return {name: state for each in self.islands if not each.resting for name, state in each.seen.items()}

    @property
    def steps(self) -> int:
        """Number of time steps of all engines."""
        return sum(island.steps for island in self.islands)

    @property
    def judgements(self) -> int:
        """Number of passes of all extensions."""
        return sum(island.stabilizer.judgements for island in self.islands)

    def updates(self) -> Updates | None:
        """Return the wall time of the updates of all islands."""
        clock = UpdateClock()
        for island in self.islands:
            clock.absorb(island.stabilizer.clock)
        return clock.updates()
