"""Finds the greatest horizontal acceleration that an assembly survives, bearing by bearing, and the mechanisms."""

from bisect import bisect
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import cos, inf, pi, sin

import numpy as np

from stability.analysis.acceleration_cut import (
    FURTHEST,
    AcceleratedProblem,
    Cut,
    Heading,
    groups_apart,
    heading,
    program_along,
    proven_distance,
    proven_reach,
    shaken,
    weights_of,
)
from stability.analysis.acceleration_margin import slide
from stability.analysis.joined_acceleration import joined_along
from stability.analysis.symmetry import Symmetry, proven_cut, symmetries
from stability.contact_law import OtherLawError
from stability.geometry.rows import Array
from stability.problem import ZERO, Motion, Problem, Tolerances, rounded
from stability.process_settings import one_thread
from stability.statics.conic_program import QuickSeries, SolverPoint, count_work
from stability.statics.equilibrium import balance, separating_velocities

# Directions of acceleration solved with low accuracy, in a third of the time, but proven like all others.
#
# At low accuracy the solver's forces lie slightly outside their cones, and its motions close contacts slightly. Forces
# are corrected as usual. A motion is corrected by adding a small multiple of a motion that opens every contact. The
# distance of the resulting cut follows by plain arithmetic: the resistance of the loads over the momentum.


