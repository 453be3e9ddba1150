"""How far, and how fast, does a brick go to and fro? Swaying is no creep and no shift: what sways comes back.

Of every brick that has come to rest, the way of its centre is followed along x and along y, and cut where it turns. A
swing is one way out and the way back after it; half of the shorter of both is its amplitude, and both together take its
period. So a brick that creeps has none, however far it gets. The largest swing of all bricks tells.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stability.engines.scene_scale import SAMPLING
from stability.model import BodyId, BodyState
from stackdsl.playing.watch import Watch
from stackdsl.trace import Sway

TREMBLE = 1e-4  # of a brick's smallest side: who comes back by less has not turned; a micrometre of a plank


@dataclass
class _Way:
    """Of one brick along one axis: where it turned last, and before that, and the farthest since."""

    noise: float  # [m]
    before: tuple[float, float]  # time [s] and place [m] of the last turn but one; at first, of rest
    turned: tuple[float, float] | None = None  # of the last turn
    farthest: tuple[float, float] = (0.0, 0.0)  # since
    forth: float = 0.0  # 1 or -1: which way it goes since then; 0 as long as it trembles

    def see(self, time: float, place: float) -> tuple[float, float]:
        """Amplitude [m] and period [s] of the swing that it is in, or has just ended; none of it at first."""
        if self.forth == 0.0:
            if abs(place - self.before[1]) <= self.noise:
                self.before = (time, self.before[1])
                return 0.0, 0.0
            self.forth, self.farthest = 1.0 if place > self.before[1] else -1.0, (time, place)
        if self.forth * (place - self.farthest[1]) >= 0.0:
            self.farthest = (time, place)
        elif abs(place - self.farthest[1]) > self.noise:
            self.before, self.turned = self.turned or self.before, self.farthest
            self.farthest, self.forth = (time, place), -self.forth
        if self.turned is None:
            return 0.0, 0.0
        out, back = abs(self.turned[1] - self.before[1]), abs(self.farthest[1] - self.turned[1])
        return 0.5 * min(out, back), self.farthest[0] - self.before[0]


@dataclass
class SwayMeter:
    """Looks for the largest swing, until something has left its place."""

    watch: Watch
    sway: Sway | None = None
    _ways: dict[BodyId, tuple[_Way, _Way]] = field(default_factory=dict)
    _looked: float = 0.0  # when that was last done [s]

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        if self.watch.first_to_leave() is not None:
            return
        for name, state in states.items():
            watched = self.watch.bricks[name]
            if watched.rest is None:  # nor will it ever be of what is thrown
                continue
            if name not in self._ways:
                noise = TREMBLE * watched.placement.brick.shape.least_thickness
                x, y, _ = watched.rest.position_W
                began = max(self._looked, time - SAMPLING)
                self._ways[name] = (_Way(noise, (began, x)), _Way(noise, (began, y)))
            for way, place in zip(self._ways[name], state.pose.position_W[:2], strict=True):
                amplitude, period = way.see(time, place)
                if amplitude > (self.sway.amplitude if self.sway is not None else 0.0):
                    self.sway = Sway(amplitude, 1.0 / period, name, time)
        self._looked = time
