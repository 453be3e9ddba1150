"""Movements of the fixed bodies that carry bricks."""

from collections.abc import Iterable
from dataclasses import dataclass

from stability.geometry.vectors import about, add, cross, norm, rotate, scale, subtract
from stability.model import BodyId, Pose, Vec3
from stability.problem import UP, ZERO


@dataclass(frozen=True, slots=True)
class SupportMotion:
    """Movement of the ground below some bricks: a turn about an axis through a point, and a shift."""

    bricks: tuple[BodyId, ...]
    shift_W: Vec3 = ZERO  # [m]
    turn: float = 0.0  # by the right-hand rule [rad]
    axis_W: Vec3 = UP
    centre_W: Vec3 = ZERO  # [m]

    def at(self, share: float) -> Pose:
        """Return the pose of the support after a share of its movement, from the origin of W."""
        turned = about(self.axis_W, share * self.turn)
        back = subtract(self.centre_W, rotate(turned, self.centre_W))
        return Pose(add(back, scale(share, self.shift_W)), turned)

    def reach(self, points_W: Iterable[Vec3]) -> float:
        """Return a bound of the displacements of points at the whole movement [m]."""
        arms = (norm(cross(subtract(point, self.centre_W), self.axis_W)) for point in points_W)
        return norm(self.shift_W) + abs(self.turn) * max(arms, default=0.0)
