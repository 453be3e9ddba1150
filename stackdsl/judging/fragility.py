"""The share of samples that fall over an intensity: points with exact intervals, and a lognormal curve through them."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf, log

import numpy as np
from scipy.special import ndtri

from stackdsl.judging.lognormal import Array, Lognormal, UndeterminedError, through_capacities, through_fates
from stackdsl.judging.shares import Interval, interval
from stackdsl.sampling.capacities import Capacity
from stackdsl.sampling.fates import Fate
from stackdsl.sampling.intensities import Intensity


@dataclass(frozen=True, slots=True)
class Point:
    """What became of the samples at one intensity."""

    value: float  # in SI, or in g
    fell: int
    unknown: int  # that may have gone either way
    count: int
    within: Interval  # of the share that falls, by Clopper and Pearson, as sure as `confidence` of this point alone
    ways: Mapping[str, int] = field(default_factory=dict)  # how many samples each way decided

    @property
    def share(self) -> float:
        """The share that falls, of those of which it is known."""
        return self.fell / known if (known := self.count - self.unknown) else float("nan")


@dataclass(frozen=True, slots=True)
class Fragility:
    """A fragility curve, and what it comes from."""

    intensity: Intensity
    points: tuple[Point, ...]
    curve: Lognormal | None  # of what stands once it is built
    no_curve: str  # why there is none
    half: float | None  # where half falls, by the points alone; None where they do not reach that
    seed: int
    confidence: float
    fell_built: int = 0  # samples that fell while they were built, before they could be shaken
    left_out: int = 0  # samples that the curve leaves out, since nothing, or no end of it, is known of them
    cpu_time: float = field(default=0.0, compare=False)  # [s], of all processes together

    def share(self, value: float) -> float | None:
        """The share that falls by the curve, those that fell while they were built among them."""
        if self.curve is None:
            return None
        before = self.fell_built / self.points[0].count if self.points else 0.0
        return before + (1.0 - before) * self.curve.share(value)

    @property
    def missed(self) -> tuple[Point, ...]:
        """The points whose interval the curve misses."""
        shares = ((point, self.share(point.value)) for point in self.points)
        return tuple(p for p, share in shares if share is not None and not p.within.low <= share <= p.within.high)


@dataclass(frozen=True, slots=True)
class Terms:
    """What a curve is of, and how sure one is to be."""

    intensity: Intensity
    seed: int
    confidence: float


def of_fates(terms: Terms, fates: Mapping[float, Sequence[int]], ways: Mapping[float, Mapping[str, int]]) -> Fragility:
    """The curve of samples whose fates are known at some intensities, the same samples at each."""
    points = tuple(_point(terms, value, np.array(fates[value]), ways[value]) for value in sorted(fates))
    above = [point.value for point in points if point.value > 0.0]
    # Nothing at all says nothing to a logarithm.
    fell = np.array([[_fell(fate) for fate in fates[value]] for value in above]).T
    curve, why = None, "no point is above zero"
    if above:
        try:
            curve, why = through_fates(np.array(above), fell, terms.confidence), ""
        except UndeterminedError as error:
            why = _why(error, terms.intensity)
    unknown = sum(point.unknown for point in points)
    return Fragility(terms.intensity, points, curve, why, _half(points), terms.seed, terms.confidence, left_out=unknown)


def _why(error: UndeterminedError, intensity: Intensity) -> str:
    return error.message.format(*map(intensity.told, error.at))


def _fell(fate: int) -> float:
    return float("nan") if fate < 0 else float(fate > 0)


def _point(
    terms: Terms, value: float, fates: "np.ndarray[tuple[int], np.dtype[np.int64]]", ways: Mapping[str, int]
) -> Point:
    fell, unknown, count = int((fates > 0).sum()), int((fates < 0).sum()), len(fates)
    return Point(value, fell, unknown, count, interval(fell, fell + unknown, count, 1.0 - terms.confidence), ways)


def of_capacities(
    terms: Terms, capacities: Sequence[Capacity], values: Sequence[float], ways: Mapping[str, int]
) -> Fragility:
    """The curve of samples of which each has an intensity at which it falls: its distribution is the curve."""
    intensity = terms.intensity
    built = [each for each in capacities if each.fate == Fate.STANDS]
    known = [each for each in built if each.survived > 0.0 and each.fails < inf]
    found = np.array([intensity.of_acceleration(0.5 * (each.survived + each.fails)) for each in known])
    curve, why = None, ""
    try:
        curve = through_capacities(found, terms.confidence)
    except UndeterminedError as error:
        why = _why(error, intensity)
    points = tuple(_shaken(terms, value, capacities, ways) for value in values)
    fell = sum(each.fate > 0 for each in capacities)
    half = _half_of(fell, found.tolist(), len(capacities))
    left_out = len(capacities) - fell - len(known)
    return Fragility(intensity, points, curve, why, half, terms.seed, terms.confidence, fell, left_out)


def _half_of(fell: int, found: Sequence[float], count: int) -> float | None:
    """The intensity at which half of so many samples have fallen; None if that is nowhere above zero."""
    ends = sorted([0.0] * fell + [*found] + [inf] * (count - fell - len(found)))
    half = ends[len(ends) // 2] if ends else inf
    return half if 0.0 < half < inf else None


def _shaken(terms: Terms, value: float, capacities: Sequence[Capacity], ways: Mapping[str, int]) -> Point:
    acceleration = terms.intensity.acceleration(value)
    told = Counter(
        "fell" if c.fails <= acceleration else "stood" if acceleration <= c.survived else "unknown" for c in capacities
    )
    count = len(capacities)
    between = interval(told["fell"], told["fell"] + told["unknown"], count, 1.0 - terms.confidence)
    return Point(value, told["fell"], told["unknown"], count, between, ways)


def _half(points: Sequence[Point]) -> float | None:
    """Where the share that falls is a half, straight between the points of probability paper."""
    known = [point for point in points if point.count > point.unknown]
    for one, other in pairwise(known):
        either_way = (one.share - 0.5) * (other.share - 0.5) <= 0.0 and 0.0 < abs(one.share - other.share) < 1.0
        if either_way and one.value > 0.0:
            a, b = (_deviations(point) for point in (one, other))
            low, high = log(one.value), log(other.value)
            return float(np.exp(low + (high - low) * a / (a - b)))
    return None


def _deviations(point: Point) -> float:
    """Below so many standard deviations lies that share of a normal distribution; no sample counts as half a one."""
    known = point.count - point.unknown
    return float(ndtri(min(max(point.fell, 0.5), known - 0.5) / known))


def spaced(first: float, last: float, count: int) -> Array:
    """So many values from one to another: alike in ratio where both are above zero, and else alike in distance."""
    if first > 0.0 and last > 0.0:
        return np.geomspace(first, last, count)
    return np.linspace(first, last, count)
