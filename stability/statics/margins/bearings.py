"""How much horizontal acceleration does an assembly survive, by bearing, and what gives way first?

Accelerations that are survived are a convex set around none (see `acceleration`). Each direction that is solved gives a
point of it and a half-plane about all of it, so between them the reach of every bearing lies between the chord of the
points and the nearest cut. The bearing where these are furthest apart is solved next, until all are known well enough.
What does not touch is solved apart: together it survives what each part does.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import cos, inf, pi, sin

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
from stability.statics.margins.rough_headings import rough_headings

NOTHING = 1e-7  # [g] a margin below is none
ALIKE = 1e-6  # share by which of two groups one must give way sooner: rounding does not choose which is named
ROUGHLY = 1e-7  # asked of the solver for forces at rest, which need not be the deepest in their cones
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


def along_bearings(
    problem: Problem,
    bearings: Sequence[float],
    tolerance: float = 0.01,
    gravity: float | None = None,
    known: Callable[[int], None] = lambda _: None,
) -> tuple[Survived, ...] | None:
    """The same of some bearings [rad], each from x towards y."""
    count = len(bearings)
    weakest = [Survived(bearing, inf, inf, None) for bearing in bearings]
    parts = groups_apart(problem)
    for number, part in enumerate(parts):
        case = shaken(part, gravity, Tolerances(), ROUGHLY) or shaken(part, gravity, Tolerances())
        if case is None:
            return None
        found = _Found(case)
        found.solve(bearings, tolerance, partial(_told, known, number * count, len(parts)))
        own = [found.survived(bearing) for bearing in bearings]
        weakest = [_weaker(one, other) for one, other in zip(weakest, own, strict=True)]
    return tuple(weakest)


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
    solved: list[Heading] = field(default_factory=list)  # by angle, counter-clockwise
    cuts: list[tuple[float, Cut]] = field(default_factory=list)  # with the distance that each is proven for [g]

    def solve(self, bearings: Sequence[float], tolerance: float, known: Callable[[int], None]) -> None:
        """Solve directions until every bearing is known to a relative tolerance."""
        headings = rough_headings(self.case, tolerance)
        for quarter in range(4):
            self.add(headings.solve(quarter * pi / 2.0))
        left = set(bearings)
        while True:
            left -= {one.angle for one in self.solved}
            open_ones = [(self._unknown(bearing), bearing) for bearing in sorted(left)]
            share, bearing = max(open_ones, default=(0.0, 0.0))
            known(len(bearings) - sum(each > tolerance for each, _ in open_ones))
            if share <= tolerance:
                return
            self.add(headings.solve(bearing))

    def add(self, one: Heading) -> None:
        """Take a direction in that was solved."""
        self.solved = sorted([*self.solved, one], key=lambda each: each.angle)
        if one.cut is not None:
            self.cuts.append((proven_distance(self.case, one.cut), one.cut))

    def survived(self, bearing: float) -> Survived:
        value, (upper, cut) = self._proven(bearing), self._bound(bearing)
        if value >= 0.5 * FURTHEST:
            return Survived(bearing, inf, inf, None)
        return Survived(bearing, value if upper > NOTHING else 0.0, upper, cut.motion if cut is not None else None)

    def _unknown(self, bearing: float) -> float:
        """The share of the upper bound that is not proven to be survived."""
        value, (upper, _) = self._proven(bearing), self._bound(bearing)
        if upper <= NOTHING or value >= 0.5 * FURTHEST:
            return 0.0
        return 1.0 if upper == inf else 1.0 - value / upper

    def _proven(self, bearing: float) -> float:
        """How far along a bearing the points that are solved reach: to the chord of the two on either side."""
        if len(self.solved) == 1:
            return self.solved[0].reach if self.solved[0].angle == bearing else 0.0
        along = (cos(bearing), sin(bearing))
        return max(_chord(one, other, along) for one, other in pairwise([*self.solved, self.solved[0]]))

    def _bound(self, bearing: float) -> tuple[float, Cut | None]:
        """The nearest half-plane along a bearing, and how far off it is [g]."""
        x, y = cos(bearing), sin(bearing)
        nearest: tuple[float, Cut | None] = (inf, None)
        for distance, cut in self.cuts:
            share = cut.normal[0] * x + cut.normal[1] * y
            if share > ALONG and distance / share < nearest[0]:
                nearest = (distance / share, cut)
        return nearest


def _chord(one: Heading, other: Heading, along: tuple[float, float]) -> float:
    """How far along a direction the chord between two points is [g]; 0 if the direction is not between them."""
    (ax, ay), (bx, by), (x, y) = one.point, other.point, along
    turn = ax * by - ay * bx
    a, b = ax * y - ay * x, x * by - y * bx  # neither is negative for a direction between the two
    if turn <= 0.0 or a < 0.0 or b < 0.0:
        return 0.0
    return turn / (a + b)
