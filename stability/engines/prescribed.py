"""What moves in a world as somebody outside says, whatever it meets: the ground with all that is fixed."""

from dataclasses import dataclass

from stability.model import AT_REST, Vec3


@dataclass
class PrescribedMotion:
    """What a world reads before each step; whoever steps it writes it."""

    # Of all that is fixed [m/s2]. All is told as seen from there: bodies feel their mass times that, the other way.
    acceleration_W: Vec3 = AT_REST
