"""Reduces a proven fall to a motion of as few bricks as possible.

Parts without contact to each other move independently, so the smallest part with positive power is a proof by itself.
Within it, as many of the slowest bricks as possible are held fixed, and for few bricks as many of the lowest before;
then the motion with the least sum of speeds is computed, which leaves all unneeded bricks at rest; then each brick is
held fixed by itself, from the lowest on: a brick that must move for any fall is needed in every smaller set too. Last,
of all motions of the remaining bricks, the initial one is taken (Gauss: least energy for the power of the loads).
"""

from collections.abc import Collection, Iterator, Sequence, Set
from dataclasses import dataclass, field
from math import hypot

import numpy as np

from stability.geometry.rows import Array
from stability.model import BodyId
from stability.problem import Motion, Problem, Tolerances
from stability.statics.conic_program import ConicProgram, Solver, clarabel_solve, quick_solve, solve
from stability.statics.equilibrium import falling_motion, proven_motion
from stability.statics.fall_description import described
from stability.statics.proof import check_motion
from stability.statics.wrench_matrix import WrenchMatrix, wrench_matrix

__all__ = ["described", "smallest_mechanism"]

FEW = 3  # up to this number of bricks, each is tested by itself
LITTLE = 24  # up to this number of bricks, as many of the lower ones as possible are held fixed first
LARGE = 120  # up to this number of bricks, the least sum of speeds is computed
SLOW = 0.05  # of the fastest: all slower bricks count like bricks of this speed
QUIET = (1e-3, 1e-6, 1e-9)  # shares of the largest speed below which a brick is first taken as static
MOST_TRIES = 24  # of holding bricks fixed one by one
ACCURACIES = (1e-9, 1e-12)  # of the least speeds, tried in turn until the result is proven


def smallest_mechanism(
    problem: Problem,
    motion: Motion,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    solver: Solver = clarabel_solve,
    quick: Solver = quick_solve,
) -> Motion:
    """Return a motion of as few bricks as are found to fall alone; `motion` itself if it proves no fall."""
    parts = [part for part in _parts(problem, motion) if check_motion(problem, part, tolerances).holds]
    if not parts:
        return motion
    search = _Search(problem, tolerances, solver, quick)
    least = search.alone(min(parts, key=lambda part: (len(part.velocity), min(part.velocity))))
    if problem.has_joints:
        return least  # the mechanism of the least load factor, whose bricks seldom fall without one another
    if len(least.velocity) > FEW:
        if len(least.velocity) <= LITTLE:
            least = search.first_held(least, search.upwards(least))
        least = search.sparse(search.first_held(least, _slowest(least)))
    return search.started(search.held(least))


def _parts(problem: Problem, motion: Motion) -> Iterator[Motion]:
    """Yield the motions of parts without contact to each other, in order of names."""
    touching: dict[BodyId, set[BodyId]] = {name: set() for name in motion.velocity}
    for contact in problem.contacts:
        if contact.lower in touching and contact.upper in touching:
            touching[contact.lower].add(contact.upper)
            touching[contact.upper].add(contact.lower)
    left = set(touching)
    for name in sorted(touching):
        if name in left:
            part, waiting = {name}, [name]
            while waiting:
                new = touching[waiting.pop()] - part
                part |= new
                waiting += new
            left -= part
            yield Motion({brick: motion.velocity[brick] for brick in sorted(part)})


