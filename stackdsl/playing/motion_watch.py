"""Which bricks still move? Those that got too far between two looks, within the last tenth of a second, to be at rest.

The limits are those beyond which nothing is frozen (`RestLimits`): 5 mm/s and 0.1 rad/s for a KAPLA plank on earth, ten
times the noise of a solver. They go with each brick's own size and with gravity (Froude): speeds with the root of size
times gravity, times with that of size by gravity. So long, since what rocks stands still where it turns back. Between
looks, since what a solver shakes within a step is fast and gets nowhere.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import sqrt

from stability.engines.scene_scale import USUAL_GRAVITY
from stability.geometry.rotations import turn_between
from stability.geometry.vectors import scale, subtract
from stability.model import BodyId, BodyState, Brick, Pose
from stability.watching.limits_by_size import times_the_usual
from stability.watching.rest import RestLimits


@dataclass
class MotionWatch:
    """When each brick was last seen to move."""

    gravity: float  # [m/s2]
    _seen: dict[BodyId, tuple[float, Pose]] = field(default_factory=dict)  # last [s]
    _limits: dict[BodyId, RestLimits] = field(default_factory=dict)
    _moved_at: dict[BodyId, float] = field(default_factory=dict)  # [s]

    def add(self, brick: Brick) -> None:
        """A brick has come."""
        size = times_the_usual(brick.shape)
        self._limits[brick.id] = RestLimits().scaled(size, sqrt(size * USUAL_GRAVITY / self.gravity))

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        """Take in all that may move; returns what did."""
        moved = []
        for name, state in states.items():
            if name in self._seen and not self._limits[name].slow(_between(*self._seen[name], time, state.pose)):
                self._moved_at[name] = time
                moved.append(name)
            self._seen[name] = (time, state.pose)
        return moved

    def stopped(self, bricks: Iterable[BodyId]) -> None:
        """These are held fixed, or gone."""
        for name in bricks:
            self._moved_at.pop(name, None)
            self._seen.pop(name, None)

    def moving(self, now: float) -> tuple[BodyId, ...]:
        """Those that still move, in the order in which they came."""
        moved_at, limits = self._moved_at, self._limits
        return tuple(name for name in limits if name in moved_at and now - moved_at[name] < limits[name].hold_off)


def _between(before: float, then: Pose, now: float, here: Pose) -> BodyState:
    """As fast as it was on the way from one pose to the other, at these times [s]."""
    per_second = 1.0 / (now - before) if now > before else 0.0
    velocity_W = scale(per_second, subtract(here.position_W, then.position_W))
    return BodyState(here, velocity_W, (0.0, 0.0, per_second * turn_between(then, here)))
