"""Friction in PyBullet: coefficients by pair, and Coulomb's cone for leaning bricks."""

import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import exp, hypot
from typing import TypeAlias

import numpy as np

from stability.engines.protocol import FrictionRecord, WrongFriction
from stability.engines.pybullet.binding import pybullet
from stability.engines.pybullet.bodies import BrickBodies
from stability.engines.pybullet.contacts import refresh_contacts
from stability.engines.pybullet.groups import WeldedGroups
from stability.geometry.vectors import add_scaled, norm, scale, subtract
from stability.model import BodyId, Vec3

# Friction coefficients by pair, in an engine with one factor per body.
#
# PyBullet multiplies the factors of two touching bodies. So the factors of all touching bodies are chosen such that
# their products are the requested coefficients: in logarithms, one linear equation per contact. Stacks have a solution,
# as each body adds an unknown. With more contacts, as in a ring of bodies, there may be none; then weighted least
# squares favour the contacts with the largest forces, and the largest error is recorded. The factors are solved again
# right before each step with new contacts.


Pair: TypeAlias = tuple[BodyId, BodyId]  # sorted by name

SMOOTH = 1e-6  # stands for no friction, which has no logarithm
UNPRESSED = 1e-4  # weight of a contact without force, relative to the contact with the largest force
LOATH = 1e-3  # scale of changes to factors that already satisfy a pair, relative to others
SAME = 1e-5  # a factor whose logarithm would change by less stays
COUNTS = 0.01  # contacts with less than this share of the largest force record no friction error
WRONG, LEAST = 1e-3, 0.01  # recorded relative error, and the least coefficient that it refers to
EVERY = 8  # steps between solutions while some coefficients are wrong, as the forces may have changed
MOST = 10.0  # PyBullet's largest coefficient


@dataclass
class PairFriction:
    """Sets the friction factors of a world's bodies before each step, if the law has several coefficients."""

    bricks: BrickBodies
    groups: WeldedGroups
    _factors: dict[int, float] = field(default_factory=dict, init=False)  # by body of the client
    _touching: frozenset[Pair] = field(default=frozenset(), init=False)  # pairs in contact at the last solution
    _solved: frozenset[Pair] = field(default=frozenset(), init=False)  # pairs with the requested coefficient
    _steps_to_look: int = field(default=0, init=False)

    def update(self, record: FrictionRecord) -> None:
        """Set the factors for the contacts of the next step, and record the largest error."""
        if not self.bricks.maker.law.differs:
            return
        pressing = self._pressing()
        pairs = frozenset(pressing)
        wrong, self._steps_to_look = bool(pairs - self._solved), self._steps_to_look - 1
        made = any(self._is_new(name) for pair in pairs for name in pair)
        if pairs - self._touching or made or (wrong and self._steps_to_look <= 0):
            self._steps_to_look, self._touching = EVERY, pairs
            self._solve(pressing, record)

    def _pressing(self) -> Mapping[Pair, float]:
        """Return the pairs in contact now, with their normal forces in the last step [engine N]."""
        client, names = self.bricks.bodies.client, self.bricks.bodies.names
        pressing: dict[Pair, float] = defaultdict(float)
        before: dict[Pair, float] = defaultdict(float)
        for forces in (before, pressing):
            for point in pybullet.getContactPoints(physicsClientId=client) or ():
                a, b = names[point[1]], names[point[2]]
                forces[min(a, b), max(a, b)] += point[9]
            if forces is before:
                pybullet.performCollisionDetection(client)
        immobile = self._held(pressing)
        return {pair: max(pressing[pair], before[pair]) for pair in sorted(pressing) if not immobile.issuperset(pair)}

    def _held(self, pairs: Iterable[Pair]) -> set[BodyId]:
        """Return the fixed and frozen bodies of these pairs; two such bodies need no friction."""
        names = {name for pair in pairs for name in pair}
        planes = self.bricks.own.planes.keys()
        return {name for name in names if name in planes or self.bricks.bodies.mass(name) == 0.0}

    def _of(self, name: BodyId) -> list[int]:
        """Return the numbers of a body's engine bodies: a plane may have two."""
        bodies = self.bricks.bodies
        if name in self.bricks.own.planes:
            return [number for number, body in bodies.names.items() if body == name]
        return [bodies.numbers[name]]

    def _solve(self, pressing: Mapping[Pair, float], record: FrictionRecord) -> None:
        """Solve for the factors of all touching bodies, with as few changes as possible."""
        pairs, names = list(pressing), sorted({name for pair in pressing for name in pair})
        requested = np.array(list(itertools.starmap(self.requested_coefficient, pairs)))
        weights = np.maximum(
            np.array(list(pressing.values())) / (max(pressing.values(), default=0.0) or 1.0), UNPRESSED
        )
        column = {name: number for number, name in enumerate(names)}
        rows = np.zeros((len(pairs), len(names)))
        for row, pair in enumerate(pairs):
            rows[row, [column[name] for name in pair]] = 1.0
        settled = {name for pair in self._solved for name in pair}
        ease = np.array([LOATH if name in settled and not self._is_new(name) else 1.0 for name in names])
        before = np.log([self._factor(name) for name in names])
        error = np.log(np.clip(requested, SMOOTH, MOST)) - rows @ before
        change = ease * np.linalg.lstsq(rows * ease * weights[:, None], error * weights)[0]
        stay = (np.abs(change) <= SAME) & [not self._is_new(name) for name in names]
        logarithms = np.where(stay, before, before + change)
        for name in itertools.compress(names, ~stay):
            self._give(name, exp(logarithms[column[name]]))
        # An existing contact point keeps its initial friction.
        touched = {name for pair, row in zip(pairs, rows, strict=True) if (row[~stay] > 0.0).any() for name in pair}
        refresh_contacts(self.bricks, sorted(touched - self.bricks.own.planes.keys()))
        actual = np.exp(rows @ logarithms)
        wrong = np.abs(actual - requested) > WRONG * np.maximum(requested, LEAST)
        self._solved = frozenset(itertools.compress(pairs, ~wrong))
        for row in np.flatnonzero(wrong & (weights >= COUNTS)).tolist():
            time = self.bricks.stepper.time
            record.note(WrongFriction(*pairs[row], float(requested[row]), float(actual[row]), time))

    def _factor(self, name: BodyId) -> float:
        """Return the current factor of a body."""
        planes, usual = self.bricks.own.planes, self.bricks.maker.own_friction()
        as_made = max(planes[name].friction / usual, SMOOTH) if name in planes else usual
        return self._factors.get(self._of(name)[0], as_made)

    def _is_new(self, name: BodyId) -> bool:
        """Check that an engine body of this body has no factor yet."""
        return any(number not in self._factors for number in self._of(name))

    def _give(self, name: BodyId, factor: float) -> None:
        for number in self._of(name):
            self._factors[number] = factor
            pybullet.changeDynamics(number, -1, lateralFriction=factor, physicsClientId=self.bricks.bodies.client)

    def requested_coefficient(self, first: BodyId, second: BodyId) -> float:
        """Return the requested coefficient of two bodies; of a group, the smallest of its bricks."""
        law, planes = self.bricks.maker.law, self.bricks.own.planes
        if first in planes:
            first, second = second, first
        first_bricks, second_bricks = self.groups.bricks_in(first), self.groups.bricks_in(second)
        if second in planes:
            return min(law.on(brick, planes[second]) for brick in first_bricks)
        return min(law.of(brick, on) for brick in first_bricks for on in second_bricks)


