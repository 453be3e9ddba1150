"""Decides whether the contacts of one problem bear changing loads, such as those of bricks in motion."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from stability.geometry.rows import Array
from stability.model import BodyId
from stability.problem import Motion, Problem, Wrench
from stability.statics.conic_program import quick_solve
from stability.statics.load_factor import central_forces, yielding
from stability.statics.wrench_matrix import WrenchMatrix, wrench_matrix

# Loads of a motion change little from step to step. So forces that balanced earlier loads are corrected for the new
# ones, with the most change where there is most room; only if the result is beyond the strength of a contact, a program
# searches for other forces. If there are none, its dual is the motion at which the contacts yield.


ACCURACY = 1e-8  # of the solver
BALANCED = 1e-6  # share of the largest load, or of a usual force: largest residual of forces that balance
FAINT = 1e-6  # weight of contacts without room
MOST = 100.0  # times a usual force: more room makes no difference
FREE = 1e-12  # share of the largest stiffness that is added to all, as a structure in the air moves freely
BARELY = 1e-6  # share: a smaller lack of strength is rounding


@dataclass(slots=True)
class BorneLoads:
    """Contacts of a problem, with the forces that balanced the last loads."""

    problem: Problem
    constant: Mapping[BodyId, Wrench] | None = None  # loads in addition to those asked about, which the contacts bear
    _system: WrenchMatrix = field(init=False)
    _steady: Array = field(init=False)
    _forces: Array = field(init=False)
    _weights: Array = field(init=False)  # of the forces in corrections
    _solve: Callable[[Array], Array] | None = field(default=None, init=False)  # of the stiffness with these weights

    def __post_init__(self) -> None:
        self._system = wrench_matrix(self.problem, whole=True, any_law=True)
        self._steady = self._system.wrench_of(self.constant or {})
        self._forces = self._weights = np.zeros(len(self._system.row_scale))

    def yields_under(self, loads: Mapping[BodyId, Wrench]) -> Motion | None:
        """Return the motion at which contacts yield under loads; None if they bear them.

        The motion is empty if contacts do not bear the loads and none was found.
        """
        growing = self._system.wrench_of(loads)
        total = growing + self._steady
        size = max(1.0, float(np.abs(total).max(initial=0.0)))
        if self._settle(self._corrected(total), total, size):
            return None
        rows = central_forces(self._system, total, ACCURACY, quick_solve)
        if not isinstance(rows, str) and self._settle(rows, total, size):
            self._solve = None
            return None
        point = yielding(self._system, growing, None if self.constant is None else self._steady, ACCURACY, quick_solve)
        if isinstance(point, str) or not np.isfinite(point.columns).all():
            return Motion({})
        return None if 0.0 <= point.share <= 1.0 + BARELY else self._system.motion(point.columns)

    def _settle(self, rows: Array, total: Array, size: float) -> bool:
        """Keep forces if they balance the loads and all contacts bear them."""
        if not np.isfinite(rows).all():
            return False
        rows = self._system.project(rows)
        if np.abs(self._system.matrix.T @ rows + total).max(initial=0.0) > BALANCED * size:
            return False
        self._forces = rows
        return True

    def _corrected(self, total: Array) -> Array:
        """Return the forces that balanced the last loads, corrected for other loads."""
        matrix = self._system.matrix
        if self._solve is None:
            from scipy.sparse import diags, identity  # noqa: PLC0415 -- slow to import, and most bricks are dry
            from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

            room = np.minimum(self._system.room(self._forces), MOST)
            self._weights = room * room + FAINT
            stiffness = matrix.T @ diags(self._weights) @ matrix
            added = FREE * abs(stiffness).max() * identity(len(total))
            self._solve = splu((stiffness + added).tocsc()).solve
        residual = matrix.T @ self._forces + total
        corrected: Array = self._forces - self._weights * (matrix @ self._solve(residual))
        return corrected
