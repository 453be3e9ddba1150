"""What all claims together ask of a run."""

from dataclasses import dataclass

from stackdsl.language.schema import Scenario

HOLD = 2.0  # [s] watched after the last action unless an expectation says for how long


@dataclass(frozen=True, slots=True)
class Asked:
    """What a run must show."""

    hold: float  # how long the structure is watched after the last action [s]
    watched: bool  # anything that only motion shows
    margins: tuple[str, ...]  # of the proof, such as `tilt`
    closely: bool  # how something begins to fall, or where it lands
    measures: tuple[str, ...]  # what is measured only if it is asked for, such as `sway`


def asked_of(scenario: Scenario) -> Asked:
    """What is expected of the scenario, and known of it, put as what a run must show."""
    claims = [claim.stated for claim in (*scenario.expect, *scenario.truth)]
    return Asked(
        hold=max((claim.needed_hold for claim in claims if claim.needed_hold is not None), default=HOLD),
        watched=not scenario.expect or not all(claim.needs_statics for claim in claims),
        margins=tuple(sorted({margin for claim in claims for margin in claim.needed_margins})),
        closely=any(claim.needs_close_looks for claim in claims),
        measures=tuple(sorted({measure for claim in claims for measure in claim.needed_measures})),
    )
