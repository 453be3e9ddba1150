"""Tracks every brick of a run: drift, tilt, the first fall, and events."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import dist, inf
from typing import Protocol

from stability.geometry.placed_shape import apart
from stability.geometry.vectors import lean_between, turn_between
from stability.model import BodyId, BodyState, Brick, Pose
from stability.problem import Motion, Placed, Stability, Stage, Verdict
from stability.stabilizers.protocol import Stabilizer, Update
from stability.stabilizers.rest import RestLimits
from stackdsl.timeline import Arrival, Placement, Timeline
from stackdsl.trace import (
    ACTIONS,
    COLLAPSE_SHARE_OF_SMALLEST_SIDE,
    COLLAPSE_TILT,
    BrickState,
    BrickTrack,
    Edge,
    Event,
    EventKind,
)
from stackdsl.wording import mm

# Follows every placed brick: where it came to rest, how far it has shifted and tilted since, and who left first.


NOT_MOVING = RestLimits(speed=0.002, angular_speed=0.035, hold_off=0.1)  # on earth; a slow topple shows in that time
VISIBLE = 1e-3  # [m]
VISIBLE_TILT = 0.01  # [rad] 1 mm at a decimetre
READ_BACK = 1e-12  # [m] what a position loses on its way into a scaled engine and back


@dataclass
class TrackedBrick:
    """One brick under watch."""

    placement: Placement
    number: int  # in order of placement
    rest: Pose | None  # None until a dropped brick has come to rest
    last: Pose
    shift: float = 0.0  # [m] largest since rest
    tilt: float = 0.0  # [rad] largest since rest; once a hit has come, of what was upright
    sunk: float | None = None  # [m] largest below rest; None until a hit has come
    slow_since: float | None = None
    not_moving: RestLimits = NOT_MOVING
    left_at: float | None = None  # [s]
    removed: bool = False
    in_hand: bool = False

    @property
    def collapse_shift(self) -> float:
        """How far its centre may shift, or sink after a hit [m]."""
        return COLLAPSE_SHARE_OF_SMALLEST_SIDE * self.placement.brick.shape.least_thickness

    @property
    def left_its_place(self) -> bool:
        """Whether it has collapsed, by the definition of the word (see trace.py)."""
        return (self.shift if self.sunk is None else self.sunk) > self.collapse_shift or self.tilt > COLLAPSE_TILT

    @property
    def displaced(self) -> bool:
        """Whether a hit has shifted it to another place, where it stands."""
        if self.rest is None or self.sunk is None:
            return False
        return dist(self.rest.position_W, self.last.position_W) > self.collapse_shift

    def hit(self) -> None:
        """Something hits the structure: from now on what merely shifts has not left its place."""
        if self.left_at is None and self.sunk is None and not self.placement.hits:
            self.sunk = 0.0

    def see(self, time: float, state: BodyState) -> None:
        """Take in where the brick is now."""
        self.last = state.pose
        if self.placement.hits or self.in_hand:
            return
        if self.rest is None:
            self._wait_for_rest(time, state)
        else:
            shift = dist(self.rest.position_W, state.pose.position_W)
            self.shift = max(self.shift, shift if shift > READ_BACK else 0.0)
            # What a hit turns on the flat has not tilted.
            turned = turn_between if self.sunk is None else lean_between
            self.tilt = max(self.tilt, turned(self.rest, state.pose))
            if self.sunk is not None:
                self.sunk = max(self.sunk, self.rest.position_W[2] - state.pose.position_W[2])
            if self.left_at is None and self.left_its_place:
                self.left_at = time

    def _wait_for_rest(self, time: float, state: BodyState) -> None:
        if not self.not_moving.slow(state):
            self.slow_since = None
            return
        self.slow_since = time if self.slow_since is None else self.slow_since
        if time - self.slow_since >= self.not_moving.hold_off:
            self.rest = state.pose

    def taken(self) -> None:
        """A hand takes it, and nothing that happens to it from now on is a fall."""
        self.in_hand = True

    def let_go(self, state: BodyState) -> None:
        """The hand has let it go: here it stands, or begins to fall."""
        self.in_hand, self.rest, self.last = False, state.pose, state.pose
        self.shift = self.tilt = 0.0
        self.sunk = None if self.sunk is None else 0.0

    def state(self, frozen: bool) -> BrickState:
        """How it ended."""
        if self.removed:
            return BrickState.REMOVED
        if self.placement.hits:
            return BrickState.THROWN
        if self.left_at is not None:
            return BrickState.FALLEN
        if self.rest is None:
            return BrickState.UNSETTLED
        if self.displaced:
            return BrickState.DISPLACED
        return BrickState.FROZEN if frozen else BrickState.STANDING

    def track(self, frozen: bool) -> BrickTrack:
        """What the trace keeps of it."""
        return BrickTrack(
            brick=self.placement.brick,
            level=self.placement.level,
            state=self.state(frozen),
            placed=self.placement.pose,
            rest=self.rest or self.last,
            final=self.last,
            shift=self.shift,
            tilt=self.tilt,
            left_at=self.left_at,
            sunk=self.sunk,
            frozen=frozen,
        )


@dataclass
class BrickTracker:
    """All bricks placed so far, in order of placement."""

    bricks: dict[BodyId, TrackedBrick] = field(default_factory=dict)
    dropped: list[TrackedBrick] = field(
        default_factory=list
    )  # where these lie, or what was thrown, is not known before
    made_of: dict[BodyId, Brick] = field(default_factory=dict)
    not_moving: RestLimits = NOT_MOVING  # what is dropped
    hit: bool = False  # whether something has hit the structure
    largest_shift: float = 0.0  # of any so far [m]
    present: dict[BodyId, None] = field(default_factory=dict)  # those that are not pulled out
    shifted: dict[BodyId, TrackedBrick] = field(
        default_factory=dict
    )  # visibly, be it that they have not left their places
    _left: dict[BodyId, TrackedBrick] = field(default_factory=dict)  # their places

    def add(self, placement: Placement) -> None:
        """A brick set down at rest counts as at rest there; a dropped one does so later, and a thrown one never."""
        rest, came = (placement.pose if placement.at_rest else None), placement.came or placement.pose
        watched = TrackedBrick(placement, len(self.bricks), rest, came, not_moving=self.not_moving)
        self.bricks[placement.brick.id] = watched
        self.made_of[placement.brick.id] = placement.brick
        self.present[placement.brick.id] = None
        if rest is None:
            self.dropped.append(watched)
        if placement.hits:
            self.struck()
        elif self.hit:
            watched.hit()

    def taken(self, brick: BodyId) -> None:
        """A hand takes a brick."""
        self.bricks[brick].taken()

    def let_go(self, bricks: Iterable[BodyId], states: Mapping[BodyId, BodyState]) -> None:
        """Hands have let bricks go."""
        for name in bricks:
            self.bricks[name].let_go(states[name])

    def struck(self) -> None:
        """Something hits the structure."""
        self.hit = True
        for watched in self.bricks.values():
            watched.hit()

    def remove(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out: their tracks end."""
        for name in bricks:
            watched = self.bricks[name]
            watched.removed = True
            del self.present[name]
            self._left.pop(name, None)
            self.shifted.pop(name, None)
            if watched in self.dropped:
                self.dropped.remove(watched)

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved."""
        for name, state in states.items():
            watched = self.bricks[name]
            watched.see(time, state)
            self.largest_shift = max(self.largest_shift, watched.shift)
            if watched.shift > VISIBLE or watched.tilt > VISIBLE_TILT:
                self.shifted[name] = watched
            if watched.left_at is not None:
                self._left[name] = watched

    def freeze(self, bricks: Iterable[BodyId]) -> None:
        """A frozen brick is at rest, whatever its past."""
        for name in bricks:
            self.bricks[name].rest = self.bricks[name].rest or self.bricks[name].last

    def where(self) -> Mapping[BodyId, Placed]:
        """All that is there, where it was last seen."""
        return {name: Placed(self.made_of[name], self.bricks[name].last) for name in self.present}

    def left(self, among: Iterable[BodyId]) -> list[BodyId]:
        """Those of some bricks that have left their places."""
        return [name for name in among if name in self._left]

    def first_to_leave(self) -> BodyId | None:
        """The brick that has left its place, by the largest shift if there are several."""
        left = min(self._left.values(), key=lambda watched: (-watched.shift, watched.number), default=None)
        return left.placement.brick.id if left is not None else None

    def youngest(self) -> Placement:
        """Whose level is under construction; what hits, is in a hand or is slid in does not count if others do."""
        watched = list(reversed(self.bricks.values()))
        built = (each.placement for each in watched if each.placement.builds and not each.in_hand)
        return next(built, watched[0].placement)


# What the extensions of several parts say of the whole scene.


WORST_FIRST = (Stability.UNSTABLE, Stability.UNDECIDED, Stability.STABLE)
Shares = Mapping[BodyId, Mapping[BodyId, float]]


class Tells(Protocol):
    """What is told of bricks that are held, as a `Stabilizer` tells it."""

    def awake(self) -> list[BodyId]:
        """The bricks that an engine moves, by name."""

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed."""

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""

    def least_margin(self) -> float | None:
        """The smallest tipping margin of what is frozen [m]; None where no model has one."""

    def verdict(self) -> Verdict | None:
        """What was proven when bricks were last set down or taken out; None where nothing proves."""

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why bricks that an engine moves are proven not to stand."""


@dataclass(frozen=True)
class CombinedStabilizer:
    """Several as one."""

    of: Callable[[BodyId], Stabilizer | None]  # by brick
    extensions: Sequence[Stabilizer]
    acted: Sequence[Stabilizer]  # those with whose bricks something was done last

    def awake(self) -> list[BodyId]:
        """The bricks that an engine moves, by name."""
        return sorted(name for each in self.extensions for name in each.awake())

    def is_frozen(self, brick: BodyId) -> bool:
        """Whether a brick is held fixed."""
        extension = self.of(brick)
        return extension is not None and extension.is_frozen(brick)

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Which part of its load goes to each body that it rests on, for every frozen brick, or those of some."""
        found: dict[BodyId, Mapping[BodyId, float]] = {}
        for each in self.extensions:
            found |= each.shares(None if bricks is None else [name for name in bricks if self.of(name) is each])
        return found

    def least_margin(self) -> float | None:
        """The smallest tipping margin of what is frozen [m]; None where no model has one."""
        margins = [margin for each in self.extensions if (margin := each.least_margin()) is not None]
        return min(margins, default=None)

    def verdict(self) -> Verdict | None:
        """What was proven when bricks were last set down or taken out: the worst, of all that fail so."""
        verdicts = [verdict for each in self.acted if (verdict := each.verdict()) is not None]
        if not verdicts:
            return None
        worst = min((verdict.stability for verdict in verdicts), key=WORST_FIRST.index)
        return _as_one([verdict for verdict in verdicts if verdict.stability is worst])

    def giving_way(self) -> Mapping[BodyId, str]:
        """Why bricks that an engine moves are proven not to stand."""
        return {name: reason for each in self.extensions for name, reason in each.giving_way().items()}


