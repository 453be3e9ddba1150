"""When a brick counts as at rest, so that it may be judged.

Frozen means held fixed in the engine because the model says that the brick stands; it still collides.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from math import hypot, inf
from typing import Self

from stability.model import BodyId, BodyState
from stability.watching.life_cycle import BrickObserver

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
