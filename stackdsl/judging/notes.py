"""Warnings about results that their author may not expect: outcomes of claims, and changes of joints left out."""

from collections.abc import Collection, Iterator

from stability.analysis.weakest import Apart
from stackdsl.compiler.compile import origin_of
from stackdsl.compiler.joints import setting_at
from stackdsl.compiler.schedule import resolved_scenario
from stackdsl.diagnostics import ScenarioWarning
from stackdsl.language.claims.claim_result import placed
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.results import ClaimOutcome
from stackdsl.timeline import JointsAction, Timeline
from stackdsl.trace import BrickState, Trace
from stackdsl.wording import GAPS, apart_text, mm, time_text

SLID = 0.05  # share of its length by which a structure may slide without a warning


def warnings_about(outcomes: Collection[ClaimOutcome], trace: Trace) -> Iterator[ScenarioWarning]:
    """Yield what the claims that are met leave open."""
    if trace.margins.apart is not None:
        yield from _aided(outcomes, trace.margins.apart)
    told = {outcome.name for outcome in outcomes}
    stands = next((outcome for outcome in outcomes if outcome.passed and outcome.name == "stands"), None)
    if stands is not None and not told & {"drift", "displaced"} and (slid := _slid(trace)) > 0.0:
        yield ScenarioWarning(
            stands.span,
            f"all bricks stand, but the whole structure slid by {mm(slid, 3)}",
            "to limit this, add a claim such as `drift: <= 10 mm`",
        )


def left_out(timeline: Timeline, trace: Trace, scenario: Scenario, source: Source) -> Iterator[ScenarioWarning]:
    """Yield the glue, the cuts and the mortar that sets after the collapse, when joints no longer change."""
    if trace.collapse is None:
        return
    fell = f"since the structure collapsed at {time_text(trace.collapse.time, 4)}"
    hint = "after a collapse, joints no longer change; write an earlier time"
    told: set[KeyPath] = set()
    for action in timeline.actions:
        if not isinstance(action, JointsAction) or action.time <= trace.collapse.time:
            continue
        if (origin := origin_of(action, scenario, source)) is not None:
            message = f"`{origin.kind}` at {time_text(action.time)} is left out, {fell}"
            yield ScenarioWarning(origin.span, message, hint)
            continue
        for path in setting_at(action.time, resolved_scenario(scenario, source), scenario):
            if path not in told:
                told.add(path)
                message = f"this joint, which sets at {time_text(action.time)}, is left out, {fell}"
                yield ScenarioWarning(source.key_span_of(path), message, hint)


def _aided(outcomes: Collection[ClaimOutcome], apart: Apart) -> Iterator[ScenarioWarning]:
    """Yield the claims that are met only with friction between neighbours; one of them if the structure falls."""
    met = {outcome.name: outcome for outcome in outcomes if outcome.passed}
    if apart.acceleration is None:
        claim = met.get("margin") or met.get("stands") or met.get("verdict")
        if claim is not None:
            yield ScenarioWarning(claim.span, apart_text(apart), GAPS)
        return
    for outcome in outcomes:
        limits = [number.least for number in outcome.numbers if number.unit == "g"]
        if outcome.passed and outcome.name == "margin" and any(each and apart.acceleration < each for each in limits):
            message = f"the margin is met only with friction between neighbours that touch; {apart_text(apart)}"
            yield ScenarioWarning(outcome.span, message, GAPS)


def _slid(trace: Trace) -> float:
    """Return the least shift of all bricks [m]; 0 if one did not shift, or if that is a small share of the length."""
    tracks = placed(trace)
    if not tracks or any(track.state is BrickState.FALLEN for track in tracks):
        return 0.0
    radius = max(track.brick.shape.bounding_radius for track in tracks)
    places = [track.rest.position_W for track in tracks]
    length = 2.0 * radius + max(max(at[axis] for at in places) - min(at[axis] for at in places) for axis in (0, 1))
    slid = min(track.shift for track in tracks)
    return slid if slid > SLID * length else 0.0
