"""Friction in PyBullet: Coulomb's cone for leaning bricks, and coefficients by pair."""

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
from stability.engines.pybullet.contacts import find_contacts_anew
from stability.engines.pybullet.groups import JoinedGroups
from stability.geometry.vectors import add_scaled, norm, scale, subtract
from stability.model import BodyId, Vec3

# Friction that differs from pair to pair, in an engine that knows one factor a body.
#
# PyBullet multiplies the factors of two bodies that touch. So the factors of all that touches just now are chosen such
# that their products are the coefficients asked for: in logarithms, one linear equation a contact. Stacks have such
# factors, since each body brings an unknown of its own. Where more touches than that, as in a ring of bodies, there may
# be none; then the contacts that are pressed most come nearest to theirs, and how far off the worst is can be told.
# Factors are chosen anew whenever others touch, right before the step in which they do.


Pair: TypeAlias = tuple[BodyId, BodyId]  # by name, the first before the second

SMOOTH = 1e-6  # stands for no friction, which has no logarithm
UNPRESSED = 1e-4  # the weight of a contact that is not pressed, against the one that is pressed most
LOATH = 1e-3  # times as easily the factor of a body is changed that has one
SAME = 1e-5  # of a logarithm: what is to change by less is let be
COUNTS = 0.01  # share of the force that presses most: of what is pressed less, a wrong friction is not told
WRONG, LEAST = 1e-3, 0.01  # share of a coefficient, or of this one where it is less
EVERY = 8  # steps between choices where not all can have what is asked, as what presses on what may have changed
MOST = 10.0  # the largest coefficient that PyBullet has


@dataclass
class PairFriction:
    """Gives the bodies of one world their factors before each step, where more is asked than one coefficient."""

    bricks: BrickBodies
    groups: JoinedGroups
    _given: dict[int, float] = field(default_factory=dict, init=False)  # by body of the client
    _met: frozenset[Pair] = field(default=frozenset(), init=False)  # what touched when factors were chosen last
    _solved: frozenset[Pair] = field(default=frozenset(), init=False)  # those of them that have what was asked
    _steps_to_look: int = field(default=0, init=False)

    def suit(self, record: FrictionRecord) -> None:
        """Let all that touches in the coming step rub as it should, and note what cannot."""
        if not self.bricks.maker.law.differs:
            return
        pressing = self._pressing()
        pairs = frozenset(pressing)
        wrong, self._steps_to_look = bool(pairs - self._solved), self._steps_to_look - 1
        made = any(self._is_new(name) for pair in pairs for name in pair)
        if pairs - self._met or made or (wrong and self._steps_to_look <= 0):
            self._steps_to_look, self._met = EVERY, pairs
            self._solve(pressing, record)

    def _pressing(self) -> Mapping[Pair, float]:
        """What touches as things are now, and how it pressed in the last step [engine N]."""
        client, names = self.bricks.bodies.client, self.bricks.bodies.names
        pressing: dict[Pair, float] = defaultdict(float)
        before: dict[Pair, float] = defaultdict(float)
        for found in (before, pressing):
            for point in pybullet.getContactPoints(physicsClientId=client) or ():
                a, b = names[point[1]], names[point[2]]
                found[min(a, b), max(a, b)] += point[9]
            if found is before:
                pybullet.performCollisionDetection(client)
        still = self._held(pressing)
        return {pair: max(pressing[pair], before[pair]) for pair in sorted(pressing) if not still.issuperset(pair)}

    def _held(self, pairs: Iterable[Pair]) -> set[BodyId]:
        """What never moves, or does not just now, of these: two such need no friction."""
        names = {name for pair in pairs for name in pair}
        planes = self.bricks.own.planes.keys()
        return {name for name in names if name in planes or self.bricks.bodies.mass(name) == 0.0}

    def _of(self, name: BodyId) -> list[int]:
        """The bodies that stand for one: a plane may be two."""
        bodies = self.bricks.bodies
        if name in self.bricks.own.planes:
            return [number for number, called in bodies.names.items() if called == name]
        return [bodies.numbers[name]]

    def _solve(self, pressing: Mapping[Pair, float], record: FrictionRecord) -> None:
        """Choose factors for all that touches, as few others as can be."""
        pairs, names = list(pressing), sorted({name for pair in pressing for name in pair})
        asked = np.array(list(itertools.starmap(self.asked, pairs)))
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
        away = np.log(np.clip(asked, SMOOTH, MOST)) - rows @ before
        change = ease * np.linalg.lstsq(rows * ease * weights[:, None], away * weights)[0]
        stay = (np.abs(change) <= SAME) & [not self._is_new(name) for name in names]
        found = np.where(stay, before, before + change)
        for name in itertools.compress(names, ~stay):
            self._give(name, exp(found[column[name]]))
        # A point that is there keeps the friction that it began with.
        touched = {name for pair, row in zip(pairs, rows, strict=True) if (row[~stay] > 0.0).any() for name in pair}
        find_contacts_anew(self.bricks, sorted(touched - self.bricks.own.planes.keys()))
        had = np.exp(rows @ found)
        wrong = np.abs(had - asked) > WRONG * np.maximum(asked, LEAST)
        self._solved = frozenset(itertools.compress(pairs, ~wrong))
        for row in np.flatnonzero(wrong & (weights >= COUNTS)).tolist():
            time = self.bricks.stepper.time
            record.note(WrongFriction(*pairs[row], asked=float(asked[row]), had=float(had[row]), time=time))

    def _factor(self, name: BodyId) -> float:
        """The factor that a body has."""
        planes, usual = self.bricks.own.planes, self.bricks.maker.own_friction()
        as_made = max(planes[name].friction / usual, SMOOTH) if name in planes else usual
        return self._given.get(self._of(name)[0], as_made)

    def _is_new(self, name: BodyId) -> bool:
        """Whether some body that stands for this one was made after factors were given."""
        return any(number not in self._given for number in self._of(name))

    def _give(self, name: BodyId, factor: float) -> None:
        for number in self._of(name):
            self._given[number] = factor
            pybullet.changeDynamics(number, -1, lateralFriction=factor, physicsClientId=self.bricks.bodies.client)

    def asked(self, one: BodyId, other: BodyId) -> float:
        """The coefficient that two bodies should have; of a group, the least of its bricks."""
        law, planes = self.bricks.maker.law, self.bricks.own.planes
        if one in planes:
            one, other = other, one
        ones, others = self.groups.bricks_in(one), self.groups.bricks_in(other)
        if other in planes:
            return min(law.on(brick, planes[other]) for brick in ones)
        return min(law.of(brick, on) for brick in ones for on in others)


