"""How far may every brick sit from its place, all at once and each in its own direction, before a verdict changes?

A guaranteed answer: whoever keeps every brick within the margin of its place in plan has an assembly that stands. It
is a lower bound; columns reach it exactly. Bricks are rigid, stay on what they lie on, and weigh what they weigh: loads
are taken to be vertical.

With every brick i at its place plus d_i, |d_i| <= e, three things change.

1. Two faces that meet on a patch P, each moved by no more than e, still meet on P inset by e: around a point of the
   inset patch a disc of radius e lies in both faces, so neither can lose the point. Forces stand on those points, which
   stay where they are. A plane without end cannot lose a point: a patch on it goes with its brick, not inset.
2. The weight w_i acts at a displaced centre: a first moment d_i w_i.
3. A force G_i on a patch that goes with brick i is displaced too: d_i G_i. With 2 it makes d_i (w_i + G_i), which is
   d_i times what the brick carries; a brick alone on the ground may sit anywhere.

These moments are met by a fixed linear rule: a change of the vertical patch forces N and of their first moments m about
the centre of the patch, of least norm relative to what the patches carry. A vertical patch force is admissible if its
resultant lies inside the patch: e_j.m + h_j N >= 0 for each border line j (inward normal e_j, h_j from the centre). So
written, the worst of all discs of displacements is a sum of lengths, without loss:

    e_j.m + (h_j - e) N  >=  e * sum over i of |e_j.M_i + (h_j - e) N_i| w_i        (M_i, N_i: the rule's answer to d_i)

which is linear in (N, m) for a given e. Friction may be needed to stand at all, so forces at the corners of the inset
patches, in their cones, are added; these are the same whatever the displacements. Where loads could be displaced by
just e with patches that are inset by e, there is the margin.
"""

from collections.abc import Collection
from dataclasses import dataclass
from math import inf

from stability.blas_threads import one_thread
from stability.geometry.polygons import inset
from stability.model import GROUND, BodyId
from stability.statics.facts import Problem
from stability.statics.margins.placement_patches import PlanPatch, plan_patches
from stability.statics.margins.placement_program import Answer, displaced, recourse

MOST_STEPS = 60  # halvings end at the tolerance; a limit only against endless loops
SIDEWAYS = 1e-9  # share of a load that may act sideways and still be rounding


@dataclass(frozen=True, slots=True)
class PlacementMargin:
    """The error of place that is survived by all bricks at once."""

    value: float  # [m] guaranteed; 0 where nothing is, inf where no error in plan matters
    limit: tuple[BodyId, BodyId] | None = None  # the contact that limits it, lower body first
    reason: str = ""  # why it is 0


@one_thread()
def placement(problem: Problem, tolerance: float = 1e-7, planes: Collection[BodyId] = (GROUND,)) -> PlacementMargin:
    """The placement error in plan that a problem's bricks survive, to a relative `tolerance`.

    `planes` are the fixed bodies without end; any other fixed body has borders that stay where they are.
    """
    if _pushed_sideways(problem):
        return PlacementMargin(0.0, reason="a load acts sideways; placement errors are worked out for weights only")
    patches = plan_patches(problem, planes)
    whole = _answer(problem, patches, 0.0)
    if whole is None or not whole.displacement > 0.0:  # nor if it is not a number
        return PlacementMargin(0.0, reason=UNSAFE)
    widest = max((patch.reach for patch in patches if not patch.moving), default=1.0)
    if whole.displacement == inf and _survives(_answer(problem, patches, widest)):
        return PlacementMargin(inf)
    value, limit = _crossing(problem, patches, whole, min(whole.displacement, widest), tolerance)
    return PlacementMargin(value, limit, "" if value > 0.0 else UNSAFE)


UNSAFE = "it stands by edges, corners or leaning faces, which an error takes away, or only just"


def _pushed_sideways(problem: Problem) -> bool:
    forces = [load.force_W for load in problem.loads.values()]
    return any(max(abs(x), abs(y)) > SIDEWAYS * abs(z) for x, y, z in forces)


def _answer(problem: Problem, patches: list[PlanPatch], error: float) -> Answer | None:
    """What is survived by the patches that are left where every brick is off its place by `error`."""
    rule = recourse(problem, [patch for patch in patches if patch.moving or inset(patch.corners, error)])
    return None if rule is None else displaced(rule, problem, error)


def _survives(answer: Answer | None) -> bool:
    return answer is not None and answer.survives


def _crossing(
    problem: Problem, patches: list[PlanPatch], whole: Answer, most: float, tolerance: float
) -> tuple[float, tuple[BodyId, BodyId] | None]:
    """The largest error that is survived, and what limits it: where it equals the displacement that loads survive.

    That displacement falls with the error, mostly along a straight line: hence chords, and halves where they fail.
    """
    low, high, limit = 0.0, most, whole.limit
    over = (min(whole.displacement, 2.0 * most), -inf)  # displacement less error, at `low` and `high`
    error = 0.5 * most
    for step in range(MOST_STEPS):
        answer = _answer(problem, patches, error)
        excess = -inf if answer is None else min(answer.displacement, 2.0 * most) - error
        if answer is not None and answer.survives:
            low, over, limit = error, (excess, over[1]), answer.limit
        else:
            high, over = error, (over[0], min(excess, 0.0))
        if high - low <= tolerance * high or (low == error and excess <= 0.5 * tolerance * error):
            break
        error = _next(low, high, over, step, tolerance)
    return low, limit


def _next(low: float, high: float, over: tuple[float, float], step: int, tolerance: float) -> float:
    """Where the chord crosses, a little to its safe side; the middle if there is no chord, or every third time."""
    middle = 0.5 * (low + high)
    if over[1] == -inf or step % 3 == 2:  # noqa: PLR2004 -- chords may creep up on one side
        return middle
    crossing = low + (high - low) * over[0] / (over[0] - over[1]) if over[0] > over[1] else middle
    return min(max(crossing * (1.0 - 0.25 * tolerance), low + 0.25 * (tolerance * high)), high)
