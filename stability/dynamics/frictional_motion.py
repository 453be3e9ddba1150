"""Motion of bricks that slip, tip and separate, by contact forces with Coulomb friction, until one lands.

Gauss' principle of least constraint with Coulomb's cone at every contact point gives the accelerations (coulomb.py).
Each step solves it for velocities in the middle of steps and poses at their ends (leapfrog), so that errors are of
second order in the step; contacts and their gaps depend only on the poses. If a corner lands on a body that its brick
has touched, the step is split and the corner stops in one impact; bricks that the impact lifts by micrometres move on
until they stand again. Every step is checked: momentum holds by construction, the residual verifies cones and slips,
and only friction may dissipate energy. The motion ends when a brick touches a new body, a standing brick begins to
move, or no solution is found.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Set
from copy import copy
from dataclasses import dataclass, field
from itertools import islice, product
from math import inf, isclose

import numpy as np

from stability.contact_law import Coulomb, GivenFriction, as_friction
from stability.contacts.bodies import solid
from stability.dynamics.contact_points import ContactScene, SceneContacts, alternatives, cones_in, slip_matrix, touching
from stability.dynamics.coulomb import (
    FrictionProblem,
    accelerations,
    inverse_mass,
    kinetic,
    potential,
    scale_of_problem,
    solve_friction,
)
from stability.dynamics.surroundings import Surroundings, surroundings_of
from stability.geometry.rows import Array
from stability.model import BodyId, BodyState, Plane
from stability.problem import Contact, Placed, Problem
from stability.statics.wrench_matrix import Cones, cones_of

MOST_POINTS = 150  # of contact; a step takes tens of milliseconds
LANDS = 3.0  # closing speed of an impact, in units of the speed that gravity adds in a step
GENTLY = 0.3  # the same for bodies that already touch elsewhere
# Sub-steps of a step with an impact, whose result has only first order.
PARTS_OF_A_LANDING = 32
# Largest motion of a standing brick by impacts, as a share of its least thickness: a twentieth of the contact
# tolerance, as its contact points are not updated.
JOLTED = 1e-3
AT_REST = 1e-6  # speed of bricks at rest, in units of the speed that gravity adds in a step
STANDS = 1e-5  # largest speed of a standing brick, as a share of the largest speed
GAINED = 1e-3  # tolerated gain of energy, as a share of the potential energy lost
ROUNDING = 1e-9  # rounding, as a share of the energy, and of the least thickness of a brick
PARTS = 1e-5  # share of the largest velocity above which loaded bodies separate
# Extrapolation of velocities from the middles of steps, latest first, to the end of the last step, by their number.
ONWARD = {1: (1.0,), 2: (1.5, -0.5), 3: (1.875, -1.25, 0.375)}
MOST_CHOICES = 4  # combinations of normals in a step


@dataclass
class FrictionalMotion:
    """Falling bricks, and the standing bricks that their forces reach."""

    place: ContactScene  # poses of all bricks
    touching: SceneContacts
    falling: Collection[BodyId]  # moving bricks
    gravity: float  # [m/s2]
    begun: Mapping[BodyId, BodyState] = field(default_factory=dict)  # initial states of moving bricks; default: at rest
    # Returns the bricks around displaced bricks; None if the scene is complete.
    look_around: Callable[[Sequence[Placed]], Collection[Placed]] | None = None
    _surroundings: Surroundings = field(init=False)  # region in which the scene is complete
    _velocities: list[Array] = field(init=False)  # (6 n,) with spins, in the middles of the last steps, latest first
    _last: float = field(default=0.0, init=False)  # duration of the last step [s]
    _forces_W: dict[tuple[BodyId, BodyId], Array] = field(default_factory=dict, init=False)  # [N]
    _energy: float = field(init=False)  # initial energy [J]
    _lands: bool = field(default=False, init=False)  # whether a corner hits a body that its brick already touches
    _deepest: float = field(default=0.0, init=False)  # deepest overlap, as a negative gap [m]
    _impact_speed: float = field(default=inf, init=False)  # faster closing points move freely until they touch [m/s]
    _displacement: float = field(default=0.0, init=False)  # upper bound of the motion of standing bricks by impacts [m]
    _others_move: bool = field(default=False, init=False)  # whether standing bricks still move
    _opened: Array = field(init=False)  # gaps at their contact points from that motion [m]

    def __post_init__(self) -> None:
        """Set the initial velocities; bricks without an initial state are at rest."""
        self._surroundings = surroundings_of(self._moving())
        first, bricks = np.zeros((len(self.place.bricks), 6)), self.place.bricks.values()
        for velocity, name in zip(first, self.place.bricks, strict=True):
            if name in self.begun:
                velocity[:] = (*self.begun[name].velocity_W, *self.begun[name].angular_velocity_W)
        self._velocities = [first.ravel()]
        self._energy = potential(bricks, self.gravity) + kinetic(bricks, self._velocities[0])
        self._opened = np.zeros(sum(cones_in(contact) for contact in self.touching.resting))

    def advance(self, duration: float) -> bool:
        """Advance by a short time [s]; return False, without advancing, if no solution is found."""
        self._update_surroundings()
        finer, part = copy(self), duration / PARTS_OF_A_LANDING
        if not self._steps(duration):
            return False
        undetected_impact = self._deepest < finer._deepest - duration * self._drift().max() - self._rounding()
        if self._lands or undetected_impact or finer._others_move:
            finer._impact_speed = GENTLY * self.gravity * duration
            if all(finer._steps(part, parts_left) for parts_left in reversed(range(PARTS_OF_A_LANDING))):
                vars(self).update(vars(finer), _impact_speed=inf)
        return True

    def _moving(self) -> list[Placed]:
        return [self.place.bricks[name] for name in sorted(self.falling)]

    def _update_surroundings(self) -> None:
        """Add the surroundings of the moving bricks to the scene if these have left the known region."""
        moving = self._moving()
        if self.look_around is not None and not self._surroundings.hold(moving):
            self._surroundings = surroundings_of(moving)
            self.place = self.place.with_fixed(self.look_around(moving))

    def _steps(self, duration: float, parts_left: int = 0) -> bool:
        """Take one step of a duration [s]; return False, without a step, if no solution is found.

        The energy of sub-steps is checked after the last. The first sub-step starts from the middle of a longer step on
        a chord, whose end has an error of the square of that step, so its forces may be inaccurate.
        """
        velocities = self.next_velocities(duration)
        if velocities is None or np.abs(velocities).max() <= AT_REST * self.gravity * duration:
            return False
        others_move = self._speed_of_others(velocities) > 0.0
        place = self.place.after(duration, velocities, self.place.bricks if others_move else self.falling)
        touches = None if place is None else self.touching.then(place)
        if place is None or touches is None or (not parts_left and self._gains(velocities, place)):
            return False
        without_impact = not self._lands and isclose(self._last, duration)
        self._velocities = [velocities, *(self._velocities if without_impact else ())][: max(ONWARD)]
        self._last = duration
        if others_move:
            self._opened = self._opened + duration * self._opening(velocities)
        self.place, self.touching, self._others_move = place, touches, others_move
        self._deepest = touches.deepest(place)
        return True

    def states(self) -> dict[BodyId, BodyState]:
        """Return the states of the falling bricks, with velocities extrapolated from the middle of the last step."""
        now = np.einsum("i,ij->j", ONWARD[len(self._velocities)], self._velocities)
        return {
            name: BodyState(placed.pose, (a, b, c), (d, e, f))
            for (name, placed), (a, b, c, d, e, f) in zip(
                self.place.bricks.items(), now.reshape(-1, 6).tolist(), strict=True
            )
            if name in self.falling
        }

    def take_landed(self) -> Sequence[BodyId]:
        """Return no bricks: an engine takes over before any comes to rest."""
        return ()

    def next_velocities(self, duration: float) -> Array | None:
        """Return the velocities in the middle of the next step of a duration [s], (6 n,); None without a solution."""
        options = [alternatives(contact) for contact in self.touching.moving]
        velocities = self._allowed([contact_options[0] for contact_options in options], duration)
        if velocities is None:
            return None
        slipping = [
            i
            for i, contact_options in enumerate(options)
            if len(contact_options) > 1 and self._separates(contact_options, velocities)
        ]
        if not slipping:
            return velocities
        for chosen in islice(product(*(options[i][1:] for i in slipping)), MOST_CHOICES):
            contacts = [contact_options[0] for contact_options in options]
            for i, contact in zip(slipping, chosen, strict=True):
                contacts[i] = contact
            velocities = self._allowed(contacts, duration)
            if velocities is not None and not any(self._separates(options[i], velocities) for i in slipping):
                return velocities
        return None

    def _separates(self, alternatives_of: Sequence[Contact], velocities: Array) -> bool:
        """Check that loaded bodies separate along one of their alternative normals."""
        pair = (alternatives_of[0].lower, alternatives_of[0].upper)
        if not np.any(self._forces_W.get(pair, 0.0)):
            return False
        cones = cones_of(Problem({}, alternatives_of[1:], {}), tuple(self.place.bricks))
        return bool((slip_matrix(cones, self.place) @ velocities)[0::3].max() > PARTS * np.abs(velocities).max())

    def _allowed(self, moving: Sequence[Contact], duration: float) -> Array | None:
        """Solve for the velocities with these moving contacts, which have one normal per point."""
        contacts = [*moving, *self.touching.resting]
        cones = cones_of(Problem({}, contacts, {}), tuple(self.place.bricks))
        if len(cones.lower) > MOST_POINTS:
            return None
        bricks, time = self.place.bricks.values(), 0.5 * (self._last + duration)
        units = scale_of_problem(bricks, self.gravity * time)
        push_out = self._drift()[np.stack([cones.lower, cones.upper])].max(axis=0)
        free = self._velocities[0] + time * accelerations(bricks, self._velocities[0], self.gravity)
        slips = slip_matrix(cones, self.place) * units.columns / units.speed
        before = (slips @ (self._velocities[0] / units.columns))[0::3]
        gaps = np.concatenate([self.touching.gaps(moving, self.place), self._opened])
        gaps = np.maximum(gaps / duration, -push_out) / units.speed
        gaps[(gaps > 0.0) & (before * units.speed < -self._impact_speed)] += 10.0 * np.abs(before).max(initial=0.0)
        problem = FrictionProblem(
            slips,
            inverse_mass(bricks) * (units.mass * units.speed**2) / np.outer(units.columns, units.columns),
            free / units.columns,
            gaps,
            Coulomb(cones.friction),
        )
        impulse = units.mass * units.speed
        solution = solve_friction(problem, self._guess(contacts, cones, time / impulse))
        if solution is None:
            return None
        impact_speeds = np.where(solution.impulses[:, 0] > 0.0, -before, 0.0)
        if any(
            impact_speeds[i] > LANDS and not self.touching.touched(*pair) for i, pair in enumerate(_pairs(contacts))
        ):
            return None
        self._lands = bool(impact_speeds.max(initial=0.0) > GENTLY)
        velocities: Array = solution.velocities * units.columns
        if not self._others_stand(velocities, duration):
            return None
        self._remember(contacts, cones, solution.impulses * (impulse / time))
        return velocities

    def _drift(self) -> Array:
        """Return the largest speed at which each brick, and the ground, may be pushed out of an overlap [m/s].

        It is the overlap that rotation causes in one step. An undetected impact overlaps deeper, and would jump.
        """
        velocities = self._velocities[0].reshape(-1, 6)
        spins = np.linalg.norm(velocities[:, 3:], axis=1)
        radii = np.array([placed.brick.shape.bounding_radius for placed in self.place.bricks.values()])
        return np.append(self._last * spins * (np.linalg.norm(velocities[:, :3], axis=1) + spins * radii), 0.0)

    def _rounding(self) -> float:
        """Return the change of an overlap by rounding [m]."""
        return ROUNDING * min(placed.brick.shape.least_thickness for placed in self.place.bricks.values())

    def _others_stand(self, velocities: Array, duration: float) -> bool:
        """Check that the standing bricks stand, except for small motions by impacts."""
        fastest = self._speed_of_others(velocities)
        if not fastest:
            return True
        if not self._lands and not self._displacement:
            return False
        self._displacement += fastest * duration
        return self._displacement <= JOLTED * min(
            placed.brick.shape.least_thickness for placed in self.place.bricks.values()
        )

    def _speed_of_others(self, velocities: Array) -> float:
        """Return the largest speed of the standing bricks [m/s]; 0 if they stand."""
        bricks = self.place.bricks
        speeds = np.abs(velocities.reshape(-1, 6))
        speeds[:, 3:] *= [[placed.brick.shape.bounding_radius] for placed in bricks.values()]
        fastest = float(speeds[[name not in self.falling for name in bricks]].max(initial=0.0))
        return fastest if fastest > STANDS * speeds.max(initial=0.0) else 0.0

    def _opening(self, velocities: Array) -> Array:
        """Return the opening speed at each contact point of the standing bricks [m/s]."""
        cones = cones_of(Problem({}, self.touching.resting, {}), tuple(self.place.bricks))
        parting: Array = (slip_matrix(cones, self.place) @ velocities)[0::3]
        return parting

    def _guess(self, contacts: Sequence[Contact], cones: Cones, share: float) -> Array | None:
        """Return initial impulses from the forces of the last step."""
        if not self._forces_W:
            return None
        forces = []
        for contact in contacts:
            shape = (cones_in(contact), 3)
            before = self._forces_W.get((contact.lower, contact.upper), np.zeros(shape))
            forces.append(before if before.shape == shape else np.zeros(shape))
        impulses: Array = share * np.einsum("cij,cj->ci", cones.axes_W, np.concatenate([np.zeros((0, 3)), *forces]))
        return impulses

    def _remember(self, contacts: Sequence[Contact], cones: Cones, forces: Array) -> None:
        forces_W = np.einsum("cij,ci->cj", cones.axes_W, forces)
        ends = np.cumsum([0, *map(cones_in, contacts)])
        self._forces_W = {
            (contact.lower, contact.upper): forces_W[first:last]
            for contact, first, last in zip(contacts, ends, ends[1:], strict=False)
        }

    def _gains(self, velocities: Array, place: ContactScene) -> bool:
        """Check for more energy in the middle of the step than initially."""
        bricks = self.place.bricks.values()
        middle = 0.5 * (potential(bricks, self.gravity) + potential(place.bricks.values(), self.gravity))
        lost = self._energy - middle
        return kinetic(bricks, velocities) > (1.0 + GAINED) * lost + ROUNDING * abs(self._energy)


def frictional_motion_of(  # noqa: PLR0913, PLR0917 -- a problem, and the bodies that its bricks may touch
    problem: Problem,
    falling: Set[BodyId],
    gravity: float,
    others: Collection[Placed],
    planes: Collection[Plane],
    friction: GivenFriction,
    states: Mapping[BodyId, BodyState] | None = None,
) -> FrictionalMotion | None:
    """Return the motion of the falling bricks of a problem, if its others stand; None if bricks overlap too deeply.

    `others` are the bricks that they may hit, including those of the problem; `states` are initial states of falling
    bricks that are not at rest.
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
    """Yield the two bodies of each point and normal."""
    for contact in contacts:
        yield from [(contact.lower, contact.upper)] * cones_in(contact)
