"""Does every branch of a small group exclude a start from rest? Or is there one? Branch and bound, with proofs alone.

Each branch is asked for multipliers that prove that nothing starts in it (`virtual_power`). Where there are none, the
dual of the program guesses a start, and Newton's method makes that exact; else the branch is split where the guess
violates the laws of contact most: at a point that both opens and is pressed, then where friction does not brake.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt

import numpy as np

from stability.statics.facts import Problem, Tolerances
from stability.statics.outcomes.branch import Branch, Condition, How, known
from stability.statics.outcomes.first_start import first_start, start_near
from stability.statics.outcomes.multipliers import Guess, guess, multipliers
from stability.statics.outcomes.other_start import Start
from stability.statics.outcomes.power_program import PowerProgram, power_program
from stability.statics.outcomes.start_equations import Array, StartEquations
from stability.statics.outcomes.virtual_power import STILL, Multipliers, ProvenBranch, lack, nothing_moves
from stability.statics.solvers.conic_program import Point, Solver, clarabel_solve, solve

ACCURACY = 1e-10
MOST_COLUMNS = 10_000  # of the programs of all branches: a second or less
HOPELESS = 1e-3  # what is lacking of a proof that no correction mends
ASIDE = 0.98  # cosine: directions closer than this to one that was asked for are not asked for again


@dataclass(frozen=True, slots=True, eq=False)
class Searched:
    """Branches that leave nothing out, or a start; neither if that was not decided."""

    proof: tuple[ProvenBranch, ...] | None
    start: Start | None
    branches: int  # that were asked


def searched(
    problem: Problem,
    equations: StartEquations,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
    most: int = MOST_COLUMNS,
) -> Searched:
    """What was found of the starts of a group that can rest."""
    start = first_start(problem, equations, tolerances)
    if start is not None:
        return Searched(None, start, 0)
    waiting: list[Branch] = [()]
    proven: list[ProvenBranch] = []
    for asked in range(1, 2 + most // _columns(equations)):
        branch = waiting.pop()
        found, guessed = _asked(equations, branch, solver)
        if found is not None:
            proven.append(ProvenBranch(branch, found))
        else:
            start = start_near(problem, equations, guessed.forces, tolerances) if guessed is not None else None
            split = _split(equations, branch, guessed if guessed is not None else _any_guess(equations))
            if start is not None or split is None:
                return Searched(None, start, asked)
            waiting += [(*branch, split.opposite), (*branch, split)]
        if not waiting:
            return Searched(tuple(proven), None, asked)
    return Searched(None, None, asked)


def _columns(equations: StartEquations) -> int:
    """About how many unknowns a branch has."""
    size, points = len(equations.loads), len(equations.normals)
    return size * size + 3 * points * (points + 1)


def _asked(equations: StartEquations, branch: Branch, solver: Solver) -> tuple[Multipliers | None, Guess | None]:
    if not known(equations, branch).basis.size:
        return nothing_moves(equations, branch), None
    program = power_program(equations, branch)
    point = solve(program.conic, ACCURACY, solver)
    if isinstance(point, str):
        return None, None
    return _proven(equations, branch, program, point), guess(program, point)


def _proven(equations: StartEquations, branch: Branch, program: PowerProgram, point: Point) -> Multipliers | None:
    for found in multipliers(program, point):
        lacking = lack(equations, ProvenBranch(branch, found))
        if lacking <= STILL:
            return found
        if lacking > HOPELESS:
            return None
    return None


def _split(equations: StartEquations, branch: Branch, guessed: Guess) -> Condition | None:
    """The question that the guess answers worst; None if there is none left."""
    pressed = np.sqrt((guessed.forces**2).sum(axis=1))
    asked = {each.point for each in branch if each.how is not How.TOWARDS}
    opening = {
        point: _strength(guessed, _normal(equations, point)) * pressed[point]
        for point, normals in enumerate(equations.normals)
        if len(normals) == 1 and point not in asked
    }
    most = max(opening, key=opening.__getitem__, default=-1)
    if most >= 0 and opening[most] > 0.0:
        return Condition(most, How.SHUT)
    return _side(equations, branch, guessed, pressed)


def _side(equations: StartEquations, branch: Branch, guessed: Guess, pressed: Array) -> Condition | None:
    """To which side of a line the point slides that does so with most force."""
    opened = {each.point for each in branch if each.how is How.OPENS}
    sliding = [
        (strength * pressed[point], point, way)
        for point, normals in enumerate(equations.normals)
        if len(normals) == 1 and point not in opened
        for strength, way in _way(equations, branch, guessed, point)
    ]
    if not sliding:
        return None
    _, point, (x, y, z) = max(sliding)
    return Condition(point, How.TOWARDS, (x, y, z))


def _any_guess(equations: StartEquations) -> Guess:
    """What splits branches where the solver says nothing."""
    size, points = len(equations.loads), len(equations.normals)
    return Guess(np.identity(size), np.zeros(size), np.ones((points, 3)))


def _normal(equations: StartEquations, point: int) -> Array:
    normal: Array = equations.axes[point, 0] @ equations.slips[point]
    return normal


def _strength(guessed: Guess, row: Array) -> float:
    return sqrt(max(float(row @ guessed.moments @ row), 0.0))


def _way(
    equations: StartEquations, branch: Branch, guessed: Guess, point: int
) -> Iterator[tuple[float, tuple[float, ...]]]:
    """How strongly a point goes along a tangent that was not asked for yet, and this, if there is one."""
    if equations.friction[point] == 0.0:
        return
    before = [np.array(each.towards) for each in branch if each.how is How.TOWARDS and each.point == point]
    across = equations.axes[point, 1:] @ equations.slips[point]
    turned = np.linalg.eigh(across @ guessed.moments @ across.T)[1].T[::-1]
    diagonal = np.array([turned[0] + turned[1], turned[0] - turned[1]]) * np.sqrt(0.5)
    for way in (*turned, *diagonal):
        direction = way @ equations.axes[point, 1:]
        if all(abs(direction @ other) < ASIDE for other in before):
            yield _strength(guessed, way @ across), tuple(direction.tolist())
            return
