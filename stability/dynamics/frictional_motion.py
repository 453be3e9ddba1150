"""How do bricks begin to slip, tip and part, and go on, while nothing lands?

Gauss' principle of least constraint with Coulomb's cone at every point of contact says how they accelerate
(coulomb.py). It is asked anew at each step, for velocities in the middle of steps and places at their ends (leapfrog),
so that errors are of second order in the step; contacts and their gaps follow from the places alone. A step in which a
corner lands on what its brick has touched is taken in parts, and what lands stops in one blow; what the blow throws by
micrometres moves on until it stands again. It goes on for as long as every step is found and checked: momentum by
construction, cones and slips by arithmetic, energy that only friction takes. It ends where a brick lands on something
new, where one that is to stand begins to move, and where nothing is found.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from copy import copy
from dataclasses import dataclass, field
from itertools import islice, product
from math import inf, isclose

import numpy as np

from stability.contact_law import Coulomb, GivenFriction, as_friction
from stability.contacts.bodies import solid
from stability.dynamics.contact_points import ContactScene, Touching, alternatives, cones_in, slip_matrix, touching
from stability.dynamics.coulomb import (
    FrictionProblem,
    accelerations,
    inverse_mass,
    kinetic,
    potential,
    pressed,
    scale_of_problem,
)
from stability.dynamics.surroundings import Surroundings, surroundings_of
from stability.geometry.rows import Array
from stability.model import BodyId, BodyState, Plane
from stability.problem import Contact, Placed, Problem
from stability.statics.wrench_matrix import Cones, cones_of

MOST_POINTS = 150  # of contact: a step takes tens of milliseconds
LANDS = 3.0  # times what gravity gives in a step: what meets faster than that lands
GENTLY = 0.3  # the same of what touches elsewhere already
# A step in which something lands is taken in so many: what a landing leaves is found to the first order only.
PARTS_OF_A_LANDING = 32
# Share of its least thickness by which landings may move what stands, before it stands again: a twentieth of what
# counts as touching, for the points on which it rests are not found anew.
JOLTED = 1e-3
AT_REST = 1e-6  # the same: what is slower has come to rest, and may be frozen
STANDS = 1e-5  # share of the speed of what moves: what is to stand and is faster does not
GAINED = 1e-3  # share of the potential energy lost: more kinetic energy is an error
ROUNDING = 1e-9  # share of all of that energy, and of the least thickness of a brick, that says nothing
PARTS = 1e-5  # of the largest velocity: more slowly, bodies that press part by rounding
# From velocities in the middles of steps, latest first, to that at the end of the last one, by how many are known.
ONWARD = {1: (1.0,), 2: (1.5, -0.5), 3: (1.875, -1.25, 0.375)}
MOST_CHOICES = 4  # of normals that are tried in a step


@dataclass
class FrictionalMotion:
    """Bricks that move, and others that feel them and are to stand."""

    place: ContactScene  # where all bricks are, and what stays as it is
    touching: Touching
    falling: Collection[BodyId]  # those that are known to move
    gravity: float  # [m/s2]
    begun: Mapping[BodyId, BodyState] = field(default_factory=dict)  # how fast what falls is at first; else at rest
    # Who is around bricks that have come elsewhere; None if all that they may ever meet is known.
    look_around: Callable[[Sequence[Placed]], Collection[Placed]] | None = None
    _surroundings: Surroundings = field(init=False)  # in which all is known
    _velocities: list[Array] = field(init=False)  # (6 n,) with spins, in the middles of the last steps, latest first
    _last: float = field(default=0.0, init=False)  # how long the last step was [s]
    _forces_W: dict[tuple[BodyId, BodyId], Array] = field(default_factory=dict, init=False)  # [N]
    _energy: float = field(init=False)  # of place and motion, at first [J]
    _lands: bool = field(default=False, init=False)  # whether a corner comes down on what it touches elsewhere already
    _deepest: float = field(default=0.0, init=False)  # how far one body is in another, as a gap [m]
    _falls_by: float = field(default=inf, init=False)  # what is faster falls until it is there, and stops then [m/s]
    _jolted: float = field(default=0.0, init=False)  # by how much landings have moved what stands, at most [m]
    _stirs: bool = field(default=False, init=False)  # whether it moves still
    _opened: Array = field(init=False)  # the gaps that this has left at each point where it rests [m]

    def __post_init__(self) -> None:
        """All that is not known to move is at rest."""
        self._surroundings = surroundings_of(self._moving())
        first, bricks = np.zeros((len(self.place.bricks), 6)), self.place.bricks.values()
        for velocity, name in zip(first, self.place.bricks, strict=True):
            if name in self.begun:
                velocity[:] = (*self.begun[name].velocity_W, *self.begun[name].angular_velocity_W)
        self._velocities = [first.ravel()]
        self._energy = potential(bricks, self.gravity) + kinetic(bricks, self._velocities[0])
        self._opened = np.zeros(sum(cones_in(contact) for contact in self.touching.resting))

    def goes_on(self, duration: float) -> bool:
        """Move for a short time [s]; False, and not at all, if it is not known how."""
        self._see()
        finer, part = copy(self), duration / PARTS_OF_A_LANDING
        if not self._steps(duration):
            return False
        unseen = self._deepest < finer._deepest - duration * self._drift().max() - self._rounding()
        if self._lands or unseen or finer._stirs:
            finer._falls_by = GENTLY * self.gravity * duration
            if all(finer._steps(part, left) for left in reversed(range(PARTS_OF_A_LANDING))):
                vars(self).update(vars(finer), _falls_by=inf)
        return True

    def _moving(self) -> list[Placed]:
        return [self.place.bricks[name] for name in sorted(self.falling)]

    def _see(self) -> None:
        """Know who is around where the bricks have come to."""
        moving = self._moving()
        if self.look_around is not None and not self._surroundings.hold(moving):
            self._surroundings = surroundings_of(moving)
            self.place = self.place.with_fixed(self.look_around(moving))

    def _steps(self, duration: float, parts_left: int = 0) -> bool:
        """Take one step of so many seconds; False, and none, if it is not known how.

        Of the parts of a step energy is asked once they are all taken. The first goes on from the middle of a longer
        step along a chord, whose end is off what presses by the square of that step: it may be without what presses.
        """
        found = self.next_velocities(duration)
        if found is None or np.abs(found).max() <= AT_REST * self.gravity * duration:
            return False
        stirs = self._stir(found) > 0.0
        place = self.place.after(duration, found, self.place.bricks if stirs else self.falling)
        touches = None if place is None else self.touching.then(place)
        if place is None or touches is None or (not parts_left and self._gains(found, place)):
            return False
        smoothly = not self._lands and isclose(self._last, duration)
        self._velocities = [found, *(self._velocities if smoothly else ())][: max(ONWARD)]
        self._last = duration
        if stirs:
            self._opened = self._opened + duration * self._opening(found)
        self.place, self.touching, self._stirs = place, touches, stirs
        self._deepest = touches.deepest(place)
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Where what falls is, and how it moves; velocities are carried on from the middle of the last step."""
        now = np.einsum("i,ij->j", ONWARD[len(self._velocities)], self._velocities)
        return {
            name: BodyState(placed.pose, (a, b, c), (d, e, f))
            for (name, placed), (a, b, c, d, e, f) in zip(
                self.place.bricks.items(), now.reshape(-1, 6).tolist(), strict=True
            )
            if name in self.falling
        }

    def take_landed(self) -> Sequence[BodyId]:
        """None: an engine takes over before anything rests again."""
        return ()

    def next_velocities(self, duration: float) -> Array | None:
        """(6 n,) in the middle of a step of so many seconds from here; None if they are not known."""
        several = [alternatives(contact) for contact in self.touching.moving]
        velocities = self._allowed([each[0] for each in several], duration)
        if velocities is None:
            return None
        slipping = [i for i, each in enumerate(several) if len(each) > 1 and self._part_by(each, velocities)]
        if not slipping:
            return velocities
        for chosen in islice(product(*(several[i][1:] for i in slipping)), MOST_CHOICES):
            contacts = [each[0] for each in several]
            for i, contact in zip(slipping, chosen, strict=True):
                contacts[i] = contact
            velocities = self._allowed(contacts, duration)
            if velocities is not None and not any(self._part_by(several[i], velocities) for i in slipping):
                return velocities
        return None

    def _part_by(self, alternatives_of: Sequence[Contact], velocities: Array) -> bool:
        """Whether bodies that press on each other part along one of the normals that they may have."""
        pair = (alternatives_of[0].lower, alternatives_of[0].upper)
        if not np.any(self._forces_W.get(pair, 0.0)):
            return False
        cones = cones_of(Problem({}, alternatives_of[1:], {}), tuple(self.place.bricks))
        return bool((slip_matrix(cones, self.place) @ velocities)[0::3].max() > PARTS * np.abs(velocities).max())

    def _allowed(self, moving: Sequence[Contact], duration: float) -> Array | None:
        """Velocities that contacts allow, each with one normal at a point."""
        contacts = [*moving, *self.touching.resting]
        cones = cones_of(Problem({}, contacts, {}), tuple(self.place.bricks))
        if len(cones.lower) > MOST_POINTS:
            return None
        bricks, time = self.place.bricks.values(), 0.5 * (self._last + duration)
        units = scale_of_problem(bricks, self.gravity * time)
        out = self._drift()[np.stack([cones.lower, cones.upper])].max(axis=0)
        free = self._velocities[0] + time * accelerations(bricks, self._velocities[0], self.gravity)
        slips = slip_matrix(cones, self.place) * units.columns / units.speed
        before = (slips @ (self._velocities[0] / units.columns))[0::3]
        gaps = np.concatenate([self.touching.gaps(moving, self.place), self._opened])
        gaps = np.maximum(gaps / duration, -out) / units.speed
        gaps[(gaps > 0.0) & (before * units.speed < -self._falls_by)] += 10.0 * np.abs(before).max(initial=0.0)
        meeting = FrictionProblem(
            slips,
            inverse_mass(bricks) * (units.mass * units.speed**2) / np.outer(units.columns, units.columns),
            free / units.columns,
            gaps,
            Coulomb(cones.friction),
        )
        impulse = units.mass * units.speed
        found = pressed(meeting, self._guess(contacts, cones, time / impulse))
        if found is None:
            return None
        meets = np.where(found.impulses[:, 0] > 0.0, -before, 0.0)
        if any(meets[i] > LANDS and not self.touching.touched(*pair) for i, pair in enumerate(_pairs(contacts))):
            return None
        self._lands = bool(meets.max(initial=0.0) > GENTLY)
        velocities: Array = found.velocities * units.columns
        if not self._others_stand(velocities, duration):
            return None
        self._remember(contacts, cones, found.impulses * (impulse / time))
        return velocities

    def _drift(self) -> Array:
        """How fast points of each brick, and of the ground, may be pushed out of what they are in [m/s].

        By as much as turning has brought them there within the last step. What landed unseen is deeper, and would jump.
        """
        velocities = self._velocities[0].reshape(-1, 6)
        spins = np.linalg.norm(velocities[:, 3:], axis=1)
        radii = np.array([placed.brick.shape.bounding_radius for placed in self.place.bricks.values()])
        return np.append(self._last * spins * (np.linalg.norm(velocities[:, :3], axis=1) + spins * radii), 0.0)

    def _rounding(self) -> float:
        """How much deeper a brick may seem from step to step though nothing landed [m]."""
        return ROUNDING * min(placed.brick.shape.least_thickness for placed in self.place.bricks.values())

    def _others_stand(self, velocities: Array, duration: float) -> bool:
        """Whether what is to stand does, but for what landings move it by."""
        fastest = self._stir(velocities)
        if not fastest:
            return True
        if not self._lands and not self._jolted:
            return False
        self._jolted += fastest * duration
        return self._jolted <= JOLTED * min(placed.brick.shape.least_thickness for placed in self.place.bricks.values())

    def _stir(self, velocities: Array) -> float:
        """How fast what is to stand moves, at most [m/s]; 0 if it stands."""
        bricks = self.place.bricks
        speeds = np.abs(velocities.reshape(-1, 6))
        speeds[:, 3:] *= [[placed.brick.shape.bounding_radius] for placed in bricks.values()]
        fastest = float(speeds[[name not in self.falling for name in bricks]].max(initial=0.0))
        return fastest if fastest > STANDS * speeds.max(initial=0.0) else 0.0

    def _opening(self, velocities: Array) -> Array:
        """How fast bodies part at each point where what stands rests [m/s]."""
        cones = cones_of(Problem({}, self.touching.resting, {}), tuple(self.place.bricks))
        parting: Array = (slip_matrix(cones, self.place) @ velocities)[0::3]
        return parting

    def _guess(self, contacts: Sequence[Contact], cones: Cones, share: float) -> Array | None:
        """Impulses like the forces of the last step."""
        if not self._forces_W:
            return None
        known = []
        for contact in contacts:
            shape = (cones_in(contact), 3)
            before = self._forces_W.get((contact.lower, contact.upper), np.zeros(shape))
            known.append(before if before.shape == shape else np.zeros(shape))
        impulses: Array = share * np.einsum("cij,cj->ci", cones.axes_W, np.concatenate([np.zeros((0, 3)), *known]))
        return impulses

    def _remember(self, contacts: Sequence[Contact], cones: Cones, forces: Array) -> None:
        forces_W = np.einsum("cij,ci->cj", cones.axes_W, forces)
        ends = np.cumsum([0, *map(cones_in, contacts)])
        self._forces_W = {
            (contact.lower, contact.upper): forces_W[first:last]
            for contact, first, last in zip(contacts, ends, ends[1:], strict=False)
        }

    def _gains(self, velocities: Array, place: ContactScene) -> bool:
        """Whether there is more energy in the middle of the step than at first."""
        bricks = self.place.bricks.values()
        middle = 0.5 * (potential(bricks, self.gravity) + potential(place.bricks.values(), self.gravity))
        lost = self._energy - middle
        return kinetic(bricks, velocities) > (1.0 + GAINED) * lost + ROUNDING * abs(self._energy)


