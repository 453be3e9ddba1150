"""How little friction is enough? The least factor on all friction coefficients with which contact forces still balance.

Less friction means smaller cones, so what stands with a factor stands with any larger one. Each step asks, for one
factor k, for the least prestress s (see `prestress`), positive where forces within the cones do not balance. By the
envelope theorem ds/dk is the power of tangential forces on slips, over k. So each step yields a verdict with its
proof, forces or a motion, and by Newton's rule the next factor to ask for, a little beyond the root, so that proofs
close in on it from both sides.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite

from stability.blas_threads import one_thread
from stability.statics.facts import Forces, Motion, Problem, Tolerances
from stability.statics.margins.prestress import least_prestress
from stability.statics.solvers.equilibrium import balance, proven_forces, proven_motion
from stability.statics.solvers.wrench_matrix import wrench_matrix

MOST_STEPS = 60
MOST_FRICTION = 1e4  # a coefficient that no material has: what needs more stands with none
WIDER = 4.0  # by how much the next question keeps away from the root after one that had no proof


@dataclass(frozen=True, slots=True)
class FrictionMargin:
    """The least friction with which contact forces can still hold."""

    factor: float  # on all coefficients, proven by `forces`; inf if no friction is enough
    too_little: (
        float  # a factor proven not to be enough, by `motion`; equal to `factor` within the tolerance; 0 if none is
    )
    coefficient: float  # the largest coefficient of the problem, times the factor
    forces: Forces | None
    motion: Motion | None


@dataclass(frozen=True, slots=True)
class _Step:
    """What was proven at one factor."""

    forces: Forces | None
    motion: Motion | None
    guess: float  # of the least factor


@one_thread()
def least_friction(
    problem: Problem,
    tolerance: float = 1e-7,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> FrictionMargin:
    """The least factor on all friction coefficients that still allows equilibrium, to a relative `tolerance`.

    This asks for equilibrium alone, and not whether it rests on self-stress.
    """
    smooth = balance(_with_friction(problem, 0.0), tolerances)
    if smooth.forces is not None:
        return FrictionMargin(0.0, 0.0, 0.0, smooth.forces, None)
    largest = max((contact.friction for contact in problem.contacts), default=0.0)
    too_little, enough = _Step(None, smooth.motion, 0.0), _Step(None, None, inf)
    low, high, factor, aside = 0.0, inf, 1.0, tolerance / 3.0
    for _ in range(MOST_STEPS if largest > 0.0 else 0):
        step = _asked(problem, factor, tolerances)
        if step.forces is not None:
            high, enough = factor, step
        elif step.motion is not None:
            low, too_little = factor, step
        else:
            aside *= WIDER
        closed = high < inf and high - low <= max(tolerance, 2.0 * aside) * high
        if closed or (high == inf and factor * largest >= MOST_FRICTION):
            break
        factor = min(_next(step, low, high, aside), MOST_FRICTION / largest)
    return FrictionMargin(high, low, largest * high if high < inf else inf, enough.forces, too_little.motion)


def _next(step: _Step, low: float, high: float, aside: float) -> float:
    """A little beyond the root that Newton's rule sees, to prove the other side next; else between the bounds."""
    factor = step.guess * (1.0 + aside if step.forces is None else 1.0 - aside)
    if isfinite(factor) and low < factor < high:
        return factor
    return 0.5 * (low + high) if high < inf else WIDER * max(low, factor)


def _with_friction(problem: Problem, factor: float) -> Problem:
    contacts = [replace(contact, friction=factor * contact.friction) for contact in problem.contacts]
    return replace(problem, contacts=contacts)


def _asked(problem: Problem, factor: float, tolerances: Tolerances) -> _Step:
    """What one factor proves, and the next guess of the least factor."""
    scaled = _with_friction(problem, factor)
    system = wrench_matrix(scaled)
    found = least_prestress(system)
    guess = factor * (1.0 - found.least / found.sliding) if found.sliding < 0.0 else inf
    forces = proven_forces(scaled, system, found.rows, tolerances) if found.least <= 0.0 else None
    motion = None if forces else proven_motion(scaled, system, found.columns, tolerances)
    return _Step(forces, motion, guess)
