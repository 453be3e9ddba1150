"""Criteria for a brick at rest, and for judging an unproven brick again."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from math import dist, hypot, inf, sqrt
from typing import Self, TypeAlias

from stability.engines.protocol import Engine
from stability.engines.scene_scale import USUAL_DIAGONAL, USUAL_SIDE
from stability.model import BodyId, BodyState, ConvexShape, Pose, convex
from stability.stabilizers.protocol import BrickObserver

# Criteria for a brick at rest, which may be judged.
#
# Frozen means fixed in the engine because the model judges that the brick stands; it still collides.


ROUNDING = 1e-9  # [s], far below any time step: clocks are sums of steps


class Activity(Enum):
    """State of a brick in its life cycle."""

    FREE = "free"  # moved by the engine, and tested whenever it is slow
    UNSTABLE = "unstable"  # woken by a failed test, and not tested before it has been slow for a while
    FROZEN = "frozen"  # part of the stack


@dataclass(frozen=True, slots=True)
class RestLimits:
    """Limits below which a brick counts as at rest.

    The source uses thresholds on speed and angular speed without stating them. The two durations are ours. `dwell`: a
    thrown brick is slow at its highest point, for 2 speed / g = 1 ms, and would freeze in the air. `hold_off`: a brick
    woken from a stack starts at rest, passes the test of a single brick at the next step, and would freeze again before
    it can move, so that a failing tower would hang in the air. A slow topple is visible within a tenth of a second.
    """

    speed: float = 0.005  # [m/s] of the centre of mass; the noise of a solver on a plank at rest is a tenth of it
    angular_speed: float = 0.1  # [rad/s]; the end of a plank then moves at about `speed`
    dwell: float = 0.002  # [s] a brick is slow before it is tested
    hold_off: float = 0.1  # [s] a woken brick is slow before it is tested
    still: float = 0.2  # factor of the limits for a woken brick: a tower that starts to tip is faster

    def slow(self, state: BodyState, share: float = 1.0) -> bool:
        """Check that a brick in this state is slower than a share of the limits."""
        speed, rate = hypot(*state.velocity_W), hypot(*state.angular_velocity_W)
        return speed < share * self.speed and rate < share * self.angular_speed

    def scaled(self, lengths: float, times: float) -> "RestLimits":
        """Scale the limits to a scene with lengths and times multiplied by these factors."""
        return replace(
            self,
            speed=self.speed * lengths / times,
            angular_speed=self.angular_speed / times,
            dwell=self.dwell * times,
            hold_off=self.hold_off * times,
        )


@dataclass(frozen=True, slots=True)
class Evidence:
    """Observations of one brick in one pass."""

    stands: bool = False  # passed its test, and rests stably on the stack
    fails: bool = False  # failed the stack test, or rests on a brick that did
    slow_for: float = 0.0  # time since the brick was last too fast [s]


def next_activity(now: Activity, evidence: Evidence, limits: RestLimits) -> Activity:
    """Return the next state; the transitions are FREE -> FROZEN -> UNSTABLE -> FREE."""
    if now is Activity.FREE and evidence.stands:
        return Activity.FROZEN
    if now is Activity.FROZEN and evidence.fails:
        return Activity.UNSTABLE
    if now is Activity.UNSTABLE and evidence.slow_for >= limits.hold_off:
        return Activity.FREE
    return now


@dataclass
class Stillness(BrickObserver):
    """Times since which the awake bricks have been slow, and the test for judging them."""

    limits_of: Callable[[BodyId], RestLimits]
    in_reach_of_hands: Collection[BodyId] = field(
        default=(), init=False
    )  # bricks that hands may move: they are not judged
    _activity: dict[BodyId, Activity] = field(default_factory=dict, init=False)
    _slow_since: dict[BodyId, float] = field(default_factory=dict, init=False)

    def follow(self, now: float, states: Mapping[BodyId, BodyState]) -> None:
        """Record the current states of the awake bricks."""
        for brick, state in states.items():
            woken = self._activity.get(brick) is Activity.UNSTABLE
            limits = self.limits_of(brick)
            if not limits.slow(state, limits.still if woken else 1.0):
                self._slow_since.pop(brick, None)
                continue
            since = self._slow_since.setdefault(brick, now)
            self._step(brick, Evidence(slow_for=now - since))

    def may_be_judged(self, brick: BodyId, now: float) -> bool:
        """Check that a brick has been slow for long enough."""
        if brick in self.in_reach_of_hands:
            return False
        long_ago = now - self.limits_of(brick).dwell + ROUNDING
        return self._slow_since.get(brick, inf) <= long_ago and self._activity.get(brick) is not Activity.UNSTABLE

    def is_slow_for(self, brick: BodyId, duration: float, now: float) -> bool:
        """Check that a brick has been slow for a duration [s]."""
        return self._slow_since.get(brick, inf) <= now - duration + ROUNDING

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """Count bricks that are set down at rest as slow since ever."""
        self._slow_since |= dict.fromkeys(bricks, -inf)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Record the passed test of frozen bricks."""
        for brick in bricks:
            self._step(brick, Evidence(stands=True))

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Record the failed test of woken bricks, which must be slow for a while before the next test."""
        for brick in bricks:
            self._slow_since.pop(brick, None)
            self._step(brick, Evidence(fails=True))

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the records of removed bricks: another brick may get the same name."""
        for brick in bricks:
            self._activity.pop(brick, None)
            self._slow_since.pop(brick, None)

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._activity |= other._activity
        self._slow_since |= other._slow_since

    def _step(self, brick: BodyId, evidence: Evidence) -> None:
        self._activity[brick] = next_activity(self._activity.get(brick, Activity.FREE), evidence, self.limits_of(brick))


