"""Tracks every brick of a run: rest pose, drift, tilt, the first fall, and events."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, degrees, dist, hypot, inf
from typing import Protocol

from stability.geometry.placed_shape import apart
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import cross, dot, lean_between, norm, rotate, turn_between
from stability.model import BodyId, BodyState, Brick, ConvexShape, Pose
from stability.name_order import in_order
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
from stackdsl.wording import mm, opened_text


def _tilt(shape: ConvexShape, rest: Pose, now: Pose, struck: bool) -> float:
    """Return the angle by which a brick has tilted [rad].

    After a hit, a rotation about the vertical is no tilt. A round brick that rolls does not tilt either: only its axis
    counts, and a ball has none.
    """
    if not isinstance(shape, RoundSolid):
        return lean_between(rest, now) if struck else turn_between(rest, now)
    if shape.height == 0.0:
        return 0.0
    before, after = (rotate(pose.orientation, (0.0, 0.0, 1.0)) for pose in (rest, now))
    if struck:
        return abs(atan2(hypot(*after[:2]), after[2]) - atan2(hypot(*before[:2]), before[2]))
    return atan2(norm(cross(before, after)), dot(before, after))


# Tracks of placed bricks: rest pose, shift and tilt since, and the first brick that left its place.


NOT_MOVING = RestLimits(speed=0.002, angular_speed=0.035, hold_off=0.1)  # on earth; even a slow topple exceeds these
VISIBLE = 1e-3  # [m]
VISIBLE_TILT = 0.01  # [rad] 1 mm at a decimetre
READ_BACK = 1e-12  # [m] rounding of a position that is written to a scaled engine and read back


@dataclass
class TrackedBrick:
    """Track of one brick."""

    placement: Placement
    number: int  # in order of placement
    rest: Pose | None  # None until a dropped brick has come to rest
    last: Pose
    shift: float = 0.0  # [m] largest since rest
    tilt: float = 0.0  # [rad] largest since rest
    sunk: float | None = None  # [m] largest below rest; None until the first hit
    slow_since: float | None = None
    not_moving: RestLimits = NOT_MOVING
    left_at: float | None = None  # [s]
    left_by: str = ""  # motion until then, in words
    removed: bool = False
    in_hand: bool = False

    @property
    def collapse_shift(self) -> float:
        """Limit of the shift of the centre, or of its sinking after a hit [m]."""
        return COLLAPSE_SHARE_OF_SMALLEST_SIDE * self.placement.brick.shape.least_thickness

    @property
    def left_its_place(self) -> bool:
        """Whether the brick has collapsed, by the definition in trace.py."""
        return (self.shift if self.sunk is None else self.sunk) > self.collapse_shift or self.tilt > COLLAPSE_TILT

    @property
    def displaced(self) -> bool:
        """Whether a hit has shifted the brick to another place, where it stands."""
        if self.rest is None or self.sunk is None:
            return False
        return dist(self.rest.position_W, self.last.position_W) > self.collapse_shift

    def hit(self) -> None:
        """Note a hit of the structure: from now on a mere shift does not count as a collapse."""
        if self.left_at is None and self.sunk is None and not self.placement.hits:
            self.sunk = 0.0

    def see(self, time: float, state: BodyState) -> None:
        """Update the track with the current state."""
        self.last = state.pose
        if self.placement.hits or self.in_hand:
            return
        if self.rest is None:
            self._wait_for_rest(time, state)
        else:
            shift = dist(self.rest.position_W, state.pose.position_W)
            self.shift = max(self.shift, shift if shift > READ_BACK else 0.0)
            struck = self.sunk is not None
            self.tilt = max(self.tilt, _tilt(self.placement.brick.shape, self.rest, state.pose, struck))
            if self.sunk is not None:
                self.sunk = max(self.sunk, self.rest.position_W[2] - state.pose.position_W[2])
            if self.left_at is None and self.left_its_place:
                self.left_at, self.left_by = time, self._motion()

    def _motion(self) -> str:
        """Return the motion that counts as a fall, in words, as in `it has sunk 4.1 mm`."""
        way, word = (self.shift, "moved") if self.sunk is None else (self.sunk, "sunk")
        return f"{word} {mm(way, 3)}" if way > self.collapse_shift else f"tilted {degrees(self.tilt):.3g} deg"

    @property
    def lies(self) -> bool:
        """Return whether the brick fell, was thrown or was dropped, so that at rest it lies and does not stand."""
        return self.left_at is not None or self.placement.hits

    def _wait_for_rest(self, time: float, state: BodyState) -> None:
        if not self.not_moving.slow(state):
            self.slow_since = None
            return
        self.slow_since = time if self.slow_since is None else self.slow_since
        if time - self.slow_since >= self.not_moving.hold_off:
            self.rest = state.pose

    def take(self) -> None:
        """Give the brick into a hand: from now on no motion of it counts as a fall."""
        self.in_hand = True

    def let_go(self, state: BodyState) -> None:
        """Let the brick go: its current pose is its new rest pose."""
        self.in_hand, self.rest, self.last = False, state.pose, state.pose
        self.shift = self.tilt = 0.0
        self.sunk = None if self.sunk is None else 0.0

    def state(self, frozen: bool) -> BrickState:
        """Return the state at the end of the run."""
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
        """Return the track for the trace."""
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
    """Tracks of all bricks placed so far, in order of placement."""

    bricks: dict[BodyId, TrackedBrick] = field(default_factory=dict)
    dropped: list[TrackedBrick] = field(default_factory=list)  # dropped and thrown bricks, whose rest pose is open
    bodies: dict[BodyId, Brick] = field(default_factory=dict)
    not_moving: RestLimits = NOT_MOVING  # of dropped bricks
    hit: bool = False  # whether the structure was hit
    largest_shift: float = 0.0  # of any brick so far [m]
    present: dict[BodyId, None] = field(default_factory=dict)  # bricks that are not removed
    shifted: dict[BodyId, TrackedBrick] = field(default_factory=dict)  # bricks that moved visibly
    _left: dict[BodyId, TrackedBrick] = field(default_factory=dict)  # bricks that left their places

    def add(self, placement: Placement) -> None:
        """Add a brick: at rest if it is set down, later if it is dropped, never if it is thrown."""
        rest, came = (placement.pose if placement.at_rest else None), placement.came or placement.pose
        watched = TrackedBrick(placement, len(self.bricks), rest, came, not_moving=self.not_moving)
        self.bricks[placement.brick.id] = watched
        self.bodies[placement.brick.id] = placement.brick
        self.present[placement.brick.id] = None
        if rest is None:
            self.dropped.append(watched)
        if placement.hits:
            self.struck()
        elif self.hit:
            watched.hit()

    def take(self, brick: BodyId) -> None:
        """Give a brick into a hand."""
        self.bricks[brick].take()

    def let_go(self, bricks: Iterable[BodyId], states: Mapping[BodyId, BodyState]) -> None:
        """Let bricks go, in their current states."""
        for name in bricks:
            self.bricks[name].let_go(states[name])

    def struck(self) -> None:
        """Note a hit of the structure for all its bricks."""
        self.hit = True
        for watched in self.bricks.values():
            watched.hit()

    def remove(self, bricks: Iterable[BodyId]) -> None:
        """End the tracks of removed bricks."""
        for name in bricks:
            watched = self.bricks[name]
            watched.removed = True
            del self.present[name]
            self._left.pop(name, None)
            self.shifted.pop(name, None)
            if watched in self.dropped:
                self.dropped.remove(watched)

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Update the tracks of bricks that may have moved."""
        for name, state in states.items():
            watched = self.bricks[name]
            watched.see(time, state)
            self.largest_shift = max(self.largest_shift, watched.shift)
            if watched.shift > VISIBLE or watched.tilt > VISIBLE_TILT:
                self.shifted[name] = watched
            if watched.left_at is not None:
                self._left[name] = watched

    def freeze(self, bricks: Iterable[BodyId]) -> None:
        """Note that frozen bricks are at rest."""
        for name in bricks:
            self.bricks[name].rest = self.bricks[name].rest or self.bricks[name].last

    def placed_bricks(self) -> Mapping[BodyId, Placed]:
        """Return all present bricks at their last poses."""
        return {name: Placed(self.bodies[name], self.bricks[name].last) for name in self.present}

    def left(self, among: Iterable[BodyId]) -> list[BodyId]:
        """Return the bricks of `among` that have left their places."""
        return [name for name in among if name in self._left]

    def first_to_leave(self) -> BodyId | None:
        """Return the brick that has left its place, the one with the largest shift of several; None if none has."""
        left = min(self._left.values(), key=lambda watched: (-watched.shift, watched.number), default=None)
        return left.placement.brick.id if left is not None else None

    def last_built(self) -> Placement:
        """Return the last placement of the build, whose level is under construction.

        Bricks that hit, are in a hand or are slid in count only if there are no others.
        """
        bricks = list(reversed(self.bricks.values()))
        built = (brick.placement for brick in bricks if brick.placement.builds and not brick.in_hand)
        return next(built, bricks[0].placement)


