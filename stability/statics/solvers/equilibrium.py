"""Can contact forces within exact Coulomb cones balance the loads on every brick? The last stage of the cascade.

One conic program over velocities u: the largest power of the loads such that no contact resists, each slip within the
dual of its friction cone. Slips may be short of that by a fixed share; the forces that hold them to it, the duals of
the program, then balance the loads with least sum. If no forces do, the power grows without end along a motion.

A solver's status decides nothing, only its points do: forces or motion are handed out once `proof` has found them
right by plain arithmetic. Where neither is, the solver is asked again with other accuracy, and then for the motion of
most power at bounded speed, of which the duals leave the least residual.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from stability.geometry.vectors import add_scaled
from stability.statics.facts import Forces, Motion, Problem, Tolerances
from stability.statics.held_upright import is_held_upright
from stability.statics.proof import check_forces, check_motion
from stability.statics.solvers.conic_program import (
    SOLVED,
    Array,
    ConicProgram,
    Solver,
    clarabel_solve,
    quick_solve,
    solve,
)
from stability.statics.solvers.separating_motion import separating_velocities
from stability.statics.solvers.wrench_matrix import Sparse, WrenchMatrix, wrench_matrix

MOST_CORRECTIONS = 3  # of forces; what they do not mend is no rounding
HOPELESS = 1e-6  # share of what a brick carries: a residual above is no rounding
FAINT = 1e-8  # share of a usual force by which even a contact that does not press may be corrected
MIXED = (1e-11, 1e-9, 1e-7, 1e-5)  # shares of the speed of the fastest that a separating motion is mixed in with
DENSE = 90  # columns up to which dense matrices are faster than the import of sparse ones
QUICK = 1e-9  # accuracy to which is asked only whether something falls
QUIET = (1e-4, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken to stay


@dataclass(frozen=True, slots=True)
class Balance:
    """Forces that balance a problem, or a motion that none can stop; neither if neither could be proven."""

    forces: Forces | None
    motion: Motion | None
    note: str  # why there is neither; empty otherwise


def balance(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
) -> Balance:
    """Proven forces that balance a problem, or a proven motion; neither, with a note, if the solver finds no proof."""
    system = wrench_matrix(problem)
    notes = []
    for build, accuracy in ATTEMPTS:
        point = solve(build(system), accuracy, solver)
        if isinstance(point, str):
            notes.append(point)
            continue
        forces = proven_forces(problem, system, point.dual[: len(system.row_scale)], tolerances)
        motion = None if forces else proven_motion(problem, system, point.x, tolerances)
        if forces or motion:
            return Balance(forces, motion, "")
        notes.append(f"{build.__name__.strip('_')} to {accuracy:g}: {point.status}, but its point proves nothing")
    return Balance(None, None, "; ".join(notes))


def falling_motion(
    problem: Problem,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = quick_solve,
) -> Motion | None:
    """A proven motion that lowers a problem; None if the solver says that there is none, which nobody has checked.

    Where weights can be handed down there is none, and the solver need not be asked.
    """
    if is_held_upright(problem):
        return None
    system = wrench_matrix(problem)
    point = solve(_held(system), QUICK, solver)
    if isinstance(point, str) or point.status == SOLVED:
        return None
    return proven_motion(problem, system, point.x, tolerances)


def _held(system: WrenchMatrix) -> ConicProgram:
    """The most power, where no slip may be short of its cone by more than a unit."""
    return ConicProgram(
        -system.loads, -system.matrix, _normal_rows(system), 0, [3] * len(system.round), len(system.flat)
    )


def _bounded(system: WrenchMatrix) -> ConicProgram:
    """The most power, where no part of the motion may be faster than a unit; duals leave the least residual."""
    from scipy.sparse import identity, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    columns = len(system.loads)
    matrix = vstack([-system.matrix, identity(columns), -identity(columns)], format="csc")
    offset = np.append(np.zeros(len(system.row_scale)), np.ones(2 * columns))
    return ConicProgram(-system.loads, matrix, offset, 0, [3] * len(system.round), len(system.flat) + 2 * columns)


# A tight accuracy comes first: it costs one or two steps, and leaves residuals that need no correction.
ATTEMPTS: tuple[tuple[Callable[[WrenchMatrix], ConicProgram], float], ...] = (
    (_held, 1e-12),
    (_bounded, 1e-13),
    (_held, 1e-9),
    (_bounded, 1e-9),
    (_held, 1e-7),
)


def _normal_rows(system: WrenchMatrix) -> Array:
    """One in the rows of normals, nothing in those of tangents."""
    rows = np.ones(len(system.row_scale))
    tangents = rows[: 3 * len(system.round)].reshape(-1, 3)
    tangents[:, 1:] = 0.0
    return rows


def proven_forces(problem: Problem, system: WrenchMatrix, rows: Array, tolerances: Tolerances) -> Forces | None:
    """Forces near the given ones, in units of the rows, that are proven to balance the problem."""
    for _ in range(1 + MOST_CORRECTIONS):
        if not np.isfinite(rows).all():
            return None
        rows = _inside(system, rows)
        residual = system.matrix.T @ rows + system.loads
        if np.abs(residual).max(initial=0.0) > HOPELESS:
            return None
        forces = system.forces(rows)
        if check_forces(problem, forces, tolerances).holds:
            return forces
        rows = rows + _correction(system, rows, residual)
    return None


def _inside(system: WrenchMatrix, rows: Array) -> Array:
    """The nearest forces within their cones."""
    held = 3 * len(system.round)
    cones = rows[:held].reshape(-1, 3)
    normal, tangential = cones[:, 0], np.hypot(cones[:, 1], cones[:, 2])
    middle = 0.5 * (normal + tangential)
    pressed = np.where(tangential <= normal, normal, np.maximum(middle, 0.0))
    shrunk = np.where(tangential <= pressed, 1.0, pressed / np.where(tangential > 0.0, tangential, 1.0))
    inside = np.stack([pressed, cones[:, 1] * shrunk, cones[:, 2] * shrunk], axis=1)
    return np.append(inside.ravel(), np.maximum(rows[held:], 0.0))


def _correction(system: WrenchMatrix, rows: Array, residual: Array) -> Array:
    """The change of least norm that takes the residual away, each force weighed by its size so that none turns over."""
    held = 3 * len(system.round)
    normal = np.append(np.repeat(rows[:held:3], 3), rows[held:])
    weight = normal * normal + FAINT
    change: Array = -weight * (system.matrix @ _solved(system.matrix, weight, residual))
    return change


def _solved(matrix: Sparse, weight: Array, residual: Array) -> Array:
    """The x of `matrix.T @ diag(weight) @ matrix @ x = residual`, or near it; nothing if that fails."""
    if len(residual) <= DENSE:
        rows = matrix.toarray()
        square = rows.T @ (weight[:, None] * rows)
        try:
            near: Array = np.linalg.solve(square + FAINT * FAINT * np.identity(len(residual)), residual)
        except np.linalg.LinAlgError:  # singular, as far as it can tell
            return np.zeros(len(residual))
        return near
    from scipy.sparse import diags, identity  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    square = matrix.T @ diags(weight) @ matrix + FAINT * FAINT * identity(len(residual))
    try:
        solved: Array = splu(square.tocsc()).solve(residual)
    except RuntimeError:  # singular, as far as it can tell
        return np.zeros(len(residual))
    return solved


def proven_motion(
    problem: Problem, system: WrenchMatrix, columns: Array, tolerances: Tolerances, quiet: Sequence[float] = QUIET
) -> Motion | None:
    """A motion near the given velocities, in units of the columns, that is proven to lower the problem.

    `quiet`: shares of the largest speed, one tried after the other, below which a brick is taken to stay.
    """
    if not (np.isfinite(columns).all() and columns @ system.loads > 0.0):
        return None
    for share in quiet:
        for motion in mended(problem, system.motion(columns, share)):
            if check_motion(problem, motion, tolerances).holds:
                return motion
    return None


def mended(problem: Problem, motion: Motion) -> Iterator[Motion]:
    """The motion, then with more of a separating motion mixed in each time, to open what rounding may have closed."""
    yield motion
    separating = separating_velocities(problem, motion.velocity) if motion.velocity else None
    if separating is not None:
        fastest = max(hypot(*velocity) for velocity, _ in motion.velocity.values())
        for share in MIXED:
            rate = share * fastest
            yield Motion({name: (add_scaled(v, rate, separating[name]), w) for name, (v, w) in motion.velocity.items()})
