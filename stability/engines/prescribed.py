"""What moves in a world as somebody outside says, whatever it meets: the ground with all that is fixed, and bricks."""

from dataclasses import dataclass, field
from typing import Final

from stability.model import AT_REST, BodyId, Vec3

# Times its own mass that a guided brick has in engines which know no bodies that move by themselves alone: all that it
# meets changes its speed by a millionth of what it would otherwise, and that only until the next step.
FIRM: Final = 1e6


@dataclass
class PrescribedMotion:
    """What a world reads before each step; whoever steps it writes it."""

    # Of all that is fixed [m/s2]. All is told as seen from there: bodies feel their mass times that, the other way.
    acceleration_W: Vec3 = AT_REST
    # Of bricks that are guided: they move so in the coming step, whatever they meet, without turning and without weight
    # [m/s]. None of them is frozen or joined. What is no longer here moves by itself, as fast as it was.
    velocities_W: dict[BodyId, Vec3] = field(default_factory=dict)