def _as_one(verdicts: Sequence[Verdict]) -> Verdict:
    """Verdicts of the same stability."""
    if len(verdicts) == 1:
        return verdicts[0]
    stages = [verdict.stage for verdict in verdicts if verdict.stage is not None]
    motions = [verdict.motion for verdict in verdicts if verdict.motion is not None]
    velocity = {name: how for motion in motions for name, how in motion.velocity.items()}
    return replace(
        verdicts[0],
        stage=max(stages, key=tuple(Stage).index, default=None),
        reason="; ".join(dict.fromkeys(filter(None, (verdict.reason for verdict in verdicts)))),
        moving=tuple(sorted(name for verdict in verdicts for name in verdict.moving)),
        motion=Motion(velocity) if motions else None,
        seconds=sum(verdict.seconds for verdict in verdicts),
    )


# What became of every brick of a timeline, whether it was placed or not.


def tracks_of(
    timeline: Timeline, watch: BrickTracker, extension: Tells | None, unproven: bool, collapsed: bool
) -> dict[BodyId, BrickTrack]:
    """The track of each, in the order of the timeline.

    `unproven`: what is not frozen was not played, as only a proof was asked for, and there was none that it stands.
    """
    found = {}
    for placement in timeline.placements:
        name = placement.brick.id
        if name not in watch.bricks:
            found[name] = _unplaced(placement)
            continue
        frozen = extension is not None and extension.is_frozen(name)
        track = watch.bricks[name].track(frozen)
        if unproven and not frozen:
            track = replace(track, state=BrickState.UNWATCHED)
        found[name] = track
    if extension is None or collapsed or all(track.state is not BrickState.STANDING for track in found.values()):
        return found
    return found | _unsettled(found, extension.giving_way())


