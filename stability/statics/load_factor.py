"""The load factor of a problem: how often its contacts can bear the loads, and the motion at which they yield.

Let K be the set of all contact forces that the contacts can bear: convex, and with the force zero. Forces within r K
balance the loads for some r if forces within K balance 1 / r of them. One conic program computes the least r, which is
zero if the contacts bear any factor, and for which no r exists if they bear none. Its dual is the motion of largest
power of the loads among those from which the contacts take a power of at most one: the mechanism that opens first. This
is limit analysis, with its lower and its upper bound.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from stability.geometry.rows import Array
from stability.statics.conic_program import ConicProgram, Solver, solve
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
    program, unit = _program(system, growing, constant)
    point = solve(program, accuracy, solver)
    if isinstance(point, str):
        return point
    return Yielding(point.x[:-1], point.dual[: program.equal], unit * float(point.x[-1]), point.status)


def _program(system: WrenchMatrix, growing: Array, constant: Array | None) -> tuple[ConicProgram, float]:
    """Return the program of the least share, its last unknown, and the unit of the share."""
    from scipy.sparse import bmat, csr_matrix, identity, vstack  # noqa: PLC0415 -- slow to import, seldom needed

    rows, limits = system.rows, system.bounded
    count = len(rows)
    each = identity(count, format="csr")
    largest = 0.0 if limits is None else max([float(np.abs(limits.least).max(initial=0.0)), *_intercepts(system)])
    unit = 1.0 / largest if largest > 0.0 else 1.0

    is_cone = np.ones(rows.round, dtype=bool)
    if limits is not None:
        is_cone[limits.cones] = False
    triples = (3 * np.flatnonzero(is_cone)[:, None] + np.arange(3)).ravel()
    round_parts, round_shares = [each[triples]], [np.zeros(len(triples))]
    flat_parts, flat_shares = [each[rows.of_round :]], [np.zeros(rows.flat)]
    if limits is not None:
        for which, intercept, slope in limits.borders:
            first = 3 * limits.cones[which]
            places = (first[:, None] + np.arange(3)).ravel()
            factor = np.stack([slope, np.ones(len(which)), np.ones(len(which))], axis=1).ravel()
            table = (factor, (np.arange(len(places)), places))
            round_parts.append(csr_matrix(table, shape=(len(places), count)))
            round_shares.append(np.stack([unit * intercept, *np.zeros((2, len(which)))], axis=1).ravel())
        flat_parts.append(each[3 * limits.cones])
        flat_shares.append(-unit * limits.least)
    cones = vstack([*round_parts, *flat_parts], format="csr")
    shares = np.concatenate([*round_shares, *flat_shares])
    steady = np.zeros(len(growing)) if constant is None else unit * constant
    matrix = bmat(
        [
            [system.matrix.T, csr_matrix(steady[:, None])],
            [-cones, csr_matrix(-shares[:, None])],
            [None, csr_matrix(np.array([[-1.0]]))],
        ],
        format="csc",
    )
    offset = np.append(-growing, np.zeros(matrix.shape[0] - len(growing)))
    cost = np.append(np.zeros(count), 1.0)
    sizes = [3] * (sum(part.shape[0] for part in round_parts) // 3)
    positive = sum(part.shape[0] for part in flat_parts) + 1
    return ConicProgram(cost, matrix, offset, len(growing), sizes, positive), unit


def _intercepts(system: WrenchMatrix) -> list[float]:
    return [] if system.bounded is None else [float(limit.max(initial=0.0)) for _, limit, _ in system.bounded.borders]
