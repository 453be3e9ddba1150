"""Outcomes -> warnings about claims that are met in a way that their author may not expect."""

from collections.abc import Collection, Iterator

from stackdsl.diagnostics import ScenarioWarning
from stackdsl.language.claims.claim_result import placed
from stackdsl.results import ClaimOutcome
from stackdsl.trace import BrickState, Trace
from stackdsl.wording import mm, survived_text

SLID = 0.05  # share of its length by which a structure may slide without a warning


def warnings_about(outcomes: Collection[ClaimOutcome], trace: Trace) -> Iterator[ScenarioWarning]:
    """Yield what the claims that are met leave open."""
    alone = trace.margins.unaided
    for outcome in outcomes:
        if outcome.passed and outcome.name == "margin" and alone is not None:
            limits = [number.least for number in outcome.numbers if number.unit == "g"]
            if any(limit is not None and alone < limit for limit in limits):
                yield ScenarioWarning(
                    outcome.span,
                    "the margin is met only with friction between neighbours that touch; it is "
                    f"{survived_text(alone)} g without it",
                    "if neighbours may be apart, write gaps between them, such as 2 mm",
                )
    told = {outcome.name for outcome in outcomes}
    stands = next((outcome for outcome in outcomes if outcome.passed and outcome.name == "stands"), None)
    if stands is not None and not told & {"drift", "displaced"} and (slid := _slid(trace)) > 0.0:
        yield ScenarioWarning(
            stands.span,
            f"all bricks stand, but the whole structure slid by {mm(slid, 3)}",
            "to limit this, add a claim such as `drift: <= 10 mm`",
        )


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
