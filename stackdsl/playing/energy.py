"""Kinetic and potential energy of all bricks, so that what an engine adds by itself shows.

Exact; of the poses and velocities that the engine has at one time. What is not looked at does not move.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from stability.geometry.vectors import dot, subtract
from stability.mechanics.inertia import inertia_times
from stability.model import BodyId, BodyState, Brick, Plane
from stackdsl.playing.ground_work import GroundWork
from stackdsl.trace import NOTABLE_GAIN, Energy

ROSE = 1e-3  # share of the smallest side, 8 micrometres for a plank: what creeps stays within it


def kinetic_energy(brick: Brick, state: BodyState) -> float:
    """Of translation and rotation [J]."""
    spin_W = state.angular_velocity_W
    rotation = dot(inertia_times(brick, state.pose.orientation, spin_W), spin_W)
    return 0.5 * (brick.mass * dot(state.velocity_W, state.velocity_W) + rotation)


@dataclass(frozen=True, slots=True)
class _Seen:
    """What a brick had when it was seen last."""

    energy: float = 0.0  # kinetic + potential, heights straight down [J]
    by_distance: float = 0.0  # the same, heights as distances from the ground [J]
    height: float = 0.0  # [m]


NOTHING = _Seen()


@dataclass
class EnergyMeter:
    """Adds up what is seen of the bricks; the ground is the level that potential energy counts from.

    A gain is that of those that moved, as a share of what they had: a large block elsewhere would hide it. They have
    got too far between two looks to be at rest, or have risen or sunk since the last action. Of that share, height
    counts as distance from the ground, which is small on a steep slope, too.
    """

    gravity: float  # [m/s2], along -z
    ground: Plane
    now: float = 0.0  # kinetic + potential energy of all bricks [J]
    outside: GroundWork = field(default_factory=GroundWork)  # what is done from outside
    _of: dict[BodyId, _Seen] = field(default_factory=dict)
    _start: float | None = None  # of all, once something was done [J]
    _at_start: dict[BodyId, _Seen] = field(default_factory=dict)  # of what was seen since
    _moved: dict[BodyId, None] = field(default_factory=dict)  # since
    _risen: float = 0.0  # how much more these had at most [J]
    _gained_before: float = 0.0  # the largest gain until then, as a share

    def see(self, time: float, bricks: Mapping[BodyId, Brick], states: Mapping[BodyId, BodyState]) -> None:
        """Take in the bricks that may have moved, of all by name."""
        self.outside.see(time, bricks, states)
        for name, state in states.items():
            brick = bricks[name]
            weight, centre_W = brick.mass * self.gravity, subtract(state.pose.position_W, self.ground.point_W)
            kinetic, was, height = kinetic_energy(brick, state), self._of.get(name, NOTHING), centre_W[2]
            by_distance = kinetic + weight * dot(self.ground.normal_W, centre_W)
            self._of[name] = own = _Seen(kinetic + weight * height, by_distance, height)
            self.now += own.energy - was.energy
            if abs(height - self._at_start.setdefault(name, was).height) > ROSE * brick.shape.least_thickness:
                self._moved[name] = None

    def forget(self, bricks: Iterable[BodyId]) -> None:
        """These were pulled out, and their energy with them."""
        for name in bricks:
            self.now -= self._of.pop(name).energy
            self.outside.forget(name)

    def start(self, by_hand: bool = False) -> None:
        """Something was done, and all was seen since: what comes now comes by itself.

        What came `by_hand` until now is no gain.
        """
        if not by_hand and (until_now := self.energy()) is not None:
            self._gained_before = max(self._gained_before, until_now.gain)
        self._start, self._at_start, self._moved, self._risen = self.now, {}, {}, 0.0
        self.outside.start()

    def look(self, moved: Iterable[BodyId]) -> None:
        """All that moves has been seen, and of that these got too far to be at rest."""
        self._moved |= dict.fromkeys(moved)
        given = self.outside.given
        more = sum(self._of[name].energy - self._at_start[name].energy - given.get(name, 0.0) for name in self._moved)
        self._risen = max(self._risen, more)

    @property
    def notably_gained(self) -> bool:
        """Whether so much was gained since the last action that it is a fault; what came before it was told then."""
        energy = self.energy()
        return energy is not None and energy.gain > NOTABLE_GAIN

    def energy(self) -> Energy | None:
        """What it was after the last action, and has been at most since; None if nothing was ever done."""
        if self._start is None:
            return None
        had = sum((self._at_start[name].by_distance for name in self._moved), 0.0)
        had += sum(self.outside.passed.get(name, 0.0) for name in self._moved)
        return Energy(self._start, self._risen, had, self._gained_before)
