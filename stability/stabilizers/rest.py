"""Decides when a brick counts as at rest, and when an unproven brick is judged again."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from math import dist, hypot, inf, sqrt
from typing import Self, TypeAlias

from stability.engines.protocol import Engine
from stability.engines.scene_scale import USUAL_DIAGONAL, USUAL_SIDE
from stability.model import BodyId, BodyState, ConvexShape, Pose, convex
from stability.stabilizers.protocol import BrickObserver

# Decides when a brick counts as at rest, so that it may be judged.
#
# Frozen means held fixed in the engine because the model says that the brick stands; it still collides.


ROUNDING = 1e-9  # [s], far below any time step: clocks are sums of steps


class Activity(Enum):
    """What the extension does with a brick."""

    FREE = "free"  # the engine moves it; it is tested whenever it is slow
    UNSTABLE = "unstable"  # woken by a failed test: not tested again until it has been slow for a while
    FROZEN = "frozen"  # part of the stack


@dataclass(frozen=True, slots=True)
class RestLimits:
    """What counts as not moving.

    The source sets a threshold on speed and turning without giving it. The two spans of time are ours. `dwell`: a brick
    in flight is slow at its highest point, for 2 speed / g = 1 ms, and would be frozen in the air. `hold_off`: a brick
    woken from a stack starts at rest, passes the test of a single brick at the next step, and would be frozen again
    before it can move; a failing tower would hang in the air. A slow topple shows within a tenth of a second.
    """

    speed: float = 0.005  # [m/s] of the centre of mass; a solver's noise on a plank at rest is a tenth of it
    angular_speed: float = 0.1  # [rad/s]; the end of a plank then moves at about `speed`
    dwell: float = 0.002  # [s] a brick is slow before it is tested
    hold_off: float = 0.1  # [s] a woken brick is still before it is tested
    still: float = 0.2  # share of the limits for a woken brick: a tower that tips by a hair is faster

    def slow(self, state: BodyState, share: float = 1.0) -> bool:
        """Whether a brick in this state is slower than a share of the limits."""
        speed, rate = hypot(*state.velocity_W), hypot(*state.angular_velocity_W)
        return speed < share * self.speed and rate < share * self.angular_speed

    def scaled(self, lengths: float, times: float) -> "RestLimits":
        """The same limits for a scene whose lengths and times are so many times larger."""
        return replace(
            self,
            speed=self.speed * lengths / times,
            angular_speed=self.angular_speed / times,
            dwell=self.dwell * times,
            hold_off=self.hold_off * times,
        )


@dataclass(frozen=True, slots=True)
class Evidence:
    """What was seen of one brick in one pass."""

    stands: bool = False  # it was tested and rests stably on the stack
    fails: bool = False  # it, or something below it, failed the stack test
    slow_for: float = 0.0  # how long it has been slow without a break [s]


def next_activity(now: Activity, seen: Evidence, limits: RestLimits) -> Activity:
    """The only steps: FREE -> FROZEN -> UNSTABLE -> FREE."""
    if now is Activity.FREE and seen.stands:
        return Activity.FROZEN
    if now is Activity.FROZEN and seen.fails:
        return Activity.UNSTABLE
    if now is Activity.UNSTABLE and seen.slow_for >= limits.hold_off:
        return Activity.FREE
    return now


@dataclass
class Stillness(BrickObserver):
    """How long each brick that the engine moves has been slow, and whether it may be judged by now."""

    limits_of: Callable[[BodyId], RestLimits]
    handled: Collection[BodyId] = field(default=(), init=False)  # that hands may move: they are not judged
    _activity: dict[BodyId, Activity] = field(default_factory=dict, init=False)
    _slow_since: dict[BodyId, float] = field(default_factory=dict, init=False)

    def follow(self, now: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in the awake bricks as they are now."""
        for brick, state in states.items():
            woken = self._activity.get(brick) is Activity.UNSTABLE
            limits = self.limits_of(brick)
            if not limits.slow(state, limits.still if woken else 1.0):
                self._slow_since.pop(brick, None)
                continue
            since = self._slow_since.setdefault(brick, now)
            self._step(brick, Evidence(slow_for=now - since))

    def may_be_judged(self, brick: BodyId, now: float) -> bool:
        """Whether a brick has been slow for long enough."""
        if brick in self.handled:
            return False
        long_ago = now - self.limits_of(brick).dwell + ROUNDING
        return self._slow_since.get(brick, inf) <= long_ago and self._activity.get(brick) is not Activity.UNSTABLE

    def set_down(self, bricks: Collection[BodyId]) -> None:
        """A brick that is set down at rest counts as having always been slow."""
        self._slow_since |= dict.fromkeys(bricks, -inf)

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """What is frozen has passed its test."""
        for brick in bricks:
            self._step(brick, Evidence(stands=True))

    def woken(self, bricks: Collection[BodyId]) -> None:
        """What is woken cannot stand, and has to be still for a while before it is tested again."""
        for brick in bricks:
            self._slow_since.pop(brick, None)
            self._step(brick, Evidence(fails=True))

    def gone(self, bricks: Collection[BodyId]) -> None:
        """Nothing is known of a brick that may come back under the same name."""
        for brick in bricks:
            self._activity.pop(brick, None)
            self._slow_since.pop(brick, None)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._activity |= other._activity
        self._slow_since |= other._slow_since

    def _step(self, brick: BodyId, seen: Evidence) -> None:
        self._activity[brick] = next_activity(self._activity.get(brick, Activity.FREE), seen, self.limits_of(brick))


