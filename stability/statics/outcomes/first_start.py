"""How bricks that can rest let go if nothing has pressed them together: a start that is shown."""

import numpy as np

from stability.statics.facts import Problem, Tolerances
from stability.statics.outcomes.other_start import Start, other_start
from stability.statics.outcomes.start_equations import Array, StartEquations
from stability.statics.outcomes.start_proof import check_start
from stability.statics.solvers.elastic_rest import brought_forth


def first_start(problem: Problem, equations: StartEquations, tolerances: Tolerances) -> Start | None:
    """A proven start near the forces that loads alone bring forth, or else near none; None if there is only rest."""
    if any(len(normals) > 1 for normals in equations.normals):
        return None
    start = start_near(problem, equations, brought_forth(problem) / equations.units[0], tolerances)
    if start is not None:
        return start
    return start_near(problem, equations, np.zeros((len(equations.normals), 3)), tolerances)


def start_near(problem: Problem, equations: StartEquations, forces: Array, tolerances: Tolerances) -> Start | None:
    """A proven start near forces (points, 3), in the units of the equations."""
    start = other_start(problem, equations, forces)
    return start if start is not None and check_start(problem, start, tolerances).holds else None
