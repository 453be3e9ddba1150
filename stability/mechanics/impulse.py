"""What an impulse does to a free brick: Newton and Euler for a homogeneous solid."""

from dataclasses import dataclass, replace
from typing import Self

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add, add_scaled, cross, subtract
from stability.model import BodyState, Brick, Pose, Quaternion, Vec3
from stability.shapes.in_pose import principal_turn


@dataclass(frozen=True, slots=True)
class FreeBody:
    """A brick in a pose, which nothing holds."""

    position_W: Vec3  # of its centre of mass [m]
    mass: float  # [kg]
    moments: Vec3  # principal ones [kg m2]
    turn: Quaternion  # of its principal axes

    @classmethod
    def of(cls, brick: Brick, pose: Pose) -> Self:
        """A brick in a pose."""
        turn = principal_turn(brick.shape, pose.orientation)
        return cls(pose.position_W, brick.mass, brick.shape.moments(brick.mass), turn)

    def after(self, velocity_W: Vec3, angular_velocity_W: Vec3, impulse_W: Vec3, at_W: Vec3) -> tuple[Vec3, Vec3]:
        """The velocity of its centre [m/s] and its spin [rad/s] after an impulse [N s] at a point of W [m]."""
        # About the principal axes [N m s].
        x, y, z = rotate(inverse(self.turn), cross(subtract(at_W, self.position_W), impulse_W))
        a, b, c = self.moments
        return (
            add_scaled(velocity_W, 1.0 / self.mass, impulse_W),
            add(angular_velocity_W, rotate(self.turn, (x / a, y / b, z / c))),
        )


def pushed(state: BodyState, brick: Brick, impulse_W: Vec3, at_W: Vec3) -> BodyState:
    """The motion of a brick after an impulse [N s] at a point of W [m]."""
    free = FreeBody.of(brick, state.pose)
    velocity_W, angular_velocity_W = free.after(state.velocity_W, state.angular_velocity_W, impulse_W, at_W)
    return replace(state, velocity_W=velocity_W, angular_velocity_W=angular_velocity_W)
