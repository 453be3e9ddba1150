"""Where does what fell come down? The common centre of mass at the moment when what falls is fastest.

A tower that tips strikes the ground with its top first and all along within moments, and slides and scatters after it.
Its kinetic energy rises until the ground begins to take it. So the peak of the kinetic energy of all bricks that have
left their places tells the moment of landing, without knowing which contact was the landing.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from stability.model import BodyId, BodyState, Vec3
from stackdsl.playing.energy import kinetic_energy
from stackdsl.playing.watch import Watch
from stackdsl.trace import Landing

OVER = 0.01  # share of the largest kinetic energy; with less, what fell rocks and slides on, and brings nothing down
LANDED = 0.5  # share of the largest kinetic energy so far; below, the ground has taken the rest


@dataclass
class LandingWatch:
    """Looks for the peak while something falls."""

    watch: Watch
    falling: bool = False  # whether the peak may be near
    _now: float = 0.0  # kinetic energy of what has left its place [J]
    _most: float = 0.0  # kinetic energy of what had left its place, at the peak so far [J]
    _time: float = 0.0  # of the peak [s]
    _at: dict[BodyId, Vec3] = field(default_factory=dict)  # where all that moved was then

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Take in all that moves."""
        bricks = self.watch.bricks
        energy = sum(kinetic_energy(bricks[name].placement.brick, states[name]) for name in self.watch.left(states))
        self._now = energy
        self.falling = energy > LANDED * self._most
        if energy > self._most:
            self._most, self._time = energy, time
            self._at = {name: state.pose.position_W for name, state in states.items()}

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """The landing of these bricks; one that stood still at that moment counts with the place where it stood."""
        if not fallen or not self._at:
            return None
        mass, x, y = 0.0, 0.0, 0.0
        for name in fallen:
            watched = self.watch.bricks[name]
            before = (watched.rest or watched.last).position_W
            then = self._at.get(name, before)
            mass += watched.placement.brick.mass
            x += watched.placement.brick.mass * (then[0] - before[0])
            y += watched.placement.brick.mass * (then[1] - before[1])
        return Landing(self._time, (x / mass, y / mass), self._now < OVER * self._most)
