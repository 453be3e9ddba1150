"""Finds the greatest horizontal acceleration that an assembly survives, bearing by bearing, and the mechanisms."""

from bisect import bisect
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np

from stability.analysis.acceleration_cut import (
    FURTHEST,
    Cut,
    Heading,
    Shaken,
    groups_apart,
    heading,
    program_along,
    proven_distance,
    proven_reach,
    shaken,
)
from stability.analysis.acceleration_margin import slide
from stability.geometry.rows import Array, Indices
from stability.geometry.vectors import rotate
from stability.problem import ZERO, Motion, Problem, Tolerances, Wrench
from stability.process_settings import one_thread
from stability.statics.conic_program import QuickSeries, SolverPoint, count_work
from stability.statics.equilibrium import separating_velocities
from stability.statics.wrench_matrix import Cones, wrench_array

# Directions of acceleration solved roughly, in a third of the time, and proven all the same.
#
# A solver that is asked for a share of a reach leaves forces a little outside of their cones, and motions that close
# contacts a little. Forces are mended as ever. To a motion so much of one that opens every contact is added that none
# is closed; how far off all accelerations lie that it then rules out is plain arithmetic: what the loads resist it by,
# over its momentum.


AT_ONCE = 2  # directions, whatever cores there are: which are solved next hangs on those that are known
FINEST, ROUGHEST = 1e-10, 1e-6  # accuracies that are asked of the solver
OF_TOLERANCE = 2e-5  # share of what a reach may be off by that the solver is asked for: with more, more directions
QUIET = (1e-4, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken to stay
MOST_OPENED = 0.01  # of the speed of the fastest: a motion that needs to be opened by more is no solution
SURELY = 1.0 + 1e-6  # times what is needed to open contacts, and to gain what a proof must: rounding
FURTHER = (4.0, 100.0, 1e4, 1e6)  # times the least gain of a proof, tried in turn


@dataclass(frozen=True, slots=True, eq=False)
class RoughHeadings:
    """A case, and how its directions are solved to a relative tolerance."""

    case: Shaken
    tolerance: float
    opening: Array | None  # (columns,) a motion that opens every contact; without one directions are solved finely
    series: tuple[QuickSeries, ...]  # as many directions are solved at once

    def solve(self, angle: float) -> Heading:
        """How far the assembly can be accelerated in one direction."""
        return self.solve_all([angle])[0]

    def solve_all(self, angles: Sequence[float]) -> list[Heading]:
        """The same of no more directions than may be solved at once, each on a core of its own where there is one."""
        if self.opening is None:
            return [heading(self.case, angle) for angle in angles]
        programs = [program_along(self.case, angle) for angle in angles]
        for program in programs:
            count_work(program)
        with ThreadPoolExecutor(len(angles)) as threads:  # what takes long is the solver, which lets others go on
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
        """The half-plane that a motion proves once it is opened."""
        for share in QUIET:
            opened = self._opened(opening, self.case.system.motion(columns, share))
            cut = proven_cut(self.case, opened) if opened is not None else None
            if cut is not None:
                return cut
        return None

    def _opened(self, opening: Array, motion: Motion) -> Motion | None:
        """A motion with as much of the opening one added, to the bricks that move, as leaves no contact closed."""
        system = self.case.system
        columns = system.columns_of(motion)
        opening = np.where(self._moves(motion), opening, 0.0)
        # Of two motions together, what slips have to spare is no less than the sum.
        spare, gained = (system.rows.spare(system.matrix @ each) for each in (columns, opening))
        closed = spare < 0.0
        if (closed & (gained <= 0.0)).any():
            return None
        needed = SURELY * float((-spare[closed] / gained[closed]).max(initial=0.0))
        if needed > MOST_OPENED:
            return None
        return system.motion(columns + needed * opening)

    def _moves(self, motion: Motion) -> Array:
        """(columns,) which belong to a brick that moves."""
        moving: Array = np.repeat([name in motion.velocity for name in self.case.system.names], 6)
        return moving[self.case.system.kept]


def rough_headings(case: Shaken, tolerance: float) -> RoughHeadings:
    """Directions of a case, solved to a relative tolerance."""
    velocities = separating_velocities(case.problem, case.problem.bricks)
    opening = None
    if velocities is not None:
        opening = case.system.columns_of(Motion({name: (velocity, ZERO) for name, velocity in velocities.items()}))
    accuracy = min(ROUGHEST, max(FINEST, OF_TOLERANCE * tolerance))
    return RoughHeadings(case, tolerance, opening, tuple(QuickSeries(accuracy) for _ in range(AT_ONCE)))


def proven_cut(case: Shaken, motion: Motion) -> Cut | None:
    """The half-plane that a motion proves, as near as it does: where it gains no more than a proof must."""
    momentum, resisted, size = _powers(case, motion)
    along = hypot(*momentum)
    if not along > 0.0:
        return None
    x, y = momentum[0] / along, momentum[1] / along
    distance = max(0.0, resisted / along)
    for times in FURTHER:
        proven = distance + times * case.tolerances.gain * size * (1.0 + distance) / along
        if case.falls(proven * x, proven * y, motion).holds:
            return Cut((x, y), proven, 0.0, motion)
    return None


def _powers(case: Shaken, motion: Motion) -> tuple[tuple[float, float], float, float]:
    """Return the power of a motion under 1 g along x and y, the loss of the loads, and the sum of sizes [W]."""
    gained, resisted, size = np.zeros(2), 0.0, 0.0
    for name, (velocity, spin) in sorted(motion.velocity.items()):
        weight, load = case.weights.get(name, 0.0), case.problem.loads.get(name, Wrench(ZERO))
        gained += weight * np.array(velocity[:2])
        resisted -= float(np.dot(load.force_W, velocity) + np.dot(load.torque_W, spin))
        size += (hypot(*load.force_W) + weight) * hypot(*velocity) + hypot(*load.torque_W) * hypot(*spin)
    return (float(gained[0]), float(gained[1])), resisted, size


# Turns and mirrors about an upright axis that map a structure onto itself: so one bearing tells of others.
#
# Bricks are piled in grids, so many a load is its own mirror image. What forces hold along one bearing, and what a
# motion rules out, is then known along its images without a solver. Nothing is taken for granted: the images are
# checked by the arithmetic that checks what is solved, so that a structure that is only nearly its own image proves no
# less.


IMAGE_ACCURACY = 1e-9  # of the size of a structure, and of its loads: by so much an image may be off
FEWEST = 12  # bricks: what is smaller is solved as soon as it is mirrored
EIGHTH = pi / 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """A turn or mirror about a vertical axis, with the images of all bricks and cones of a structure."""

    matrix: Array  # (3, 3)
    bricks: Indices  # (bricks,) the image of each
    cones: Indices  # (cones,) the image of each
    signs: Array  # (cones,) -1 where the image is of the force on the other body

    def image(self, case: Shaken, one: Heading, angle: float) -> Heading | None:
        """Return the result of a direction in its image at this angle; None if it is not proven there."""
        x, y = one.reach * cos(angle), one.reach * sin(angle)
        rows = self._rows(case, one.rows)
        if not case.holds(x, y, rows):
            return None
        cut = None if one.cut is None else proven_cut(case, self._motion(case, one.cut.motion))
        return None if cut is None and one.cut is not None else Heading(angle, one.reach, rows, one.slips, cut)

    def angle(self, angle: float) -> float:
        """The image of a bearing [rad], from 0 on."""
        x, y, _ = self.matrix @ np.array([cos(angle), sin(angle), 0.0])
        return atan2(y, x) % (2.0 * pi)

    def _rows(self, case: Shaken, rows: Array) -> Array:
        system = case.system
        forces = np.zeros((len(self.cones), 3))
        forces[self.cones] = self.signs[:, None] * (system.forces_W(rows) @ self.matrix.T)
        return system.rows_of(forces)

    def _motion(self, case: Shaken, motion: Motion) -> Motion:
        """Spins are axial: a mirror turns them round."""
        names, turn = case.system.names, float(np.linalg.det(self.matrix)) * self.matrix
        image = {name: names[self.bricks[number]] for number, name in enumerate(names)}
        return Motion(
            {
                image[name]: (_vector(self.matrix @ np.array(velocity)), _vector(turn @ np.array(spin)))
                for name, (velocity, spin) in motion.velocity.items()
            }
        )


def _vector(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return (x, y, z)


def symmetries(case: Shaken) -> Sequence[Symmetry]:
    """Those of the turns and mirrors of a square, in the plan of one of the bricks, that a structure has."""
    names = case.system.names
    if len(names) < FEWEST:
        return ()
    centres = np.array([case.problem.bricks[name].pose.position_W for name in names])
    centre = 0.5 * (centres.min(axis=0) + centres.max(axis=0))
    size = float(np.abs(centres - centre).max()) or 1.0
    found = (_symmetry(case, matrix, (centres - centre) / size, centre, size) for matrix in _candidates(case.problem))
    return tuple(one for one in found if one is not None)


def _candidates(problem: Problem) -> Iterator[Array]:
    """Three quarter turns, and the mirrors along the sides and the diagonals of the first brick."""
    first = problem.bricks[min(problem.bricks)]
    x, y, _ = rotate(first.pose.orientation, (1.0, 0.0, 0.0))
    along = atan2(y, x)
    for quarter in (1, 2, 3):
        c, s = cos(quarter * pi / 2.0), sin(quarter * pi / 2.0)
        yield np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for eighth in range(4):
        c, s = cos(2.0 * (along + eighth * EIGHTH)), sin(2.0 * (along + eighth * EIGHTH))
        yield np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])


