"""The least and the greatest force that each contact, and each brick, carries, with a proof of both.

Contact forces are not unique: a plank on three supports may lie on two of them. All forces that the contacts can bear
and that balance the loads are a convex set. A conic program computes the least sum of normal forces in this set, and
another one the greatest; both have the same matrix. The dual of each is a motion, and its virtual power proves the
bound by plain arithmetic (`greatest_sum`): no forces whatever carry more, or less.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
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
from stability.statics.conic_program import OffsetSeries, SolverPoint, clarabel_solve, solve
from stability.statics.equilibrium import INWARDS, factorized_correction, proven_inside, separating_motion
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
from stability.statics.wrench_matrix import WrenchMatrix, flattened, motion_of, wrench_matrix

ACCURACY = 1e-8  # requested of the solver, whose points are corrected and checked
ROUNDING = 1e-12  # share of the fastest speed by which contacts open beyond what a proof requires
CORRECTIONS = 2  # of forces by the same factorization
CORNERS_OF_A_FACE = 3


@dataclass(frozen=True, slots=True)
class Bound:
    """Bound of a sum of normal forces."""

    force: float  # proven by `motion` [N]; infinite if none is proven
    motion: Motion | None  # the proof
    reached: float | None  # the sum of the nearest forces that were found to balance the bricks [N]
    forces_W: Array | None  # (n, 3) these forces, by contact, point and normal [N]


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
) -> dict[BodyId, Carried] | None:
    """Return by body the least and greatest sum of normal forces by which others lie on it; None if it cannot stand.

    `bodies` are bricks or fixed bodies of the problem, by default all. Contacts of upright faces side by side do not
    count, but their pushes and friction may carry weight. Raises LookupError for other names, OtherLawError
    for round contacts.
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
    return _of_groups(problem, onto, tolerances)