# Rest limits by the size of a brick.


# Least thickness that the limits refer to, relative to the reference brick's proportions. The time step follows the
# diagonal, so an engine's noise on a flatter brick is as large as on this.
SHEET = 0.1
LimitsOf: TypeAlias = Callable[[BodyId], RestLimits]


@dataclass
class LimitsBySize(BrickObserver):
    """Limits of the reference brick, scaled to each brick of an engine (Froude)."""

    engine: Engine
    usual: RestLimits
    _of: dict[BodyId, RestLimits] = field(default_factory=dict, init=False)

    def __call__(self, brick: BodyId) -> RestLimits:
        """Return the limits of a brick; those of the reference brick if its shape is not convex."""
        limits = self._of.get(brick)
        if limits is None:
            shape = convex(self.engine.shape(brick))
            size = 1.0 if shape is None else relative_size(shape)
            limits = self._of[brick] = self.usual.scaled(lengths=size, times=sqrt(size))
        return limits

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop the limits of removed bricks: a brick of another size may get the same name."""
        for brick in bricks:
            self._of.pop(brick, None)


def relative_size(shape: ConvexShape) -> float:
    """Return the size of a brick relative to the reference brick: by its smallest side, for sheets by its diagonal."""
    return max(shape.least_thickness / USUAL_SIDE, SHEET * 2.0 * shape.bounding_radius / USUAL_DIAGONAL)


# Repeated judgement of unproven bricks at rest: a verdict changes only if a pose changes.


# Movement of a brick that allows another judgement, as a share of its smallest side: a quarter of the largest gap of a
# contact, so that no contact is missed that the engine is closing.
MOVED = 0.005
MOMENT = 0.1  # pause as a share of the hold-off while bricks at rest touch moving ones
RETRY = 10.0  # interval of repeated judgements without changes, as a multiple of the hold-off


@dataclass(frozen=True, slots=True)
class _Refusal:
    pose: Pose
    time: float  # [s]
    changes: int  # value of the change counter at that time


@dataclass
class Refusals(BrickObserver):
    """Poses and times at which bricks were judged without a proof."""

    limits_of: Callable[[BodyId], RestLimits]  # the hold-off is the pause after a judgement without a proof
    _changes: int = field(default=0, init=False)  # counter of changes of the frozen bricks
    _not_before: float = field(default=0.0, init=False)  # [s] earliest time of the next judgement
    _of: dict[BodyId, _Refusal] = field(default_factory=dict, init=False)

    def may_judge(self, now: float) -> bool:
        """Check that the pause since the last refusal is over."""
        return now >= self._not_before

    def has_changed(self, brick: BodyId, pose: Pose, smallest_side: float, now: float) -> bool:
        """Check that a brick was not refused yet, or that something has changed since its refusal."""
        refused = self._of.get(brick)
        if (
            refused is None
            or refused.changes != self._changes
            or now >= refused.time + RETRY * self.limits_of(brick).hold_off
        ):
            return True
        return dist(refused.pose.position_W, pose.position_W) > MOVED * smallest_side

    def refuse(self, poses: Iterable[tuple[BodyId, Pose]], now: float) -> None:
        """Record the poses of bricks that were not proven."""
        refused = {brick: _Refusal(pose, now, self._changes) for brick, pose in poses}
        self._of |= refused
        if refused:
            self._not_before = now + min(self.limits_of(brick).hold_off for brick in refused)

    def wait(self, now: float, bricks: Iterable[BodyId]) -> None:
        """Pause the judgements shortly, as some of these bricks rest and touch others that still move."""
        moment = min((MOMENT * self.limits_of(brick).hold_off for brick in bricks), default=0.0)
        self._not_before = max(self._not_before, now + moment)

    def changed(self) -> None:
        """Record a change of the frozen bricks or their supports."""
        self._changes += 1

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Record new supports, and drop the refusals of the frozen bricks."""
        self._left(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Record the loss of supports."""
        if bricks:
            self.changed()

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Record the loss of supports, and drop the refusals of the removed bricks."""
        self._left(bricks)

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._of |= other._of
        self._not_before = max(self._not_before, other._not_before)
        self.changed()

    def _left(self, bricks: Collection[BodyId]) -> None:
        """Drop the refusals of bricks."""
        if bricks:
            self.changed()
        for brick in bricks:
            self._of.pop(brick, None)