def frictional_motion_of(  # noqa: PLR0913, PLR0917 -- a problem, and what its bricks may come to touch
    problem: Problem,
    falling: Set[BodyId],
    gravity: float,
    others: Collection[Placed],
    planes: Collection[Plane],
    friction: GivenFriction,
    states: Mapping[BodyId, BodyState] | None = None,
) -> FrictionalMotion | None:
    """How bricks of a problem go on that cannot stand, if its other ones do; None if that is not known.

    `others` are what they may hit, those of the problem included; `states` tell how fast what falls already is, where
    it is not at rest.
    """
    bricks = dict(sorted(problem.bricks.items()))
    if not bricks.keys() >= falling:
        return None
    fixed = {placed.brick.id: placed for placed in others if placed.brick.id not in bricks}
    solids = {name: solid(placed) for name, placed in (*bricks.items(), *fixed.items())}
    place = ContactScene(bricks, fixed, {plane.id: plane for plane in planes}, as_friction(friction), solids)
    touches = touching(place, falling)
    return FrictionalMotion(place, touches, falling, gravity, states or {}) if touches is not None else None


def _pairs(contacts: Sequence[Contact]) -> Iterator[tuple[BodyId, BodyId]]:
    """The two bodies of each point and normal."""
    for contact in contacts:
        yield from [(contact.lower, contact.upper)] * cones_in(contact)