@one_thread()
def loads_between(
    problem: Problem,
    pairs: Collection[tuple[BodyId, BodyId]] | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> dict[tuple[BodyId, BodyId], Carried] | None:
    """Return by lower and upper body the least and greatest normal force between them; None if they cannot stand.

    `pairs` are by default all that touch. Raises LookupError for a pair that does not touch, OtherLawError for
    round contacts.
    """
    admit_problem(problem)
    between: dict[tuple[BodyId, BodyId], list[int]] = {}
    for number, contact in enumerate(problem.contacts):
        between.setdefault((contact.lower, contact.upper), []).append(number)
    for lower, upper in pairs or ():
        if (lower, upper) not in between:
            raise LookupError(f"'{upper}' has no contact on '{lower}'")
    groups = between if pairs is None else {pair: between[pair] for pair in pairs}
    return _of_groups(problem, groups, tolerances)


def area_of(contact: Contact) -> float:
    """Return the area of a contact [m2]; 0 for a line or a point, and for the points of a joint."""
    corners = contact.points_W
    if len(corners) < CORNERS_OF_A_FACE or not contact.law.is_cone:
        return 0.0
    total: Vec3 = (0.0, 0.0, 0.0)
    for one, other in pairwise(corners[1:]):
        total = add_scaled(total, 0.5, cross(subtract(one, corners[0]), subtract(other, corners[0])))
    return norm(total)


Key = TypeVar("Key", BodyId, tuple[BodyId, BodyId])


def _of_groups(
    problem: Problem, groups: Mapping[Key, Sequence[int]], tolerances: Tolerances
) -> dict[Key, Carried] | None:
    if problem.is_round:
        raise OtherLawError("loads of bricks with round contacts are not supported")
    if problem.ties:
        raise OtherLawError("loads of bricks with ties of unknown tension are not supported")
    bounds = SumBounds(problem, tolerances)
    found: dict[Key, Carried] = {}
    for key, contacts in groups.items():
        both = bounds.of(bounds.weights_of(contacts))
        if both is None:
            return None
        found[key] = Carried(*both, sum(area_of(problem.contacts[number]) for number in contacts))
    return found


class SumBounds:
    """Programs of the least and greatest weighted sums of the normal forces of one problem."""

    def __init__(self, problem: Problem, tolerances: Tolerances) -> None:
        """Set up the matrix that all programs share."""
        self.problem = problem
        self._tolerances = rounded(problem, tolerances)
        self._system: WrenchMatrix = wrench_matrix(problem, any_law=True)
        self._cones: ProofCones | None = proof_cones(problem)
        self._loads = proof_loads(problem)
        self._normals_W = np.zeros((0, 3)) if self._cones is None else self._cones.normals
        separating = separating_motion(problem)
        self._separating = None if separating is None else velocity_rows(self._system.names, separating)
        self._spare: Array | None = None
        if self._cones is not None and self._separating is not None:
            self._spare = -shortfalls_of(self._cones, np.zeros(len(self._normals_W)), self._separating)
        self._sizes = [len(contact.points_W) * len(contact.normals_W) for contact in problem.contacts]
        # A usual force, in which costs are written [N].
        self._unit = sum(norm(load.force_W) for load in problem.loads.values()) or 1.0
        rows, system = self._system.rows, self._system
        self._normal_rows, self._order = rows.normals, np.append(system.round, system.flat)
        self._transposed = system.matrix.T.tocsr()
        program = rows.program(-system.loads, -system.matrix, np.zeros(len(rows)))
        self._middle: Array | None = None
        self._correction: Callable[[Array], Array] | None = None
        self._series = OffsetSeries(program, ACCURACY)

    def weights_of(self, contacts: Collection[int]) -> Array:
        """Return weights of 1 for the forces of some contacts, by number, and of 0 for all others."""
        chosen = np.zeros(len(self._sizes))
        chosen[list(contacts)] = 1.0
        return np.repeat(chosen, self._sizes)

    def of(self, weights: Array) -> tuple[Bound, Bound] | None:
        """Return the least and the greatest weighted sum; None if no forces are proven to balance the problem."""
        if not weights.any():
            none = Bound(0.0, Motion({}), 0.0, None)
            return none, none
        lower, upper = self._greatest(-weights), self._greatest(weights)
        if lower.forces_W is None and upper.forces_W is None:
            return None
        reached = None if lower.reached is None else -lower.reached
        return replace(lower, force=-lower.force, reached=reached), upper

    def _greatest(self, weights: Array) -> Bound:
        """Return the greatest weighted sum, with forces that reach it nearly and a motion that proves it."""
        system = self._system
        cost = np.zeros(len(system.rows))
        cost[self._normal_rows] = -weights[self._order] / self._unit
        cost *= system.row_scale
        point = self._solved(cost)
        if isinstance(point, str):
            return Bound(inf, None, None, None)
        rows, columns = (point.dual, point.x) if system.bounded is None else (point.x, point.dual[: len(system.loads)])
        forces_W = self._balanced(rows)
        reached = None if forces_W is None else float(weights @ np.einsum("ij,ij->i", forces_W, self._normals_W))
        velocity = self._proof(weights, columns)
        if velocity is None or self._cones is None:
            return Bound(inf, None, reached, forces_W)
        force = greatest_pressed(self._cones, self._loads, weights, velocity)
        return Bound(force, motion_of(system.names, velocity[:-1]), reached, forces_W)

    def _solved(self, cost: Array) -> SolverPoint | str:
        """Return the forces of least cost and their motion; without bounded forces, as the dual of the motion."""
        if self._system.bounded is not None:
            return least_forces(self._system, self._system.loads, cost, ACCURACY, clarabel_solve)
        return solve(self._series.program, ACCURACY, lambda *_: self._series.solve(cost))

    def _balanced(self, rows: Array) -> Array | None:
        """Return (n, 3) forces near the given ones that are proven to balance the problem [N]."""
        for share in INWARDS:
            forces_W = self._corrected(rows + share * (self._central() - rows))
            if forces_W is not None:
                return forces_W
        forces = proven_inside(self.problem, self._system, rows, self._central, self._tolerances)
        return None if forces is None else flattened(forces)

    def _corrected(self, rows: Array) -> Array | None:
        """Return forces without their residual, by the factorization of the central forces, if they are proven."""
        system = self._system
        if self._correction is None:
            self._correction = factorized_correction(system, self._central())
        if self._correction is None or self._cones is None or not np.isfinite(rows).all():
            return None
        rows = system.project(rows)
        for _ in range(CORRECTIONS):
            rows = rows + self._correction(self._transposed @ rows + system.loads)
        forces_W = system.forces_W(rows)
        return forces_W if check_pressed(self._cones, self._loads, forces_W, self._tolerances).holds else None

    def _central(self) -> Array:
        """Return forces far within all limits."""
        if self._middle is None:
            middle = central_forces(self._system, self._system.loads, ACCURACY, clarabel_solve)
            self._middle = np.full(len(self._system.rows), nan) if isinstance(middle, str) else middle
        return self._middle

    def _proof(self, weights: Array, columns: Array) -> Array | None:
        """Return velocities near the given ones that open all contacts fast enough to prove a bound."""
        if not np.isfinite(columns).all() or self._cones is None:
            return None
        # In this scale weights are speeds of 1 m/s.
        velocity = np.vstack([self._system.velocity(self._unit * columns), np.zeros(6)])
        short = shortfalls_of(self._cones, weights, velocity)
        if not (short > 0.0).any():
            return velocity
        if self._separating is None or self._spare is None:
            return None
        fastest = float(np.abs(velocity[:, :3]).max(initial=0.0))
        rate = float(((short + ROUNDING * (1.0 + fastest)) / self._spare).max())
        return velocity + rate * self._separating
