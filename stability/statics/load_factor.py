"""The load factor of a problem: how often its contacts can bear the loads, and the motion at which they yield.

Let K be the set of all contact forces that the contacts can bear: convex, and with the force zero. Forces within r K
balance the loads for some r if forces within K balance 1 / r of them. One conic program computes the least r, which is
zero if the contacts bear any factor, and for which no r exists if they bear none. Its dual is the motion of largest
power of the loads among those from which the contacts take a power of at most one: the mechanism that opens first. This
is limit analysis, with its lower and its upper bound.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stability.geometry.rows import Array, Indices
from stability.statics.conic_program import ConicProgram, Matrix, Solver, SolverPoint, solve
from stability.statics.wrench_matrix import WrenchMatrix


@dataclass(frozen=True, slots=True, eq=False)
class Yielding:
    """Point of a solver, unproven: forces that balance the growing loads, and the motion at which contacts yield."""

    rows: Array  # forces that balance the growing loads, within their sets times `share`
    columns: Array  # the motion, up to a factor
    share: float  # the inverse of the load factor
    status: str


def yielding(
    system: WrenchMatrix, growing: Array, constant: Array | None, accuracy: float, solver: Solver
) -> Yielding | str:
    """Return the solver's point for loads that are `constant` plus a factor times `growing`, or why there is none."""
    cones, shares, sizes, positive = _limits(system)
    unit = 1.0 / (float(np.abs(shares).max(initial=0.0)) or 1.0)
    steady = np.zeros(len(growing)) if constant is None else unit * constant
    parts = [[system.matrix.T, _column(steady)], [-cones, _column(-unit * shares)], [None, _column(-np.ones(1))]]
    cost = np.append(np.zeros(cones.shape[1]), 1.0)
    offset = np.concatenate([-growing, np.zeros(len(shares) + 1)])
    point = solve(_program(cost, parts, offset, sizes, positive + 1), accuracy, solver)
    if isinstance(point, str):
        return point
    return Yielding(point.x[:-1], point.dual[: len(growing)], unit * float(point.x[-1]), point.status)


def central_forces(system: WrenchMatrix, loads: Array, accuracy: float, solver: Solver) -> Array | str:
    """Return forces that balance loads, as far within all limits as the solver's path leads; or why there are none.

    No cost pulls them to a border, so rounding errors can be corrected within the limits.
    """
    point = least_forces(system, loads, np.zeros(len(system.rows)), accuracy, solver)
    return point if isinstance(point, str) else point.x


def least_forces(system: WrenchMatrix, loads: Array, cost: Array, accuracy: float, solver: Solver) -> SolverPoint | str:
    """Return forces of least cost (rows,) that balance loads, and first in the dual the motion that proves the least.

    Without a point, returns the reason.
    """
    cones, shares, sizes, positive = _limits(system)
    offset = np.concatenate([-loads, shares])
    program = _program(cost, [[system.matrix.T], [-cones]], offset, sizes, positive)
    return solve(program, accuracy, solver)


def _program(
    cost: Array, parts: Sequence[Sequence[Matrix]], offset: Array, sizes: Sequence[int], positive: int
) -> ConicProgram:
    from scipy.sparse import bmat  # noqa: PLC0415 -- slow to import, seldom needed

    return ConicProgram(cost, bmat(parts, format="csc"), offset, len(offset) - sum(sizes) - positive, sizes, positive)


def _column(values: Array) -> Matrix:
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, seldom needed

    return csr_matrix(values[:, None])


def _limits(system: WrenchMatrix) -> tuple[Matrix, Array, list[int], int]:
    """Return the limits of forces, as a matrix and constants whose sum is in cones: sizes of round ones, then rays."""
    from scipy.sparse import csr_matrix, identity, vstack  # noqa: PLC0415 -- slow to import, seldom needed

    rows, bounded = system.rows, system.bounded
    each = identity(len(rows), format="csr")
    ties, slack = -each[system.of_ties], system.most_tension
    if bounded is None:
        shares = np.append(np.zeros(len(rows)), slack)
        return vstack([each, ties], format="csr"), shares, [3] * rows.round, rows.flat + len(slack)
    is_cone = np.ones(rows.round, dtype=bool)
    is_cone[bounded.cones] = False
    triples = _rows_of(np.flatnonzero(is_cone))
    parts, constants = [each[triples]], [np.zeros(len(triples))]
    for which, intercept, slope in bounded.borders:
        places, ones = _rows_of(bounded.cones[which]), np.ones(len(which))
        factors = np.stack([slope, ones, ones], axis=1).ravel()
        parts.append(csr_matrix((factors, (np.arange(len(places)), places)), shape=(len(places), len(rows))))
        constants.append(np.stack([intercept, 0.0 * ones, 0.0 * ones], axis=1).ravel())
    sizes = [3] * (sum(part.shape[0] for part in parts) // 3)
    parts += [each[rows.of_round :], each[3 * bounded.cones], ties]
    constants += [np.zeros(rows.flat), -bounded.least, slack]
    positive = rows.flat + len(bounded.cones) + len(slack)
    return vstack(parts, format="csr"), np.concatenate(constants), sizes, positive


def _rows_of(cones: Indices) -> Indices:
    """Return the three rows of each cone."""
    rows: Indices = (3 * cones[:, None] + np.arange(3)).ravel()
    return rows
