"""Follows every placed brick: where it came to rest, how far it has shifted and tilted since, and who left first."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import dist

from stability.geometry.rotations import lean_between, turn_between
from stability.model import BodyId, BodyState, Brick, Pose
from stability.statics.facts import Placed
from stability.watching.rest import RestLimits
from stackdsl.timeline import Placement
from stackdsl.trace import COLLAPSE_SHARE_OF_SMALLEST_SIDE, COLLAPSE_TILT, BrickState, BrickTrack

NOT_MOVING = RestLimits(speed=0.002, angular_speed=0.035, hold_off=0.1)  # on earth; a slow topple shows in that time
VISIBLE = 1e-3  # [m]
VISIBLE_TILT = 0.01  # [rad] 1 mm at a decimetre
READ_BACK = 1e-12  # [m] what a position loses on its way into a scaled engine and back


@dataclass
class Watched:
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
class Watch:
    """All bricks placed so far, in order of placement."""

    bricks: dict[BodyId, Watched] = field(default_factory=dict)
    dropped: list[Watched] = field(default_factory=list)  # where these lie, or what was thrown, is not known before
    made_of: dict[BodyId, Brick] = field(default_factory=dict)
    not_moving: RestLimits = NOT_MOVING  # what is dropped
    hit: bool = False  # whether something has hit the structure
    largest_shift: float = 0.0  # of any so far [m]
    present: dict[BodyId, None] = field(default_factory=dict)  # those that are not pulled out
    shifted: dict[BodyId, Watched] = field(default_factory=dict)  # visibly, be it that they have not left their places
    _left: dict[BodyId, Watched] = field(default_factory=dict)  # their places

    def add(self, placement: Placement) -> None:
        """A brick set down at rest counts as at rest there; a dropped one does so later, and a thrown one never."""
        rest, came = (placement.pose if placement.at_rest else None), placement.came or placement.pose
        watched = Watched(placement, len(self.bricks), rest, came, not_moving=self.not_moving)
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
