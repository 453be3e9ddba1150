"""Which horizontal acceleration does an assembly survive, in whatever direction?

Every brick is pulled sideways by its mass times the acceleration, besides its weight. The accelerations that contact
forces can hold against are a convex set around none. Directions that were solved are points of it, motions cut it from
outside (see `acceleration_cut`); the margin lies between the largest disc within what the points span and the nearest
cut. The next direction is the foot of the perpendicular on the nearest cut, else the corner where two cuts meet.

Chords alone are slow where the set is round. Where bodies slide alike in all directions, other forces prove whole arcs
(see `sliding_all_ways`). Elsewhere the forces between solved directions are interpolated: with t = tan(angle / 2),
(1 + t^2) (1, cos, sin) are polynomials in t, so polynomials through (1 + t^2) times the solved forces balance every
direction between. That they stay within their cones, f_n >= 0 and f_n^2 - |f_t|^2 >= 0, is shown by the coefficients
of these polynomials in Bernstein's basis, none of which is negative.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan, atan2, hypot, inf, pi

import numpy as np

from stability.blas_threads import one_thread
from stability.geometry.hulls import hull
from stability.geometry.plan import Point2
from stability.statics.facts import Motion, Problem, Tolerances
from stability.statics.margins.acceleration_cut import (
    Cut,
    Heading,
    Shaken,
    distance_of,
    heading,
    mended,
    proven_distance,
    shaken,
)
from stability.statics.margins.arc_forces import stay_inside
from stability.statics.margins.face_centre import centred
from stability.statics.margins.groups import groups_apart
from stability.statics.margins.sliding_all_ways import hold_along, slide
from stability.statics.solvers.wrench_matrix import Array

MOST_HEADINGS = 120  # what is open then stays open between `value` and `upper`
NOTHING = 1e-7  # [g] a margin below is none
ALIKE = 1e-6  # share by which mechanisms or groups must differ: rounding does not choose which is named
INEXACT = 1e-4  # share by which the solver may have a cut too near
ROUND = 0.9  # share of the friction at which all slides: what survives less is reached by a few chords
SAME_BEARING = 6  # digits of a bearing [rad]
NODES = (4, 8)  # headings through which forces are interpolated
WIDEST = 3.0  # [rad] angle over which they are
NEAR = 0.02  # share of an arc; a direction this near to one of its ends tells nothing new


@dataclass(frozen=True, slots=True)
class AccelerationMargin:
    """The horizontal acceleration that is survived in every direction, in units of g."""

    value: float  # proven by forces in every direction; inf if it is held on all sides
    upper: float  # proven by `motion` not to be survived
    bearing: float  # the worst direction, from x towards y [rad]
    motion: Motion | None  # how it then moves
    headings: int  # directions that were solved


@dataclass(frozen=True, slots=True, eq=False)
class _Arc:
    """All directions between two that were solved, counter-clockwise."""

    start: Heading
    end: Heading
    smooth: float = 0.0  # [g] proven by interpolated forces

    @property
    def width(self) -> float:
        return (self.end.angle - self.start.angle) % (2.0 * pi) or 2.0 * pi

    @property
    def proven(self) -> float:
        """The acceleration that is survived in all these directions."""
        if self.width >= pi:
            return self.smooth
        (ax, ay), (bx, by) = self.start.point, self.end.point
        dx, dy = bx - ax, by - ay
        length = dx * dx + dy * dy
        part = min(1.0, max(0.0, -(ax * dx + ay * dy) / length)) if length > 0.0 else 0.0
        return max(self.smooth, hypot(ax + part * dx, ay + part * dy))


@one_thread()
def acceleration(
    problem: Problem,
    tolerance: float = 1e-6,
    gravity: float | None = None,
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
) -> AccelerationMargin | None:
    """The acceleration survived in the worst direction, to a relative `tolerance`; None if it is not proven to stand.

    Ten directions are enough for it where bodies tip; four to eight where they slide alike in all directions.
    `gravity` [m/s2] is needed where loads are more than weights; else every brick weighs what its load pulls down with.
    What does not touch is solved apart: together it survives what the weakest does.
    """
    weakest: AccelerationMargin | None = None
    for part in groups_apart(problem):
        found = _of_one_group(part, tolerance, gravity, tolerances)
        if found is None:
            return None
        weakest = found if weakest is None else _weaker(weakest, found)
    return weakest


def _weaker(one: AccelerationMargin, other: AccelerationMargin) -> AccelerationMargin:
    """What two groups survive together, and what ends it."""
    first = other if other.upper < one.upper * (1.0 - ALIKE) else one
    return replace(first, value=min(one.value, other.value), headings=one.headings + other.headings)


def _of_one_group(
    problem: Problem, tolerance: float, gravity: float | None, tolerances: Tolerances
) -> AccelerationMargin | None:
    case = shaken(problem, gravity, tolerances)
    if case is None:
        return None
    first = _facing(problem)
    sliding = slide(case, 0.0)  # alike in all directions: any is the worst
    solved = [heading(case, first + quarter * pi / 2.0) for quarter in range(4)]
    arcs = [_Arc(a, b) for a, b in pairwise([*solved, solved[0]])]
    middles: dict[float, Array] = {}
    while True:
        nearest = _nearest(case, solved, sliding)
        upper = distance_of(nearest)
        enough = upper * (1.0 - tolerance)
        weakest = min(range(len(arcs)), key=lambda i: arcs[i].proven)
        arc = arcs[weakest]
        if arc.proven >= enough or upper <= NOTHING or upper == inf or len(solved) >= MOST_HEADINGS:
            return _margin(case, arc.proven, nearest, solved)
        is_round = sliding is not None and upper >= ROUND * sliding.distance
        middle = arc.start.angle + 0.5 * arc.width
        slides = is_round and hold_along(case, enough, middle, arc.width)
        if slides or _is_smooth(arcs, weakest, case, enough, middles):
            arcs[weakest] = replace(arc, smooth=enough)
        else:
            solved.append(heading(case, _next(arc, nearest)))
            arcs[weakest : weakest + 1] = [_Arc(arc.start, solved[-1]), _Arc(solved[-1], arc.end)]


def _nearest(case: Shaken, solved: Sequence[Heading], sliding: Cut | None) -> Cut | None:
    """The nearest of all cuts. Those of the solver are known to its accuracy only, so that near ones must be proven."""
    cut = min((one.cut for one in solved), key=distance_of)
    if sliding is None or distance_of(cut) < sliding.distance * (1.0 - INEXACT):
        return cut
    return cut if cut is not None and proven_distance(case, cut) < sliding.distance else sliding


def _margin(case: Shaken, proven: float, nearest: Cut | None, solved: Sequence[Heading]) -> AccelerationMargin:
    if nearest is None:
        return AccelerationMargin(inf, inf, solved[0].angle, None, len(solved))
    upper = proven_distance(case, nearest)
    value = proven if upper > NOTHING else 0.0
    nearest = _first_alike(case, nearest, upper, solved)
    return AccelerationMargin(value, upper, atan2(nearest.normal[1], nearest.normal[0]), nearest.motion, len(solved))


def _first_alike(case: Shaken, nearest: Cut, upper: float, solved: Sequence[Heading]) -> Cut:
    """Of cuts that are as near, such as those of a symmetric structure, the first counter-clockwise from +x."""
    most = upper * (1.0 + ALIKE)
    found = [one.cut for one in solved if one.cut is not None and one.cut.distance <= most]
    alike = [nearest, *(cut for cut in found if proven_distance(case, cut) <= most)]
    return min(alike, key=_turn)


def _turn(cut: Cut) -> float:
    """The bearing of a cut, from 0 to 2 pi [rad]; what is +x but for rounding is 0."""
    return round(atan2(cut.normal[1], cut.normal[0]), SAME_BEARING) % (2.0 * pi)


def tilt(acceleration: float) -> float:
    """The angle [rad] of the ground up to which an assembly stands that survives this acceleration [g].

    Seen from a ground tilted by a, weights pull with g cos(a) into it and with g sin(a) along it: as on level ground
    with an acceleration of tan(a), all loads times cos(a). Contact forces only scale with that, and cones do not care.
    """
    return atan(acceleration)


def _facing(problem: Problem) -> float:
    """The direction in which the weight is nearest to the border of its support: a first guess that turns with it."""
    fixed = [c for c in problem.contacts if c.lower not in problem.bricks or c.upper not in problem.bricks]
    support = hull((x, y) for contact in fixed for x, y, _ in contact.points_W)
    total = sum(-load.force_W[2] for load in problem.loads.values())
    if not support or not total > 0.0:
        return 0.0
    centre = [
        sum(-load.force_W[2] * problem.bricks[name].pose.position_W[axis] for name, load in problem.loads.items())
        / total
        for axis in (0, 1)
    ]
    return min((_beyond(a, b, centre) for a, b in pairwise([*support, support[0]])))[1]


def _beyond(a: Point2, b: Point2, centre: Sequence[float]) -> tuple[float, float]:
    """How far a border line is from a point inside, and the bearing out across it."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return (dx * (centre[1] - a[1]) - dy * (centre[0] - a[0])) / hypot(dx, dy), atan2(-dx, dy)


