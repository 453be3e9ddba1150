"""Response of a free brick to impulses, and to applied forces with friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

from stability.contact_law import Coulomb
from stability.geometry.placed_shape import principal_turn
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, norm, rotate, scale, subtract
from stability.model import AT_REST, BodyState, Brick, Pose, Quaternion, Vec3


@dataclass(frozen=True, slots=True)
class FreeBody:
    """Free brick at a pose: Newton's and Euler's equations for an impulse."""

    position_W: Vec3  # of the centre of mass [m]
    mass: float  # [kg]
    moments: Vec3  # principal moments of inertia [kg m2]
    turn: Quaternion  # of the principal axes

    @classmethod
    def of(cls, brick: Brick, pose: Pose) -> Self:
        """Create from a brick at a pose."""
        turn = principal_turn(brick.shape, pose.orientation)
        return cls(pose.position_W, brick.mass, brick.shape.moments(brick.mass), turn)

    def after(self, velocity_W: Vec3, angular_velocity_W: Vec3, impulse_W: Vec3, at_W: Vec3) -> tuple[Vec3, Vec3]:
        """Return the velocity of the centre [m/s] and the spin [rad/s] after an impulse [N s] at a point of W [m]."""
        # About the principal axes [N m s].
        x, y, z = rotate(inverse(self.turn), cross(subtract(at_W, self.position_W), impulse_W))
        a, b, c = self.moments
        return (
            add_scaled(velocity_W, 1.0 / self.mass, impulse_W),
            add(angular_velocity_W, rotate(self.turn, (x / a, y / b, z / c))),
        )


def pushed(state: BodyState, brick: Brick, impulse_W: Vec3, at_W: Vec3) -> BodyState:
    """Return the state of a brick after an impulse [N s] at a point of W [m]."""
    free = FreeBody.of(brick, state.pose)
    velocity_W, angular_velocity_W = free.after(state.velocity_W, state.angular_velocity_W, impulse_W, at_W)
    return replace(state, velocity_W=velocity_W, angular_velocity_W=angular_velocity_W)


# Friction of a moving brick on fixed bodies that press on it.
#
# Coulomb's law at each point: friction stops the point if it can, and otherwise opposes its motion with its limit.
# Sequential impulses, as in engines, solve it from the velocity of the brick. In an engine this acts one step late: if
# its own contacts cannot hold a steadily pushed brick and this friction could, the brick creeps by the velocity gained
# in a step. It never pushes a brick at rest.


SWEEPS = 4  # iterations over the points; more change the path of a sliding plank by less than a thousandth
SETTLED = 1e-4  # convergence: largest change of an impulse as a share of its limit


@dataclass(frozen=True, slots=True)
class AppliedForce:
    """Normal force on a point of a brick, with friction."""

    force_W: Vec3  # along the normal [N]
    at_W: Vec3  # [m]
    friction: float  # Coulomb coefficient


def friction_impulses(brick: Brick, state: BodyState, forces: Sequence[AppliedForce], duration: float) -> list[Vec3]:
    """Return the friction impulse at each point while forces act for a duration [s], in W [N s]."""
    free, impulses = FreeBody.of(brick, state.pose), [AT_REST] * len(forces)
    velocity_W, spin_W = state.velocity_W, state.angular_velocity_W
    for _ in range(SWEEPS):
        settled = True
        for index, force in enumerate(forces):
            stopping = subtract(impulses[index], _impulse_of_sliding(free, velocity_W, spin_W, force))
            limit = Coulomb(force.friction).greatest_friction(norm(force.force_W)) * duration
            length = norm(stopping)
            allowed = scale(limit / length, stopping) if length > limit else stopping
            change = subtract(allowed, impulses[index])
            if norm(change) > SETTLED * limit:
                velocity_W, spin_W = free.after(velocity_W, spin_W, change, force.at_W)
                impulses[index], settled = allowed, False
        if settled:
            break
    return impulses


def _impulse_of_sliding(free: FreeBody, velocity_W: Vec3, spin_W: Vec3, force: AppliedForce) -> Vec3:
    """Return the impulse that would give a point its tangential velocity [N s]."""
    arm = subtract(force.at_W, free.position_W)
    velocity = add(velocity_W, cross(spin_W, arm))
    normal_W = scale(1.0 / norm(force.force_W), force.force_W)
    sideways = add_scaled(velocity, -dot(velocity, normal_W), normal_W)
    speed = norm(sideways)
    if speed == 0.0:
        return AT_REST
    along = scale(1.0 / speed, sideways)
    moved, turned = free.after(AT_REST, AT_REST, along, force.at_W)
    speed_per_impulse = dot(add(moved, cross(turned, arm)), along)  # [m/s] for 1 N s
    return scale(1.0 / speed_per_impulse, sideways)
