"""The work that shaking ground does on bricks, as seen from the ground: it is none that an engine added by itself.

There a brick of mass m feels -m a, so that it gets -m a dx on its way. Between two looks at it, its way is the cubic
through both places and speeds, in as many parts as it takes for the acceleration to be nearly even in each.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stability.geometry.vectors import dot
from stability.mechanics.ground_motion import GroundMotion
from stability.model import BodyId, BodyState, Brick

PARTS = 4  # of the time between two looks, of some 10 ms each


@dataclass
class GroundWork:
    """What was done on each brick since something was done last."""

    motion: GroundMotion | None = None  # None while the ground does not shake
    given: dict[BodyId, float] = field(default_factory=dict)  # [J]
    passed: dict[BodyId, float] = field(default_factory=dict)  # to and fro, all counted as more than zero [J]
    _seen: dict[BodyId, tuple[float, float, float]] = field(default_factory=dict)  # time, and place and speed along it

    def start(self) -> None:
        """Count from now on."""
        self.given, self.passed = {}, {}

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        if self.motion is None:
            return
        for name, state in states.items():
            along = self.motion.direction_W
            here = (time, dot(along, state.pose.position_W), dot(along, state.velocity_W))
            before, self._seen[name] = self._seen.get(name, here), here
            if before[0] < time and before[0] < self.motion.ends:
                work = -bricks[name].mass * self._weighed(before, here)
                self.given[name] = self.given.get(name, 0.0) + work
                self.passed[name] = self.passed.get(name, 0.0) + abs(work)

    def forget(self, brick: BodyId) -> None:
        """A brick is gone."""
        self._seen.pop(brick, None)

    def _weighed(self, before: tuple[float, float, float], here: tuple[float, float, float]) -> float:
        """The acceleration of the ground times the way through it, summed [m2/s2]."""
        assert self.motion is not None
        part, found, last = (here[0] - before[0]) / PARTS, 0.0, before[1]
        for number in range(1, PARTS + 1):
            place = _between(before, here, number / PARTS)
            found += self.motion.mean(before[0] + (number - 1) * part, part) * (place - last)
            last = place
        return found


def _between(before: tuple[float, float, float], here: tuple[float, float, float], share: float) -> float:
    """Where the cubic through two places with their speeds is after a share of the time."""
    (t0, x0, v0), (t1, x1, v1) = before, here
    s, span = share, t1 - t0
    return x0 + (x1 - x0) * s * s * (3.0 - 2.0 * s) + span * (v0 * s * (1.0 - s) ** 2 - v1 * s * s * (1.0 - s))
