"""Guaranteed or possible: is rest all that can happen to what is balanced, or could it let go as well?

Where forces along normals alone balance a group, rest is guaranteed at any friction (`margins.guarantee`). Of a group
that needs friction, and is small, every other start is proven impossible, or one is found (`search`). What is neither
stays possible without more being said.
"""

from dataclasses import dataclass, replace

from stability.blas_threads import one_thread
from stability.model import BodyId
from stability.name_order import in_order
from stability.statics.admission import admit_forces, admit_problem
from stability.statics.facts import Forces, Problem, Tolerances
from stability.statics.margins.groups import groups_apart
from stability.statics.margins.guarantee import guarantee, without_gaps
from stability.statics.outcomes.branch import leave_nothing_out
from stability.statics.outcomes.first_start import lets_go
from stability.statics.outcomes.other_start import Start
from stability.statics.outcomes.search import MOST_COLUMNS, searched
from stability.statics.outcomes.start_equations import start_equations
from stability.statics.outcomes.virtual_power import ProvenBranch, check_branch
from stability.statics.solvers.fall_words import described

MOST_BRICKS = 5  # of a group that is decided by its modes of contact
MOST_POINTS = 20  # of its contacts, likewise: beyond, a branch takes a second


@dataclass(frozen=True, slots=True, eq=False)
class Braced:
    """A group that friction alone holds for certain: in none of the branches, which leave nothing out, it starts."""

    problem: Problem
    proof: tuple[ProvenBranch, ...]

    def holds(self) -> bool:
        """Whether the proof is right, by arithmetic and without a solver."""
        equations = start_equations(self.problem)
        branches = [each.branch for each in self.proof]
        return leave_nothing_out(branches) and all(check_branch(equations, each) for each in self.proof)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What can happen to bricks that can rest."""

    guaranteed: bool  # rest is all that can
    normal: Forces | None = None  # forces along normals alone that balance everything, if that is why
    braced: tuple[Braced, ...] = ()  # the groups of which friction is needed, if that is why
    start: Start | None = None  # how bricks could start to move instead
    lets_go: str = ""  # that in words
    undecided: tuple[BodyId, ...] = ()  # a group of which nothing more is known
    across_gaps: bool = False  # rest is all that can happen only if gaps between bodies count as contact

    @property
    def reason(self) -> str:
        """Why, in words; empty where normal forces alone balance everything."""
        if self.across_gaps:
            return "it counts on gaps as contact"
        if self.lets_go:
            return f"it could let go: {self.lets_go}"
        if self.undecided:
            names = in_order(self.undecided)
            shown = ", ".join(names) if len(names) <= MOST_BRICKS else f"{names[0]} and {len(names) - 1} more"
            return f"friction is needed, and whether it could let go was not decided of {shown}"
        return "friction is needed, and nothing else can happen" if self.braced else ""


@one_thread()
def outcome(
    problem: Problem,
    known: Forces | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    most: int = MOST_COLUMNS,
) -> Outcome:
    """What can happen to a problem that is proven to stand; `known` are forces that balance it.

    `most` bounds the work that is spent on each group that needs friction, in unknowns of its programs.
    Rest is guaranteed only if it is so without the points of contacts at which there is a gap.
    Raises TypeError for what is no problem, or no forces.
    """
    admit_problem(problem)
    admit_forces(known)
    normal = guarantee(problem, known, tolerances)
    if normal is not None:
        return Outcome(guaranteed=True, normal=normal)
    touching = without_gaps(problem)
    if touching is not problem and not _of_leaning(touching, tolerances, most).guaranteed:
        return Outcome(guaranteed=False, across_gaps=True)
    return _of_leaning(problem, tolerances, most)


def _of_leaning(problem: Problem, tolerances: Tolerances, most: int) -> Outcome:
    """What can happen to a problem whose groups need friction, or some of them."""
    leaning = [group for group in groups_apart(problem) if guarantee(group, None, tolerances) is None]
    found = [_of_group(group, tolerances, most) for group in leaning]
    if not found:
        return Outcome(guaranteed=True)
    worst = min(found, key=lambda each: (each.guaranteed, not each.lets_go))
    return replace(worst, braced=tuple(group for each in found for group in each.braced))


def _of_group(group: Problem, tolerances: Tolerances, most: int) -> Outcome:
    points = sum(len(contact.points_W) for contact in group.contacts)
    if len(group.bricks) > MOST_BRICKS or points > MOST_POINTS:
        return _let_go(group, lets_go(group, tolerances))
    search = searched(group, start_equations(group), tolerances, most=most)
    if search.proof is not None:
        return Outcome(guaranteed=True, braced=(Braced(group, search.proof),))
    return _let_go(group, search.start)


def _let_go(group: Problem, start: Start | None) -> Outcome:
    if start is None:
        return Outcome(guaranteed=False, undecided=tuple(group.bricks))
    return Outcome(guaranteed=False, start=start, lets_go=described(group, start.acceleration))
