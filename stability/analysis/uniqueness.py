"""Decides whether rest is the only motion that the laws of contact allow, or one of several."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np

from stability.analysis.acceleration_cut import groups_apart
from stability.analysis.margins import guarantee, without_gaps
from stability.analysis.uniqueness_program import (
    STILL,
    Branch,
    Condition,
    ContactMode,
    Guess,
    Multipliers,
    PowerProgram,
    ProvenBranch,
    branch_constraints,
    check_branch,
    cover_every_case,
    guess,
    multipliers,
    power_program,
    proof_error,
    proof_without_motion,
)
from stability.geometry.rows import Array
from stability.model import BodyId
from stability.name_order import in_order, names_text
from stability.notebook import Display, Displayed, display_of
from stability.problem import Forces, Problem, Tolerances, admit_problem
from stability.process_settings import one_thread
from stability.statics.assembly import admit_forces
from stability.statics.conic_program import Solver, SolverPoint, clarabel_solve, solve
from stability.statics.fall_description import described
from stability.statics.initial_motion import (
    InitialMotion,
    StartEquations,
    find_any_start,
    find_start,
    find_start_near,
    start_equations,
)

# Branch and bound over the contact conditions of a small group: proves rest unique, or finds another motion.
#
# For each branch a program computes multipliers that prove that no motion starts in it (see `Multipliers`). If there
# are none, the dual of the program suggests a start, which Newton's method makes exact; else the branch is split where
# the suggestion violates the laws of contact most: at a point that both opens and is under pressure, then where
# friction does not oppose the slip.


ACCURACY = 1e-10
MOST_COLUMNS = 10_000  # of the programs of all branches: a second or less
HOPELESS = 1e-3  # an error of a proof that corrections cannot remove
ASIDE = 0.98  # cosine: directions closer than this to an earlier one are skipped


@dataclass(frozen=True, slots=True, eq=False)
class StartSearch:
    """Complete set of branches with proofs, or a start; neither if undecided."""

    proof: tuple[ProvenBranch, ...] | None
    start: InitialMotion | None
    branches: int  # number of branches searched


def search_start(
    problem: Problem,
    equations: StartEquations,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
    most: int = MOST_COLUMNS,
) -> StartSearch:
    """Search for a motion that starts from rest in a group, or prove that there is none."""
    start = find_any_start(problem, equations, tolerances)
    if start is not None:
        return StartSearch(None, start, 0)
    waiting: list[Branch] = [()]
    proven: list[ProvenBranch] = []
    for count in range(1, 2 + most // _columns(equations)):
        branch = waiting.pop()
        proof, guessed = _asked(equations, branch, solver)
        if proof is not None:
            proven.append(ProvenBranch(branch, proof))
        else:
            start = find_start_near(problem, equations, guessed.forces, tolerances) if guessed is not None else None
            split = _split(equations, branch, guessed if guessed is not None else _any_guess(equations))
            if start is not None or split is None:
                return StartSearch(None, start, count)
            waiting += [(*branch, split.opposite), (*branch, split)]
        if not waiting:
            return StartSearch(tuple(proven), None, count)
    return StartSearch(None, None, count)


def _columns(equations: StartEquations) -> int:
    """Return the approximate number of unknowns of a branch."""
    size, points = len(equations.loads), len(equations.normals)
    return size * size + 3 * points * (points + 1)


def _asked(equations: StartEquations, branch: Branch, solver: Solver) -> tuple[Multipliers | None, Guess | None]:
    if not branch_constraints(equations, branch).basis.size:
        return proof_without_motion(equations, branch), None
    program = power_program(equations, branch)
    point = solve(program.conic, ACCURACY, solver)
    if isinstance(point, str):
        return None, None
    return _proven(equations, branch, program, point), guess(program, point)


def _proven(equations: StartEquations, branch: Branch, program: PowerProgram, point: SolverPoint) -> Multipliers | None:
    for candidate in multipliers(program, point):
        lacking = proof_error(equations, ProvenBranch(branch, candidate))
        if lacking <= STILL:
            return candidate
        if lacking > HOPELESS:
            return None
    return None


def _split(equations: StartEquations, branch: Branch, guessed: Guess) -> Condition | None:
    """Return the condition that the suggestion violates most; None if there is none left."""
    pressed = np.sqrt((guessed.forces**2).sum(axis=1))
    decided = {each.point for each in branch if each.how is not ContactMode.TOWARDS}
    opening = {
        point: _strength(guessed, _normal(equations, point)) * pressed[point]
        for point, normals in enumerate(equations.normals)
        if len(normals) == 1 and point not in decided
    }
    most = max(opening, key=opening.__getitem__, default=-1)
    if most >= 0 and opening[most] > 0.0:
        return Condition(most, ContactMode.SHUT)
    return _side(equations, branch, guessed, pressed)


def _side(equations: StartEquations, branch: Branch, guessed: Guess, pressed: Array) -> Condition | None:
    """Return the condition on the side to which the point with the largest power of friction slides."""
    opened = {each.point for each in branch if each.how is ContactMode.OPENS}
    sliding = [
        (strength * pressed[point], point, way)
        for point, normals in enumerate(equations.normals)
        if len(normals) == 1 and point not in opened
        for strength, way in _way(equations, branch, guessed, point)
    ]
    if not sliding:
        return None
    _, point, (x, y, z) = max(sliding)
    return Condition(point, ContactMode.TOWARDS, (x, y, z))


def _any_guess(equations: StartEquations) -> Guess:
    """Return a guess that splits branches if the solver gives none."""
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
    """Yield the speed and the direction of a point along a tangent without a condition yet, if there is one."""
    if equations.law_at(point).friction == 0.0:
        return
    before = [np.array(each.towards) for each in branch if each.how is ContactMode.TOWARDS and each.point == point]
    across = equations.axes[point, 1:] @ equations.slips[point]
    turned = np.linalg.eigh(across @ guessed.moments @ across.T)[1].T[::-1]
    diagonal = np.array([turned[0] + turned[1], turned[0] - turned[1]]) * np.sqrt(0.5)
    for way in (*turned, *diagonal):
        direction = way @ equations.axes[point, 1:]
        if all(abs(direction @ other) < ASIDE for other in before):
            yield _strength(guessed, way @ across), tuple(direction.tolist())
            return


# Rest of a balanced group is either guaranteed or only possible.
#
# If forces along normals alone balance a group, rest is guaranteed at any friction (`margins.guarantee`). In a small
# group that needs friction, every other start is proven impossible, or one is found (`search_start`). Otherwise rest
# stays possible, without a further statement.


MOST_BRICKS = 5  # of a group that is decided by its contact modes
MOST_POINTS = 20  # of the contacts of such a group: with more, a branch takes a second


@dataclass(frozen=True, slots=True, eq=False)
class FrictionProof:
    """Group that friction is certain to hold: no motion starts in any of a complete set of branches."""

    problem: Problem
    proof: tuple[ProvenBranch, ...]

    def holds(self) -> bool:
        """Return whether the proof is correct, by arithmetic and without a solver."""
        equations = start_equations(self.problem)
        branches = [each.branch for each in self.proof]
        return cover_every_case(branches) and all(check_branch(equations, each) for each in self.proof)


@dataclass(frozen=True, slots=True, eq=False)
class RestOutcome(Displayed):
    """The possible motions of bricks that can rest."""

    guaranteed: bool  # whether rest is the only possibility
    normal: Forces | None = None  # forces along normals alone that balance everything, if they prove it
    braced: tuple[FrictionProof, ...] = ()  # the groups that need friction, with their proofs, if rest is guaranteed
    start: InitialMotion | None = None  # another possible motion from rest
    lets_go: str = ""  # description of `start`
    undecided: tuple[BodyId, ...] = ()  # a group without a proof and without a start
    across_gaps: bool = False  # whether rest is guaranteed only if gaps between bodies count as contact

    @property
    def reason(self) -> str:
        """Return the reason in words; empty if normal forces alone balance everything."""
        if self.across_gaps:
            return "the proof counts gaps as contact"
        if self.lets_go:
            return f"the bricks could also start to move: {self.lets_go}"
        if self.undecided:
            shown = names_text(in_order(self.undecided))
            return f"friction is needed, and it is undecided whether {shown} could start to move"
        return "friction is needed, and no motion is possible" if self.braced else ""


@display_of.register
def _(found: RestOutcome) -> Display:
    why = found.reason or "forces along normals alone balance every brick"
    word = "\u2713 guaranteed" if found.guaranteed else "\u2013 possible"
    return Display("rest", [("why", why)], word, found.guaranteed or None)


@one_thread()
def outcome(
    problem: Problem,
    known: Forces | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    most: int = MOST_COLUMNS,
) -> RestOutcome:
    """Return the possible motions of a problem proven to stand; `known` are balancing forces, if any are known.

    `most` limits the work for each group that needs friction, in unknowns of its programs. Rest is guaranteed only if
    it is also guaranteed without the contact points that have a gap. Raises TypeError if `problem` is not a Problem or
    `known` is neither Forces nor None, OtherLawError for bricks with joints.
    """
    admit_problem(problem)
    admit_forces(known)
    problem.require_dry("the guarantee of rest")
    normal = guarantee(problem, known, tolerances)
    if normal is not None:
        return RestOutcome(guaranteed=True, normal=normal)
    touching = without_gaps(problem)
    if touching is not problem and not _of_leaning(touching, tolerances, most).guaranteed:
        return RestOutcome(guaranteed=False, across_gaps=True)
    return _of_leaning(problem, tolerances, most)


def _of_leaning(problem: Problem, tolerances: Tolerances, most: int) -> RestOutcome:
    """Return the possible motions of a problem of which some groups need friction."""
    leaning = [group for group in groups_apart(problem) if guarantee(group, None, tolerances) is None]
    outcomes = [_of_group(group, tolerances, most) for group in leaning]
    if not outcomes:
        return RestOutcome(guaranteed=True)
    worst = min(outcomes, key=lambda each: (each.guaranteed, not each.lets_go))
    return replace(worst, braced=tuple(group for each in outcomes for group in each.braced))


def _of_group(group: Problem, tolerances: Tolerances, most: int) -> RestOutcome:
    points = sum(len(contact.points_W) for contact in group.contacts)
    if len(group.bricks) > MOST_BRICKS or points > MOST_POINTS:
        return _let_go(group, find_start(group, tolerances))
    search = search_start(group, start_equations(group), tolerances, most=most)
    if search.proof is not None:
        return RestOutcome(guaranteed=True, braced=(FrictionProof(group, search.proof),))
    return _let_go(group, search.start)


def _let_go(group: Problem, start: InitialMotion | None) -> RestOutcome:
    if start is None:
        return RestOutcome(guaranteed=False, undecided=tuple(group.bricks))
    return RestOutcome(guaranteed=False, start=start, lets_go=described(group, start.acceleration))
