"""What a claim comes to that bricks may still change which move when the watch ends: nobody knows, so it fails."""

from math import inf

from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.claims.finding import Finding
from stackdsl.trace import Trace
from stackdsl.wording import how_many, names_text


def may_still_change(stated: ClaimKind, trace: Trace) -> bool:
    """Whether what still moves could make a claim come out otherwise."""
    return bool(trace.moving or trace.unsettled) and not stated.of_the_watch and not stated.is_decided(trace)


def still_moving(found: Finding, trace: Trace) -> Finding:
    """The finding, with why it is none."""
    why = []
    if count := len(trace.moving):
        why.append(f"still moving at the end of the watch: {how_many(count, 'brick')}")
    if slow := [track for track in trace.unsettled if track.brick.id not in trace.moving]:
        causes = dict.fromkeys(track.gives_way or "it has not come to rest" for track in slow)
        why.append(
            f"not settled at the end of the watch: {names_text([t.brick.id for t in slow])}: {'; '.join(causes)}"
        )
    watched = trace.cost.simulated_time - max(trace.last_action, trace.last_arrival)  # [s]
    advice = f"watch longer, such as `watch: {2 * max(1, round(watched))} s`"
    return Finding(f"{found.measured}; {'; '.join(why)}; {advice}", -inf, "", passed=False, numbers=found.numbers)
