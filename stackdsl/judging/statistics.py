"""Judges claims about shares of samples, with exact confidence intervals and as few samples as decide.

The interval is that of Clopper and Pearson: it contains the true share at least as often as the confidence requires,
whatever that share is. Looking repeatedly and stopping at the first favourable result would break this guarantee. So
the looks are fixed beforehand, at the planned number of samples, its half, its quarter and so on, and each look gets an
equal part of the permitted error (Bonferroni). This holds for any dependence between the looks.
"""

from dataclasses import dataclass
from enum import Enum
from math import inf, isinf

from scipy.special import betaincinv

from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.claim_result import PERCENT, ClaimResult
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Ensemble, Measure

FIRST_LOOK = 100  # samples; fewer rarely decide
MOST_MORE = 10**12  # samples; more are never drawn


class Decision(Enum):
    """Whether a share is within its wanted bounds, by the samples so far."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "open"  # either may be true


@dataclass(frozen=True, slots=True)
class Interval:
    """Confidence interval of a share."""

    low: float
    high: float


def looks(planned: int) -> tuple[int, ...]:
    """Return the numbers of samples after which claims are judged; the last is `planned`."""
    counts = [planned]
    while counts[-1] >= 2 * FIRST_LOOK:
        counts.append((counts[-1] + 1) // 2)
    return tuple(reversed(counts))


def error_of_a_look(planned: int, confidence: float) -> float:
    """Return the permitted error of one look, such that all looks together have the given confidence."""
    return (1.0 - confidence) / len(looks(planned))


def interval(least: int, most: int, count: int, error: float) -> Interval:
    """Return the Clopper-Pearson interval of a share, given that `least` to `most` of `count` samples are hits."""
    low = float(betaincinv(least, count - least + 1, 0.5 * error)) if least > 0 else 0.0
    high = float(betaincinv(most + 1, count - most, 1.0 - 0.5 * error)) if most < count else 1.0
    return Interval(low, high)


def decided(wanted: Tolerance, between: Interval) -> Decision:
    """Return HOLDS if every share of an interval is within the bounds, FAILS if none is, OPEN otherwise."""
    if wanted.holds(between.low) and wanted.holds(between.high):
        return Decision.HOLDS
    within = Tolerance(between.low, between.high, low_open=False, high_open=False, text="")
    return Decision.OPEN if wanted.meets(within) else Decision.FAILS


def judge_share(claim: ClaimKind, ensemble: Ensemble, confidence: float) -> tuple[ClaimResult, Decision]:
    """Return the result of a claim about a share, and whether it is decided."""
    wanted = claim.wanted_share
    assert wanted is not None  # validation refuses other claims in a scenario with samples
    count, least = ensemble.drawn, _holding(claim, ensemble)
    error = error_of_a_look(ensemble.planned, confidence)
    between = interval(least, least + ensemble.unknown, count, error)
    decision = decided(wanted, between)
    share = f"{_percent(between.low)} .. {_percent(between.high)} %"
    unknown = f", and {ensemble.unknown} undecided" if ensemble.unknown else ""
    measured = f"{share} ({least} of {count} samples{unknown})"
    if decision is Decision.OPEN:
        measured = f"undecided: {measured}; {_more(wanted, ensemble, least, error)}"
    margin = _margin(wanted, between, decision)
    numbers = (Measure(PERCENT * least / count, _limit(wanted.low), _limit(wanted.high), "%"),)
    return ClaimResult(measured, PERCENT * margin, "%", decision is Decision.HOLDS, numbers), decision


def _holding(claim: ClaimKind, ensemble: Ensemble) -> int:
    fell = sum(count for level, count in ensemble.fell.items() if claim.holds_for_sample(level))
    return fell + (ensemble.stood if claim.holds_for_sample(None) else 0)


def _percent(share: float) -> str:
    return f"{PERCENT * share:.4g}"


def _limit(bound: float) -> float | None:
    return None if isinf(bound) else PERCENT * bound


def _margin(wanted: Tolerance, between: Interval, decision: Decision) -> float:
    """Return the distance of the interval to the nearest bound: positive inside the bounds, negative outside."""
    least = min(wanted.margin(between.low), wanted.margin(between.high))
    return max(wanted.margin(between.low), wanted.margin(between.high)) if decision is Decision.FAILS else least


def _more(wanted: Tolerance, ensemble: Ensemble, least: int, error: float) -> str:
    """Return a text with the number of further samples that would decide, if the share stays the same."""
    needed = samples_needed(wanted, least / ensemble.drawn, ensemble.unknown / ensemble.drawn, error)
    if isinf(needed):
        return "the share is so close to the limit that no number of samples would decide it"
    return f"about {_round(max(1, int(needed) - ensemble.drawn))} more samples would decide it"


def samples_needed(wanted: Tolerance, share: float, unknown: float, error: float) -> float:
    """Return about how many samples decide; inf if no number does.

    `share` is the fraction of hits, and `unknown` the fraction of samples that may be hits.
    """

    def decides(count: int) -> bool:
        least = round(share * count)
        most = min(count, least + round(unknown * count))
        return decided(wanted, interval(least, most, count, error)) is not Decision.OPEN

    high = FIRST_LOOK
    while not decides(high):
        high *= 2
        if high > MOST_MORE:
            return inf
    low = high // 2
    while high - low > max(1, high // 50):
        middle = (low + high) // 2
        low, high = (low, middle) if decides(middle) else (middle, high)
    return high


def _round(count: int) -> str:
    """Return a number rounded to two digits."""
    return f"{int(float(f'{count:.2g}')):,}"
