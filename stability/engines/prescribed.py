"""What moves in a world as somebody outside says, whatever it meets: the ground with all that is fixed, and bricks."""

from dataclasses import dataclass, field
from typing import Final

from stability.geometry.vectors import add_scaled, dot
from stability.model import AT_REST, BodyId, BodyState, Vec3

# Times its own mass that a carried brick has in engines which know no bodies that move by themselves alone: all that it
# meets changes its speed by a millionth of what it would otherwise, and that only until the next step.
FIRM: Final = 1e6


@dataclass(frozen=True, slots=True)
class Guided:
    """How a brick moves in the coming step, whatever it meets: carried, without weight and without turning, or slid.

    What is slid keeps its weight, and all that presses on it: along `free_W` it moves by itself, and may tilt. Its own
    velocity is given to it anew in each engine step, so that it falls behind by what friction takes of that in one.
    """

    velocity_W: Vec3  # of its centre [m/s]; of what is slid, across `free_W`
    free_W: Vec3 | None = None  # unit; None if it is carried

    @property
    def carried(self) -> bool:
        """Whether it has no motion of its own."""
        return self.free_W is None

    def motion(self, own: BodyState) -> tuple[Vec3, Vec3]:
        """Velocity [m/s] and angular velocity [rad/s] that it is to have, from those that it has."""
        if self.free_W is None:
            return self.velocity_W, AT_REST
        along, about = dot(self.free_W, own.velocity_W), dot(self.free_W, own.angular_velocity_W)
        across_W = add_scaled(self.velocity_W, -dot(self.free_W, self.velocity_W), self.free_W)
        return add_scaled(across_W, along, self.free_W), add_scaled(own.angular_velocity_W, -about, self.free_W)


@dataclass
class PrescribedMotion:
    """What a world reads before each step; whoever steps it writes it."""

    # Of all that is fixed [m/s2]. All is told as seen from there: bodies feel their mass times that, the other way.
    acceleration_W: Vec3 = AT_REST
    # None of these bricks is frozen or joined. What is no longer here moves by itself, as fast as it was.
    guided: dict[BodyId, Guided] = field(default_factory=dict)