# The extensions of several islands, combined to that of the whole scene.


WORST_FIRST = (Stability.UNSTABLE, Stability.UNDECIDED, Stability.STABLE)
Shares = Mapping[BodyId, Mapping[BodyId, float]]


class StabilizerState(Protocol):
    """The state of a scene by its stabilizer: the read-only part of an `Stabilizer`."""

    def awake(self) -> list[BodyId]:
        """Return the names of the bricks that an engine moves."""

    def is_frozen(self, brick: BodyId) -> bool:
        """Return whether a brick is held fixed."""

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Return, for every frozen brick or those of `bricks`, the share of its load on each of its supports."""

    def least_margin(self) -> float | None:
        """Return the smallest tipping margin of the frozen bricks [m]; None if the model has none."""

    def verdict(self) -> Verdict | None:
        """Return the verdict when bricks were last set down or removed; None without proofs."""

    def giving_way(self) -> Mapping[BodyId, str]:
        """Return the moving bricks that are proven not to stand, with the reasons."""


@dataclass(frozen=True)
class CombinedStabilizer:
    """The stabilizers of several islands as one."""

    of: Callable[[BodyId], Stabilizer | None]  # by brick
    extensions: Sequence[Stabilizer]
    acted: Sequence[Stabilizer]  # of the islands that the last action concerned

    def awake(self) -> list[BodyId]:
        """Return the names of the bricks that an engine moves."""
        return sorted(name for each in self.extensions for name in each.awake())

    def is_frozen(self, brick: BodyId) -> bool:
        """Return whether a brick is held fixed."""
        extension = self.of(brick)
        return extension is not None and extension.is_frozen(brick)

    def shares(self, bricks: Collection[BodyId] | None = None) -> Shares:
        """Return, for every frozen brick or those of `bricks`, the share of its load on each of its supports."""
        shares: dict[BodyId, Mapping[BodyId, float]] = {}
        for each in self.extensions:
            shares |= each.shares(None if bricks is None else [name for name in bricks if self.of(name) is each])
        return shares

    def least_margin(self) -> float | None:
        """Return the smallest tipping margin of the frozen bricks [m]; None if no model has one."""
        margins = [margin for each in self.extensions if (margin := each.least_margin()) is not None]
        return min(margins, default=None)

    def verdict(self) -> Verdict | None:
        """Return the worst verdict of the islands of the last action, merged if several share it."""
        verdicts = [verdict for each in self.acted if (verdict := each.verdict()) is not None]
        if not verdicts:
            return None
        worst = min((verdict.stability for verdict in verdicts), key=WORST_FIRST.index)
        return _merged([verdict for verdict in verdicts if verdict.stability is worst])

    def giving_way(self) -> Mapping[BodyId, str]:
        """Return the moving bricks that are proven not to stand, with the reasons."""
        return {name: reason for each in self.extensions for name, reason in each.giving_way().items()}


def _merged(verdicts: Sequence[Verdict]) -> Verdict:
    """Merge verdicts of the same stability."""
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


# Tracks of all bricks of a timeline, those that were not placed included.


def tracks_of(
    timeline: Timeline,
    watch: BrickTracker,
    extension: StabilizerState | None,
    unplayed: BrickState | None,
    collapsed: bool,
) -> dict[BodyId, BrickTrack]:
    """Return the track of every brick, in the order of the timeline.

    `unplayed` is the state of bricks that are not frozen if no motion is played, as only a proof was requested.
    """
    tracks = {}
    for placement in timeline.placements:
        name = placement.brick.id
        if name not in watch.bricks:
            tracks[name] = _unplaced(placement)
            continue
        frozen = extension is not None and extension.is_frozen(name)
        track = watch.bricks[name].track(frozen)
        if unplayed is not None and not frozen:
            track = replace(track, state=unplayed)
        tracks[name] = track
    if extension is None or collapsed or all(track.state is not BrickState.STANDING for track in tracks.values()):
        return tracks
    return tracks | _unsettled(tracks, extension.giving_way())


def _unsettled(tracks: Mapping[BodyId, BrickTrack], giving_way: Mapping[BodyId, str]) -> dict[BodyId, BrickTrack]:
    """Return the tracks of bricks that are proven to fall but still stand, as their fall takes longer than the run."""
    return {
        name: replace(tracks[name], state=BrickState.UNSETTLED, gives_way=reason)
        for name, reason in giving_way.items()
        if tracks[name].state is BrickState.STANDING
    }


def _unplaced(placement: Placement) -> BrickTrack:
    pose = placement.pose
    return BrickTrack(placement.brick, placement.level, BrickState.UNPLACED, pose, pose, pose, shift=0.0, tilt=0.0)


# Events of a run, counts of proofs, and the supports of each brick after its placement.


OnEvent = Callable[[Event], None]


@dataclass
class EventLog:
    """The events of one run; each is passed on at once."""

    on_event: OnEvent
    events: list[Event] = field(default_factory=list, init=False)
    edges_when_placed: dict[BodyId, tuple[Edge, ...]] = field(default_factory=dict, init=False)
    _proofs: Counter[str] = field(default_factory=Counter, init=False)  # number of bricks by proof

    def add(self, event: Event) -> None:
        """Store an event and pass it on."""
        self.events.append(event)
        self.on_event(event)

    def add_update(self, now: float, update: Update, watch: BrickTracker) -> None:
        """Add events for the bricks that the extension froze and woke in one pass."""
        stays = tuple(brick for brick in update.frozen if brick not in update.woken)
        if stays:
            self._proofs[update.proof] += len(stays)
            lying = tuple(brick for brick in stays if watch.bricks[brick].lies)
            self.add(Event(now, EventKind.FROZEN, stays, update.proof, lying=lying))
        if update.opened:
            pairs = sorted(tuple(in_order(pair)) for pair in update.opened)
            bricks = {name for pair in pairs for name in pair if name in watch.bricks}
            self.add(Event(now, EventKind.OPENED, tuple(in_order(bricks)), opened_text(pairs)))
        if update.woken:
            self.add(Event(now, EventKind.WOKEN, update.woken, update.reason, riding=update.riding))

    def close_placement(self, extension: StabilizerState, watch: BrickTracker) -> None:
        """Note the supports of the last placed bricks and the margin of the stack, before the next action."""
        if extension.awake():
            return  # moving bricks have no margin, and their supports still change
        for index in range(len(self.events) - 1, -1, -1):
            if self.events[index].kind in ACTIONS - {EventKind.PLACED}:
                return  # the placement before this action is closed already
            if self.events[index].kind is EventKind.PLACED:
                placed = self.events[index].bricks
                if any(watch.bricks[brick].placement.hits for brick in placed):
                    return  # supports of a thrown brick are not noted
                self.events[index] = replace(self.events[index], margin=extension.least_margin())
                shares = extension.shares(placed)
                self.edges_when_placed |= {brick: edges_of(brick, shares.get(brick, {})) for brick in placed}
                return

    def in_order(self) -> tuple[Event, ...]:
        """Return the events by time; islands add theirs when it is their turn."""
        return tuple(sorted(self.events, key=lambda event: event.time))

    def last_placed(self) -> tuple[BodyId, ...]:
        """Return the bricks of the last action if it placed bricks."""
        last = next((event for event in reversed(self.events) if event.kind in ACTIONS), None)
        return last.bricks if last is not None and last.kind is EventKind.PLACED else ()

    def proofs(self) -> Mapping[str, int]:
        """Return the number of proven bricks by kind of proof."""
        return {proof: count for proof, count in sorted(self._proofs.items()) if proof}


def edges_of(brick: BodyId, shares: Mapping[BodyId, float]) -> tuple[Edge, ...]:
    """Return the supports of a brick with their shares of its load."""
    return tuple(Edge(brick, on, shares[on]) for on in sorted(shares))


# A brick needs free space when it is placed. Others may have moved there during the run, unknown to the author.


# [m] a placed brick may overlap a dropped one by this depth: engines let bricks sink and creep by as much.
MOST_OVERLAP = 1e-3


@dataclass(frozen=True, slots=True)
class Blocked:
    """Reason why a run cannot go on: no free space for a brick, or too much work."""

    brick: BodyId
    time: float  # [s]
    by: BodyId
    depth: float  # [m]
    thrown: bool = False  # whether the brick is thrown or dropped rather than set down
    refined: bool = False  # whether it happens only at half the step and twice the iterations
    pressed: BodyId | None = None  # the brick that the hand with `brick` has pressed into `by`
    too_much: str = ""  # the amount of work, if it is more than a run may take; `brick` is one of the moving bricks
    unplayed: str = ""  # why the system does not play the scenario at all

    def in_words(self) -> str:
        """Return the reason in words."""
        if self.too_much or self.unplayed:
            return self.too_much or self.unplayed
        if self.pressed is not None:
            if self.pressed == self.by:
                behind = f"an immovable obstacle holds it back by {mm(self.depth, 3)}"
                return f"the hand cannot continue to move brick '{self.brick}' at {self.time:.3f} s: {behind}"
            into = f"it presses '{self.pressed}' {mm(self.depth, 3)} into '{self.by}', which does not move"
            return f"the hand cannot continue to move brick '{self.brick}' at {self.time:.3f} s: {into}"
        where = f"'{self.by}' has moved into its place, with an overlap of {mm(self.depth, 3)}"
        return f"brick '{self.brick}' cannot be placed at {self.time:g} s: {where}"


class BlockedPlacementError(RuntimeError):
    """The run cannot go on; `blocked` has the reason."""

    def __init__(self, blocked: Blocked) -> None:
        super().__init__(blocked.in_words())
        self.blocked = blocked


def require_clearance(placement: Placement, watch: BrickTracker) -> None:
    """Raise BlockedPlacementError if a brick has no free space.

    All present bricks are checked if the structure was hit or the brick is thrown or slid in; otherwise only dropped
    and visibly shifted ones.
    """
    anywhere = placement.arrival is Arrival.SLID_IN or watch.hit or placement.hits
    others = [watch.bricks[name] for name in watch.present] if anywhere else watch.dropped
    own = placement.brick.id
    inside = {other.placement.brick.id: _depth(placement, other) for other in others if other.placement.brick.id != own}
    inside = {name: depth for name, depth in inside.items() if depth > MOST_OVERLAP}
    # A brick that tips or creeps without falling rises from below. An engine pushes the placed brick out of it, unless
    # it is more than halfway inside.
    halfway = 0.5 * placement.brick.shape.least_thickness
    tipped = {name: _depth(placement, other) for name, other in watch.shifted.items() if name != own}
    inside |= {name: depth for name, depth in tipped.items() if depth > halfway}
    deepest = max(inside, key=inside.__getitem__, default=None)
    if deepest is not None:
        raise BlockedPlacementError(Blocked(own, placement.time, deepest, inside[deepest], placement.hits))


def _depth(placement: Placement, other: TrackedBrick) -> float:
    """Return the depth by which the placed brick would overlap another one [m]."""
    brick, own = other.placement.brick, placement.brick.shape
    pose = placement.came or placement.pose
    if dist(pose.position_W, other.last.position_W) > own.bounding_radius + brick.shape.bounding_radius:
        return -inf
    return -apart(placement.brick.shape, pose, brick.shape, other.last).gap
