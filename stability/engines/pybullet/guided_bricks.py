"""Bricks that somebody outside moves: a body of PyBullet without mass moves nothing, so these get much of it.

In each engine step such a brick is given its speed anew, and what gravity adds in that step is taken off before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stability.engines.prescribed import FIRM
from stability.engines.pybullet.brick_bodies import BrickBodies
from stability.geometry.vectors import add_scaled
from stability.model import AT_REST, BodyId, Vec3


@dataclass
class GuidedBricks:
    """Which bricks are guided, and how fast."""

    bricks: BrickBodies
    _velocities_W: Mapping[BodyId, Vec3] = field(default_factory=dict, init=False)  # [m/s]

    def follow(self, velocities_W: Mapping[BodyId, Vec3]) -> None:
        """Guide these from now on [m/s], and no others."""
        before, self._velocities_W = self._velocities_W, dict(velocities_W)
        for brick in before:
            if brick not in velocities_W and brick in self.bricks.own.bricks and not self.bricks.holds(brick):
                self.bricks.weigh(brick, 1.0)
                self.bricks.comes_free(brick)
        for brick in velocities_W:
            if brick not in before:
                self.bricks.stays(brick)  # as for falling
            self.bricks.weigh(brick, FIRM)  # each time, for it may have got another body

    def exert(self, pull_W: Vec3, duration: float) -> None:
        """Give them their speeds before an engine step of a duration [s] in which all is pulled by so much [m/s2]."""
        for brick, velocity_W in self._velocities_W.items():
            self.bricks.bodies.set_motion(brick, add_scaled(velocity_W, -duration, pull_W), AT_REST)
