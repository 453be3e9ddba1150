"""What presses on bricks that is not in the client as a body with weight: it is told to every engine step."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from stability.engines.pybullet.client_bodies import ClientBodies
from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import add, add_scaled, subtract
from stability.mechanics.impulse import pushed
from stability.mechanics.rubbing import Pressed, friction_impulses
from stability.model import BodyId, Brick, Vec3


@dataclass(frozen=True, slots=True)
class _Load:
    """What presses on one brick."""

    brick: Brick
    at_B: Sequence[tuple[Pressed, Vec3]]  # each with where it acts, seen from the centre and in axes of the brick [m]


@dataclass
class Presses:
    """The loads on the bodies of a client."""

    bodies: ClientBodies
    _loads: dict[BodyId, _Load] = field(default_factory=dict, init=False)

    def press(self, brick: Brick, pressed: Sequence[Pressed]) -> None:
        """Let these forces, and no others, act on a brick from now on."""
        if not pressed:
            self.leave(brick.id)
            return
        pose = self.bodies.states([brick.id])[brick.id].pose
        turn = inverse(pose.orientation)
        at_B = [(each, rotate(turn, subtract(each.at_W, pose.position_W))) for each in pressed]
        self._loads[brick.id] = _Load(brick, at_B)

    def leave(self, body: BodyId) -> None:
        """Let nothing press on a body any more."""
        self._loads.pop(body, None)

    def exert(self, duration: float) -> None:
        """Give bricks the impulses of what presses on them in the coming engine step of a duration [s].

        As a change of their motion, since PyBullet leaves the torque of forces out of what it takes friction to stop.
        """
        if not self._loads:
            return
        for name, state in self.bodies.states(self._loads).items():
            load, pose = self._loads[name], state.pose
            pressed = [
                replace(each, at_W=add(pose.position_W, rotate(pose.orientation, at_B))) for each, at_B in load.at_B
            ]
            rubbed = friction_impulses(load.brick, state, pressed, duration)
            for each, impulse in zip(pressed, rubbed, strict=True):
                state = pushed(state, load.brick, add_scaled(impulse, duration, each.force_W), each.at_W)
            self.bodies.set_motion(name, state.velocity_W, state.angular_velocity_W)