def _unsettled(tracks: Mapping[BodyId, BrickTrack], giving_way: Mapping[BodyId, str]) -> dict[BodyId, BrickTrack]:
    """What is proven to fall where nothing was seen to: some falls take longer than a run."""
    return {
        name: replace(tracks[name], state=BrickState.UNSETTLED, gives_way=reason)
        for name, reason in giving_way.items()
        if tracks[name].state is BrickState.STANDING
    }


def _unplaced(placement: Placement) -> BrickTrack:
    pose = placement.pose
    return BrickTrack(placement.brick, placement.level, BrickState.UNPLACED, pose, pose, pose, shift=0.0, tilt=0.0)


# What is told of a run while it goes on: its events, what proved the bricks, and how each was carried at first.


OnEvent = Callable[[Event], None]


@dataclass
class EventLog:
    """The events of one run, told as they come."""

    on_event: OnEvent
    events: list[Event] = field(default_factory=list, init=False)
    carried_at_first: dict[BodyId, tuple[Edge, ...]] = field(default_factory=dict, init=False)
    _proofs: Counter[str] = field(default_factory=Counter, init=False)  # bricks by what proved them

    def tell(self, event: Event) -> None:
        """Something has happened."""
        self.events.append(event)
        self.on_event(event)

    def tell_update(self, now: float, update: Update) -> None:
        """What the extension has frozen and woken in one pass."""
        stays = tuple(brick for brick in update.frozen if brick not in update.woken)
        if stays:
            self._proofs[update.proof] += len(stays)
            self.tell(Event(now, EventKind.FROZEN, stays, update.proof))
        if update.woken:
            self.tell(Event(now, EventKind.WOKEN, update.woken, update.reason, riding=update.riding))

    def close_placement(self, extension: Tells, watch: BrickTracker) -> None:
        """Before the next bricks come: note how the last ones were carried, and how safely the stack stood."""
        if extension.awake():
            return  # what still moves has no margin, and who carries whom is about to change
        for index in range(len(self.events) - 1, -1, -1):
            if self.events[index].kind in ACTIONS - {EventKind.PLACED}:
                return  # the bricks placed before it were looked at when it came
            if self.events[index].kind is EventKind.PLACED:
                placed = self.events[index].bricks
                if any(watch.bricks[brick].placement.hits for brick in placed):
                    return  # nor is who carries a missile
                self.events[index] = replace(self.events[index], margin=extension.least_margin())
                shares = extension.shares(placed)
                self.carried_at_first |= {brick: edges_of(brick, shares.get(brick, {})) for brick in placed}
                return

    def in_order(self) -> tuple[Event, ...]:
        """By time: parts of a scene tell what happened in them when it is their turn."""
        return tuple(sorted(self.events, key=lambda event: event.time))

    def last_placed(self) -> tuple[BodyId, ...]:
        """The bricks of the last action, if that was to place some."""
        last = next((event for event in reversed(self.events) if event.kind in ACTIONS), None)
        return last.bricks if last is not None and last.kind is EventKind.PLACED else ()

    def proofs(self) -> Mapping[str, int]:
        """How many bricks were proven by what."""
        return {proof: count for proof, count in sorted(self._proofs.items()) if proof}


