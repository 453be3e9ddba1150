"""How long each brick that the engine moves has been slow, and whether it may be judged by now."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import inf

from stability.model import BodyId, BodyState
from stability.watching.freezing import Activity, Evidence, RestLimits, next_activity

ROUNDING = 1e-9  # [s] clocks are sums of steps


@dataclass
class Stillness:
    """Follows the awake bricks of one engine from step to step."""

    limits: RestLimits
    _activity: dict[BodyId, Activity] = field(default_factory=dict, init=False)
    _slow_since: dict[BodyId, float] = field(default_factory=dict, init=False)

    def set_down(self, bricks: Iterable[BodyId]) -> None:
        """These bricks were set down at rest: they may be judged at once, before any step."""
        self._slow_since |= dict.fromkeys(bricks, -inf)

    def follow(self, now: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in the awake bricks as they are now."""
        for brick, state in states.items():
            woken = self._activity.get(brick) is Activity.UNSTABLE
            if not self.limits.slow(state, self.limits.still if woken else 1.0):
                self._slow_since.pop(brick, None)
                continue
            since = self._slow_since.setdefault(brick, now)
            self._step(brick, Evidence(slow_for=now - since))

    def may_be_judged(self, brick: BodyId, now: float) -> bool:
        """Whether a brick has been slow for long enough."""
        long_ago = now - self.limits.dwell + ROUNDING
        return self._slow_since.get(brick, inf) <= long_ago and self._activity.get(brick) is not Activity.UNSTABLE

    def froze(self, brick: BodyId) -> None:
        """A brick was frozen."""
        self._step(brick, Evidence(stands=True))

    def woke(self, brick: BodyId) -> None:
        """A brick was given back to the engine, for it cannot stand."""
        self._slow_since.pop(brick, None)
        self._step(brick, Evidence(fails=True))

    def forget(self, brick: BodyId) -> None:
        """A brick is gone, or is another one by now."""
        self._activity.pop(brick, None)
        self._slow_since.pop(brick, None)

    def _step(self, brick: BodyId, seen: Evidence) -> None:
        self._activity[brick] = next_activity(self._activity.get(brick, Activity.FREE), seen, self.limits)
