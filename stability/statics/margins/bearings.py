"""How much horizontal acceleration does an assembly survive, by bearing, and what gives way first?

Accelerations that are survived are a convex set around none (see `acceleration`). Each direction that is solved gives a
point of it and a half-plane about all of it, so between them the reach of every bearing lies between the chord of the
points and the nearest cut. The bearing where these are furthest apart is solved next, until all are known well enough.
What does not touch is solved apart: together it survives what each part does.
"""

from bisect import bisect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import cos, inf, pi, sin

from stability.blas_threads import one_thread
from stability.statics.facts import Motion, Problem, Tolerances
from stability.statics.margins.acceleration_cut import (
    FURTHEST,
    Cut,
    Heading,
    Shaken,
    heading,
    proven_distance,
    shaken,
)
from stability.statics.margins.groups import groups_apart
from stability.statics.margins.rough_headings import AT_ONCE, RoughHeadings, rough_headings
from stability.statics.margins.sliding_all_ways import slide
from stability.statics.margins.symmetries import Symmetry, symmetries

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
    """What is survived along `count` bearings around, from x on, each to a relative `tolerance`.

    None if the problem is not proven to stand. `gravity` [m/s2] is needed where loads are more than weights; else every
    brick weighs what its load pulls down with. Where no motion is proven, `upper` stays further off. `known` is
    told of how many bearings enough is known, as it goes on.
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
    """What is survived along one bearing; None if the problem is not proven to stand."""
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
    """What both survive together, and what ends it."""
    first = other if other.upper < one.upper * (1.0 - ALIKE) else one
    return replace(first, value=min(one.value, other.value))


@dataclass
class _Found:
    """What is known of the accelerations that one group survives."""

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
        """What is known of one bearing."""
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
        """How far off the nearest cut is along a bearing [g]; that of what slides is as far off in all directions."""
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
