"""Toppling: a part turns about an axis as one body, for as long as it is proven to hold together and to hit nothing."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import radians

from stability.model import BodyId, BodyState, Plane
from stability.motion.falling_part import FallingPart, falling_part, holds_together, is_clear, part_in_motion, reach
from stability.statics.facts import Motion, Placed, Problem

# It is proven that a part holds together at every fifth degree; it is parted at the last at which it does. Later the
# weight turns against the layers, and what reaches farther than 30 deg has hit something in most cases.
STAGE, FURTHEST = radians(5.0), radians(30.0)
ROUNDING = 1e-9  # share of an angle: stages are sums of angles
# A part is looked at so often that no corner of it passes more than this share of the smallest side unseen.
UNSEEN = 0.5


@dataclass
class Toppling:
    """A part that turns about one axis."""

    part: FallingPart
    others: Collection[Placed]  # what it may hit
    planes: Collection[Plane]
    pitch: float  # between the angles at which it is looked at [rad]
    angle: float = 0.0  # [rad]
    speed: float = 0.0  # of the angle [rad/s]
    _clear: float = 0.0  # the angle up to which nothing is hit [rad]
    _stage: float = 0.0  # up to which it is proven to hold together

    def goes_on(self, duration: float) -> bool:
        """Turn for a short time [s]; False, and not at all, if it is not proven that it does as one body."""
        angle, speed = self.part.pendulum.after(self.angle, self.speed, duration)
        while angle > self._clear:
            if not self._looked_further():
                return False
        self.angle, self.speed = angle, speed
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Where its bricks are, and how they move."""
        return part_in_motion(self.part, self.angle, self.speed)

    def take_landed(self) -> Sequence[BodyId]:
        """None: an engine takes over before anything rests again."""
        return ()

    def _looked_further(self) -> bool:
        if self._clear >= self._stage:
            stage = self._stage + STAGE
            if stage > FURTHEST * (1.0 + ROUNDING) or not holds_together(self.part, stage):
                return False
            self._stage = stage
        further = min(self._stage, self._clear + self.pitch)
        if not is_clear(self.part, further, self.others, self.planes):
            return False
        self._clear = further
        return True


def toppling_of(
    problem: Problem, motion: Motion, gravity: float, others: Collection[Placed], planes: Collection[Plane]
) -> Toppling | None:
    """How what begins to move topples; None if it is not one turn about one axis, or not proven to be one body.

    `others` and `planes` are what it may hit, what it turns on included.
    """
    part = falling_part(problem, motion, gravity)
    if part is None or not holds_together(part, 0.0):
        return None
    moving = [problem.bricks[name] for name in sorted(part.moving)]
    smallest = min(placed.brick.shape.least_thickness for placed in (*moving, *others))
    return Toppling(part, others, planes, UNSEEN * smallest / reach(part))
