"""How little more weight on one brick lets an assembly stand that falls?

One conic program a brick: the most power of the loads along a motion that no contact resists, where the brick may not
rise faster than a unit. That power is the weight: forces, the duals of the program, balance the loads and as much more
on the brick, and the motion still gains where it weighs less. Where the power has no end, no weight is enough.

The solver's point decides nothing. The weight that is handed out has forces that arithmetic has checked, and a share of
it that is as near as asked has a motion that falls.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from stability.blas_threads import one_thread
from stability.geometry.vectors import add
from stability.model import BodyId
from stability.statics.facts import ZERO, Problem, Tolerances, Wrench
from stability.statics.solvers.conic_program import ConicProgram, clarabel_solve, solve
from stability.statics.solvers.equilibrium import proven_forces, proven_motion
from stability.statics.solvers.wrench_matrix import wrench_matrix

ACCURACY = 1e-12  # asked of the solver
SHARES = (1e-8, 1e-6, 1e-4)  # by which a weight may be more than the least, tried in turn until forces are proven


@dataclass(frozen=True, slots=True)
class Counterweight:
    """The least weight at the centre of a brick with which contact forces balance."""

    brick: BodyId
    weight: float  # [N] proven to be enough for balance
    too_little: float  # [N] proven not to be; less than `weight` by a share of 1e-4 at most


@one_thread()
def counterweight(
    problem: Problem,
    brick: BodyId,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> Counterweight | None:
    """The least weight on a brick that balances a problem which nothing balances as it is; None if none is found.

    This asks for equilibrium alone, and not whether it rests on self-stress. Raises LookupError for an unknown brick.
    """
    if brick not in problem.bricks:
        raise LookupError(f"there is no brick '{brick}'")
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    system = wrench_matrix(problem, whole=True)
    unit = sum(-load.force_W[2] for load in problem.loads.values()) / max(1, len(problem.loads))  # [N] a usual weight
    pressing = system.wrench_of({brick: Wrench((0.0, 0.0, -unit))})
    program = ConicProgram(
        -system.loads,
        vstack([-system.matrix, csc_matrix(-pressing)], format="csc"),
        np.append(np.zeros(len(system.row_scale)), 1.0),
        0,
        [3] * len(system.round),
        len(system.flat) + 1,
    )
    point = solve(program, ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.dual).all() or not point.dual[-1] > 0.0:
        return None
    least, rows = float(point.dual[-1]) * unit, point.dual[:-1]
    for share in SHARES:
        enough, too_little = (_with_weight(problem, brick, factor * least) for factor in (1.0 + share, 1.0 - share))
        heavier, lighter = wrench_matrix(enough), wrench_matrix(too_little, whole=True)
        # Rows and columns are told in units that depend on what bricks carry, so each system has them in its own.
        forces = proven_forces(enough, heavier, rows * system.row_scale / heavier.row_scale, tolerances)
        columns = lighter.columns_of(system.motion(point.x))
        if forces is not None and proven_motion(too_little, lighter, columns, tolerances) is not None:
            return Counterweight(brick, (1.0 + share) * least, (1.0 - share) * least)
    return None


@one_thread()
def least_counterweight(problem: Problem, bricks: Collection[BodyId]) -> Counterweight | None:
    """The least of the weights on these bricks that balance a problem, ties by name; None if none does."""
    found = [weight for brick in sorted(bricks) if (weight := counterweight(problem, brick)) is not None]
    return min(found, key=lambda each: (each.weight, each.brick), default=None)


def _with_weight(problem: Problem, brick: BodyId, weight: float) -> Problem:
    load = problem.loads.get(brick, Wrench(ZERO))
    heavier = replace(load, force_W=add(load.force_W, (0.0, 0.0, -weight)))
    return replace(problem, loads={**problem.loads, brick: heavier})
