"""Bricks that somebody outside moves. A body of PyBullet without mass moves nothing, so what is carried gets much.

In each engine step such a brick is given its speed anew, and what gravity adds to it in that step is taken off before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stability.engines.prescribed import FIRM, Guided
from stability.engines.pybullet.brick_bodies import BrickBodies
from stability.geometry.vectors import add_scaled
from stability.model import BodyId, Vec3


@dataclass
class GuidedBricks:
    """Which bricks are guided, and how."""

    bricks: BrickBodies
    _guided: Mapping[BodyId, Guided] = field(default_factory=dict, init=False)

    def follow(self, guided: Mapping[BodyId, Guided]) -> None:
        """Guide these from now on, and no others."""
        before, self._guided = self._guided, dict(guided)
        for brick, was in before.items():
            left = brick not in guided and brick in self.bricks.own.bricks and not self.bricks.holds(brick)
            if left and was.carried:
                self.bricks.weigh(brick, 1.0)
                self.bricks.comes_free(brick)
        for brick, each in guided.items():
            if brick not in before:
                self.bricks.stays(brick)  # as for falling
            if each.carried:
                self.bricks.weigh(brick, FIRM)  # each time, for it may have got another body

    def exert(self, pull_W: Vec3, duration: float) -> None:
        """Give them their speeds before an engine step of a duration [s] in which all is pulled by so much [m/s2]."""
        states = self.bricks.bodies.states(self._guided)
        for brick, each in self._guided.items():
            velocity_W, angular_velocity_W = each.motion(states[brick])
            if each.carried:
                velocity_W = add_scaled(velocity_W, -duration, pull_W)
            self.bricks.bodies.set_motion(brick, velocity_W, angular_velocity_W)
