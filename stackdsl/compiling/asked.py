"""What all claims together ask of a run."""

from dataclasses import dataclass

from stackdsl.language.schema import Scenario

# Unless the scenario or a claim says for how long.
HOLD = 2.0  # [s] watched after the last action
AFTERMATH = 1.0  # [s] a collapse is followed; a plank falls from a metre in less than half of it


@dataclass(frozen=True, slots=True)
class Asked:
    """What a run must show."""

    hold: float  # how long the structure is watched after the last action [s]
    followed: float  # how long a collapse is [s]
    watched: bool  # anything that only motion shows
    margins: tuple[str, ...]  # of the proof, such as `tilt`
    told_margins: tuple[str, ...]  # the same, where few bricks make them cheap; nothing depends on them
    closely: bool  # how something begins to fall, or where it lands
    measures: tuple[str, ...]  # what is measured only if it is asked for, such as `sway`


def asked_of(scenario: Scenario) -> Asked:
    """What is expected of the scenario, and known of it, put as what a run must show."""
    claims = [claim.stated for claim in (*scenario.expect, *scenario.truth)]
    spans = [span for span in (scenario.watch, *(claim.needed_hold for claim in claims)) if span is not None]
    return Asked(
        hold=max(spans, default=HOLD),
        followed=scenario.watch or AFTERMATH,
        watched=scenario.watch is not None
        or scenario.world.shake is not None
        or any(step.place is not None for step in scenario.build)
        or any(impact.done.lasts for impact in scenario.impacts)
        or not scenario.expect
        or not all(claim.needs_statics for claim in claims),
        margins=tuple(sorted({margin for claim in claims for margin in claim.needed_margins})),
        told_margins=tuple(sorted({margin for claim in claims for margin in claim.told_margins})),
        closely=any(claim.needs_close_looks for claim in claims),
        measures=tuple(sorted({measure for claim in claims for measure in claim.needed_measures})),
    )
