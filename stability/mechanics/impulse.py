"""What an impulse does to a free brick: Newton and Euler for a homogeneous solid."""

from dataclasses import replace

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add, add_scaled, cross, subtract
from stability.model import BodyState, Brick, Vec3
from stability.shapes.in_pose import principal_turn


def pushed(state: BodyState, brick: Brick, impulse_W: Vec3, at_W: Vec3) -> BodyState:
    """The motion of a brick after an impulse [N s] at a point of W [m]."""
    turn = principal_turn(brick.shape, state.pose.orientation)
    twist = rotate(inverse(turn), cross(subtract(at_W, state.pose.position_W), impulse_W))  # principal axes [N m s]
    a, b, c = brick.shape.moments(brick.mass)
    return replace(
        state,
        velocity_W=add_scaled(state.velocity_W, 1.0 / brick.mass, impulse_W),
        angular_velocity_W=add(state.angular_velocity_W, rotate(turn, (twist[0] / a, twist[1] / b, twist[2] / c))),
    )
