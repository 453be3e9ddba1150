"""Fails a scenario in which something falls before the first impact, unless a claim expects it.

A wall that falls while it is built passes `falls: {count: <= 5}` just as a wall that a throw hardly touches. So an
early fall is a separate failure, unless a claim expects it, such as `collapses` or `verdict: unstable`.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import inf

from stability.name_order import in_order, names_text
from stability.problem import Stability, Verdict
from stackdsl.compiler.impacts import impact_actions
from stackdsl.compiler.schedule import ResolvedScenario, resolved_scenario
from stackdsl.diagnostics import Span
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import Source
from stackdsl.results import ClaimOutcome
from stackdsl.timeline import Action, HoldAction, Placement, time_of_arrival
from stackdsl.trace import Event, EventKind, Trace
from stackdsl.wording import level_text

EARLY = 0.05  # [s] by which a thrown or dropped brick may hit the structure before its planned time of arrival


@dataclass(frozen=True, slots=True)
class FirstLoad:
    """The first impact or shaking after the build."""

    name: str  # such as `impact 1 (throw)`
    span: Span
    begins: float  # [s]
    met: float  # earliest contact of a flying brick with the structure; otherwise the same as `begins` [s]


def falls_before_impacts(
    trace: Trace, expected: Iterable[ClaimKind], scenario: Scenario, source: Source
) -> Iterator[ClaimOutcome]:
    """Yield a failure if bricks fell before the first impact and no claim expects that."""
    fell = trace.collapse
    if fell is None or not (scenario.impacts or scenario.world.shake is not None):
        return
    first = min(_loads(resolved_scenario(scenario, source), scenario, source), key=lambda load: load.met, default=None)
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
    where = f"{gave_way:.3f} s" if fell.fallen else f"{level_text(fell.level, fell.step)} at {gave_way:.3f} s"
    named = names_text(in_order(fallen), among=trace.tracks)
    measured = (
        f"it gave way at {where}, before {first.name} at {first.begins:g} s: {named}; claims "
        "about the impact are then meaningless; if the fall is intended, add a claim such as `collapses: any`"
    )
    margin = gave_way - first.met
    yield ClaimOutcome(f"until {first.name}", "that it stands", measured, margin, "s", passed=False, span=first.span)


def _loads(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[FirstLoad]:
    """Yield every impact and the shaking. A hand that holds a brick loads the structure only when it lets go."""
    actions: list[tuple[int, Action]] = [
        (moment.turn - 1, action) for moment, action in impact_actions(built, scenario, source).actions
    ]
    slid_in = [
        (number, moment.time) for number, moment in enumerate(built.impacts) if scenario.impacts[number].content.slid_in
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
    """Return the last wake event of the brick that fell first, with its reason; of any brick if that has none."""
    if trace.collapse is None:
        return None
    events = [e for e in trace.events if e.kind is EventKind.WOKEN and e.time <= trace.collapse.time and e.reason]
    about = [event for event in events if trace.collapse.brick in event.bricks]
    return next(reversed(about or events), None)


def proof_of_fall(trace: Trace, woken: Event | None) -> Verdict | None:
    """Return the proof that the bricks that fell had to fall; None if there is none, or it is about another fall."""
    if trace.collapse is None or trace.numerical:
        return None
    if trace.disproof is not None:
        return trace.disproof
    proven = trace.statics
    if proven is None or proven.stability is not Stability.UNSTABLE:
        return None
    return proven if woken is None or proven.reason == woken.reason else None