def edges_of(brick: BodyId, shares: Mapping[BodyId, float]) -> tuple[Edge, ...]:
    """Who carries a brick, and which part of its load."""
    return tuple(Edge(brick, on, shares[on]) for on in sorted(shares))


# A brick that is placed needs room: where others have moved to is not known when a scenario is written.


# [m] a brick that is placed may lie this deep in one that was dropped: engines let bricks sink and creep by as much.
MOST_OVERLAP = 1e-3


@dataclass(frozen=True, slots=True)
class Blocked:
    """Why a run cannot go on: a brick is to be placed where another one is by now, or what moves takes too much."""

    brick: BodyId
    time: float  # [s]
    by: BodyId
    depth: float  # [m]
    thrown: bool = False  # whether the brick comes flying, or falls, rather than being set down
    refined: bool = False  # whether that is so only at half the step and twice the iterations
    pressed: BodyId | None = None  # the brick that the hand with the first has pressed into what does not give way
    too_much: str = ""  # what is more work than a run may take: the brick is one of those that move

    def in_words(self) -> str:
        """What cannot go on, and why."""
        if self.too_much:
            return self.too_much
        if self.pressed is not None:
            if self.pressed == self.by:
                behind = f"it is {mm(self.depth, 3)} behind, and what is in its way does not give way"
                return f"the hand cannot move brick '{self.brick}' on at {self.time:.3f} s: {behind}"
            into = f"'{self.pressed}' is pressed {mm(self.depth, 3)} into '{self.by}', which does not give way"
            return f"the hand cannot move brick '{self.brick}' on at {self.time:.3f} s: {into}"
        where = f"'{self.by}' has moved there ({mm(self.depth, 3)} of overlap)"
        return f"brick '{self.brick}' cannot be placed at {self.time:g} s: {where}"