def _symmetry(case: Shaken, matrix: Array, places: Array, centre: Array, size: float) -> Symmetry | None:
    """The symmetry of this matrix; None if it maps some brick, load or cone onto none."""
    forces, torques, weights = _loads(case, size)
    turn = float(np.linalg.det(matrix)) * matrix
    bricks = _onto(
        np.hstack([places @ matrix.T, forces @ matrix.T, torques @ turn.T, weights]),
        np.hstack([places, forces, torques, weights]),
    )
    if bricks is None:
        return None
    points = (case.system.cones.points_W - centre) / size
    onto = _cones_onto(case.system.cones, matrix, points, np.append(bricks, len(bricks)))
    if onto is None or len(np.unique(onto % len(points))) < len(points):
        return None
    return Symmetry(matrix, bricks, onto % len(points), np.where(onto < len(points), 1.0, -1.0))


def _loads(case: Shaken, size: float) -> tuple[Array, Array, Array]:
    """Forces, torques and weights of the bricks, in shares of the largest; lengths in those of the structure."""
    names = case.system.names
    loads = wrench_array(names, case.problem.loads) / np.array([1.0, 1.0, 1.0, size, size, size])
    weights = np.array([[case.weights.get(name, 0.0)] for name in names])
    unit = float(max(np.abs(loads).max(initial=0.0), np.abs(weights).max(initial=0.0))) or 1.0
    return loads[:, :3] / unit, loads[:, 3:] / unit, weights / unit


