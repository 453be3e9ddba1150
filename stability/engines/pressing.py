"""Loads from bodies outside the engine, such as the dead load of frozen bricks, on the bricks that it moves."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Protocol

from stability.dynamics.rigid_body import AppliedForce, FreeBody, friction_impulses
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, rotate, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, Quaternion, Vec3

# An engine applies the loads at each of its steps before it solves its contacts: as forces, or as changes of velocity.


class StateSource(Protocol):
    """Source of the states of an engine's bodies."""

    def states(self, names: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Return poses and motions by name."""


@dataclass(frozen=True, slots=True)
class _Load:
    """Applied forces on one brick."""

    brick: Brick
    # Each force with its point of application, from the centre and in axes of the brick [m].
    at_B: Sequence[tuple[AppliedForce, Vec3]]


@dataclass
class AppliedLoads:
    """Loads on the bricks of an engine."""

    _loads: dict[BodyId, _Load] = field(default_factory=dict, init=False)

    def apply_forces(self, brick: Brick, state: BodyState, forces: Sequence[AppliedForce]) -> None:
        """Replace the forces on a brick; each keeps its point of the brick."""
        if not forces:
            self.leave(brick.id)
            return
        turn = inverse(state.pose.orientation)
        self._loads[brick.id] = _Load(
            brick, [(force, rotate(turn, subtract(force.at_W, state.pose.position_W))) for force in forces]
        )

    def leave(self, brick: BodyId) -> None:
        """Remove all forces on a brick."""
        self._loads.pop(brick, None)

    def forces(self, bodies: StateSource) -> Iterator[tuple[BodyId, list[AppliedForce]]]:
        """Yield each loaded brick, and the forces on it at its current pose."""
        for name, state in bodies.states(self._loads.keys()).items() if self._loads else ():
            place, turn = state.pose.position_W, state.pose.orientation
            yield (
                name,
                [replace(force, at_W=add(place, rotate(turn, at_B))) for force, at_B in self._loads[name].at_B],
            )

    def acting(self, bodies: StateSource, duration: float) -> Iterator["AppliedImpulses"]:
        """Yield the impulses on each loaded brick in the next engine step of a duration [s]."""
        for name, forces in self.forces(bodies):
            brick, (state,) = self._loads[name].brick, bodies.states([name]).values()
            friction = friction_impulses(brick, state, forces, duration)
            yield AppliedImpulses(
                brick,
                state,
                [
                    (add_scaled(impulse, duration, force.force_W), force.at_W)
                    for force, impulse in zip(forces, friction, strict=True)
                ],
            )


@dataclass(frozen=True, slots=True)
class AppliedImpulses:
    """Impulses on a brick in one step."""

    brick: Brick
    state: BodyState  # before the step
    impulses: Sequence[tuple[Vec3, Vec3]]  # each in W [N s], with the point of W at which it acts [m]

    def pushed(self) -> BodyState:
        """Return the state of the brick after all impulses."""
        free = FreeBody.of(self.brick, self.state.pose)
        velocity_W, spin_W = self.state.velocity_W, self.state.angular_velocity_W
        for impulse_W, at_W in self.impulses:
            velocity_W, spin_W = free.after(velocity_W, spin_W, impulse_W, at_W)
        return replace(self.state, velocity_W=velocity_W, angular_velocity_W=spin_W)

    def wrench(self, duration: float) -> tuple[Vec3, Vec3]:
        """Return the mean force over a duration [N] and its torque about the centre of the brick [N m], in W."""
        force, torque = AT_REST, AT_REST
        for impulse_W, at_W in self.impulses:
            force = add_scaled(force, 1.0 / duration, impulse_W)
            arm = subtract(at_W, self.state.pose.position_W)
            torque = add_scaled(torque, 1.0 / duration, cross(arm, impulse_W))
        return force, torque


OPPOSITE = -1.0 + 1e-12  # cosine below which two directions are opposite, so that any half turn is shortest


def shortest_turn(before: Vec3, after: Vec3) -> Quaternion:
    """Return the shortest rotation from one unit vector to another, which turns a plane to its normal."""
    cosine = dot(before, after)
    if cosine < OPPOSITE:
        x, y, z = before
        return _half_turn_about((0.0, -z, y) if abs(x) < abs(z) else (-y, x, 0.0))
    half = sqrt(2.0 * (1.0 + cosine))
    x, y, z = cross(before, after)
    return (x / half, y / half, z / half, half / 2.0)


def _half_turn_about(axis: Vec3) -> Quaternion:
    length = sqrt(dot(axis, axis))
    return (axis[0] / length, axis[1] / length, axis[2] / length, 0.0)
