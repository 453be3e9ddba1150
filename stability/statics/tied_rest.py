"""Bricks that stand by ties whose tension is more than that with which they were put on.

A tie has the tension with which it was put on, unless the balance of the bricks needs more. A motion proves a fall if
it gains power with the tension that takes most from it. A larger tension may be self-stress, which presses bricks
together and which nothing ensures. If some motion opens every contact and shortens some ties, the tensions of these
ties are none: the loads determine them. All other ties keep their first tension.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stability.problem import Forces, Motion, Problem, Tolerances
from stability.process_settings import one_thread
from stability.statics.conic_program import clarabel_solve
from stability.statics.equilibrium import balance, separating_motion, widest_separation
from stability.statics.load_factor import least_forces
from stability.statics.mechanism import smallest_mechanism
from stability.statics.proof import power
from stability.statics.self_stress import SHUT, forces_without_self_stress
from stability.statics.wrench_matrix import wrench_matrix

ACCURACY = 1e-10  # requested of the solver; its results are checked
NEEDED = (1e-9, 1e-6, 1e-3)  # shares by which the needed tension is taken larger, tried in turn until it is proven
YIELDS = 1e-3  # share of the power that ties take from a motion: one that takes less hardly yields
SLIGHT = 1e-6  # share of the largest tension: a smaller one counts as none


@dataclass(frozen=True, slots=True)
class TiedRest:
    """Forces without self-stress that balance a tied problem, or a motion that no tension stops, or why neither."""

    forces: Forces | None = None
    motion: Motion | None = None
    note: str = ""


@one_thread()
def tied_rest(problem: Problem, tolerances: Tolerances, *, names_smallest: bool = False) -> TiedRest:
    """Return the proof that a problem with ties of unknown tension stands, or that it falls."""
    found = balance(problem, tolerances)
    if found.motion is not None:
        motion = smallest_mechanism(problem, found.motion, tolerances) if names_smallest else found.motion
        return TiedRest(motion=motion)
    if found.forces is None:
        return TiedRest(note=f"too close to the limit of stability for a proof in either direction ({found.note})")
    determined = determined_tensions(problem)
    if determined.ties != problem.ties:
        found = balance(determined, tolerances)
    if found.forces is not None and (not determined.ties or separating_motion(determined) is not None):
        forces = forces_without_self_stress(determined, found.forces, tolerances)
        if forces is not None:
            return TiedRest(forces)
    needed = needed_tensions(problem, tolerances)
    if needed is None:
        return TiedRest(note="only self-stress can hold the structure: forces that its loads do not require")
    tightened = ", ".join(
        f"a tension of {tie.least + more:.4g} N in the tie '{tie.name}'"
        for tie, more in zip(problem.ties, needed, strict=True)
        if more > 0.0
    )
    return TiedRest(note=f"it needs {tightened}, but nothing draws it tighter than it was put on")


def determined_tensions(problem: Problem) -> Problem:
    """Return the problem with those ties only whose tension the loads determine; the others keep their least one."""
    if not problem.ties:
        return problem
    widest = widest_separation(problem)
    if widest is None:
        return replace(problem, ties=())
    pairs = zip(problem.ties, widest.of_ties, strict=True)
    return replace(problem, ties=tuple(tie for tie, shortening in pairs if shortening > SHUT))


def needed_tensions(problem: Problem, tolerances: Tolerances) -> tuple[float, ...] | None:
    """Return tensions above the least ones, of the least sum, with which bricks are proven to stand [N], or None."""
    system = wrench_matrix(problem, any_law=True)
    cost = np.zeros(len(system.rows))
    cost[system.of_ties] = system.row_scale[system.of_ties] / system.row_scale[system.of_ties].max()
    point = least_forces(system, system.loads, cost, ACCURACY, clarabel_solve)
    if isinstance(point, str) or not np.isfinite(point.x).all():
        return None
    more = np.maximum(point.x[system.of_ties] * system.row_scale[system.of_ties], 0.0)
    more[more <= SLIGHT * more.max(initial=0.0)] = 0.0
    for share in NEEDED:
        tried = [min((1.0 + share) * each, tie.more) for each, tie in zip(more.tolist(), problem.ties, strict=True)]
        known = problem.drawn(tried)
        forces = balance(known, tolerances).forces
        if forces is not None and forces_without_self_stress(known, forces, tolerances) is not None:
            return tuple(tried)
    return None


def ties_that_yield(problem: Problem, motion: Motion) -> Iterator[str]:
    """Yield in words the ties that take power from a motion at their strength."""
    taken = [-tie.most * power(tie.pulls, motion) for tie in problem.ties]
    for tie, each in zip(problem.ties, taken, strict=True):
        if each > YIELDS * max(taken):
            yield f"the tie '{tie.name}' reaches its strength of {tie.most:.4g} N"