# Rest limits of each brick by its own size.


# Of the usual brick's proportions. An engine steps by diagonals, and so shakes what is flatter as much as this.
SHEET = 0.1
LimitsOf: TypeAlias = Callable[[BodyId], RestLimits]


@dataclass
class LimitsBySize(BrickObserver):
    """Limits that were chosen for the usual brick, scaled to each brick of an engine (Froude)."""

    engine: Engine
    usual: RestLimits
    _of: dict[BodyId, RestLimits] = field(default_factory=dict, init=False)

    def __call__(self, brick: BodyId) -> RestLimits:
        """The limits of a brick; the usual ones of what is no solid."""
        limits = self._of.get(brick)
        if limits is None:
            shape = convex(self.engine.shape(brick))
            size = 1.0 if shape is None else times_the_usual(shape)
            limits = self._of[brick] = self.usual.scaled(lengths=size, times=sqrt(size))
        return limits

    def gone(self, bricks: Collection[BodyId]) -> None:
        """A brick of another size may come back under the same name."""
        for brick in bricks:
            self._of.pop(brick, None)


def times_the_usual(shape: ConvexShape) -> float:
    """How many times the usual brick a brick is, by its smallest side; a sheet is held to what an engine can do."""
    return max(shape.least_thickness / USUAL_SIDE, SHEET * 2.0 * shape.bounding_radius / USUAL_DIAGONAL)


# Decides when to judge unproven bricks at rest again: a verdict changes only if a pose does.


# Share of its smallest side that a brick must move by to be news: a quarter of the gap that still counts as contact,
# so that a contact which the engine is closing is not missed.
MOVED = 0.005
MOMENT = 0.1  # share of the hold-off for which nothing is asked while bricks at rest touch moving ones
RETRY = 10.0  # times the hold-off after which everything is news again


@dataclass(frozen=True, slots=True)
class _Refusal:
    pose: Pose
    time: float  # [s]
    changes: int  # how often what is frozen had changed by then


@dataclass
class Refusals(BrickObserver):
    """Where and when bricks were not proven."""

    limits_of: Callable[[BodyId], RestLimits]  # their hold-off is between one attempt that refused a brick and the next
    _changes: int = field(default=0, init=False)  # how often what is frozen has changed
    _not_before: float = field(default=0.0, init=False)  # [s] time of the next attempt
    _of: dict[BodyId, _Refusal] = field(default_factory=dict, init=False)

    def may_ask(self, now: float) -> bool:
        """Whether the last refusal is long enough ago for another attempt."""
        return now >= self._not_before

    def is_news(self, brick: BodyId, pose: Pose, smallest_side: float, now: float) -> bool:
        """Whether a brick was not refused yet, or something has changed since."""
        refused = self._of.get(brick)
        if (
            refused is None
            or refused.changes != self._changes
            or now >= refused.time + RETRY * self.limits_of(brick).hold_off
        ):
            return True
        return dist(refused.pose.position_W, pose.position_W) > MOVED * smallest_side

    def refuse(self, poses: Iterable[tuple[BodyId, Pose]], now: float) -> None:
        """Remember where bricks are that were not proven."""
        refused = {brick: _Refusal(pose, now, self._changes) for brick, pose in poses}
        self._of |= refused
        if refused:
            self._not_before = now + min(self.limits_of(brick).hold_off for brick in refused)

    def wait(self, now: float, bricks: Iterable[BodyId]) -> None:
        """Ask nothing for a moment, because some of these bricks rest, and touch others that still move."""
        moment = min((MOMENT * self.limits_of(brick).hold_off for brick in bricks), default=0.0)
        self._not_before = max(self._not_before, now + moment)

    def changed(self) -> None:
        """What is frozen, or what that rests on, is no longer what it was when bricks were refused."""
        self._changes += 1

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """There is more to stand on, and what was refused before is proven."""
        self._left(bricks)

    def woken(self, bricks: Collection[BodyId]) -> None:
        """There is less to stand on."""
        if bricks:
            self.changed()

    def gone(self, bricks: Collection[BodyId]) -> None:
        """There may be less to stand on, and a new brick under an old name was never refused."""
        self._left(bricks)

    def absorb(self, other: Self) -> None:
        """The bricks of another come into this engine."""
        self._of |= other._of
        self._not_before = max(self._not_before, other._not_before)
        self.changed()

    def _left(self, bricks: Collection[BodyId]) -> None:
        """These are not among the bricks that wait for a proof any more."""
        if bricks:
            self.changed()
        for brick in bricks:
            self._of.pop(brick, None)
