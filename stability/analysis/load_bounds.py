"""The least and the greatest force that each contact, and each brick, carries, with a proof of both.

Contact forces are not unique: a plank on three supports may lie on two of them. All forces that the contacts can bear
and that balance the loads are a convex set. A conic program computes the least sum of normal forces in this set, and
another one the greatest; all of them are solved together (`shared_forces`). The dual of each is a motion, and its
virtual power proves the bound by plain arithmetic (`greatest_sum`): no forces whatever carry more, or less.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import inf, nan
from typing import TypeVar

import numpy as np

from stability.contact_law import OtherLawError
from stability.geometry.rows import Array
from stability.geometry.vectors import add_scaled, cross, norm, subtract
from stability.model import BodyId, Vec3
from stability.problem import Contact, Motion, Problem, Tolerances, admit_problem, rounded
from stability.process_settings import one_thread
from stability.statics.certificate import lies_on
from stability.statics.conic_program import clarabel_solve
from stability.statics.equilibrium import proven_inside, separating_motion
from stability.statics.load_factor import central_forces, least_forces
from stability.statics.proof import (
    ProofCones,
    check_pressed,
    greatest_pressed,
    proof_cones,
    proof_loads,
    shortfalls_of,
    velocity_rows,
)
from stability.statics.round_borders import circumscribed, inscribed
from stability.statics.shared_forces import SharedForces
from stability.statics.wrench_matrix import WrenchMatrix, flattened, motion_of, wrench_matrix

ACCURACY = 1e-8  # share of a force to which bounds are computed
FAINT = 1e-6  # share of the greatest normal force below which one may be a rounding error
MOST_AT_ONCE = 2_000_000  # entries of the sums that are solved together
TWICE = 2.0  # a wider bound than this many times the accuracy is sought by a program of its own
ROUNDING = 1e-12  # share of the fastest speed by which contacts open beyond what a proof requires
CORNERS_OF_A_FACE = 3


@dataclass(frozen=True, slots=True)
class Bound:
    """Bound of a sum of normal forces."""

    force: float  # proven by `motion` [N]; infinite if none is proven
    reached: float | None = None  # the sum of the nearest forces that were found to balance the bricks [N]
    forces_W: Array | None = None  # (n, 3) these forces, by contact, point and normal [N]
    names: Sequence[BodyId] = ()
    velocity: Array | None = None  # (names, 6) velocities and spins of the bricks that prove the force [m/s, rad/s]

    @property
    def motion(self) -> Motion | None:
        """Return the proof; None without one."""
        return None if self.velocity is None else motion_of(self.names, self.velocity)

    @property
    def width(self) -> float:
        """Return the distance from the bound to what forces reach [N]; infinite if one of them is unknown."""
        return inf if self.reached is None else abs(self.force - self.reached)


UNKNOWN = Bound(inf)


@dataclass(frozen=True, slots=True)
class Carried:
    """Least and greatest force of a contact, or of all that lies on a brick."""

    least: Bound
    greatest: Bound
    area: float  # of the contacts [m2]; 0 for edges and corners

    @property
    def pressure(self) -> tuple[float, float] | None:
        """Return the least and the greatest mean pressure [Pa]; None if no face touches."""
        return (self.least.force / self.area, self.greatest.force / self.area) if self.area > 0.0 else None


@one_thread()
def loads_on(
    problem: Problem,
    bodies: Collection[BodyId] | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    accuracy: float = ACCURACY,
) -> dict[BodyId, Carried] | None:
    """Return by body the least and greatest sum of normal forces by which others lie on it; None if it cannot stand.

    `bodies` are bricks or fixed bodies of the problem, by default all. Contacts of upright faces side by side do not
    count, but their pushes and friction may carry weight. Forces that are found reach each bound within a share
    `accuracy` of the greatest sum, unless rounding and round borders prevent it. Raises LookupError for other names,
    OtherLawError for ties of unknown tension.
    """
    admit_problem(problem)
    present = {*problem.bricks, *(contact.lower for contact in problem.contacts)}
    for name in bodies or ():
        if name not in present:
            raise LookupError(f"there is no body '{name}' among the bricks and their supports")
    onto: dict[BodyId, list[int]] = {name: [] for name in sorted(present if bodies is None else bodies)}
    for number, contact in enumerate(problem.contacts):
        if contact.lower in onto and lies_on(contact):
            onto[contact.lower].append(number)
    return _of_groups(problem, onto, tolerances, accuracy)


@one_thread()
def loads_between(
    problem: Problem,
    pairs: Collection[tuple[BodyId, BodyId]] | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    accuracy: float = ACCURACY,
) -> dict[tuple[BodyId, BodyId], Carried] | None:
    """Return by lower and upper body the least and greatest normal force between them; None if they cannot stand.

    `pairs` are by default all that touch. Forces that are found reach each bound within a share `accuracy` of the
    greatest sum, unless rounding and round borders prevent it. Raises LookupError for a pair that does not touch,
    OtherLawError for ties of unknown tension.
    """
    admit_problem(problem)
    between: dict[tuple[BodyId, BodyId], list[int]] = {}
    for number, contact in enumerate(problem.contacts):
        between.setdefault((contact.lower, contact.upper), []).append(number)
    for lower, upper in pairs or ():
        if (lower, upper) not in between:
            raise LookupError(f"'{upper}' has no contact on '{lower}'")
    groups = between if pairs is None else {pair: between[pair] for pair in pairs}
    return _of_groups(problem, groups, tolerances, accuracy)


def area_of(contact: Contact) -> float:
    """Return the area of a contact [m2]; 0 for a line or a point, and for the points of a joint."""
    if contact.patch is not None:
        return contact.patch.area if contact.law.is_cone else 0.0
    corners = contact.points_W
    if len(corners) < CORNERS_OF_A_FACE or not contact.law.is_cone:
        return 0.0
    total: Vec3 = (0.0, 0.0, 0.0)
    for one, other in pairwise(corners[1:]):
        total = add_scaled(total, 0.5, cross(subtract(one, corners[0]), subtract(other, corners[0])))
    return norm(total)


Key = TypeVar("Key", BodyId, tuple[BodyId, BodyId])


def _of_groups(
    problem: Problem, groups: Mapping[Key, Sequence[int]], tolerances: Tolerances, accuracy: float
) -> dict[Key, Carried] | None:
    if problem.ties:
        raise OtherLawError("loads of bricks with ties of unknown tension are not supported")
    found = _sums(inscribed(problem), groups.values(), tolerances, accuracy)
    if found is not None and problem.is_round:
        # Forces within the true contacts reach the sums; polygons around the contacts prove the bounds.
        around = _sums(circumscribed(problem), groups.values(), tolerances, accuracy)
        if around is None:
            return None
        found = [
            (_with_forces_of(least, lower), _with_forces_of(greatest, upper))
            for (least, greatest), (lower, upper) in zip(around, found, strict=True)
        ]
    if found is None:
        return None
    areas = (sum(area_of(problem.contacts[number]) for number in contacts) for contacts in groups.values())
    return {key: Carried(*both, area) for key, both, area in zip(groups, found, areas, strict=True)}


def _sums(
    problem: Problem, groups: Iterable[Sequence[int]], tolerances: Tolerances, accuracy: float
) -> list[tuple[Bound, Bound]] | None:
    bounds = SumBounds(problem, tolerances)
    return bounds.of([bounds.weights_of(contacts) for contacts in groups], accuracy)


def _with_forces_of(bound: Bound, other: Bound) -> Bound:
    return replace(bound, reached=other.reached, forces_W=other.forces_W)


class SumBounds:
    """Programs of the least and greatest weighted sums of the normal forces of one problem."""

    def __init__(self, problem: Problem, tolerances: Tolerances) -> None:
        """Set up what all programs share."""
        self.problem = problem
        self._tolerances = rounded(problem, tolerances)
        self._system: WrenchMatrix = wrench_matrix(problem, any_law=True)
        self._cones: ProofCones | None = proof_cones(problem)
        self._loads = proof_loads(problem)
        self._normals_W = np.zeros((0, 3)) if self._cones is None else self._cones.normals
        self._shared = SharedForces.of(self._system)
        self._sizes = [len(contact.points_W) * len(contact.normals_W) for contact in problem.contacts]
        # A usual force, in which sums are written [N].
        self._unit = sum(norm(load.force_W) for load in problem.loads.values()) or 1.0
        self._order = np.append(self._system.round, self._system.flat)
        self._middle: Array | None = None

    def weights_of(self, contacts: Collection[int]) -> Array:
        """Return weights of 1 for the forces of some contacts, by number, and of 0 for all others."""
        chosen = np.zeros(len(self._sizes))
        chosen[list(contacts)] = 1.0
        return np.repeat(chosen, self._sizes)

    def of(self, weights: Sequence[Array], accuracy: float = ACCURACY) -> list[tuple[Bound, Bound]] | None:
        """Return the least and the greatest of each weighted sum; None if no forces are proven to balance the problem.

        The forces that are found reach a bound within a share `accuracy` of the greatest sum, unless rounding
        prevents it.
        """
        none = Bound(0.0, 0.0, velocity=np.zeros((0, 6)))
        some = [each for each in weights if each.any()]
        bounds = iter(self._greatest([sign * each for each in some for sign in (-1.0, 1.0)], accuracy))
        pairs = list(zip(bounds, bounds, strict=True))
        if any(lower.forces_W is None and upper.forces_W is None for lower, upper in pairs):
            return None
        found = iter([(_mirrored(lower), upper) for lower, upper in pairs])
        return [next(found) if each.any() else (none, none) for each in weights]

    def _greatest(self, weights: Sequence[Array], accuracy: float) -> list[Bound]:
        """Return the greatest weighted sums, with forces that nearly reach them and motions that prove them."""
        found: list[Bound] = []
        size = max(1, MOST_AT_ONCE // max(1, len(self._system.rows)))
        for first in range(0, len(weights), size):
            found += self._together(weights[first : first + size], accuracy)
        return found

    def _together(self, weights: Sequence[Array], accuracy: float) -> list[Bound]:
        """Return some greatest sums, each by a program of its own where that of all is not close enough."""
        if self._shared is None:
            return [self._alone(each) for each in weights]
        sums = np.stack([self._rows_of(each) for each in weights], axis=1)
        points = self._shared.greatest(sums, accuracy, self._smallest / self._unit)
        found = [self._bound(*each) for each in zip(weights, points.rows.T, points.columns.T, strict=True)]
        scales = np.maximum(self._smallest, self._unit * np.abs(sums.T @ self._shared.central_rows))
        return [
            bound if bound.width <= TWICE * accuracy * scale else _closer(bound, self._alone(each))
            for bound, each, scale in zip(found, weights, scales.tolist(), strict=True)
        ]

    def _alone(self, weights: Array) -> Bound:
        """Return the greatest weighted sum by a program of its own."""
        system = self._system
        point = least_forces(system, system.loads, -self._rows_of(weights), ACCURACY, clarabel_solve)
        return UNKNOWN if isinstance(point, str) else self._bound(weights, point.x, point.dual[: len(system.loads)])

    def _rows_of(self, weights: Array) -> Array:
        """Return the weights of the rows, by which their forces add up to a share of the usual force."""
        rows = np.zeros(len(self._system.rows))
        rows[self._system.rows.normals] = weights[self._order] / self._unit
        return rows * self._system.row_scale

    def _bound(self, weights: Array, rows: Array, columns: Array) -> Bound:
        """Return what proven forces near the given ones reach, and what a motion near the given one permits."""
        forces_W = self._balanced(rows)
        reached = None if forces_W is None else float(weights @ np.einsum("ij,ij->i", forces_W, self._normals_W))
        force, velocity = self._proof(weights, columns)
        return Bound(force, reached, forces_W, self._system.names, velocity)

    def _balanced(self, rows: Array) -> Array | None:
        """Return (n, 3) forces near the given ones that are proven to balance the problem [N]."""
        if self._cones is None or not np.isfinite(rows).all():
            return None
        forces_W = self._system.forces_W(rows)
        if check_pressed(self._cones, self._loads, forces_W, self._tolerances).holds:
            return forces_W
        # Contacts that can bear nothing must not keep what rounding left there.
        normal = self._system.rows.by_row(rows[self._system.rows.normals])
        for each in (rows, np.where(normal > FAINT * normal.max(), rows, 0.0)):
            forces = proven_inside(self.problem, self._system, each, self._central, self._tolerances)
            if forces is not None:
                return flattened(forces)
        return None

    def _central(self) -> Array | None:
        """Return forces far within all limits."""
        if self._middle is None:
            middle = central_forces(self._system, self._system.loads, ACCURACY, clarabel_solve)
            self._middle = np.full(len(self._system.rows), nan) if isinstance(middle, str) else middle
        return self._middle

    def _proof(self, weights: Array, columns: Array) -> tuple[float, Array | None]:
        """Return a bound, and velocities near the given ones that open all contacts fast enough to prove it."""
        if not np.isfinite(columns).all() or self._cones is None:
            return inf, None
        # In this scale weights are speeds of 1 m/s.
        velocity = np.vstack([self._system.velocity(self._unit * columns), np.zeros(6)])
        force = greatest_pressed(self._cones, self._loads, weights, velocity)
        if force == inf and self._separating is not None:
            separating, spare = self._separating
            fastest = float(np.abs(velocity[:, :3]).max(initial=0.0))
            short = shortfalls_of(self._cones, weights, velocity)
            velocity += float(((short + ROUNDING * (1.0 + fastest)) / spare).max()) * separating
            force = greatest_pressed(self._cones, self._loads, weights, velocity)
        if force == inf:  # rest proves at least that contacts only push
            velocity = np.zeros_like(velocity)
            force = greatest_pressed(self._cones, self._loads, weights, velocity)
        return force, None if force == inf else velocity[:-1]

    @cached_property
    def _separating(self) -> tuple[Array, Array] | None:
        """Return velocities that open all contacts, and how fast [m/s]."""
        motion = separating_motion(self.problem)
        if motion is None or self._cones is None:
            return None
        velocity = velocity_rows(self._system.names, motion)
        return (
            None
            if velocity is None
            else (velocity, -shortfalls_of(self._cones, np.zeros(len(self._normals_W)), velocity))
        )

    @cached_property
    def _smallest(self) -> float:
        """Return the smallest load of a brick [N], below which forces need not be told apart."""
        return max(FAINT * self._unit, min((norm(load.force_W) for load in self.problem.loads.values()), default=0.0))


def _closer(one: Bound, other: Bound) -> Bound:
    """Return the closer bound of both, with the closer forces."""
    bound, forces = min(one, other, key=lambda each: each.force), max(one, other, key=_reached)
    return _with_forces_of(bound, forces)


def _reached(bound: Bound) -> float:
    return -inf if bound.reached is None else bound.reached


def _mirrored(bound: Bound) -> Bound:
    """Return the least sum from the greatest one of opposite weights."""
    return replace(bound, force=-bound.force, reached=None if bound.reached is None else -bound.reached)