AT_ONCE = 2  # directions, independent of the number of cores: the choice of the next ones depends on the known ones
FINEST, ROUGHEST = 1e-10, 1e-6  # accuracies requested of the solver
OF_TOLERANCE = 2e-5  # ratio of the solver's accuracy to the tolerance of a reach; a larger one needs more directions
QUIET = (1e-4, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken as static
MOST_OPENED = 0.01  # share of the largest speed: a motion that needs a larger correction is no solution
SURELY = 1.0 + 1e-6  # factor for rounding on the opening of contacts and on the gain that a proof needs


@dataclass(frozen=True, slots=True, eq=False)
class RoughHeadings:
    """Problem with the solvers of its directions, to a relative tolerance."""

    case: AcceleratedProblem
    tolerance: float
    # (columns,) a motion that opens every contact; without one, directions are solved with high accuracy
    opening: Array | None
    series: tuple[QuickSeries, ...]  # the number of directions that are solved at once

    def solve(self, angle: float) -> Heading:
        """Return the greatest acceleration of the assembly in one direction."""
        return self.solve_all([angle])[0]

    def solve_all(self, angles: Sequence[float]) -> list[Heading]:
        """Return the same for several directions, at most one per series, in threads."""
        if self.opening is None:
            return [heading(self.case, angle) for angle in angles]
        programs = [program_along(self.case, angle) for angle in angles]
        for program in programs:
            count_work(program)
        # the solver takes most of the time and releases the interpreter lock
        with ThreadPoolExecutor(len(angles)) as threads:
            points = list(threads.map(QuickSeries.solve, self.series, programs))
        return [self._proven(self.opening, angle, point) for angle, point in zip(angles, points, strict=True)]

    def _proven(self, opening: Array, angle: float, point: SolverPoint) -> Heading:
        if not (np.isfinite(point.x).all() and np.isfinite(point.dual).all()):
            return heading(self.case, angle)
        value, columns = max(0.0, -float(point.dual[0])), point.x[:-1]
        cut = self._cut(opening, columns) if value < 0.5 * FURTHEST else None
        if cut is None:
            return heading(self.case, angle)
        reach, rows = proven_reach(self.case, (cos(angle), sin(angle)), value, point.dual[1:-1])
        share = cut.normal[0] * cos(angle) + cut.normal[1] * sin(angle)
        if share <= 0.0 or reach < (1.0 - self.tolerance) * cut.distance / share:
            return heading(self.case, angle)
        return Heading(angle, reach, rows, self.case.system.matrix @ columns, cut)

    def _cut(self, opening: Array, columns: Array) -> Cut | None:
        """Return the half-plane that a motion proves after its correction."""
        for share in QUIET:
            opened = self._opened(opening, self.case.system.motion(columns, share))
            cut = proven_cut(self.case, opened) if opened is not None else None
            if cut is not None:
                return cut
        return None

    def _opened(self, opening: Array, motion: Motion) -> Motion | None:
        """Return the motion plus the least opening motion of its moving bricks that leaves no contact closing."""
        system = self.case.system
        columns = system.columns_of(motion)
        opening = np.where(self._moves(motion), opening, 0.0)
        # The slack of the slips of a sum of two motions is at least the sum of their slacks.
        spare, gained = (system.rows.spare(system.matrix @ each) for each in (columns, opening))
        closed = spare < 0.0
        if (closed & (gained <= 0.0)).any():
            return None
        needed = SURELY * float((-spare[closed] / gained[closed]).max(initial=0.0))
        if needed > MOST_OPENED:
            return None
        return system.motion(columns + needed * opening)

    def _moves(self, motion: Motion) -> Array:
        """Return (columns,) whether each column belongs to a moving brick."""
        moving: Array = np.repeat([name in motion.velocity for name in self.case.system.names], 6)
        return moving[self.case.system.kept]


def rough_headings(case: AcceleratedProblem, tolerance: float) -> RoughHeadings:
    """Return the solvers of the directions of a problem, to a relative tolerance."""
    velocities = separating_velocities(case.problem, case.problem.bricks)
    opening = None
    if velocities is not None:
        opening = case.system.columns_of(Motion({name: (velocity, ZERO) for name, velocity in velocities.items()}))
    accuracy = min(ROUGHEST, max(FINEST, OF_TOLERANCE * tolerance))
    return RoughHeadings(case, tolerance, opening, tuple(QuickSeries(accuracy) for _ in range(AT_ONCE)))


# The greatest horizontal acceleration that an assembly survives, by bearing, and its first mechanism.
#
# Survivable accelerations form a convex set around zero (see `acceleration`). Each solved direction gives a point of it
# and a half-plane that contains it, so the reach of each bearing lies between the chord of the points and the nearest
# cut. The bearing with the largest difference is solved next, until all are known to the tolerance. Groups without
# contact to each other are solved separately: together they survive what each of them survives.


NOTHING = 1e-7  # [g] a smaller margin counts as zero
# relative difference by which one of two groups must be weaker, so that rounding does not choose which one is named
ALIKE = 1e-6
ROUGHLY = 1e-7  # requested accuracy of the forces at rest, which need not be deepest in their cones
SAME = 1e-9  # [rad] bearings closer than this are equal
ALONG = 1e-12  # cosine below which a cut bounds nothing in a direction


@dataclass(frozen=True, slots=True)
class Survived:
    """Horizontal acceleration that is survived along one bearing, in units of g."""

    bearing: float  # against the acceleration of the ground, along the pull on the bricks: from x towards y
    value: float  # proven by forces; inf if no motion limits it
    upper: float  # proven by `motion` as an upper bound
    motion: Motion | None  # of the structure at the limit


def by_bearing(
    problem: Problem,
    count: int = 72,
    tolerance: float = 0.01,
    gravity: float | None = None,
    on_progress: Callable[[int], None] = lambda _: None,
) -> tuple[Survived, ...] | None:
    """Return the survived accelerations along `count` bearings, from x on, each to a relative `tolerance`.

    None if the problem is not proven to stand. `gravity` [m/s2] is needed if loads are more than weights; without it
    the weight of a brick is the vertical part of its load. Without a proven motion `upper` is less tight. `on_progress`
    is called with the number of finished bearings.
    """
    return along_bearings(
        problem, [2.0 * pi * number / count for number in range(count)], tolerance, gravity, on_progress
    )


@one_thread()
def along_bearings(
    problem: Problem,
    bearings: Sequence[float],
    tolerance: float = 0.01,
    gravity: float | None = None,
    on_progress: Callable[[int], None] = lambda _: None,
) -> tuple[Survived, ...] | None:
    """Return the survived accelerations along given bearings [rad], each from x towards y."""
    if problem.has_joints:
        return _of_joined(problem, bearings, gravity, on_progress)
    count, around = len(bearings), [bearing % (2.0 * pi) for bearing in bearings]
    weakest = [Survived(bearing, inf, inf, None) for bearing in bearings]
    parts = groups_apart(problem)
    for number, part in enumerate(parts):
        case = shaken(part, gravity, Tolerances(), ROUGHLY) or shaken(part, gravity, Tolerances())
        if case is None:
            return None
        bounds = _Found(case, {bearing: one.upper for bearing, one in zip(around, weakest, strict=True)})
        bounds.solve(around, tolerance, partial(_report, on_progress, number * count, len(parts)))
        own = [bounds.survived(bearing) for bearing in bearings]
        weakest = [_weaker(one, other) for one, other in zip(weakest, own, strict=True)]
    return tuple(weakest)


@one_thread()
def along_bearing(problem: Problem, bearing: float, gravity: float | None = None) -> Survived | None:
    """Return the survived acceleration along one bearing; None if the problem is not proven to stand."""
    if problem.has_joints:
        joined = _of_joined(problem, [bearing], gravity, lambda _: None)
        return None if joined is None else joined[0]
    weakest = Survived(bearing, inf, inf, None)
    for part in groups_apart(problem):
        case = shaken(part, gravity, Tolerances())
        if case is None:
            return None
        bounds = _Found(case)
        bounds.add(heading(case, bearing))
        weakest = _weaker(weakest, bounds.survived(bearing))
    return weakest


def _of_joined(
    problem: Problem, bearings: Sequence[float], gravity: float | None, on_progress: Callable[[int], None]
) -> tuple[Survived, ...] | None:
    """Return the survived acceleration of bricks with joints along each bearing, one program each.

    Smaller accelerations along the same bearing are survived, too, since forces at both ends can be mixed.
    """
    if problem.is_brittle:
        raise OtherLawError("accelerations by bearing are not computed for brittle joints")
    tolerances, weights = rounded(problem, Tolerances()), weights_of(problem, gravity)
    if balance(problem, tolerances).forces is None:
        return None
    along = []
    for done, bearing in enumerate(bearings, 1):
        along.append(Survived(bearing, *joined_along(problem, weights, bearing, tolerances)))
        on_progress(done)
    return tuple(along)


def _report(on_progress: Callable[[int], None], before: int, parts: int, done: int) -> None:
    on_progress((before + done) // parts)


def _weaker(one: Survived, other: Survived) -> Survived:
    """Return the weaker of two results."""
    first = other if other.upper < one.upper * (1.0 - ALIKE) else one
    return replace(first, value=min(one.value, other.value))


@dataclass
class _Found:
    """Proven bounds on the accelerations that one group survives."""

    case: AcceleratedProblem
    # [g] by bearing: no larger value is needed, as other groups are proven to survive no more
    enough: Mapping[float, float] = field(default_factory=dict)
    solved: list[Heading] = field(default_factory=list)  # by angle, counter-clockwise
    cuts: list[tuple[float, Cut]] = field(default_factory=list)  # with the proven distance of each [g]
    sliding: tuple[float, Cut] | None = None  # of bricks that slide alike in all directions

    def solve(self, bearings: Sequence[float], tolerance: float, on_progress: Callable[[int], None]) -> None:
        """Solve directions until every bearing is known to a relative tolerance."""
        headings = rough_headings(self.case, tolerance)
        sliding = slide(self.case, 0.0)
        self.sliding = (proven_distance(self.case, sliding), sliding) if sliding is not None else None
        images = symmetries(self.case)
        at_once = 1 if images else AT_ONCE  # an image may make the other direction unnecessary
        for first in range(0, 4, at_once):
            self._solve([0.5 * pi * quarter for quarter in range(first, first + at_once)], headings, images, bearings)
        left = sorted(bearings)
        while True:
            left = [bearing for bearing in left if not self._is_solved(bearing)]
            unknown = {bearing: share for bearing in left if (share := self._unknown(bearing)) > tolerance}
            on_progress(len(bearings) - len(unknown))
            if not unknown:
                return
            self._solve(self._next(unknown, left, tolerance, at_once), headings, images, bearings)

    def _next(
        self, unknown: Mapping[float, float], left: Sequence[float], tolerance: float, at_once: int
    ) -> list[float]:
        """Return the directions to solve next, each between solved ones, where the bounds are widest."""
        gaps: dict[int, float] = {}
        for bearing in sorted(unknown, key=unknown.__getitem__, reverse=True):
            gap = bisect(self.solved, bearing, key=_angle) % len(self.solved)
            if gap not in gaps:
                gaps[gap] = self._furthest(bearing, left, tolerance)
            if len(gaps) == at_once:
                break
        return list(gaps.values())

    def _solve(
        self, angles: Sequence[float], headings: RoughHeadings, images: Sequence[Symmetry], bearings: Sequence[float]
    ) -> None:
        """Solve the directions without a result, and add their images that are proven."""
        unsolved = [angle for angle in angles if not self._is_solved(angle)]
        for one in headings.solve_all(unsolved) if unsolved else ():
            self.add(one)
            for symmetry in images:
                turned = symmetry.angle(one.angle)
                turned = next((bearing for bearing in bearings if _apart(bearing, turned) <= SAME), turned)
                image = None if self._is_solved(turned) else symmetry.image(self.case, one, turned)
                if image is not None:
                    self.add(image)

    def _is_solved(self, angle: float) -> bool:
        return any(_apart(one.angle, angle) <= SAME for one in self.solved)

    def add(self, one: Heading) -> None:
        """Add a solved direction."""
        self.solved = sorted([*self.solved, one], key=lambda each: each.angle)
        if one.cut is not None:
            self.cuts.append((proven_distance(self.case, one.cut), one.cut))

    def survived(self, bearing: float) -> Survived:
        """Return the bounds for one bearing."""
        value, (upper, cut) = self._proven(bearing), self._bound(bearing)
        if value >= 0.5 * FURTHEST:
            return Survived(bearing, inf, inf, None)
        slides = self.sliding is not None and cut is self.sliding[1]
        motion = None if cut is None else _turned(cut, bearing) if slides else cut.motion
        return Survived(bearing, value if upper > NOTHING else 0.0, upper, motion)

    def _furthest(self, bearing: float, left: Sequence[float], tolerance: float) -> float:
        """Return the farthest useful bearing to solve next, beyond the last solved direction before `bearing`.

        It is the last one for which the chord to it would leave no bearing between unknown, if the reach there were as
        large as possible: along an edge the steps go to its end, and along an arc they are even. If no limit of the
        reach is known, the result is the middle one of the bearings in between.
        """
        before = max((one for one in self.solved if one.angle <= bearing), key=_angle, default=self.solved[-1])
        turn = min((one.angle - before.angle) % (2.0 * pi) or 2.0 * pi for one in self.solved if one is not before)
        between = [each for each in left if 0.0 < (each - before.angle) % (2.0 * pi) < turn]
        between.sort(key=lambda each: (each - before.angle) % (2.0 * pi))
        if self._asked(bearing) == inf:
            return between[len(between) // 2]
        furthest = between[0]
        for number, end in enumerate(between):
            at_best = replace(before, angle=end, reach=self._asked(end))
            if any(self._unknown(each, _chord(before, at_best, each)) > tolerance for each in between[:number]):
                break
            furthest = end
        return furthest

    def _unknown(self, bearing: float, proven: float | None = None) -> float:
        """Return the share of the upper bound that is not proven to be survived."""
        value, upper = self._proven(bearing) if proven is None else proven, self._asked(bearing)
        if upper <= NOTHING or value >= 0.5 * FURTHEST:
            return 0.0
        return 1.0 if upper == inf else 1.0 - value / upper

    def _asked(self, bearing: float) -> float:
        """Return the greatest acceleration of interest [g]: more is proven not to be survived."""
        return min(self._bound(bearing)[0], self.enough.get(bearing, inf))

    def _proven(self, bearing: float) -> float:
        """Return the proven acceleration along a bearing: up to the chord of the solved points on both sides."""
        if len(self.solved) == 1:
            return self.solved[0].reach if self.solved[0].angle == bearing else 0.0
        # One pair of points encloses the bearing, or two if the bearing is solved itself, within rounding.
        after = bisect(self.solved, bearing % (2.0 * pi), key=_angle)
        around = [self.solved[number % len(self.solved)] for number in range(after - 2, after + 2)]
        return max(_chord(one, other, bearing) for one, other in pairwise(around))

    def _bound(self, bearing: float) -> tuple[float, Cut | None]:
        """Return the distance of the nearest cut along a bearing [g]; uniform sliding has one in all directions."""
        x, y = cos(bearing), sin(bearing)
        nearest: tuple[float, Cut | None] = (inf, None)
        for distance, cut in self.cuts:
            share = cut.normal[0] * x + cut.normal[1] * y
            if share > ALONG and distance / share < nearest[0]:
                nearest = (distance / share, cut)
        return self.sliding if self.sliding is not None and self.sliding[0] <= nearest[0] else nearest


def _apart(one: float, other: float) -> float:
    """Return the angle between two bearings [rad]."""
    return abs((one - other + pi) % (2.0 * pi) - pi)


def _angle(one: Heading) -> float:
    return one.angle


def _turned(cut: Cut, bearing: float) -> Motion:
    """Return the motion of bricks that slide alike in all directions, along one of them."""
    x, y = cos(bearing), sin(bearing)
    return Motion({name: ((x, y, velocity[2]), spin) for name, (velocity, spin) in cut.motion.velocity.items()})


def _chord(one: Heading, other: Heading, bearing: float) -> float:
    """Return the distance of the chord between two points along a bearing [g]; 0 if it is not between them."""
    (ax, ay), (bx, by), (x, y) = one.point, other.point, (cos(bearing), sin(bearing))
    turn = ax * by - ay * bx
    a, b = ax * y - ay * x, x * by - y * bx  # neither is negative for a direction between the two points
    if turn <= 0.0 or a < 0.0 or b < 0.0:
        return 0.0
    return turn / (a + b)
