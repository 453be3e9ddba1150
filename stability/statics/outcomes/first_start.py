"""How bricks that can rest let go if nothing has pressed them together: a start that is shown."""

from math import hypot

import numpy as np

from stability.geometry.vectors import scale
from stability.statics.facts import ZERO, Forces, Motion, Problem, Tolerances
from stability.statics.outcomes.other_start import Start, other_start
from stability.statics.outcomes.start_equations import Array, StartEquations, start_equations
from stability.statics.outcomes.start_proof import check_start
from stability.statics.solvers.elastic_rest import brought_forth

MOST_POINTS = 100  # of contacts: beyond, to make a start exact takes seconds


def lets_go(problem: Problem, tolerances: Tolerances) -> Start | None:
    """A proven start of bricks that can rest, however many they are; None if none is found with little work."""
    if sum(len(contact.points_W) for contact in problem.contacts) > MOST_POINTS:
        return _without_forces(problem, tolerances)
    return _found(problem, start_equations(problem), tolerances)


def first_start(problem: Problem, equations: StartEquations, tolerances: Tolerances) -> Start | None:
    """A proven start of a small group, which is looked for near no forces as well."""
    start = _found(problem, equations, tolerances)
    if start is not None:
        return start
    return start_near(problem, equations, np.zeros((len(equations.normals), 3)), tolerances)


def start_near(problem: Problem, equations: StartEquations, forces: Array, tolerances: Tolerances) -> Start | None:
    """A proven start near forces (points, 3), in the units of the equations."""
    start = other_start(problem, equations, forces)
    return start if start is not None and check_start(problem, start, tolerances).holds else None


def _found(problem: Problem, equations: StartEquations, tolerances: Tolerances) -> Start | None:
    """A proven start without forces, or else near those that loads bring forth."""
    if any(len(normals) > 1 for normals in equations.normals):
        return None
    start = _without_forces(problem, tolerances)
    if start is not None:
        return start
    return start_near(problem, equations, brought_forth(problem) / equations.units[0], tolerances)


def _without_forces(problem: Problem, tolerances: Tolerances) -> Start | None:
    """The start in which nothing presses; None if it is not lawful, or loads turn a brick."""
    if any(hypot(*load.torque_W) > 0.0 for load in problem.loads.values()):
        return None
    falling = {
        name: (scale(1.0 / problem.bricks[name].brick.mass, load.force_W), ZERO) for name, load in problem.loads.items()
    }
    none = Forces(tuple(((ZERO,) * len(c.normals_W),) * len(c.points_W) for c in problem.contacts))
    start = Start(Motion(falling), none)
    return start if check_start(problem, start, tolerances).holds else None
