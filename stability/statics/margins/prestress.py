"""How much prestress do contacts need to balance the loads, or how much have they to spare?

The least s such that forces balance the loads while every normal force may count for s more than it is:
|f_t| <= mu (f_n + s c), with c what the contact's upper brick may carry. With s < 0 the forces lie deep inside their
cones; with s > 0 there are none within, and the motion that shows it is the proof. Solved over velocities, as in
`equilibrium`: the greatest power of the loads less the separation of all contacts, of which the duals are the forces.
"""

from dataclasses import dataclass

import numpy as np

from stability.statics.solvers.conic_program import Array, ConicProgram, clarabel_solve, quick_solve
from stability.statics.solvers.wrench_matrix import WrenchMatrix

ACCURACY = 1e-11  # asked of the solver
ROUGH = 1e-8  # an accuracy for which steps need not be refined


@dataclass(frozen=True, slots=True, eq=False)
class Prestress:
    """The solver's answer, which proves nothing before plain arithmetic has checked it."""

    least: float  # in shares of what upper bricks may carry; never below -1
    rows: Array  # (rows,) forces, within their cones if `least` is not positive
    columns: Array  # (columns,) velocities, a proof of instability if `least` is positive
    sliding: float  # power of tangential forces on slips; never positive


def least_prestress(system: WrenchMatrix, accuracy: float = ACCURACY) -> Prestress:
    """The least prestress with which the loads are balanced; `accuracy` is asked of the solver."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    normal = np.zeros(len(system.row_scale))
    normal[: 3 * len(system.round) : 3] = 1.0
    normal[3 * len(system.round) :] = 1.0
    separation = system.matrix.T @ normal
    program = ConicProgram(
        -(system.loads + separation),
        # The separation is bounded, so that its dual, the prestress, is at least -1.
        vstack([-system.matrix, csc_matrix(separation)], format="csc"),
        np.append(np.zeros(len(normal)), 1.0),
        0,
        [3] * len(system.round),
        len(system.flat) + 1,
    )
    point = (clarabel_solve if accuracy < ROUGH else quick_solve)(program, accuracy)
    pressed, least = point.dual[:-1], float(point.dual[-1]) - 1.0
    slips = system.matrix @ point.x
    sliding = float(np.where(normal > 0.0, 0.0, pressed * slips).sum())
    return Prestress(least, pressed - least * normal, point.x, sliding)
