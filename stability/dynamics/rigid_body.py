"""What impulses and rubbing contacts do to a free brick."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

from stability.contact_law import Coulomb
from stability.geometry.placed_shape import principal_turn
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, norm, rotate, scale, subtract
from stability.model import AT_REST, BodyState, Brick, Pose, Quaternion, Vec3

# The change of velocity of a free brick by an impulse: Newton and Euler for a homogeneous solid.


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


# Friction of a brick that moves against bodies that press on it and do not move themselves.
#
# Coulomb's law at each point: friction stops the point if it can, and else opposes its motion with all that it has.
# What stops it is found by sequential impulses, as engines do, from the velocity that the brick has. What is told so to
# an engine comes a step late: where its own contacts cannot hold a brick that something pushes steadily, and this
# friction could, the brick creeps by what it gains in a step. It never pushes a brick that rests.


SWEEPS = 4  # over the points; more change the way of a plank that slides by less than a thousandth
SETTLED = 1e-4  # share of the most that friction can do at a point: what changes by less has settled


@dataclass(frozen=True, slots=True)
class AppliedForce:
    """What presses on a point of a brick, and rubs on it."""

    force_W: Vec3  # along the normal [N]
    at_W: Vec3  # [m]
    friction: float  # Coulomb coefficient


def friction_impulses(brick: Brick, state: BodyState, pressed: Sequence[AppliedForce], duration: float) -> list[Vec3]:
    """The impulse of friction at each point while forces press for a duration [s], in W [N s]."""
    free, found = FreeBody.of(brick, state.pose), [AT_REST] * len(pressed)
    velocity_W, spin_W = state.velocity_W, state.angular_velocity_W
    for _ in range(SWEEPS):
        settled = True
        for index, each in enumerate(pressed):
            wanted = subtract(found[index], _impulse_of_sliding(free, velocity_W, spin_W, each))
            most, length = Coulomb(each.friction).greatest_friction(norm(each.force_W)) * duration, norm(wanted)
            allowed = scale(most / length, wanted) if length > most else wanted
            more = subtract(allowed, found[index])
            if norm(more) > SETTLED * most:
                velocity_W, spin_W = free.after(velocity_W, spin_W, more, each.at_W)
                found[index], settled = allowed, False
        if settled:
            break
    return found


def _impulse_of_sliding(free: FreeBody, velocity_W: Vec3, spin_W: Vec3, each: AppliedForce) -> Vec3:
    """The impulse at a point that would give it the sideways velocity that it has [N s]."""
    arm = subtract(each.at_W, free.position_W)
    velocity = add(velocity_W, cross(spin_W, arm))
    normal_W = scale(1.0 / norm(each.force_W), each.force_W)
    sideways = add_scaled(velocity, -dot(velocity, normal_W), normal_W)
    speed = norm(sideways)
    if speed == 0.0:
        return AT_REST
    along = scale(1.0 / speed, sideways)
    moved, turned = free.after(AT_REST, AT_REST, along, each.at_W)
    by_one = dot(add(moved, cross(turned, arm)), along)  # [m/s] for 1 N s
    return scale(1.0 / by_one, sideways)
