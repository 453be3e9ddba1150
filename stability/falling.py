"""Parts that fall as one body, for as long as a proof says that they do; bricks that fall one by one begin gently.

A solver begins a fall wrongly: contact forces start from nothing, so that all sinks at first, most at the bottom of
what is tall, and a tower that hangs over by a millimetre topples in half the time. A part that is proven to turn as one
needs no solver: it is a pendulum, and an engine gets its bricks when the proof ends, where and as fast as they are. Nor
do planks that slip down a wall, or down each other (statics/sliding.py).
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from math import dist, hypot, radians

from stability.engine import World
from stability.model import BodyId, BodyState, Box, Brick, Plane
from stability.statics.facts import Motion, Placed, Tolerances
from stability.statics.sliding import Slip, slip_of
from stability.statics.structure import Structure
from stability.statics.turning import FallingPart, falling_part, holds_together, is_clear, part_in_motion, reach

# It is proven that a part holds together at every fifth degree; it is parted at the last at which it does. Later the
# weight turns against the layers, and what reaches farther than 30 deg has hit something in most cases.
STAGE, FURTHEST = radians(5.0), radians(30.0)
# A part is looked at so often that no corner of it passes more than this share of the smallest side unseen.
UNSEEN = 0.5
MOST = 100  # bricks of a part: a proof takes some tens of milliseconds at each angle
MOST_FEELING = 60  # bricks besides it that are proven to stand under what it does to them
AT_REST = 1e-6  # [m/s], and [rad/s]: what moves already has begun otherwise


@dataclass
class _Swing:
    """A part that turns as one body."""

    part: FallingPart
    others: Sequence[Placed]  # what it may hit
    planes: Sequence[Plane]
    pitch: float  # between the angles at which it is looked at [rad]
    angle: float = 0.0  # [rad]
    speed: float = 0.0  # of the angle [rad/s]
    _clear: float = 0.0  # the angle up to which nothing is hit [rad]
    _stage: float = 0.0  # up to which it is proven to hold together

    def goes_on(self, duration: float) -> bool:
        """Turn for a short time [s]; False, and not at all, if it is not proven that it does as one body."""
        angle, speed = self.part.pendulum.after(self.angle, self.speed, duration)
        while angle > self._clear:
            if not self._looked_further():
                return False
        self.angle, self.speed = angle, speed
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Where its bricks are, and how they move."""
        return part_in_motion(self.part, self.angle, self.speed)

    def _looked_further(self) -> bool:
        if self._clear >= self._stage:
            stage = self._stage + STAGE
            if stage > FURTHEST * (1.0 + 1e-9) or not holds_together(self.part, stage):
                return False
            self._stage = stage
        further = min(self._stage, self._clear + self.pitch)
        if not is_clear(self.part, further, self.others, self.planes):
            return False
        self._clear = further
        return True


@dataclass
class FallingParts:
    """Looks after what falls in one world. Before each of its steps, ask `turn` whether one is needed."""

    world: World
    planes: Sequence[Plane]
    friction: float  # Coulomb coefficient of brick on brick
    gravity: float  # [m/s2]
    _coming: Motion | None = field(default=None, init=False)
    _gently: bool = field(default=False, init=False)
    _swing: _Swing | Slip | None = field(default=None, init=False)

    def woken(self, awake: Collection[BodyId], motion: Motion | None) -> None:
        """Say that bricks were given back to the engine, which are awake by now, and with which motion they begin."""
        self.end()
        self._gently = True
        self._coming = motion if motion is not None and motion.velocity.keys() == set(awake) else None

    def turn(self, steps: int) -> int:
        """Let up to so many time steps of the world pass; returns how many did before an engine has to take one."""
        coming, self._coming = self._coming, None
        if coming is not None and 0 < len(coming.velocity) <= MOST:
            self._swing = self._begun(coming)
        passed = self._turned(self._swing, steps) if self._swing is not None else 0
        if not passed and self._gently:
            self.world.ease_in()
            self._gently = False
        return passed

    def _turned(self, swing: _Swing | Slip, steps: int) -> int:
        step, passed = self.world.settings.time_step, 0
        while passed < steps and swing.goes_on(step):
            passed += 1
        self.world.skip(passed * step)
        for name, state in swing.states().items():
            self.world.set_state(name, state)
        if passed < steps:
            self.end()
        return passed

    def end(self) -> None:
        """Let every brick move by itself, for something else is about to happen."""
        if self._swing is not None:
            self._swing, self._gently = None, True
        self._coming = None  # what has not begun to turn yet does not begin alone any more

    def _begun(self, motion: Motion) -> _Swing | Slip | None:
        states = self.world.states(sorted(motion.velocity))
        if any(hypot(*s.velocity_W, *s.angular_velocity_W) > AT_REST for s in states.values()):
            return None
        bricks = list(self._placed(motion.velocity))
        others, beyond = self._around(bricks)
        structure = Structure(tuple(self.planes), (), self.friction, self.gravity, Tolerances())
        for placed in (*bricks, *others, *beyond):
            structure.put(placed)
        # What lies beyond is taken as fixed, for what it rests on may be farther still.
        known = structure.spread(motion.velocity.keys(), len(bricks) + MOST_FEELING)
        names = sorted(known - {placed.brick.id for placed in beyond})
        problem = structure.problem(names, structure.contacts_of(names))
        part = falling_part(problem, motion, self.gravity)
        if part is None or not holds_together(part, 0.0):
            return slip_of(problem, motion, self.gravity, others, self.planes)
        smallest = min(min(placed.brick.size) for placed in (*bricks, *others))
        return _Swing(part, others, self.planes, UNSEEN * smallest / reach(part))

    def _placed(self, bricks: Collection[BodyId]) -> Iterator[Placed]:
        masses, states = self.world.masses(), self.world.states(bricks)
        for name in sorted(bricks):
            shape = self.world.shape(name)
            if isinstance(shape, Box):
                yield Placed(Brick(name, shape.size, masses[name]), states[name].pose)

    def _around(self, part: Sequence[Placed]) -> tuple[list[Placed], list[Placed]]:
        """The other bricks that these may touch, or reach as they turn; and those that may touch one of these."""
        middle = part[0].pose.position_W
        within = 2.0 * max(dist(middle, one.pose.position_W) + hypot(*one.brick.size) for one in part)
        near, beyond = [], []
        for placed in self._placed(self.world.masses().keys() - {one.brick.id for one in part}):
            apart, size = dist(middle, placed.pose.position_W), hypot(*placed.brick.size)
            if apart <= within + size:
                near.append(placed)
            else:
                beyond.append((apart - size, placed))
        farthest = within + 2.0 * max((hypot(*one.brick.size) for one in near), default=0.0)
        return near, [placed for nearest, placed in beyond if nearest <= farthest]
