"""Fits a lognormal fragility curve to shares of collapse, with exact intervals."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import exp, inf, log, sqrt

import numpy as np
from scipy.optimize import minimize
from scipy.special import bdtr, chdtrc, chdtri, log_ndtr, ndtr, ndtri, stdtrit

from stability.geometry.rows import Array
from stability.notebook import Printed
from stackdsl.judging.statistics import Interval, interval
from stackdsl.sampling.sample_outcomes import SampleOutcome
from stackdsl.studies.fragility_intensity import Capacity, Intensity

# A lognormal curve through shares of collapse, by maximum likelihood: median and dispersion, with confidence intervals.
#
# The share that falls at an intensity x is Phi(ln(x / median) / dispersion), or 1 minus that if falls become rarer with
# x. With shares at several intensities, the likelihood is that of binomial counts (Baker, Efficient analytical
# fragility function fitting using dynamic structural analysis, Earthquake Spectra 31, 2015). The counts are not
# independent, as the same samples are judged at all intensities, so the inverse of Fisher's information would be too
# small. The covariance is that of the scores summed by sample (the clustered sandwich estimator of Huber and White). If
# the intensity at which each sample falls is known, its logarithm is normal, and the intervals are exact: those of
# Student and of chi squared.


ROUNDING = 1e-9  # of logarithms: samples that differ by less count as equal
LEVEL = 1e-7  # of a slope in deviations: smaller than the effect of one sample in millions
FEWEST_POINTS = 2
FEWEST_TESTED = 3  # points; a lognormal curve goes exactly through two
STEEP = "and the points do not determine the slope; take closer points there"
HALF = 0.5  # of the samples
FEWEST = 8  # samples with known capacities; the test of a fit holds from 8
TEST_LEVEL = 0.05  # probability with which a truly lognormal curve is refused
LEAST_P = 1e-4  # smaller values are not shown
MOST_STATISTIC = 10.0  # of Anderson and Darling; the formula of p holds below


@dataclass(frozen=True, slots=True)
class Lognormal:
    """A lognormal curve, with confidence intervals of its parameters."""

    median: float  # the intensity at which half of the samples fall
    dispersion: float  # standard deviation of the logarithm of the intensity
    median_within: Interval
    dispersion_within: Interval
    rises: bool  # whether more samples fall at a larger intensity

    def share(self, value: float) -> float:
        """Return the share that falls at an intensity."""
        if value <= 0.0:
            return 0.0 if self.rises else 1.0
        deviations = log(value / self.median) / self.dispersion
        return float(ndtr(deviations if self.rises else -deviations))


@dataclass(frozen=True, slots=True)
class FitTest:
    """Test of a lognormal curve against all samples at once."""

    method: str
    p: float  # probability of a fit that is at least as poor, if the curve is lognormal
    largest: float  # difference between the share of samples and that of the curve
    at: float  # intensity of the largest difference
    level: float = TEST_LEVEL  # p value below which the curve is refused

    @property
    def refuses(self) -> bool:
        """Return true if the test rejects the lognormal curve."""
        return self.p < self.level

    @property
    def p_text(self) -> str:
        """The p value with its sign."""
        return f"p < {LEAST_P:f}".rstrip("0") if self.p < LEAST_P else f"p = {self.p:.2g}"

    def text(self, at: str) -> str:
        """Return the result of the test in words; `at` is the intensity of the largest difference."""
        return (
            f"{self.p_text} ({self.method}, level {100.0 * self.level:g} %); "
            f"the shares differ by at most {100.0 * self.largest:.1f} percentage points, at {at}"
        )


class UndeterminedError(Exception):
    """The data do not determine a curve; the message has a `{}` for each of the intensities `at`."""

    def __init__(self, message: str, *at: float) -> None:
        super().__init__(message)
        self.message, self.at = message, at


def fit_to_outcomes(values: Array, fell: Array, confidence: float) -> tuple[Lognormal, FitTest]:
    """Return the curve through the outcomes of samples at some intensities above zero, and its test.

    `fell` is (samples, intensities): 1 if a sample fell, 0 if it stood, NaN if that is unknown. Raises
    UndeterminedError.
    """
    known, x = ~np.isnan(fell), np.log(values)
    fallen, count = np.nansum(fell, axis=0), known.sum(axis=0)
    _refuse_undetermined(values, fallen, count)
    middle, width = float(x.mean()), float(x.std())
    z = (x - middle) / width  # normalized for the solver
    a, b = _most_likely(z, fallen, count)
    eta = a + b * z
    density = np.exp(-0.5 * eta**2) / sqrt(2.0 * np.pi)
    above, below = np.exp(log_ndtr(eta)), np.exp(log_ndtr(-eta))
    design = np.stack([np.ones_like(z), z])
    information = (design * (count * density**2 / (above * below))) @ design.T
    each = np.where(known, np.where(fell == 1.0, density / above, -density / below), 0.0)
    scores = each @ design.T
    inverse = np.linalg.inv(information)
    covariance = inverse @ (scores.T @ scores) @ inverse
    deviations = float(ndtri(0.5 + 0.5 * confidence))
    # If the same samples fall at all intensities, the slope and its error are only rounding.
    if abs(b) <= LEVEL or abs(b) <= deviations * sqrt(covariance[1, 1]):
        raise UndeterminedError("the share of collapse does not change significantly with the intensity")
    # ln median = middle - width a / b, and dispersion = width / |b|; the errors follow from the first derivatives.
    of_median = width * np.array([-1.0 / b, a / b**2])
    spreads = (sqrt(of_median @ covariance @ of_median), sqrt(covariance[1, 1]) / abs(b))
    median, dispersion = exp(middle - width * a / b), width / abs(b)
    of_both = (
        _within(number, deviations * spread) for number, spread in zip((median, dispersion), spreads, strict=True)
    )
    about_median, about_dispersion = of_both
    fitted = Lognormal(median, dispersion, about_median, about_dispersion, rises=bool(b > 0.0))
    weights = design * (density / (above * below))
    return fitted, _test_of_outcomes(values, fell, above, weights.T @ inverse, (design * count * density).T)


def _test_of_outcomes(values: Array, fell: Array, expected: Array, weights: Array, slopes: Array) -> FitTest:
    """Return the chi-squared test of expected shares, corrected for the same samples at all points.

    The statistic is the sum of the squared standard deviations of all counts. Its distribution is that of a weighted
    sum of chi-squared variables, since counts are correlated and the curve is fitted to them; it is approximated as by
    Rao and Scott, On chi-squared tests for multiway contingency tables, Annals of Statistics 12, 1984 (second order).
    Correlations are those of the samples, variances those of the curve. `weights` (points, 2) times the residuals is
    the change of the parameters, and `slopes` (points, 2) the derivatives of the counts by the parameters.
    """
    known = ~np.isnan(fell)
    count, shares = known.sum(axis=0), np.nanmean(fell, axis=0)
    residuals = np.where(known, fell - shares, 0.0)
    spreads = np.sqrt((residuals**2).sum(axis=0))
    scale = np.where(spreads > 0.0, spreads, 1.0)
    correlation = (residuals / scale).T @ (residuals / scale)
    np.fill_diagonal(correlation, 1.0)
    deviations = np.sqrt(count * expected * (1.0 - expected))
    moved = (np.eye(len(values)) - slopes @ weights.T) * deviations
    # A count that is expected to be far below one sample has a spread of one sample.
    units = np.maximum(deviations, 1.0)
    covariance = moved @ correlation @ moved.T / np.outer(units, units)
    mean, square = float(np.trace(covariance)), float((covariance**2).sum())
    statistic = float((((shares - expected) * count / units) ** 2).sum())
    p = float(chdtrc(mean**2 / square, statistic * mean / square))
    worst = int(np.argmax(np.abs(shares - expected)))
    return FitTest("chi-squared test of all points", p, float(abs(shares - expected)[worst]), float(values[worst]))


def fit_to_capacities(capacities: Array, confidence: float) -> tuple[Lognormal, FitTest]:
    """Return the curve of samples with known capacities, and its test. Raises UndeterminedError."""
    count = len(capacities)
    if count < FEWEST:
        raise UndeterminedError(f"only {count} samples have a known capacity, and a curve needs {FEWEST}")
    logs = np.log(capacities)
    mean, deviation = float(logs.mean()), float(logs.std())
    if deviation <= ROUNDING:
        raise UndeterminedError("all samples fall at {}, without any dispersion", exp(mean))
    unbiased, error = deviation * sqrt(count / (count - 1.0)), 1.0 - confidence
    half = float(stdtrit(count - 1, 1.0 - 0.5 * error)) * unbiased / sqrt(count)
    squares = unbiased * sqrt(count - 1.0)
    low, high = (squares / sqrt(float(chdtri(count - 1, share))) for share in (0.5 * error, 1.0 - 0.5 * error))
    fitted = Lognormal(exp(mean), deviation, _within(exp(mean), half), Interval(low, high), rises=True)
    return fitted, _test_of_capacities(np.sort(logs), mean, unbiased)


def _test_of_capacities(logs: Array, mean: float, deviation: float) -> FitTest:
    """Return the test of Anderson and Darling of sorted logarithms, with estimated mean and deviation.

    The p value is that of Stephens in D'Agostino and Stephens, Goodness-of-Fit Techniques, 1986, table 4.9.
    """
    count, z = len(logs), (logs - mean) / deviation
    odd = 2.0 * np.arange(1, count + 1) - 1.0
    raw = -count - float(odd @ (log_ndtr(z) + log_ndtr(-z[::-1]))) / count
    a = min(raw * (1.0 + 0.75 / count + 2.25 / count**2), MOST_STATISTIC)
    if a >= 0.6:  # noqa: PLR2004 -- the ranges of the four formulas
        p = exp(1.2937 - 5.709 * a + 0.0186 * a**2)
    elif a > 0.34:  # noqa: PLR2004
        p = exp(0.9177 - 4.279 * a - 1.38 * a**2)
    elif a > 0.2:  # noqa: PLR2004
        p = 1.0 - exp(-8.318 + 42.796 * a - 59.938 * a**2)
    else:
        p = 1.0 - exp(-13.436 + 101.14 * a - 223.73 * a**2)
    ranks = np.arange(count + 1) / count
    off = np.maximum(ranks[1:] - ndtr(z), ndtr(z) - ranks[:-1])
    worst = int(np.argmax(off))
    return FitTest("Anderson-Darling test of the capacities", p, float(off[worst]), exp(float(logs[worst])))


def _within(number: float, half: float) -> Interval:
    return Interval(number * float(np.exp(-half)), number * float(np.exp(half)))


def _most_likely(z: Array, fallen: Array, count: Array) -> Array:
    """Return (2,) the a and b that maximize the likelihood of the counts under Phi(a + b z).

    They are unique, as the intensities of fallen and standing samples overlap.
    """

    def cost(parameters: Array) -> tuple[float, Array]:
        eta = parameters[0] + parameters[1] * z
        above, below = log_ndtr(eta), log_ndtr(-eta)
        log_density = -0.5 * eta**2 - 0.5 * np.log(2.0 * np.pi)
        slope = fallen * np.exp(log_density - above) - (count - fallen) * np.exp(log_density - below)
        return -float(fallen @ above + (count - fallen) @ below), -np.array([slope.sum(), slope @ z])

    start = np.array([float(ndtri((fallen.sum() + 0.5) / (count.sum() + 1.0))), 0.0])
    result = minimize(cost, start, jac=True, method="BFGS", options={"gtol": 1e-9 * float(count.sum())})
    solution: Array = result.x
    return solution


def _refuse_undetermined(values: Array, fallen: Array, count: Array) -> None:
    """Raise UndeterminedError if no curve has the largest likelihood, as for a step between two points."""
    if len(values) < FEWEST_TESTED:
        raise UndeterminedError(f"a curve and its test need {FEWEST_TESTED} points above zero; take more points")
    if fallen.sum() in (0, count.sum()):
        which = "no sample falls" if not fallen.any() else "all samples fall"
        raise UndeterminedError(f"{which} at any point above zero; take points on both sides of the change")
    some_fell, some_stood = values[fallen > 0], values[fallen < count]
    for before, after in ((some_stood, some_fell), (some_fell, some_stood)):
        if before.max() <= after.min():
            if before.max() == after.min():
                raise UndeterminedError(f"the share jumps at {{}}, {STEEP}", float(after.min()))
            raise UndeterminedError(
                f"the share jumps between {{}} and {{}}, {STEEP}", float(before.max()), float(after.min())
            )


# The share of samples that fall, by intensity: points with exact intervals, and a lognormal curve through them.
#
# Samples that fall during the build count as fallen at each point and in the half point. The lognormal curve describes
# the other samples.


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """The outcomes of the samples at one intensity."""

    value: float  # in SI, or in g
    fell: int
    unknown: int  # undecided and unfit samples
    count: int
    within: Interval  # of the share that falls, by Clopper and Pearson, with `confidence` for this point alone
    ways: Mapping[str, int] = field(default_factory=dict)  # number of samples by kind of proof

    @property
    def share(self) -> float:
        """The share of the decided samples that falls."""
        return self.fell / known if (known := self.count - self.unknown) else float("nan")


@dataclass(frozen=True, slots=True)
class Fragility(Printed):
    """A fragility curve, its points, and the settings."""

    intensity: Intensity
    points: tuple[CurvePoint, ...]
    curve: Lognormal | None  # of the samples that stand once built; None if they do not follow one
    no_curve: str  # reason why there is none
    half: float | None  # intensity at which half of the samples fall, by the points alone; None outside their range
    half_within: Interval | None  # of `half`, without assuming a lognormal curve; None outside the range of the points
    seed: int
    confidence: float
    fell_built: int = 0  # samples that fell during the build, before the acceleration or tilt
    left_out: int = 0  # samples that the curve leaves out: undecided, or with no known upper bound of their capacity
    cpu_time: float = field(default=0.0, compare=False)  # [s], of all processes together
    name: str = ""  # of the case
    refused: Lognormal | None = None  # the best fit, if the test refuses it
    test: FitTest | None = None  # of the curve, or of the refused fit
    bearing: float | None = None  # of the acceleration or tilt [rad]; None for the worst of each sample
    jitter: str = ""  # placement errors in the scenario; empty if there are none
    capacities: Mapping[int, Capacity] = field(default_factory=dict)  # by number of the sample

    @property
    def fit(self) -> Lognormal | None:
        """The best fit, whether refused or not."""
        return self.curve or self.refused

    def share(self, value: float) -> float | None:
        """Return the share that falls by the best fit, including the samples that fell during the build."""
        if self.fit is None:
            return None
        before = self.fell_built / self.points[0].count if self.points else 0.0
        return before + (1.0 - before) * self.fit.share(value)

    @property
    def samples(self) -> int:
        """The number of samples at each point."""
        return self.points[0].count if self.points else 0

    @property
    def bracket(self) -> tuple["CurvePoint", "CurvePoint"] | None:
        """The points between which half of the samples fall; None if no neighbours differ about that."""
        return _bracket(self.points)


@dataclass(frozen=True, slots=True)
class CurveSettings:
    """The settings of a curve."""

    intensity: Intensity
    seed: int
    confidence: float
    bearing: float | None = None  # [rad]
    jitter: str = ""

    def fragility(  # noqa: PLR0913, PLR0917 -- the fields of a curve
        self,
        points: tuple[CurvePoint, ...],
        fitted: Callable[[], tuple[Lognormal, FitTest]],
        half: float | None,
        half_within: Interval | None,
        fell_built: int = 0,
        left_out: int = 0,
    ) -> Fragility:
        """Return a fragility curve with the fit, unless the data do not determine it or its test refuses it."""
        curve, refused, test, why = None, None, None, ""
        try:
            curve, test = fitted()
            if test.refuses:
                curve, refused = None, curve
                why = f"refused with {test.text(self.intensity.told(test.at))}"
        except UndeterminedError as error:
            why = error.message.format(*map(self.intensity.told, error.at))
        return Fragility(
            self.intensity,
            points,
            curve,
            why,
            half,
            half_within,
            self.seed,
            self.confidence,
            fell_built,
            left_out,
            refused=refused,
            test=test,
            bearing=self.bearing,
            jitter=self.jitter,
        )


def curve_of_outcomes(
    terms: CurveSettings, outcomes: Mapping[float, Sequence[int]], ways: Mapping[float, Mapping[str, int]]
) -> Fragility:
    """Return the curve of samples with outcomes at several intensities, the same samples at each."""
    points = tuple(_point(terms, value, np.array(outcomes[value]), ways[value]) for value in sorted(outcomes))
    above = [point.value for point in points if point.value > 0.0]
    # Zero has no logarithm.
    fell = np.array([[_fell(outcome) for outcome in outcomes[value]] for value in above]).T
    unknown = sum(point.unknown for point in points)
    bracket = _bracket(points)
    within = Interval(bracket[0].value, bracket[1].value) if bracket is not None else None

    def fitted() -> tuple[Lognormal, FitTest]:
        return fit_to_outcomes(np.array(above), fell, terms.confidence)

    return terms.fragility(points, fitted, _half(points), within, left_out=unknown)


def _fell(outcome: int) -> float:
    return float("nan") if outcome < 0 else float(outcome > 0)


def _point(
    terms: CurveSettings, value: float, outcomes: "np.ndarray[tuple[int], np.dtype[np.int64]]", ways: Mapping[str, int]
) -> CurvePoint:
    fell, unknown, count = int((outcomes > 0).sum()), int((outcomes < 0).sum()), len(outcomes)
    return CurvePoint(value, fell, unknown, count, interval(fell, fell + unknown, count, 1.0 - terms.confidence), ways)


def curve_of_capacities(
    terms: CurveSettings, capacities: Sequence[Capacity], values: Sequence[float], ways: Mapping[str, int]
) -> Fragility:
    """Return the curve of samples with capacities: their distribution."""
    intensity = terms.intensity
    built = [each for each in capacities if each.outcome == SampleOutcome.STANDS]
    known = [each for each in built if each.survived > 0.0 and each.fails < inf]
    middles = np.array([intensity.of_acceleration(0.5 * (each.survived + each.fails)) for each in known])
    points = tuple(_point_of_capacities(terms, value, capacities, ways) for value in values)
    fell = sum(each.outcome > 0 for each in capacities)
    half = _half_of(fell, middles.tolist(), len(capacities))
    left_out = len(capacities) - fell - len(known)
    within = None if half is None else _half_within(intensity, capacities, terms.confidence)
    return terms.fragility(points, lambda: fit_to_capacities(middles, terms.confidence), half, within, fell, left_out)


def _half_within(intensity: Intensity, capacities: Sequence[Capacity], confidence: float) -> Interval:
    """Return the interval of the median capacity by order statistics, for any distribution.

    The number of samples below the median is binomial with a probability of one half (David and Nagaraja, Order
    Statistics, section 7.1).
    """
    count = len(capacities)
    below = int((bdtr(np.arange(count), count, 0.5) <= 0.5 * (1.0 - confidence)).sum())
    lows = [0.0, *sorted(each.survived for each in capacities)]
    highs = [*sorted(each.fails for each in capacities), inf]
    return Interval(intensity.of_acceleration(lows[below]), intensity.of_acceleration(highs[count - below]))


def _half_of(fell: int, capacities: Sequence[float], count: int) -> float | None:
    """Return the intensity at which half of the samples have fallen; None if it is zero or unknown."""
    ends = sorted([0.0] * fell + [*capacities] + [inf] * (count - fell - len(capacities)))
    half = ends[len(ends) // 2] if ends else inf
    return half if 0.0 < half < inf else None


def _point_of_capacities(
    terms: CurveSettings, value: float, capacities: Sequence[Capacity], ways: Mapping[str, int]
) -> CurvePoint:
    acceleration = terms.intensity.acceleration(value)
    counts = Counter(
        "fell" if c.fails <= acceleration else "stood" if acceleration <= c.survived else "unknown" for c in capacities
    )
    count = len(capacities)
    between = interval(counts["fell"], counts["fell"] + counts["unknown"], count, 1.0 - terms.confidence)
    return CurvePoint(value, counts["fell"], counts["unknown"], count, between, ways)


def _bracket(points: Sequence[CurvePoint]) -> tuple[CurvePoint, CurvePoint] | None:
    """Return the closest points around the first crossing of one half whose intervals exclude one half.

    On a side without such a point, it is the neighbour of the crossing.
    """
    known = [point for point in points if point.count > point.unknown]
    for number, (left, right) in enumerate(pairwise(known)):
        if left.share != right.share and (left.share - HALF) * (right.share - HALF) <= 0.0:
            fewer = [point for point in known if point.within.high < HALF]
            more = [point for point in known if point.within.low > HALF]
            under, over = (fewer, more) if left.share < right.share else (more, fewer)
            before = [point for point in under if point in known[: number + 1]]
            after = [point for point in over if point in known[number + 1 :]]
            return (before or [left])[-1], (after or [right])[0]
    return None


def _half(points: Sequence[CurvePoint]) -> float | None:
    """Return the intensity at which half of the samples fall, by linear interpolation on probability paper."""
    known = [point for point in points if point.count > point.unknown]
    for left, right in pairwise(known):
        either_way = (left.share - 0.5) * (right.share - 0.5) <= 0.0 and 0.0 < abs(left.share - right.share) < 1.0
        if either_way and left.value > 0.0:
            a, b = (_deviations(point) for point in (left, right))
            low, high = log(left.value), log(right.value)
            return float(np.exp(low + (high - low) * a / (a - b)))
    return None


def _deviations(point: CurvePoint) -> float:
    """Return the normal quantile of the share of a point; shares of 0 and 1 are moved by half a sample."""
    known = point.count - point.unknown
    return float(ndtri(min(max(point.fell, 0.5), known - 0.5) / known))


def spaced(first: float, last: float, count: int) -> Array:
    """Return `count` values between two: geometric if both are above zero, otherwise linear."""
    if first > 0.0 and last > 0.0:
        return np.geomspace(first, last, count)
    return np.linspace(first, last, count)
