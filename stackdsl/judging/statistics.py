"""Shares of samples held against what is wanted of them: with exact intervals, as few samples as decide, and no guess.

The interval is that of Clopper and Pearson: whatever the true share is, it lies inside at least as often as one wants
to be sure. To look again and again and to stop as soon as one likes what one sees would spoil that. So the looks are
fixed before, at the number of samples that is planned, its half, its quarter and so on, and they share what one may be
wrong by: each is made as sure as it takes for all of them to be right together (Bonferroni), which holds however the
looks depend on each other.
"""

from dataclasses import dataclass
from enum import Enum
from math import inf, isinf

from scipy.special import betaincinv

from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.claim_result import PERCENT, ClaimResult
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Ensemble, Measure

FIRST_LOOK = 100  # samples; fewer decide little
MOST_MORE = 10**12  # samples; so many will never be drawn


class Decision(Enum):
    """What samples say of a share that is wanted."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "open"  # either may be true


@dataclass(frozen=True, slots=True)
class Interval:
    """Between which a share lies, as surely as was asked for."""

    low: float
    high: float


def looks(planned: int) -> tuple[int, ...]:
    """After how many samples it is asked whether they decide; the last is all that are planned."""
    found = [planned]
    while found[-1] >= 2 * FIRST_LOOK:
        found.append((found[-1] + 1) // 2)
    return tuple(reversed(found))


def error_of_a_look(planned: int, confidence: float) -> float:
    """How often one look may be wrong, so that all together are as seldom wrong as is asked for."""
    return (1.0 - confidence) / len(looks(planned))


def interval(least: int, most: int, count: int, error: float) -> Interval:
    """The interval of Clopper and Pearson of a share, of which between `least` and `most` of `count` samples are."""
    low = float(betaincinv(least, count - least + 1, 0.5 * error)) if least > 0 else 0.0
    high = float(betaincinv(most + 1, count - most, 1.0 - 0.5 * error)) if most < count else 1.0
    return Interval(low, high)


def decided(wanted: Tolerance, between: Interval) -> Decision:
    """Whether all shares of an interval are as wanted, or none is."""
    if wanted.holds(between.low) and wanted.holds(between.high):
        return Decision.HOLDS
    within = Tolerance(between.low, between.high, low_open=False, high_open=False, text="")
    return Decision.OPEN if wanted.meets(within) else Decision.FAILS


def judged(stated: ClaimKind, ensemble: Ensemble, confidence: float) -> tuple[ClaimResult, Decision]:
    """What a claim of a share comes to."""
    wanted = stated.wanted_share
    assert wanted is not None  # other claims are refused where there are samples
    count, least = ensemble.drawn, _holding(stated, ensemble)
    error = error_of_a_look(ensemble.planned, confidence)
    between = interval(least, least + ensemble.unknown, count, error)
    found = decided(wanted, between)
    share = f"{_percent(between.low)} .. {_percent(between.high)} %"
    unknown = f", and {ensemble.unknown} may or may not" if ensemble.unknown else ""
    measured = f"{share} ({least} of {count} samples{unknown})"
    if found is Decision.OPEN:
        measured = f"undecided: {measured}; {_more(wanted, ensemble, least, error)}"
    margin = _margin(wanted, between, found)
    numbers = (Measure(PERCENT * least / count, _limit(wanted.low), _limit(wanted.high), "%"),)
    return ClaimResult(measured, PERCENT * margin, "%", found is Decision.HOLDS, numbers), found


def _holding(stated: ClaimKind, ensemble: Ensemble) -> int:
    fell = sum(count for level, count in ensemble.fell.items() if stated.holds_of(level))
    return fell + (ensemble.stood if stated.holds_of(None) else 0)


def _percent(share: float) -> str:
    return f"{PERCENT * share:.4g}"


def _limit(bound: float) -> float | None:
    return None if isinf(bound) else PERCENT * bound


def _margin(wanted: Tolerance, between: Interval, found: Decision) -> float:
    """How far the interval is from the nearest bound: positive inside; how far it reaches beyond, where it does."""
    least = min(wanted.margin(between.low), wanted.margin(between.high))
    return max(wanted.margin(between.low), wanted.margin(between.high)) if found is Decision.FAILS else least


def _more(wanted: Tolerance, ensemble: Ensemble, least: int, error: float) -> str:
    """How many samples more would decide, if the share stays what it is."""
    needed = samples_needed(wanted, least / ensemble.drawn, ensemble.unknown / ensemble.drawn, error)
    if isinf(needed):
        return "no number of samples would decide a share so close to the limit"
    return f"some {_round(max(1, int(needed) - ensemble.drawn))} more samples would decide it"


def samples_needed(wanted: Tolerance, share: float, unknown: float, error: float) -> float:
    """About how many samples decide, of which this share holds and of which another is unknown; inf where none do."""

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
    """Two digits of a number, and then zeros."""
    return f"{int(float(f'{count:.2g}')):,}"
