"""The ground of one run, which may shake: what the world is told of it before each step."""

from dataclasses import dataclass
from math import hypot

from stability.engines.protocol import World
from stability.mechanics.ground_motion import GroundMotion
from stability.model import AT_REST


@dataclass
class Ground:
    """At rest, until it begins to shake."""

    world: World
    gravity: float  # [m/s2]
    motion: GroundMotion | None = None  # None while it does not shake

    @property
    def pull(self) -> float:
        """How fast what is free gets faster at most, as seen from the ground [m/s2]."""
        if self.motion is None:
            return self.gravity
        return hypot(self.gravity, *self.motion.extremes(self.world.time()))

    def shake(self) -> bool:
        """Tell the world how the ground moves in its coming step; whether it does."""
        if self.motion is None:
            return False
        now = self.world.time()
        if now >= self.motion.ends:
            self.motion = None
            self.world.prescribed.acceleration_W = AT_REST
            return False
        self.world.prescribed.acceleration_W = self.motion.mean_W(now, self.world.settings.time_step)
        return True