# Coulomb's cone for the friction on leaning bricks.
#
# PyBullet has two friction forces at a contact point, along the sliding direction and across it, each limited by
# Coulomb's law alone. Without sliding the direction is random noise, and a ladder or an inverted V can stand on up to
# 1.4 times the true friction. An invisibly small velocity far above the noise aligns the direction with the load; if
# the cone cannot carry the load then, the brick slips.


BEYOND = 1.005  # tolerated ratio of the friction to its limit
NUDGE = 1e-5  # [engine m/s] a micrometre a second for KAPLA planks; resting bricks vibrate at a tenth of it or less
NOTHING: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class FrictionCones:
    """Makes bricks with rounded edges slip at Coulomb's limit, if the settings require it."""

    bricks: BrickBodies
    pairs: PairFriction
    _steps_to_look: int = field(default=EVERY, init=False)

    def look(self) -> None:
        """Check the friction after every `EVERY` steps."""
        self._steps_to_look -= 1
        if self.bricks.maker.settings.friction_cones and self._steps_to_look <= 0:
            self._steps_to_look = EVERY
            if not self.bricks.stepper.lively:
                self._let_slip()

    def _let_slip(self) -> None:
        """Give every leaning brick with too large friction a small velocity against the excess."""
        bodies = self.bricks.bodies
        for name in sorted(self.bricks.rounded & bodies.numbers.keys(), key=bodies.numbers.__getitem__):
            too_much_W = self._held_beyond(name)
            strength = norm(too_much_W)  # may underflow to 0 for forces that are too small to matter
            if strength > 0.0 and not self.bricks.holds(name):
                velocity, angular_velocity = bodies.raw_motion(name)
                slips = add_scaled(velocity, -NUDGE / strength, too_much_W)
                bodies.set_raw_motion(name, slips, angular_velocity)

    def _held_beyond(self, name: BodyId) -> Vec3:
        """Return the sum of the friction forces on a brick that are outside their cones [engine N]."""
        total_W = NOTHING
        for point in self.bricks.bodies.raw_contacts(name):
            normal_force, along, direction, across, cross_direction = point[9:14]
            friction = self.pairs.requested_coefficient(name, self.bricks.bodies.names[point[2]])
            if hypot(along, across) > BEYOND * friction * normal_force:
                # PyBullet's friction acts on the other body.
                total_W = subtract(total_W, add_scaled(scale(along, direction), across, cross_direction))
        return total_W