# Limits the friction on leaning bricks to Coulomb's cone.
#
# PyBullet has two friction forces at a contact point, along the sliding and across it, and each may be as strong as
# Coulomb allows by itself. Where nothing slides, "along" is the direction of whatever noise there is, and a ladder or
# an inverted V can stand with up to 1.4 times the friction that there is. A speed far below all that anybody sees, but
# far above the noise, turns "along" to where the load pulls; if the cone does not hold it then, it slips.


BEYOND = 1.005  # times as much friction as the cone allows: less is let be
NUDGE = 1e-5  # [engine m/s] a micrometre a second for KAPLA planks; what stands trembles at a tenth of that, or less
NOTHING: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class FrictionCones:
    """Lets bricks with rounded edges slip as soon as Coulomb does, if the settings say so."""

    bricks: BrickBodies
    pairs: PairFriction
    _steps_to_look: int = field(default=EVERY, init=False)

    def look(self) -> None:
        """Look after a step, if it is time to."""
        self._steps_to_look -= 1
        if self.bricks.maker.settings.friction_cones and self._steps_to_look <= 0:
            self._steps_to_look = EVERY
            if not self.bricks.stepper.lively:
                self._let_slip()

    def _let_slip(self) -> None:
        """Nudge every brick that leans at rest and is held by too much, against what holds it."""
        bodies = self.bricks.bodies
        for name in sorted(self.bricks.rounded & bodies.numbers.keys(), key=bodies.numbers.__getitem__):
            too_much_W = self._held_beyond(name)
            strength = norm(too_much_W)  # 0 also of forces whose squares are: those hold nothing
            if strength > 0.0 and not self.bricks.holds(name):
                velocity, angular_velocity = bodies.raw_motion(name)
                slips = add_scaled(velocity, -NUDGE / strength, too_much_W)
                bodies.set_raw_motion(name, slips, angular_velocity)

    def _held_beyond(self, name: BodyId) -> Vec3:
        """The sum of the friction forces on a brick that are outside of their cones [engine N]."""
        total_W = NOTHING
        for point in self.bricks.bodies.raw_contacts(name):
            normal_force, along, way, across, other_way = point[9:14]
            friction = self.pairs.asked(name, self.bricks.bodies.names[point[2]])
            if hypot(along, across) > BEYOND * friction * normal_force:
                # PyBullet's friction acts on the other body.
                total_W = subtract(total_W, add_scaled(scale(along, way), across, other_way))
        return total_W
