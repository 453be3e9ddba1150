"""Parts that fall as one body, for as long as a proof says that they do; bricks that fall one by one begin gently.

A solver begins a fall wrongly: contact forces start from nothing, so that all sinks at first, most at the bottom of
what is tall, and a tower that hangs over by a millimetre topples in half the time. As one body it starts exactly.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from math import dist, hypot, radians

from stability.engine import World
from stability.geometry import turn_between
from stability.model import BodyId, Box, Brick, Plane, Pose
from stability.statics.facts import Motion, Placed, Tolerances
from stability.statics.structure import Structure
from stability.statics.turning import FallingPart, turn_of, turns_as_one_until

# At which it is proven that a part holds together; it is parted at the last at which it does. Later the weight turns
# against the layers, and what reaches farther than 30 deg has hit something in most cases.
ANGLES = tuple(radians(angle) for angle in (0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0))
MOST = 100  # bricks of a part: a proof takes some tens of milliseconds at each angle
AT_REST = 1e-6  # [m/s], and [rad/s]: what moves already has begun otherwise


@dataclass(frozen=True, slots=True)
class _Held:
    """A part that falls as one body."""

    brick: BodyId  # any of it
    start: Pose
    until: float  # [rad]


@dataclass
class FallingParts:
    """Looks after what falls in one world. Call `begin` before each of its steps, and `follow` after it."""

    world: World
    planes: Sequence[Plane]
    friction: float  # Coulomb coefficient of brick on brick
    gravity: float  # [m/s2]
    _coming: Motion | None = field(default=None, init=False)
    _gently: bool = field(default=False, init=False)
    _held: _Held | None = field(default=None, init=False)

    def woken(self, awake: Collection[BodyId], motion: Motion | None) -> None:
        """Say that bricks were given back to the engine, which are awake by now, and with which motion they begin."""
        self.end()
        self._gently = True
        self._coming = motion if motion is not None and motion.velocity.keys() == set(awake) else None

    def begin(self) -> None:
        """Before a step: make one body of what falls as one."""
        coming, self._coming = self._coming, None
        if coming is not None and 1 < len(coming.velocity) <= MOST and self._join(coming):
            self._gently = False
        if self._gently:
            self.world.ease_in()
            self._gently = False

    def follow(self) -> tuple[BodyId, ...]:
        """After a step: part what is no longer proven to hold together; these are its bricks."""
        if self._held is not None:
            pose = self.world.states([self._held.brick])[self._held.brick].pose
            if turn_between(self._held.start, pose) >= self._held.until:
                return self.end()
        return ()

    def end(self) -> tuple[BodyId, ...]:
        """Let every brick move by itself, for something else is about to happen; these were one body."""
        if self._held is None:
            return ()
        parted = self.world.part(self._held.brick)
        self._held, self._gently = None, True
        return parted

    def _join(self, motion: Motion) -> bool:
        names = sorted(motion.velocity)
        states = self.world.states(names)
        if any(hypot(*s.velocity_W, *s.angular_velocity_W) > AT_REST for s in states.values()):
            return False
        until = self._holds_until(motion)
        if not until:
            return False
        for name in names:
            self.world.freeze(name)
        self.world.join(names)
        self._held = _Held(names[0], states[names[0]].pose, until)
        return True

    def _holds_until(self, motion: Motion) -> float | None:
        structure = Structure(tuple(self.planes), (), self.friction, self.gravity, Tolerances())
        others = list(self._near(motion.velocity))
        for placed in (*self._placed(motion.velocity), *others):
            structure.put(placed)
        names = sorted(motion.velocity)
        problem = structure.problem(names, structure.contacts_of(names))
        turn = turn_of(problem, motion)
        if turn is None:
            return None
        return turns_as_one_until(FallingPart(problem, turn, self.gravity), ANGLES, others, self.planes)

    def _placed(self, bricks: Collection[BodyId]) -> Iterator[Placed]:
        masses, states = self.world.masses(), self.world.states(bricks)
        for name in sorted(bricks):
            shape = self.world.shape(name)
            if isinstance(shape, Box):
                yield Placed(Brick(name, shape.size, masses[name]), states[name].pose)

    def _near(self, bricks: Collection[BodyId]) -> Iterator[Placed]:
        """The other bricks that these may touch, or reach as they turn."""
        part = list(self._placed(bricks))
        middle = part[0].pose.position_W
        reach = 2.0 * max(dist(middle, one.pose.position_W) + hypot(*one.brick.size) for one in part)
        for placed in self._placed(self.world.masses().keys() - set(bricks)):
            if dist(middle, placed.pose.position_W) <= reach + hypot(*placed.brick.size):
                yield placed
