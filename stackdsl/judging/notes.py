"""Outcomes -> warnings about claims that are met in a way that their author may not expect."""

from collections.abc import Collection, Iterator

from stability.analysis.weakest import Apart
from stackdsl.diagnostics import ScenarioWarning
from stackdsl.language.claims.claim_result import placed
from stackdsl.results import ClaimOutcome
from stackdsl.trace import BrickState, Trace
from stackdsl.wording import GAPS, apart_text, mm

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
