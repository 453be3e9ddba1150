"""What an impulse does to a free brick: Newton and Euler for a homogeneous box."""

from dataclasses import replace

from stability.geometry.rotations import rotate
from stability.geometry.vectors import add, add_scaled, cross, subtract
from stability.model import BodyState, Vec3


def pushed(state: BodyState, size: Vec3, mass: float, impulse_W: Vec3, at_W: Vec3) -> BodyState:
    """The motion of a brick of this size [m] and mass [kg] after an impulse [N s] at a point of W [m]."""
    x, y, z, w = state.pose.orientation
    twist = rotate((-x, -y, -z, w), cross(subtract(at_W, state.pose.position_W), impulse_W))  # in body axes [N m s]
    a, b, c = moments(size, mass)
    return replace(
        state,
        velocity_W=add_scaled(state.velocity_W, 1.0 / mass, impulse_W),
        angular_velocity_W=add(
            state.angular_velocity_W, rotate(state.pose.orientation, (twist[0] / a, twist[1] / b, twist[2] / c))
        ),
    )


def moments(size: Vec3, mass: float) -> Vec3:
    """The moments of inertia of a homogeneous box about its axes [kg m2]."""
    a, b, c = (side * side for side in size)
    return (mass * (b + c) / 12.0, mass * (a + c) / 12.0, mass * (a + b) / 12.0)
