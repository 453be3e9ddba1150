"""Fails a scenario in which something falls before the first impact, unless a claim expects it.

A wall that falls while it is built meets `falls: {count: <= 5}` as well as one that a throw hardly touches. So that is
a failure of its own, unless a claim expects the fall, such as `collapses` or `verdict: unstable`.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import inf

from stability.name_order import in_order
from stability.problem import Stability, Verdict
from stackdsl.compiler.impacts import done
from stackdsl.compiler.schedule import Built, built_of
from stackdsl.diagnostics import Span
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.results import ClaimOutcome
from stackdsl.timeline import Action, HoldAction, Placement, time_of_arrival
from stackdsl.trace import Event, EventKind, Trace
from stackdsl.wording import level_text, names_text

EARLY = 0.05  # [s] how much before its aim what is thrown or dropped may meet the structure


@dataclass(frozen=True, slots=True)
class FirstLoad:
    """The first thing that is done to the structure, other than building it."""

    name: str  # such as `impact 1, a throw,`
    span: Span
    begins: float  # [s]
    met: float  # when what flies may first meet the structure; otherwise when it begins [s]


def fallen_before_impacts(
    trace: Trace, expected: Iterable[ClaimKind], scenario: Scenario, source: Source
) -> Iterator[ClaimOutcome]:
    """The failure of what fell before the first impact though no claim expects it; nothing where none did."""
    fell = trace.collapse
    if fell is None or not (scenario.impacts or scenario.world.shake is not None):
        return
    first = min(_loads(built_of(scenario, source), scenario, source), key=lambda load: load.met, default=None)
    if first is None:
        return
    woken = woken_before(trace)
    proven = woken if proof_of_fall(trace, woken) is not None else None
    gave_way = min(fell.time, proven.time if proven is not None and proven.time < first.begins else inf)
    if gave_way >= first.met:
        return
    fallen = {fell.brick} | {
        name for name, track in trace.tracks.items() if track.left_at is not None and track.left_at < first.met
    }
    if any(claim.expects_fall_of(fallen) for claim in expected):
        return
    where = f"{level_text(fell.level, fell.step)} at {gave_way:.3f} s"
    measured = (
        f"it gave way at {where}, before {first.name} at {first.begins:g} s: {names_text(in_order(fallen))}; what is "
        "expected of that says nothing then; if it is meant to fall, expect it, such as by `collapses: any`"
    )
    margin = gave_way - first.met
    yield ClaimOutcome(f"until {first.name}", "that it stands", measured, margin, "s", passed=False, span=first.span)


def _loads(built: Built, scenario: Scenario, source: Source) -> Iterator[FirstLoad]:
    """All that is done to the structure. A hand that holds a brick does something only as it lets go."""
    actions: list[tuple[int, Action]] = [
        (moment.turn - 1, action) for moment, action in done(built, scenario, source).actions
    ]
    slid_in = [
        (number, moment.time) for number, moment in enumerate(built.impacts) if scenario.impacts[number].done.slid_in
    ]
    for number, action in actions:
        if not isinstance(action, HoldAction):
            flies = isinstance(action, Placement) and action.hits
            met = max(action.time, time_of_arrival(action) - EARLY) if flies else action.time
            yield _impact(number, action.time, met, scenario, source)
    for number, time in slid_in:
        yield _impact(number, time, time, scenario, source)
    if built.shaken is not None:
        time = built.shaken.time
        yield FirstLoad("the shaking", source.key_span_of(("world", "shake")), time, time)


def _impact(number: int, begins: float, met: float, scenario: Scenario, source: Source) -> FirstLoad:
    kind = scenario.impacts[number].kind
    return FirstLoad(f"impact {number + 1} ({kind})", source.key_span_of(("impacts", number, kind)), begins, met)


def woken_before(trace: Trace) -> Event | None:
    """When what fell was last told to, and why."""
    if trace.collapse is None:
        return None
    events = [e for e in trace.events if e.kind is EventKind.WOKEN and e.time <= trace.collapse.time and e.reason]
    about = [event for event in events if trace.collapse.brick in event.bricks]
    return next(reversed(about or events), None)


def proof_of_fall(trace: Trace, woken: Event | None) -> Verdict | None:
    """The proof that what fell had to; None if there is none, or if what is proven is of something else."""
    if trace.collapse is None or trace.numerical:
        return None
    if trace.disproof is not None:
        return trace.disproof
    proven = trace.statics
    if proven is None or proven.stability is not Stability.UNSTABLE:
        return None
    return proven if woken is None or proven.reason == woken.reason else None