class BlockedPlacementError(RuntimeError):
    """A brick is to be placed where another one is by now."""

    def __init__(self, blocked: Blocked) -> None:
        super().__init__(blocked.in_words())
        self.blocked = blocked


def require_clearance(placement: Placement, watch: BrickTracker) -> None:
    """Raise the error if a brick has no room; one that is slid in may also be in the way of what gave a little."""
    anywhere = placement.arrival is Arrival.SLID_IN or watch.hit or placement.hits
    others = [watch.bricks[name] for name in watch.present] if anywhere else watch.dropped
    own = placement.brick.id
    inside = {other.placement.brick.id: _depth(placement, other) for other in others if other.placement.brick.id != own}
    inside = {name: depth for name, depth in inside.items() if depth > MOST_OVERLAP}
    # What tips or creeps without falling comes up from below: an engine pushes out of it what is not halfway inside.
    halfway = 0.5 * placement.brick.shape.least_thickness
    tipped = {name: _depth(placement, other) for name, other in watch.shifted.items() if name != own}
    inside |= {name: depth for name, depth in tipped.items() if depth > halfway}
    deepest = max(inside, key=inside.__getitem__, default=None)
    if deepest is not None:
        raise BlockedPlacementError(Blocked(own, placement.time, deepest, inside[deepest], placement.hits))


def _depth(placement: Placement, other: TrackedBrick) -> float:
    """How far the brick would be inside another one [m]."""
    brick, own = other.placement.brick, placement.brick.shape
    pose = placement.came or placement.pose
    if dist(pose.position_W, other.last.position_W) > own.bounding_radius + brick.shape.bounding_radius:
        return -inf
    return -apart(placement.brick.shape, pose, brick.shape, other.last).gap
