"""Motion of parts of a structure by their equations, without an engine, as long as a proof covers it.

A part that is proven to turn as one body is a pendulum (toppling.py): an engine starts such a fall inaccurately, and a
tower that overhangs by a millimetre may topple in half the time. Bricks that drop freely and rest where they land need
no engine either (dropping.py). An engine moves all others.
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

MOST = 100  # most bricks of a part: a proof takes some tens of milliseconds at each angle
MOST_FEELING = 60  # most bricks around the part that are proven to stand under its forces
AT_REST = 1e-6  # [m/s] and [rad/s] largest initial speed: the equations start from rest


class KnownMotion(Protocol):
    """Motion that follows from its own equations, without an engine."""

    def advance(self, duration: float) -> bool:
        """Advance by a short time [s]; return False, without advancing, if the equations do not cover it."""

    def states(self) -> Mapping[BodyId, BodyState]:
        """Return the current states of its bricks."""

    def take_landed(self) -> Sequence[BodyId]:
        """Return the bricks that have come to rest for good since the last call."""


@dataclass(frozen=True, slots=True)
class _Around:
    """Bricks that are about to move, with the bricks that they may touch or press on."""

    structure: Structure
    moving: Set[BodyId]
    near: Sequence[Placed]  # bricks that they may touch
    farthest: Set[BodyId]  # bricks that these may touch in turn

    def problem(self, most: int) -> Problem:
        """Return the problem of the moving bricks and at most `most` other bricks that their forces may reach."""
        names = sorted(self.structure.spread(self.moving, len(self.moving) + most) - self.farthest)
        return self.structure.problem(names, self.structure.contacts_of(names))


@dataclass
class FallingParts:
    """Motions without an engine in one world. Call `advance` before each step of the world."""

    world: World
    planes: Sequence[Plane]
    friction: GivenFriction  # of brick on brick
    gravity: float  # [m/s2]
    # Bricks that landed in the last steps, to be judged like bricks that are set down.
    landed: Sequence[BodyId] = field(default=(), init=False)
    proven: int = field(default=0, init=False)  # bricks in all proofs of landings so far
    _awake: Collection[BodyId] = field(default=(), init=False)  # bricks whose motion may be known
    _onset: Motion | None = field(default=None, init=False)  # initial motion of all awake bricks
    _substeps_due: bool = field(default=False, init=False)
    _motion: KnownMotion | None = field(default=None, init=False)
    _region: Surroundings = field(default=EVERYWHERE, init=False)  # the region in plan that affects the motion

    def woken(self, awake: Collection[BodyId], motion: Motion | None) -> None:
        """Handle the waking of bricks that cannot stand; `awake` are all awake bricks, `motion` their proven onset."""
        self.end()
        self._awake, self._substeps_due = awake, True
        self._onset = motion if motion is not None and motion.velocity.keys() == set(awake) else None

    def disturbed(self, by: Iterable[Placed]) -> None:
        """End the known motion if one of these bricks, which are about to be changed, is near to it."""
        if self._motion is None or not all(self._is_beyond(placed, self._motion) for placed in by):
            self.end()

    def _is_beyond(self, placed: Placed, motion: KnownMotion) -> bool:
        (x, y, _), (first_x, first_y, _) = placed.pose.position_W, self._region.middle_W
        far = hypot(x - first_x, y - first_y) > self._region.within + across(placed)
        return far and placed.brick.id not in motion.states()

    def let_go(self, awake: Collection[BodyId]) -> None:
        """Handle a change after which these bricks are awake; some may have been released in the air."""
        if self._motion is not None:
            if self._motion.states().keys() == set(awake):
                return
            self.end()
        self._awake = self._awake or awake

    def advance(self, steps: int, driven: bool = False) -> int:
        """Advance by up to this many time steps of the world; return the number before the engine must take a step.

        While the ground shakes or hands move bricks, the world is `driven` and the engine takes all steps, as the
        equations do not cover that.
        """
        if driven and self._motion is not None:
            self.end()
        elif self._awake and not driven:
            self._motion = self._begun()
        self._awake, self._onset, self.landed = (), None, ()
        passed = self._followed(steps)
        if not passed and self._substeps_due:
            self.world.substep_next_contact()
            self._substeps_due = False
        return passed

    def _followed(self, steps: int) -> int:
        step, passed = self.world.settings.time_step, 0
        while self._motion is not None and passed < steps and not self.landed:
            if self._motion.advance(step):
                passed += 1
                self.world.skip(step)  # one by one, so that the clock's rounding does not depend on `steps`
                self.landed = self._motion.take_landed()
            else:
                self._tell_world(self._motion)
                self.end()
        if self._motion is not None:
            self._tell_world(self._motion)
        return passed

    def _tell_world(self, motion: KnownMotion) -> None:
        for name, state in motion.states().items():
            self.world.set_state(name, state)

    def end(self) -> None:
        """End the known motion: the engine moves the bricks from now on."""
        if self._motion is not None:
            self._motion, self._substeps_due = None, True
        self._awake, self._onset = (), None  # an initial motion that has not started is no longer valid

    def _begun(self) -> KnownMotion | None:
        self._region = EVERYWHERE
        return self._drop() or self._fall()

    def _drop(self) -> KnownMotion | None:
        """Return the drop of all awake bricks, if they fall freely."""
        states = self.world.states(sorted(self._awake))
        if not all(hypot(*s.velocity_W[:2], *s.angular_velocity_W) <= AT_REST for s in states.values()):
            return None
        from stability.dynamics.dropping import dropping_of  # noqa: PLC0415 -- most that is built stands

        moving = {placed.brick.id: (placed, states[placed.brick.id]) for placed in self._placed(states)}
        if len(moving) < len(states):
            return None
        others = list(self._placed(self.world.masses().keys() - states.keys()))
        drop = dropping_of(moving, others, self.planes, self.friction, self.gravity)
        if drop is not None:
            drop.count = self._count
        return drop

    def _count(self, bricks: int) -> None:
        self.proven += bricks

    def _fall(self) -> KnownMotion | None:
        """Return the fall of bricks that start from rest and turn as one body."""
        states = self.world.states(sorted(self._awake))
        starts = all(hypot(*s.velocity_W, *s.angular_velocity_W) <= AT_REST for s in states.values())
        if self._onset is None or len(states) > MOST or not starts:
            return None
        around = self._around(states)
        if around is None:
            return None
        from stability.dynamics.toppling import toppling_of  # noqa: PLC0415 -- most that is built stands

        return toppling_of(around.problem(MOST_FEELING), self._onset, self.gravity, around.near, self.planes)

    def _around(self, moving: Collection[BodyId]) -> "_Around | None":
        """Return the moving bricks with those that they may touch or press on; None if a shape is not convex."""
        bricks = list(self._placed(moving))
        if len(bricks) < len(moving):
            return None
        near, beyond = self._beside(bricks)
        structure = Structure(tuple(self.planes), (), self.friction, self.gravity, Tolerances())
        for placed in (*bricks, *near, *beyond):
            structure.put(placed)
        # The bricks beyond count as fixed, as their own supports may be farther away.
        return _Around(structure, set(moving), near, {placed.brick.id for placed in beyond})

    def _placed(self, bricks: Collection[BodyId]) -> Iterator[Placed]:
        masses, states = self.world.masses(), self.world.states(bricks)
        for name in sorted(bricks):
            shape = convex(self.world.shape(name))
            if shape is not None:
                yield Placed(Brick(name, shape, masses[name]), states[name].pose)

    def _beside(self, part: Sequence[Placed]) -> tuple[list[Placed], list[Placed]]:
        """Return the other bricks that a part may touch, and the bricks beyond that may touch these."""
        surroundings = surroundings_of(part)
        near, beyond = [], []
        for placed in self._placed(self.world.masses().keys() - {other.brick.id for other in part}):
            apart, extent = dist(surroundings.middle_W, placed.pose.position_W), across(placed)
            if apart <= surroundings.within + extent:
                near.append(placed)
            else:
                beyond.append((apart - extent, placed))
        farthest = surroundings.within + 2.0 * max((across(other) for other in near), default=0.0)
        self._region = Surroundings(surroundings.middle_W, farthest)
        return near, [placed for nearest, placed in beyond if nearest <= farthest]
