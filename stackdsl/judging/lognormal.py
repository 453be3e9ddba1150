"""A lognormal curve through shares of collapse, by maximum likelihood: median, dispersion, and how sure both are.

At an intensity x the share that falls is Phi(ln(x / median) / dispersion), or one less that where falls grow rarer with
x. Of what is judged at several intensities the likelihood is that of a binomial count at each (Baker, Efficient
analytical fragility function fitting using dynamic structural analysis, Earthquake Spectra 31, 2015). But the same
samples are judged at all of them, so that the counts are not independent, and the inverse of Fisher's information would
be too sure: the covariance here is that of the scores summed by sample (the sandwich of Huber and White, clustered).
Where the intensity is known at which each sample falls, its logarithm is normal, and the intervals are exact: those of
Student and of chi squared.
"""

from dataclasses import dataclass
from math import exp, log, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import chdtri, log_ndtr, ndtr, ndtri, stdtrit

from stackdsl.judging.shares import Interval

Array = NDArray[np.float64]

ROUNDING = 1e-9  # of logarithms: samples that differ by less are alike
LEVEL = 1e-7  # of a slope in deviations: less than one sample of millions that falls or stands changes it
FEWEST_POINTS = 2
STEEP = "and the points do not say how steeply; take closer ones there"
FEWEST = 3  # samples whose intensities are known, to say how they are spread


@dataclass(frozen=True, slots=True)
class Lognormal:
    """A curve, and the intervals in which its numbers lie."""

    median: float  # the intensity at which half falls
    dispersion: float  # standard deviation of its logarithm
    median_within: Interval
    dispersion_within: Interval
    rises: bool  # whether more falls at more

    def share(self, value: float) -> float:
        """The share that falls at an intensity."""
        if value <= 0.0:
            return 0.0 if self.rises else 1.0
        deviations = log(value / self.median) / self.dispersion
        return float(ndtr(deviations if self.rises else -deviations))


class UndeterminedError(Exception):
    """The data do not determine a curve; the message says why, with a `{}` for each of the intensities `at`."""

    def __init__(self, message: str, *at: float) -> None:
        super().__init__(message)
        self.message, self.at = message, at


def through_fates(values: Array, fell: Array, confidence: float) -> Lognormal:
    """The curve through what fell at some intensities, more than zero.

    `fell` is (samples, intensities): 1 where a sample fell, 0 where it stood, NaN where that is not known. Raises
    UndeterminedError.
    """
    known, x = ~np.isnan(fell), np.log(values)
    fallen, count = np.nansum(fell, axis=0), known.sum(axis=0)
    _refuse_undetermined(values, fallen, count)
    middle, width = float(x.mean()), float(x.std())
    z = (x - middle) / width  # of size one, for the solver
    found = _most_likely(z, fallen, count)
    eta = found[0] + found[1] * z
    density = np.exp(-0.5 * eta**2) / sqrt(2.0 * np.pi)
    above, below = np.exp(log_ndtr(eta)), np.exp(log_ndtr(-eta))
    design = np.stack([np.ones_like(z), z])
    information = (design * (count * density**2 / (above * below))) @ design.T
    each = np.where(known, np.where(fell == 1.0, density / above, -density / below), 0.0)
    scores = each @ design.T
    inverse = np.linalg.inv(information)
    covariance = inverse @ (scores.T @ scores) @ inverse
    deviations = float(ndtri(0.5 + 0.5 * confidence))
    # Where the same samples fall at all intensities, neither the slope nor what is known of it is but rounding.
    if abs(found[1]) <= LEVEL or abs(found[1]) <= deviations * sqrt(covariance[1, 1]):
        raise UndeterminedError("the share of collapse does not change with it beyond chance")
    # ln median = middle - width a / b, and dispersion = width / |b|: both by the first derivatives.
    a, b = found
    of_median = width * np.array([-1.0 / b, a / b**2])
    spreads = (sqrt(of_median @ covariance @ of_median), sqrt(covariance[1, 1]) / abs(b))
    median, dispersion = exp(middle - width * a / b), width / abs(b)
    of_both = (
        _within(number, deviations * spread) for number, spread in zip((median, dispersion), spreads, strict=True)
    )
    about_median, about_dispersion = of_both
    return Lognormal(median, dispersion, about_median, about_dispersion, rises=bool(b > 0.0))


def through_capacities(capacities: Array, confidence: float) -> Lognormal:
    """The curve of samples of which is known at which intensity each falls. Raises UndeterminedError."""
    count = len(capacities)
    if count < FEWEST:
        raise UndeterminedError(f"of {count} samples is known at how much each falls, and {FEWEST} are the fewest")
    logs = np.log(capacities)
    mean, deviation = float(logs.mean()), float(logs.std())
    if deviation <= ROUNDING:
        raise UndeterminedError("all fall at {}, and nothing is spread", exp(mean))
    unbiased, error = deviation * sqrt(count / (count - 1.0)), 1.0 - confidence
    half = float(stdtrit(count - 1, 1.0 - 0.5 * error)) * unbiased / sqrt(count)
    squares = unbiased * sqrt(count - 1.0)
    low, high = (squares / sqrt(float(chdtri(count - 1, share))) for share in (0.5 * error, 1.0 - 0.5 * error))
    return Lognormal(exp(mean), deviation, _within(exp(mean), half), Interval(low, high), rises=True)


def _within(number: float, half: float) -> Interval:
    return Interval(number * float(np.exp(-half)), number * float(np.exp(half)))


def _most_likely(z: Array, fallen: Array, count: Array) -> Array:
    """(2,) for which Phi(a + b z) has the counts most likely; they overlap, so there is one such pair."""

    def cost(found: Array) -> tuple[float, Array]:
        eta = found[0] + found[1] * z
        above, below = log_ndtr(eta), log_ndtr(-eta)
        log_density = -0.5 * eta**2 - 0.5 * np.log(2.0 * np.pi)
        slope = fallen * np.exp(log_density - above) - (count - fallen) * np.exp(log_density - below)
        return -float(fallen @ above + (count - fallen) @ below), -np.array([slope.sum(), slope @ z])

    start = np.array([float(ndtri((fallen.sum() + 0.5) / (count.sum() + 1.0))), 0.0])
    result = minimize(cost, start, jac=True, method="BFGS", options={"gtol": 1e-9 * float(count.sum())})
    solution: Array = result.x
    return solution


def _refuse_undetermined(values: Array, fallen: Array, count: Array) -> None:
    """Raise UndeterminedError where no curve is the likeliest one: counts on both sides of a step say nothing of it."""
    if len(values) < FEWEST_POINTS:
        raise UndeterminedError("one intensity above zero is too few for a curve; ask for more points")
    if fallen.sum() in (0, count.sum()):
        which = "none falls at any point" if not fallen.any() else "all fall at each point"
        raise UndeterminedError(f"{which} above zero; take points on both sides of where that changes")
    some_fell, some_stood = values[fallen > 0], values[fallen < count]
    for before, after in ((some_stood, some_fell), (some_fell, some_stood)):
        if before.max() <= after.min():
            if before.max() == after.min():
                raise UndeterminedError(f"all turns about {{}}, {STEEP}", float(after.min()))
            raise UndeterminedError(
                f"all turns between {{}} and {{}}, {STEEP}", float(before.max()), float(after.min())
            )
