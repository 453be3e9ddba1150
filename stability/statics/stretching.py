"""How far can loads be stretched along a direction before no contact forces balance them?

One conic programme: of all motions that no contact resists and by which the direction gains 1, the one that the loads
resist least. What they resist it with bounds the factor from above, its duals are forces at that factor. Both are
handed out only as far as `proof` finds them right.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from stability.model import BodyId
from stability.statics.equilibrium import balance, mended, proven_forces
from stability.statics.facts import ZERO, Forces, Motion, Problem, Tolerances, Wrench
from stability.statics.programme import Array, Programme, Solver, asked, clarabel_solve
from stability.statics.proof import check_motion, effort, power
from stability.statics.wrench_matrix import WrenchMatrix, wrench_matrix

ACCURACIES = (1e-10, 1e-13, 1e-7)  # that the solver is asked for until its point proves both bounds
RETREATS = (0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4)  # shares by which the lower bound may stay behind what the solver says
ADVANCES = (1.0, 10.0, 1e3, 1e5)  # times the least gain that a motion must show, by which the upper bound may go beyond
QUIET = (1e-4, 1e-6, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken to stay


@dataclass(frozen=True, slots=True)
class Stretch:
    """How far loads can be stretched along a direction: by `lower` they still can be balanced, by `upper` not."""

    lower: float  # proven by `forces`; infinite if the direction alone can be balanced, and so added for ever
    upper: float  # proven by `motion`; infinite if there is none
    forces: Forces  # balance `loads + lower * direction`; the loads alone if `lower` is infinite
    motion: Motion | None  # scaled so that the direction gains 1 by it

    @property
    def gap(self) -> float:
        """How much is not known."""
        return 0.0 if self.lower == self.upper else self.upper - self.lower


def stretch(
    problem: Problem,
    direction: Mapping[BodyId, Wrench],
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solve: Solver = clarabel_solve,
    system: WrenchMatrix | None = None,
) -> Stretch | None:
    """The largest s for which contacts can balance `loads + s * direction`, between proven bounds; None if unknown.

    A motion u that no contact resists proves the upper bound: of balanced loads and forces, the loads gain nothing by
    it, `(loads + s * direction) . u <= 0`. With `direction . u = 1`, as it is scaled here, `s <= -loads . u`, which
    `upper` exceeds by rounding only. It bounds any other direction e by which u gains: `s <= -loads . u / (e . u)`,
    both by `proof.power`. `system` is `wrench_matrix(problem, whole=True)`, to be handed in when asking repeatedly.
    """
    system = wrench_matrix(problem, whole=True) if system is None else system
    towards = system.wrench_of(direction)
    unit = float(np.abs(towards).max(initial=0.0))
    if not 0.0 < unit < inf:
        return None
    for accuracy in ACCURACIES:
        point = asked(_programme(system, towards / unit), accuracy, solve)
        if isinstance(point, str):
            continue
        question = _Question(problem, direction, tolerances, system, solve)
        factor, rows = -float(point.dual[0]) / unit, point.dual[1:]
        upper, motion = question.upper(point.x)
        if motion is None and factor > 0.0 and question.endless(rows / (factor * unit) if factor else rows):
            base = balance(problem, tolerances, solve).forces
            return None if base is None else Stretch(inf, inf, base, None)
        found = question.lower(factor, rows) if isfinite(factor) else None
        if found is not None and motion is not None:
            return Stretch(found[0], upper, found[1], motion)
    return None


def stretched(problem: Problem, direction: Mapping[BodyId, Wrench], factor: float) -> Problem:
    """The same problem under its loads and `factor` times those of the direction."""
    loads = dict(problem.loads)
    for name, more in direction.items():
        load = loads.get(name, Wrench(ZERO))
        force = tuple(a + factor * b for a, b in zip(load.force_W, more.force_W, strict=True))
        torque = tuple(a + factor * b for a, b in zip(load.torque_W, more.torque_W, strict=True))
        loads[name] = Wrench((force[0], force[1], force[2]), (torque[0], torque[1], torque[2]))
    return replace(problem, loads=loads)


def _programme(system: WrenchMatrix, towards: Array) -> Programme:
    """The least resistance of the loads to a motion by which the direction gains one."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import, and few ask for margins

    matrix = vstack([csc_matrix(towards[None, :]), -system.matrix], format="csc")
    offset = np.zeros(1 + len(system.row_scale))
    offset[0] = 1.0
    return Programme(-system.loads, matrix, offset, 1, [3] * len(system.round), len(system.flat))


@dataclass(frozen=True, slots=True)
class _Question:
    """What is asked, and of whom."""

    problem: Problem
    direction: Mapping[BodyId, Wrench]
    tolerances: Tolerances
    system: WrenchMatrix
    solve: Solver

    def upper(self, columns: Array) -> tuple[float, Motion | None]:
        """The least proven upper bound, and the motion that proves it."""
        best: tuple[float, Motion | None] = (inf, None)
        if not np.isfinite(columns).all():
            return best
        for quiet in QUIET:
            for motion in mended(self.problem, self.system.motion(columns, quiet)):
                gain = power(self.direction, motion)
                scaled = _scaled(motion, 1.0 / gain) if gain > 0.0 else motion
                bound = self._bound(scaled) if gain > 0.0 else inf
                if bound < best[0]:
                    best = (bound, scaled)
                if bound < inf:
                    break  # more of a lift only takes the bound further up
        return best

    def _bound(self, motion: Motion) -> float:
        """The least factor at which a motion by which the direction gains one is proven to lower the problem."""
        factor = -power(self.problem.loads, motion)
        # Not of the loads stretched: where these cancel, nothing would be least.
        whole = effort(self.problem.loads, motion) + abs(factor) * effort(self.direction, motion)
        least = self.tolerances.gain * whole
        for advance in ADVANCES:
            beyond = factor + advance * least
            if check_motion(stretched(self.problem, self.direction, beyond), motion, self.tolerances).holds:
                return beyond
        return inf

    def lower(self, factor: float, rows: Array) -> tuple[float, Forces] | None:
        """The largest proven lower bound near the given one, and forces that prove it."""
        for retreat in RETREATS:
            kept = factor - retreat * abs(factor)
            problem = stretched(self.problem, self.direction, kept)
            system = replace(self.system, loads=self.system.wrench_of(problem.loads))
            forces = proven_forces(problem, system, rows, self.tolerances)
            if forces is None and retreat > 0.0:
                forces = balance(problem, self.tolerances, self.solve).forces
            if forces is not None:
                return kept, forces
        return None

    def endless(self, rows: Array) -> bool:
        """Whether forces near these balance the direction alone."""
        problem = replace(self.problem, loads=self.direction)
        system = replace(self.system, loads=self.system.wrench_of(self.direction))
        return proven_forces(problem, system, rows, self.tolerances) is not None


def _scaled(motion: Motion, factor: float) -> Motion:
    def times(vector: tuple[float, float, float]) -> tuple[float, float, float]:
        return (vector[0] * factor, vector[1] * factor, vector[2] * factor)

    return Motion({name: (times(v), times(w)) for name, (v, w) in motion.velocity.items()})
