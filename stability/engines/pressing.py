"""What presses on bricks that an engine moves, and is no body with weight there: it is told to every engine step.

It is told as a change of motion, before the engine solves its contacts. Forces would be the usual way, but PyBullet
leaves their torque out when it works out what friction must stop, and a brick pressed on one side then slides away.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add, add_scaled, subtract
from stability.mechanics.impulse import pushed
from stability.mechanics.rubbing import Pressed, friction_impulses
from stability.model import BodyId, BodyState, Brick, Vec3


class Moving(Protocol):
    """The bodies of an engine, as they move."""

    def states(self, names: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        """Poses and motions."""

    def set_motion(self, name: BodyId, velocity_W: Vec3, angular_velocity_W: Vec3) -> None:
        """Give a body a velocity of its centre [m/s] and an angular velocity [rad/s]."""


@dataclass(frozen=True, slots=True)
class _Load:
    """What presses on one brick."""

    brick: Brick
    at_B: Sequence[tuple[Pressed, Vec3]]  # each with where it acts, seen from the centre and in axes of the brick [m]


@dataclass
class Presses:
    """The loads on the bricks of an engine."""

    _loads: dict[BodyId, _Load] = field(default_factory=dict, init=False)

    def press(self, brick: Brick, state: BodyState, pressed: Sequence[Pressed]) -> None:
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

    def exert(self, bodies: Moving, duration: float) -> None:
        """Give bricks the impulses of what presses on them in the coming engine step of a duration [s]."""
        if not self._loads:
            return
        for name, state in bodies.states(self._loads.keys()).items():
            load, pose = self._loads[name], state.pose
            pressed = [
                replace(each, at_W=add(pose.position_W, rotate(pose.orientation, at_B))) for each, at_B in load.at_B
            ]
            rubbed = friction_impulses(load.brick, state, pressed, duration)
            after = state
            for each, impulse in zip(pressed, rubbed, strict=True):
                after = pushed(after, load.brick, add_scaled(impulse, duration, each.force_W), each.at_W)
            bodies.set_motion(name, after.velocity_W, after.angular_velocity_W)
