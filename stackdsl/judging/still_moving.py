"""What a claim comes to that bricks may still change which move when the watch ends: nobody knows, so it fails."""

from math import inf

from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.finding import Finding
from stackdsl.trace import Trace


def may_still_change(stated: ClaimKind, trace: Trace) -> bool:
    """Whether what still moves could make a claim come out otherwise."""
    return bool(trace.moving) and not stated.of_the_watch and not stated.is_decided(trace)


def still_moving(found: Finding, trace: Trace) -> Finding:
    """The finding, with why it is none."""
    count = len(trace.moving)
    watched = trace.cost.simulated_time - max(trace.last_action, trace.last_arrival)  # [s]
    why = f"still moving at the end of the watch: {count} brick{'s' * (count > 1)}"
    advice = f"watch longer, such as `watch: {2 * max(1, round(watched))} s`"
    return Finding(f"{found.measured}; {why}; {advice}", -inf, "", passed=False, numbers=found.numbers)