def _next(arc: _Arc, nearest: Cut | None) -> float:
    """The direction within an arc that promises most."""
    choices = []
    if nearest is not None:
        choices.append(atan2(nearest.normal[1], nearest.normal[0]))
    corner = _corner(arc)
    if corner is not None:
        choices.append(atan2(corner[1], corner[0]))
    for angle in choices:
        share = ((angle - arc.start.angle) % (2.0 * pi)) / arc.width
        if NEAR < share < 1.0 - NEAR:
            return arc.start.angle + share * arc.width
    return arc.start.angle + 0.5 * arc.width


def _corner(arc: _Arc) -> Point2 | None:
    """Where the cuts of the two ends meet."""
    if arc.start.cut is None or arc.end.cut is None:
        return None
    (ax, ay), (bx, by) = arc.start.cut.normal, arc.end.cut.normal
    turn = ax * by - ay * bx
    if turn <= NEAR * NEAR:
        return None
    a, b = arc.start.cut.distance, arc.end.cut.distance
    return ((a * by - b * ay) / turn, (b * ax - a * bx) / turn)


def _is_smooth(arcs: Sequence[_Arc], index: int, case: Shaken, radius: float, middles: dict[float, Array]) -> bool:
    """Whether interpolated forces prove a radius along an arc; `middles` are forces by heading, as they are needed."""
    arc = arcs[index]
    middle = arc.start.angle + 0.5 * arc.width
    for count in NODES:
        if count > len(arcs):
            return False
        nodes = [arcs[(index + shift) % len(arcs)].start for shift in range(1 - count // 2, 1 + count // 2)]
        angles = [(node.angle - middle + pi) % (2.0 * pi) - pi for node in nodes]
        if angles != sorted(angles) or angles[-1] - angles[0] > WIDEST or min(node.reach for node in nodes) < radius:
            continue
        for node in nodes:
            if node.angle not in middles:
                middles[node.angle] = mended(case.at(*node.point), centred(case.system, node.rows, node.slips))
        forces = np.stack([case.rest + radius / node.reach * (middles[node.angle] - case.rest) for node in nodes])
        if stay_inside(forces, len(case.system.round), angles, 0.5 * arc.width):
            return True
    return False
