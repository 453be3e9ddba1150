"""Conic programs, and the solver that computes points for them. The solver's status is used only as a note."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from stability.geometry.rows import Array
from stability.work_limit import TooMuchWorkError, add_program, add_steps

Matrix: TypeAlias = Any  # compressed by column; scipy's matrices have no types

FINE = 1e-10  # requested accuracies below this leave little to correct
MOST_STEPS = 200  # of the interior-point method; 15 to 40 are usual
# Rows. For larger programs refining each step's solution is a third of the work and gains less than later corrections.
LARGE = 20_000
SOLVED, NEARLY_SOLVED = "Solved", "AlmostSolved"
INFEASIBLE = "Infeasible"  # part of the status of a program without a solution


@dataclass(frozen=True, slots=True, eq=False)
class ConicProgram:
    """Minimise `cost @ x` with `offset - matrix @ x` zero in the first `equal` rows and in cones in the other rows.

    With `curvature`, half of `x @ curvature @ x` is added to the cost. A round cone of size k has k rows of which the
    first is at least the norm of the others. A semidefinite cone has the upper triangle of a symmetric matrix, by
    columns, with the off-diagonal entries times the square root of two.
    """

    cost: Array  # (columns,)
    matrix: Matrix  # (rows, columns)
    offset: Array  # (rows,)
    equal: int = 0  # number of rows
    round: Sequence[int] = ()  # sizes of the round cones
    positive: int = 0  # number of rows that must not be negative
    curvature: Matrix = None  # (columns, columns), its upper triangle
    semidefinite: int = 0  # size of the only semidefinite cone, in the last rows


@dataclass(frozen=True, slots=True, eq=False)
class SolverPoint:
    """Final point of a solver, and the status that it reports."""

    x: Array  # (columns,)
    dual: Array  # (rows,) in the same cones for a solution: `matrix.T @ dual + cost = 0`
    status: str


Solver: TypeAlias = Callable[[ConicProgram, float], SolverPoint]  # arguments: the program and the requested accuracy


def clarabel_solve(program: ConicProgram, accuracy: float) -> SolverPoint:
    """Return Clarabel's point, by an interior-point method."""
    if len(program.offset) > LARGE:
        quick = quick_solve(program, accuracy)
        # An unreachable accuracy ends in "almost solved" with refinement too: the check shows whether the point is good
        # enough.
        if quick.status == SOLVED or (quick.status == NEARLY_SOLVED and accuracy < FINE):
            return quick
    return _solved(program, accuracy, refined=True)


def quick_solve(program: ConicProgram, accuracy: float) -> SolverPoint:
    """Return Clarabel's point without refinement, which is a third of the work: enough for low accuracy."""
    return _solved(program, accuracy, refined=False)


def _solved(program: ConicProgram, accuracy: float, *, refined: bool) -> SolverPoint:
    count_work(program)
    solution = _made_ready(program, accuracy, refined=refined).solve()
    add_steps(_entries(program), solution.iterations)
    return _point(solution)


class QuickSeries:
    """Solver of programs whose matrices differ in values but not in sparsity.

    Only the first program needs a set-up, a tenth of its time.
    """

    def __init__(self, accuracy: float) -> None:
        """Store the `accuracy` that is requested for all programs."""
        self._accuracy = accuracy
        self._solver: Any = None

    def solve(self, program: ConicProgram) -> SolverPoint:
        """Return the point of the next program."""
        if self._solver is None:
            self._solver = _made_ready(program, self._accuracy, refined=False)
        else:
            self._solver.update(A=program.matrix)
        return _point(self._solver.solve())


def count_work(program: ConicProgram) -> None:
    """Count the work of a program before it is solved. Raises TooMuchWorkError."""
    add_program(_entries(program))


def _entries(program: ConicProgram) -> int:
    entries: int = program.matrix.nnz + (0 if program.curvature is None else program.curvature.nnz)
    return entries


def _point(solution: Any) -> SolverPoint:  # noqa: ANN401 -- Clarabel's has no type
    return SolverPoint(np.array(solution.x), np.array(solution.z), str(solution.status))


def _made_ready(program: ConicProgram, accuracy: float, *, refined: bool) -> Any:  # noqa: ANN401
    import clarabel  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_iter = MOST_STEPS
    settings.max_threads = 1  # the same bytes on every machine
    settings.presolve_enable = False  # presolve may remove rows whose dual is needed
    if program.semidefinite:  # with linearly dependent equalities, a smaller regularisation makes the first step fail
        settings.static_regularization_constant = 1e-7
        settings.chordal_decomposition_enable = False
    settings.iterative_refinement_enable = refined
    settings.tol_feas = settings.tol_gap_abs = settings.tol_gap_rel = accuracy
    settings.tol_infeas_abs = settings.tol_infeas_rel = accuracy
    cones = [clarabel.ZeroConeT(program.equal)] if program.equal else []
    kinds = {size: clarabel.SecondOrderConeT(size) for size in set(program.round)}
    cones += [kinds[size] for size in program.round]
    cones += [clarabel.NonnegativeConeT(program.positive)] if program.positive else []
    cones += [clarabel.PSDTriangleConeT(program.semidefinite)] if program.semidefinite else []
    curvature = _flat(len(program.cost)) if program.curvature is None else program.curvature
    return clarabel.DefaultSolver(curvature, program.cost, program.matrix, program.offset, cones, settings)


@lru_cache(maxsize=64)
def _flat(columns: int) -> Any:  # noqa: ANN401 -- scipy's matrices have no types
    """Return zero curvature: a matrix that the solver only reads."""
    from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    return csc_matrix((columns, columns))


def solve(program: ConicProgram, accuracy: float, solver: Solver) -> SolverPoint | str:
    """Return the solver's point, or the reason why there is none."""
    try:
        point = solver(program, accuracy)
    except TooMuchWorkError:
        raise
    except Exception as error:
        return f"the solver failed: {error}"
    if point.x.shape != program.cost.shape or point.dual.shape != program.offset.shape:
        return f"{point.status}, but the returned point has the wrong shape"
    return point