def _cones_onto(cones: Cones, matrix: Array, points: Array, image: Indices) -> Indices | None:
    """Return the image of each cone, plus the number of cones if lower and upper body are exchanged.

    `image` has the image of each brick and, as its last entry, of the fixed bodies.
    """
    normals, lower, upper, friction = cones.axes_W[:, 0], cones.lower, cones.upper, cones.friction
    mapped = np.column_stack([points @ matrix.T, normals @ matrix.T, image[lower], image[upper], friction])
    as_they_are = np.column_stack([points, normals, lower, upper, friction])
    exchanged = np.column_stack([points, -normals, upper, lower, friction])
    return _onto(mapped, np.vstack([as_they_are, exchanged]))


def _onto(rows: Array, others: Array) -> Indices | None:
    """Which of the other rows each row is like; None if one is like none, or two are like the same."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 -- slow to import, and few need it

    distance, which = cKDTree(others).query(rows, distance_upper_bound=IMAGE_ACCURACY)
    found: Indices = np.asarray(which, dtype=np.int64)
    return found if np.isfinite(distance).all() and len(np.unique(found)) == len(found) else None


# The greatest horizontal acceleration that an assembly survives, by bearing, and its first mechanism.
#
# Accelerations that are survived are a convex set around none (see `acceleration`). Each direction that is solved gives
# a point of it and a half-plane about all of it, so between them the reach of every bearing lies between the chord of
# the points and the nearest cut. The bearing where these are furthest apart is solved next, until all are known well
# enough. What does not touch is solved apart: together it survives what each part does.


NOTHING = 1e-7  # [g] a margin below is none
ALIKE = 1e-6  # share by which of two groups one must give way sooner: rounding does not choose which is named
ROUGHLY = 1e-7  # asked of the solver for forces at rest, which need not be the deepest in their cones
SAME = 1e-9  # [rad] bearings as near as this are one
ALONG = 1e-12  # cosine below which a cut bounds nothing in a direction


@dataclass(frozen=True, slots=True)
class Survived:
    """The horizontal acceleration that is survived along one bearing, in units of g."""

    bearing: float  # that the ground accelerates against, and bricks are pulled along: from x towards y [rad]
    value: float  # proven by forces; inf if nothing gives way
    upper: float  # proven by `motion` not to be survived
    motion: Motion | None  # how it then moves


def by_bearing(
    problem: Problem,
    count: int = 72,
    tolerance: float = 0.01,
    gravity: float | None = None,
    known: Callable[[int], None] = lambda _: None,
) -> tuple[Survived, ...] | None:
    """Return the survived accelerations along `count` bearings, from x on, each to a relative `tolerance`.

    None if the problem is not proven to stand. `gravity` [m/s2] is needed where loads are more than weights; else the
    weight of a brick is the vertical part of its load. Without a proven motion, `upper` is further off. `known` is
    called with the number of finished bearings.
    """
    return along_bearings(problem, [2.0 * pi * number / count for number in range(count)], tolerance, gravity, known)


@one_thread()
def along_bearings(
    problem: Problem,
    bearings: Sequence[float],
    tolerance: float = 0.01,
    gravity: float | None = None,
    known: Callable[[int], None] = lambda _: None,
) -> tuple[Survived, ...] | None:
    """The same of some bearings [rad], each from x towards y."""
    count, around = len(bearings), [bearing % (2.0 * pi) for bearing in bearings]
    weakest = [Survived(bearing, inf, inf, None) for bearing in bearings]
    parts = groups_apart(problem)
    for number, part in enumerate(parts):
        case = shaken(part, gravity, Tolerances(), ROUGHLY) or shaken(part, gravity, Tolerances())
        if case is None:
            return None
        found = _Found(case, {bearing: one.upper for bearing, one in zip(around, weakest, strict=True)})
        found.solve(around, tolerance, partial(_told, known, number * count, len(parts)))
        own = [found.survived(bearing) for bearing in bearings]
        weakest = [_weaker(one, other) for one, other in zip(weakest, own, strict=True)]
    return tuple(weakest)


@one_thread()
def along_bearing(problem: Problem, bearing: float, gravity: float | None = None) -> Survived | None:
    """Return the survived acceleration along one bearing; None if the problem is not proven to stand."""
    weakest = Survived(bearing, inf, inf, None)
    for part in groups_apart(problem):
        case = shaken(part, gravity, Tolerances())
        if case is None:
            return None
        found = _Found(case)
        found.add(heading(case, bearing))
        weakest = _weaker(weakest, found.survived(bearing))
    return weakest


def _told(known: Callable[[int], None], before: int, parts: int, done: int) -> None:
    known((before + done) // parts)


def _weaker(one: Survived, other: Survived) -> Survived:
    """Return the weaker of two results."""
    first = other if other.upper < one.upper * (1.0 - ALIKE) else one
    return replace(first, value=min(one.value, other.value))


@dataclass
class _Found:
    """Proven bounds on the accelerations that one group survives."""

    case: Shaken
    enough: Mapping[float, float] = field(default_factory=dict)  # [g] by bearing: others are proven to survive no more
    solved: list[Heading] = field(default_factory=list)  # by angle, counter-clockwise
    cuts: list[tuple[float, Cut]] = field(default_factory=list)  # with the distance that each is proven for [g]
    sliding: tuple[float, Cut] | None = None  # of bricks that slide alike in all directions

    def solve(self, bearings: Sequence[float], tolerance: float, known: Callable[[int], None]) -> None:
        """Solve directions until every bearing is known to a relative tolerance."""
        headings = rough_headings(self.case, tolerance)
        sliding = slide(self.case, 0.0)
        self.sliding = (proven_distance(self.case, sliding), sliding) if sliding is not None else None
        images = symmetries(self.case)
        at_once = 1 if images else AT_ONCE  # an image may make the other one needless
        for first in range(0, 4, at_once):
            self._solve([0.5 * pi * quarter for quarter in range(first, first + at_once)], headings, images, bearings)
        left = sorted(bearings)
        while True:
            left = [bearing for bearing in left if not self._is_solved(bearing)]
            unknown = {bearing: share for bearing in left if (share := self._unknown(bearing)) > tolerance}
            known(len(bearings) - len(unknown))
            if not unknown:
                return
            self._solve(self._next(unknown, left, tolerance, at_once), headings, images, bearings)

    def _next(
        self, unknown: Mapping[float, float], left: Sequence[float], tolerance: float, at_once: int
    ) -> list[float]:
        """The directions to solve next, where least is known: each between others of those that are solved."""
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
        """Solve directions as far as they are not known yet, and take their images in that hold."""
        asked = [angle for angle in angles if not self._is_solved(angle)]
        for one in headings.solve_all(asked) if asked else ():
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
        """Take a direction in that was solved."""
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
        """How far on from the direction that was solved before a bearing one may go to solve the next.

        If that reaches as far as it may, the chord to it leaves nothing between unknown: along an edge one so goes on
        to its end, and about an arc in even steps. Where nothing is known to give way, halfway does.
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
        """The share of the upper bound that is not proven to be survived."""
        value, upper = self._proven(bearing) if proven is None else proven, self._asked(bearing)
        if upper <= NOTHING or value >= 0.5 * FURTHEST:
            return 0.0
        return 1.0 if upper == inf else 1.0 - value / upper

    def _asked(self, bearing: float) -> float:
        """No more than this is asked for [g]: it is proven not to be survived."""
        return min(self._bound(bearing)[0], self.enough.get(bearing, inf))

    def _proven(self, bearing: float) -> float:
        """How far along a bearing the points that are solved reach: to the chord of the two on either side."""
        if len(self.solved) == 1:
            return self.solved[0].reach if self.solved[0].angle == bearing else 0.0
        # One pair has it between them, or two where it is solved itself, as far as that can be told.
        after = bisect(self.solved, bearing % (2.0 * pi), key=_angle)
        around = [self.solved[number % len(self.solved)] for number in range(after - 2, after + 2)]
        return max(_chord(one, other, bearing) for one, other in pairwise(around))

    def _bound(self, bearing: float) -> tuple[float, Cut | None]:
        """Return the distance of the nearest cut along a bearing [g], which uniform sliding has in all directions."""
        x, y = cos(bearing), sin(bearing)
        nearest: tuple[float, Cut | None] = (inf, None)
        for distance, cut in self.cuts:
            share = cut.normal[0] * x + cut.normal[1] * y
            if share > ALONG and distance / share < nearest[0]:
                nearest = (distance / share, cut)
        return self.sliding if self.sliding is not None and self.sliding[0] <= nearest[0] else nearest


def _apart(one: float, other: float) -> float:
    """The angle between two bearings [rad]."""
    return abs((one - other + pi) % (2.0 * pi) - pi)


def _angle(one: Heading) -> float:
    return one.angle


def _turned(cut: Cut, bearing: float) -> Motion:
    """The motion of bricks that slide alike in all directions, along one of them."""
    x, y = cos(bearing), sin(bearing)
    return Motion({name: ((x, y, velocity[2]), spin) for name, (velocity, spin) in cut.motion.velocity.items()})


def _chord(one: Heading, other: Heading, bearing: float) -> float:
    """How far along a bearing the chord between two points is [g]; 0 if the direction is not between them."""
    (ax, ay), (bx, by), (x, y) = one.point, other.point, (cos(bearing), sin(bearing))
    turn = ax * by - ay * bx
    a, b = ax * y - ay * x, x * by - y * bx  # neither is negative for a direction between the two
    if turn <= 0.0 or a < 0.0 or b < 0.0:
        return 0.0
    return turn / (a + b)
