"""Who carries whom, and what is proven."""

from math import inf, isnan

from stackdsl.judging.finding import SHOWN_PER_SI, Finding, all_of, within
from stackdsl.language.claims import Margin, RestsOn
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Trace


def rests_on(claim: RestsOn, trace: Trace) -> Finding:
    """Whether one brick is carried by another, and how much of its load."""
    edge = next((edge for edge in trace.edges if (edge.upper, edge.lower) == (claim.brick, claim.support)), None)
    share = 0.0 if edge is None else edge.share
    if edge is None:
        margin = share if claim.share is None else claim.share.margin(share)
        return Finding("it does not rest there", min(margin, 0.0), "of its load", passed=False)
    if isnan(share):
        known = "it rests there, and its share is not known: friction, leaning or a counterweight holds it"
        return Finding(known, inf if claim.share is None else -inf, "", passed=claim.share is None)
    if claim.share is None:
        return Finding(f"share {share:.3f}", share, "of its load", passed=True)
    return within(claim.share, share, "of its load", f"share {share:.3f}")


def verdict(claim: str, trace: Trace) -> Finding:
    """What statics says."""
    if trace.statics is None:
        return Finding("nothing was set down at rest", inf, "", passed=False)
    reason = f": {trace.statics.reason}" if trace.statics.reason else ""
    return Finding(f"{trace.statics.stability}{reason}", inf, "", passed=trace.statics.stability == claim)


def margin(claim: Margin, trace: Trace) -> Finding:
    """How much the proof that it stands would survive."""
    return all_of([_part(key, getattr(claim, key), getattr(trace.margins, key)) for key in claim.asked])


def _part(key: str, wanted: Tolerance, value: float | None) -> Finding:
    """One kind of margin."""
    unit = {"acceleration": "g", "tilt": "deg", "friction": "", "placement": "mm"}[key]
    if value is None:
        return Finding(f"no {key} is proven", -inf, unit, passed=False)
    return within(wanted, value, unit, f"{key} {SHOWN_PER_SI.get(unit, 1.0) * value:.4g} {unit}".rstrip())
