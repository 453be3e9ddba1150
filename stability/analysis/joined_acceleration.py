"""Finds the greatest horizontal acceleration that bricks with joints survive in every direction, with proof."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from math import atan2, cos, hypot, inf, pi, sin
from typing import Final

from stability.analysis.load_factor import GrownLoads, bracket_of, forces_at, motion_at
from stability.model import BodyId
from stability.problem import Motion, Problem, Tolerances, Wrench
from stability.process_settings import one_thread
from stability.statics.equilibrium import balance

# The survived accelerations are a convex set, as sums of admissible forces of two with weights are admissible. So all
# within the polygon of some proven accelerations are survived, and each motion that proves a fall in one direction
# proves one beyond a straight line. Directions are added where the polygon is nearest to the origin.


FIRST: Final = 8  # directions
MOST_DIRECTIONS: Final = 48
COARSE: Final = 1e-3  # relative accuracy: each halving of an arc costs some programs
HELD: Final = 1e3  # [g] a direction in which more is survived counts as held
APART: Final = 1e-3  # [rad] directions that are closer to each other differ little
BESIDE: Final = 1e-9  # share by which a line is taken further away, for rounding


@dataclass(frozen=True, slots=True)
class RoundAcceleration:
    """Horizontal acceleration that joined bricks survive in every direction, as a multiple of gravity."""

    value: float  # proven by forces in some directions and convexity between them
    upper: float  # proven by `motion`; inf without one
    bearing: float  # of the worst direction, from +x towards +y [rad]
    motion: Motion | None
    headings: int  # number of solved directions


@one_thread()
def acceleration_of_joined(
    problem: Problem, weights: Mapping[BodyId, float], tolerance: float, tolerances: Tolerances
) -> RoundAcceleration | None:
    """Return the acceleration that bricks of these weights [N] survive all around; None if they do not stand."""
    if balance(problem, tolerances).forces is None:
        return None
    survived: dict[float, float] = {}
    worst = RoundAcceleration(0.0, inf, 0.0, None, 0)
    coming = [2.0 * pi * number / FIRST for number in range(FIRST)]
    while coming:
        angle = coming.pop(0)
        along = GrownLoads(problem, pulled(weights, angle))
        bracket = bracket_of(along, tolerances)
        if bracket.above is not None:
            worst = min(
                worst, _beyond(problem, weights, angle, *bracket.above, tolerances), key=lambda each: each.upper
            )
        if bracket.at_once is not None:
            return replace(worst, value=0.0, upper=0.0, bearing=angle, motion=bracket.at_once, headings=len(survived))
        held = bracket.below is None and forces_at(along, HELD, None, tolerances) is not None
        survived[angle] = HELD if held else 0.0 if bracket.below is None else min(bracket.below[0], HELD)
        if not coming:
            value, nearest = _inscribed(survived)
            worst = replace(worst, value=value, headings=len(survived))
            enough = value >= worst.upper * (1.0 - max(tolerance, COARSE)) or value >= HELD * cos(pi / FIRST)
            coming = [] if enough or len(survived) >= MOST_DIRECTIONS else [nearest]
    return worst if worst.motion is not None else replace(worst, value=inf)


def joined_along(
    problem: Problem, weights: Mapping[BodyId, float], bearing: float, tolerances: Tolerances
) -> tuple[float, float, Motion | None]:
    """Return the acceleration that standing bricks survive along a bearing, one that is too large, and its proof [g].

    Without a proof of a fall both are infinite if `HELD` is survived; otherwise the first one is what is proven.
    """
    along = GrownLoads(problem, pulled(weights, bearing))
    bracket = bracket_of(along, tolerances)
    if bracket.at_once is not None:
        return 0.0, 0.0, bracket.at_once
    if bracket.below is None and forces_at(along, HELD, None, tolerances) is not None:
        return inf, inf, None
    above, motion = bracket.above or (inf, None)
    return 0.0 if bracket.below is None else bracket.below[0], above, motion


def pulled(weights: Mapping[BodyId, float], angle: float) -> dict[BodyId, Wrench]:
    """Return the weights as horizontal loads along an angle."""
    return {name: Wrench((weight * cos(angle), weight * sin(angle), 0.0)) for name, weight in weights.items()}


def _beyond(  # noqa: PLR0913, PLR0917 -- a proof, and what it is about
    problem: Problem,
    weights: Mapping[BodyId, float],
    angle: float,
    factor: float,
    motion: Motion,
    tolerances: Tolerances,
) -> RoundAcceleration:
    """Return the nearest acceleration that a motion proves to be too large, from its proof in one direction."""
    x = sum(weights[name] * velocity[0] for name, (velocity, _) in motion.velocity.items())
    y = sum(weights[name] * velocity[1] for name, (velocity, _) in motion.velocity.items())
    along, size = x * cos(angle) + y * sin(angle), hypot(x, y)
    bearing = atan2(y, x)
    if along > 0.0:
        distance = factor * along / size * (1.0 + BESIDE)
        if motion_at(GrownLoads(problem, pulled(weights, bearing)), distance, motion, tolerances) is not None:
            return RoundAcceleration(0.0, distance, bearing % (2.0 * pi), motion, 0)
    return RoundAcceleration(0.0, factor, angle, motion, 0)


def _inscribed(survived: Mapping[float, float]) -> tuple[float, float]:
    """Return the least distance of the polygon of these accelerations, and a direction in which to go on there."""
    (first, size), *others = sorted(survived.items())
    nearest = (inf, 0.0)
    for (one, near), (other, far) in pairwise([(first, size), *others, (first + 2.0 * pi, size)]):
        a, b = (near * cos(one), near * sin(one)), (far * cos(other), far * sin(other))
        dx, dy = b[0] - a[0], b[1] - a[1]
        part = -(a[0] * dx + a[1] * dy) / (dx * dx + dy * dy) if dx or dy else 0.0
        part = min(1.0, max(0.0, part))
        foot = a[0] + part * dx, a[1] + part * dy
        towards = one + (atan2(foot[1], foot[0]) - one) % (2.0 * pi)
        is_new = one + APART < towards < other - APART
        nearest = min(nearest, (hypot(*foot), (towards if is_new else 0.5 * (one + other)) % (2.0 * pi)))
    return nearest
