"""Applies the dead load of frozen bricks to bricks that an engine moves."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Protocol

from stability.dynamics.rigid_body import AppliedForce, FreeBody, friction_impulses
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, rotate, subtract
from stability.model import AT_REST, BodyId, BodyState, Brick, Quaternion, Vec3

# Loads on moving bricks from bodies outside the engine, applied at every engine step.
#
# An engine takes it as forces, or as the change of motion that they come to, before it solves its contacts.


class Moving(Protocol):
    """The bodies of an engine, as they move."""

    def states(self, names: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Poses and motions."""


@dataclass(frozen=True, slots=True)
class _Load:
    """What presses on one brick."""

    brick: Brick
    at_B: Sequence[
        tuple[AppliedForce, Vec3]
    ]  # each with where it acts, seen from the centre and in axes of the brick [m]


@dataclass
class Presses:
    """The loads on the bricks of an engine."""

    _loads: dict[BodyId, _Load] = field(default_factory=dict, init=False)

    def apply_forces(self, brick: Brick, state: BodyState, pressed: Sequence[AppliedForce]) -> None:
        """Let these forces, and no others, act on a brick from now on, each at its point of the brick."""
        if not pressed:
            self.leave(brick.id)
            return
        turn = inverse(state.pose.orientation)
        self._loads[brick.id] = _Load(
            brick, [(each, rotate(turn, subtract(each.at_W, state.pose.position_W))) for each in pressed]
        )

    def leave(self, brick: BodyId) -> None:
        """Let nothing press on a brick any more."""
        self._loads.pop(brick, None)

    def acting(self, bodies: Moving, duration: float) -> Iterator["Acting"]:
        """What acts on each brick that is pressed in the coming engine step of a duration [s]."""
        for name, state in bodies.states(self._loads.keys()).items() if self._loads else ():
            load, pose = self._loads[name], state.pose
            pressed = [
                replace(each, at_W=add(pose.position_W, rotate(pose.orientation, at_B))) for each, at_B in load.at_B
            ]
            rubbed = friction_impulses(load.brick, state, pressed, duration)
            yield Acting(
                load.brick,
                state,
                [
                    (add_scaled(impulse, duration, each.force_W), each.at_W)
                    for each, impulse in zip(pressed, rubbed, strict=True)
                ],
            )


@dataclass(frozen=True, slots=True)
class Acting:
    """What acts on a brick in a step."""

    brick: Brick
    state: BodyState  # before the step
    impulses: Sequence[tuple[Vec3, Vec3]]  # each in W [N s], with the point of W at which it acts [m]

    def pushed(self) -> BodyState:
        """The motion of the brick after all of it."""
        free = FreeBody.of(self.brick, self.state.pose)
        velocity_W, spin_W = self.state.velocity_W, self.state.angular_velocity_W
        for impulse_W, at_W in self.impulses:
            velocity_W, spin_W = free.after(velocity_W, spin_W, impulse_W, at_W)
        return replace(self.state, velocity_W=velocity_W, angular_velocity_W=spin_W)

    def wrench(self, duration: float) -> tuple[Vec3, Vec3]:
        """The mean force over a duration [N], and its torque about the centre of the brick [N m], in W."""
        force, torque = AT_REST, AT_REST
        for impulse_W, at_W in self.impulses:
            force = add_scaled(force, 1.0 / duration, impulse_W)
            arm = subtract(at_W, self.state.pose.position_W)
            torque = add_scaled(torque, 1.0 / duration, cross(arm, impulse_W))
        return force, torque


# The shortest turn from one direction to another, by which a plane is turned to its normal.


OPPOSITE = -1.0 + 1e-12  # cosine below which any turn by 180 deg is the shortest


def shortest_turn(before: Vec3, after: Vec3) -> Quaternion:
    """The shortest turn that takes one unit vector to another."""
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