@dataclass(frozen=True, slots=True)
class _Search:
    """Search for motions of fewer bricks; each accepted motion is proven."""

    problem: Problem
    tolerances: Tolerances
    solver: Solver  # for motions of least speed
    quick: Solver  # for the existence of a fall
    # no subset of one of these falls while the other bricks are held fixed
    standing: list[Set[BodyId]] = field(default_factory=list)

    def alone(self, motion: Motion) -> Motion:
        """Return the smallest part of a motion that is proven by itself."""
        parts = [part for part in _parts(self.problem, motion) if self._proven(part)]
        return min(parts, key=lambda part: (len(part.velocity), min(part.velocity)), default=motion)

    def _proven(self, motion: Motion) -> bool:
        return check_motion(self.problem, motion, self.tolerances).holds

    def of(self, bricks: Collection[BodyId]) -> Problem:
        """Return the problem of these bricks with the others held fixed."""
        return self.problem.part(bricks)

    def sparse(self, motion: Motion) -> Motion:
        """Return a motion within the given one of least sum of speeds per power of the loads; slow bricks weigh more.

        Bricks that hardly move come to rest where possible.
        """
        if not FEW < len(motion.velocity) <= LARGE:
            return motion
        least = self._least(motion, by_brick=True)
        return self.alone(least) if least is not None else motion

    def started(self, motion: Motion) -> Motion:
        """Return the initial motion of the same bricks."""
        return self._least(motion, by_brick=False) or motion

    def _least(self, motion: Motion, by_brick: bool) -> Motion | None:
        """Return a proven motion of least speed: the sum over bricks, or the norm of all together, weighted by mass.

        None for bricks with joints, which take power from a motion.
        """
        problem = self.of(motion.velocity)
        if problem.has_joints:
            return None
        system = wrench_matrix(problem, whole=True)
        columns = system.columns_of(motion)
        weights = _by_slowness(system, columns) if by_brick else _by_energy(system, problem)
        gain = float(system.loads @ columns) / float(np.linalg.norm(weights * columns))
        program = _least_speed(system, weights, 6 if by_brick else len(columns), gain)
        for accuracy in ACCURACIES:
            point = solve(program, accuracy, self.solver)
            if isinstance(point, str):
                continue
            proven = proven_motion(self.problem, system, point.x[: len(columns)], self.tolerances, QUIET)
            if proven is not None:
                return proven
        return None

    def held(self, motion: Motion) -> Motion:
        """Return a motion within the given one after bricks were held fixed one by one, from the lowest on."""
        for name in self.upwards(motion)[:MOST_TRIES]:
            if name in motion.velocity:
                motion = self._without(motion, [name]) or motion
        return motion

    def first_held(self, motion: Motion, order: Sequence[BodyId]) -> Motion:
        """Return a motion after as many of the first bricks in an order as possible were held fixed."""
        held, too_many = 0, len(order)
        while held + 1 < too_many:
            middle = (held + too_many) // 2
            fewer = self._without(motion, order[:middle])
            if fewer is None:
                too_many = middle
            else:
                motion, held = fewer, middle
        return motion

    def _without(self, motion: Motion, fixed: Sequence[BodyId]) -> Motion | None:
        """Return a proven motion of the bricks that are not held fixed."""
        rest = set(motion.velocity) - set(fixed)
        if not rest or any(rest <= standing for standing in self.standing):
            return None
        fewer = falling_motion(self.of(rest), self.tolerances, self.quick)
        if fewer is None:
            self.standing.append(rest)
        return self.alone(fewer) if fewer is not None and self._proven(fewer) else None

    def upwards(self, motion: Motion) -> list[BodyId]:
        """Return the moving bricks, the lowest centre first."""
        heights = {name: self.problem.bricks[name].pose.position_W[2] for name in motion.velocity}
        return sorted(heights, key=lambda name: (heights[name], name))


def _slowest(motion: Motion) -> list[BodyId]:
    """Return the moving bricks, the slowest centre first."""
    return sorted(motion.velocity, key=lambda name: (hypot(*motion.velocity[name][0]), name))


def _by_slowness(system: WrenchMatrix, columns: Array) -> Array:
    """Return the scales from columns to speeds relative to those of a motion, up to a factor."""
    weights = _by_speed(system)
    speeds = np.linalg.norm((weights * columns).reshape(-1, 6), axis=1)
    slowness = 1.0 / (speeds / speeds.max() + SLOW)
    slow: Array = weights * np.repeat(slowness / slowness.max(), 6)
    return slow


def _by_speed(system: WrenchMatrix) -> Array:
    """Return the scales from columns, which are speeds times carried loads, to speeds, up to a factor."""
    force = np.repeat(system.column_scale[0::6], 6)
    weights: Array = force.min() / force
    return weights


def _by_energy(system: WrenchMatrix, problem: Problem) -> Array:
    """Return the scales from columns to speeds times roots of mass, with spins as of a ball, up to a factor."""
    masses = np.array([problem.bricks[name].brick.mass for name in system.names])
    spins = np.tile([1.0, 1.0, 1.0, *[3.0**-0.5] * 3], len(masses))
    weights: Array = np.repeat(np.sqrt(masses / masses.max()), 6) * spins * _by_speed(system)
    largest = float(weights.max())
    return weights / largest


def _least_speed(system: WrenchMatrix, weights: Array, width: int, gain: float) -> ConicProgram:
    """Return the program of the least sum of norms of `width` weighted columns for a power `gain` of the loads."""
    from scipy.sparse import bmat, csc_matrix  # noqa: PLC0415 -- slow to import, seldom needed

    columns, held = len(weights), system.rows.of_round
    groups = columns // width
    size = groups * (width + 1)
    first = (width + 1) * np.arange(groups)
    norms = csc_matrix((np.ones(groups), (first, np.arange(groups))), shape=(size, groups))
    others = np.delete(np.arange(size), first)
    parts = csc_matrix((weights, (others, np.arange(columns))), shape=(size, columns))
    power = csc_matrix(system.loads[None, :] / gain)
    matrix = bmat([[power, None], [-system.matrix[:held], None], [-parts, -norms], [-system.matrix[held:], None]])
    offset = np.zeros(matrix.shape[0])
    offset[0] = 1.0
    cost = np.append(np.zeros(columns), np.ones(groups))
    return system.rows.program(cost, matrix.tocsc(), offset, equal=1, norms=[width + 1] * groups)
