"""Lets parts of a structure move by their equations, without an engine, for as long as a proof covers it.

A solver begins a fall wrongly: contact forces start from nothing, so that everything sinks at first, most at the bottom
of a tall structure, and a tower that hangs over by a millimetre topples in half the time. A part that is proven to turn
as one body needs no solver: it is a pendulum (toppling.py). What slips, or falls in several parts, or rocks and rolls
from one edge to another, needs none either until something new is met (frictional_motion.py): an engine gets its
bricks then, where and as fast as they are. Nor does what drops with nothing under it, and rests where it lands
(dropping.py). All other bricks that begin to fall are eased in by the engine.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import dist, hypot
from typing import Protocol

from stability.contact_law import GivenFriction
from stability.dynamics.surroundings import EVERYWHERE, Surroundings, across, surroundings_of
from stability.engines.protocol import World
from stability.model import BodyId, BodyState, Brick, Plane, convex
from stability.problem import Motion, Placed, Problem, Tolerances
from stability.statics.structure import Structure

MOST = 100  # bricks of a part: a proof takes some tens of milliseconds at each angle
MOST_FEELING = 60  # bricks around the part for which it is proven that they stand under its forces
MOST_PRESSED = 6  # the same where that is asked at each step
AT_REST = 1e-6  # [m/s], and [rad/s]: a brick that is faster moves already, and the equations start from rest


class KnownMotion(Protocol):
    """A motion that follows from its own equations, without an engine, for as long as nothing else happens."""

    def goes_on(self, duration: float) -> bool:
        """Move for a short time [s]; False, and not at all, if it is not known how."""

    def states(self) -> Mapping[BodyId, BodyState]:
        """Where its bricks are, and how they move."""

    def take_landed(self) -> Sequence[BodyId]:
        """The bricks that have come to rest for good since this was asked last."""


@dataclass(frozen=True, slots=True)
class _Around:
    """Bricks that are about to move, among what they may touch or press on."""

    structure: Structure
    moving: Set[BodyId]
    near: Sequence[Placed]  # what they may touch
    farthest: Set[BodyId]  # what those may touch in turn

    def problem(self, most: int) -> Problem:
        """Of what moves, and of so many bricks at most that may feel it."""
        names = sorted(self.structure.spread(self.moving, len(self.moving) + most) - self.farthest)
        return self.structure.problem(names, self.structure.contacts_of(names))


@dataclass
class FallingParts:
    """Looks after what falls in one world. Before each of its steps, ask `advance` whether one is needed."""

    world: World
    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    landed: Sequence[BodyId] = field(default=(), init=False)  # in the last steps: they are to be judged as set down
    proven: int = field(default=0, init=False)  # bricks in all proofs of landings so far
    _awake: Collection[BodyId] = field(default=(), init=False)  # what moves from now on, if that may be known
    _coming: Motion | None = field(default=None, init=False)  # with which all of that begins
    _gently: bool = field(default=False, init=False)
    _known: KnownMotion | None = field(default=None, init=False)
    _matters: Surroundings = field(default=EVERYWHERE, init=False)  # where it matters to it what there is, in plan

    def woken(self, awake: Collection[BodyId], motion: Motion | None) -> None:
        """Say that bricks cannot stand, which are awake by now, and with which motion they begin, if it is proven."""
        self.end()
        self._awake, self._gently = awake, True
        self._coming = motion if motion is not None and motion.velocity.keys() == set(awake) else None

    def disturbed(self, by: Iterable[Placed]) -> None:
        """Say that something is about to be done with these bricks; a motion that none of them comes near goes on."""
        if self._known is None or not all(self._is_beyond(placed, self._known) for placed in by):
            self.end()

    def _is_beyond(self, placed: Placed, known: KnownMotion) -> bool:
        (x, y, _), (first_x, first_y, _) = placed.pose.position_W, self._matters.middle_W
        far = hypot(x - first_x, y - first_y) > self._matters.within + across(placed)
        return far and placed.brick.id not in known.states()

    def let_go(self, awake: Collection[BodyId]) -> None:
        """Say that something was done, and which bricks are awake by now: some may have been let go in the air."""
        if self._known is not None:
            if self._known.states().keys() == set(awake):
                return
            self.end()
        self._awake = self._awake or awake

    def advance(self, steps: int, driven: bool = False) -> int:
        """Let up to so many time steps of the world pass; returns how many did before an engine has to take one.

        Where the ground shakes or hands are at work, it is `driven`, and one has to take them all: no equation here
        knows of that.
        """
        if driven and self._known is not None:
            self.end()
        elif self._awake and not driven:
            self._known = self._begun()
        self._awake, self._coming, self.landed = (), None, ()
        passed = self._followed(steps)
        if not passed and self._gently:
            self.world.substep_next_contact()
            self._gently = False
        return passed

    def _followed(self, steps: int) -> int:
        step, passed = self.world.settings.time_step, 0
        while self._known is not None and passed < steps and not self.landed:
            if self._known.goes_on(step):
                passed += 1
                self.world.skip(step)  # one by one: how many pass at once is not to show in a clock
                self.landed = self._known.take_landed()
            else:
                self._tell_world(self._known)
                after = self._after(self._known)
                self.end()
                self._known, self._gently = after, after is None
        if self._known is not None:
            self._tell_world(self._known)
        return passed

    def _tell_world(self, known: KnownMotion) -> None:
        for name, state in known.states().items():
            self.world.set_state(name, state)

    def _after(self, known: KnownMotion) -> KnownMotion | None:
        """How bricks go on once they are not known to move as one any more: by the laws of what slips and parts.

        Of few bricks, since forces are found at each step. What they do to each other as they land is told with it, as
        when a prism rolls from one face onto the next.
        """
        from stability.dynamics.toppling import Toppling  # noqa: PLC0415 -- most that is built stands

        moving = known.states()
        if not isinstance(known, Toppling) or len(moving) > MOST_PRESSED:
            return None
        around = self._around(moving.keys())
        return self._in_parts(around, moving) if around is not None else None

    @property
    def follows(self) -> bool:
        """Whether what moves goes on without an engine."""
        return self._known is not None

    def end(self) -> None:
        """Let every brick move by itself, for something else is about to happen."""
        if self._known is not None:
            self._known, self._gently = None, True
        self._awake, self._coming = (), None  # a motion that has not begun is not valid any more

    def _begun(self) -> KnownMotion | None:
        self._matters = EVERYWHERE
        return self._drop() or self._fall()

    def _drop(self) -> KnownMotion | None:
        """How all that moves drops, if it does."""
        states = self.world.states(sorted(self._awake))
        if not all(hypot(*s.velocity_W[:2], *s.angular_velocity_W) <= AT_REST for s in states.values()):
            return None
        from stability.dynamics.dropping import dropping_of  # noqa: PLC0415 -- most that is built stands

        moving = {placed.brick.id: (placed, states[placed.brick.id]) for placed in self._placed(states)}
        if len(moving) < len(states):
            return None
        others = list(self._placed(self.world.masses().keys() - states.keys()))
        found = dropping_of(moving, others, self.planes, self.friction, self.gravity)
        if found is not None:
            found.count = self._count
        return found

    def _count(self, bricks: int) -> None:
        self.proven += bricks

    def _fall(self) -> KnownMotion | None:
        """How what begins to fall goes on, if that is known."""
        states = self.world.states(sorted(self._awake))
        if len(states) > MOST or any(hypot(*s.velocity_W, *s.angular_velocity_W) > AT_REST for s in states.values()):
            return None
        around = self._around(states)
        return None if around is None else self._as_one(around) or self._in_parts(around)

    def _as_one(self, around: "_Around") -> KnownMotion | None:
        if self._coming is None:
            return None
        from stability.dynamics.toppling import toppling_of  # noqa: PLC0415 -- most that is built stands

        return toppling_of(around.problem(MOST_FEELING), self._coming, self.gravity, around.near, self.planes)

    def _in_parts(self, around: "_Around", states: Mapping[BodyId, BodyState] | None = None) -> KnownMotion | None:
        from stability.dynamics.frictional_motion import frictional_motion_of  # noqa: PLC0415 -- most that is built stands

        found = frictional_motion_of(
            around.problem(MOST_PRESSED),
            around.moving,
            self.gravity,
            around.near,
            self.planes,
            self.friction,
            states,
        )
        if found is not None:
            found.look_around = lambda part: self._beside(part)[0]
        return found

    def _around(self, moving: Collection[BodyId]) -> "_Around | None":
        """What moves, where it is now, with what it may touch or press on; None if some of it has no convex shape."""
        bricks = list(self._placed(moving))
        if len(bricks) < len(moving):
            return None
        near, beyond = self._beside(bricks)
        structure = Structure(tuple(self.planes), (), self.friction, self.gravity, Tolerances())
        for placed in (*bricks, *near, *beyond):
            structure.put(placed)
        # What lies beyond is taken as fixed, for what it rests on may be farther still.
        return _Around(structure, set(moving), near, {placed.brick.id for placed in beyond})

    def _placed(self, bricks: Collection[BodyId]) -> Iterator[Placed]:
        masses, states = self.world.masses(), self.world.states(bricks)
        for name in sorted(bricks):
            shape = convex(self.world.shape(name))
            if shape is not None:
                yield Placed(Brick(name, shape, masses[name]), states[name].pose)

    def _beside(self, part: Sequence[Placed]) -> tuple[list[Placed], list[Placed]]:
        """The other bricks that a part may touch or reach, and beyond them those that may touch these."""
        surroundings = surroundings_of(part)
        near, beyond = [], []
        for placed in self._placed(self.world.masses().keys() - {one.brick.id for one in part}):
            apart, size = dist(surroundings.middle_W, placed.pose.position_W), across(placed)
            if apart <= surroundings.within + size:
                near.append(placed)
            else:
                beyond.append((apart - size, placed))
        farthest = surroundings.within + 2.0 * max((across(one) for one in near), default=0.0)
        self._matters = Surroundings(surroundings.middle_W, farthest)
        return near, [placed for nearest, placed in beyond if nearest <= farthest]
