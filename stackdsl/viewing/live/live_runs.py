"""What a live page is told of a case: at once what statics says of it, then how it was played, then its margins."""

import os
from collections.abc import Sequence
from dataclasses import dataclass

from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.knobs import Knobs
from stackdsl.judging.known import known_of
from stackdsl.judging.proofs import proofs_of
from stackdsl.outcome import VariantResult
from stackdsl.reading.uncollected import uncollected
from stackdsl.recording.recorder import Recorder
from stackdsl.report.proof_text import Extent, proven_lines
from stackdsl.report.run_text import run_text
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.modification import as_played
from stackdsl.viewing.live.preview import preview_of
from stackdsl.viewing.replay.replay_page import told
from stackdsl.viewing.run_view import view_of

MANNERS = 10  # of a worker beside the browser, which is to draw first what is known already


@dataclass(frozen=True, slots=True)
class Played:
    """A case that was played."""

    told: str  # JSON for the page
    text: str  # for a terminal
    result: VariantResult


@uncollected()  # what is made is small, and who looks waits
def preview(case: Case) -> str:
    """What a page is told at once."""
    return told(preview_of(case))


def played(case: Case) -> Played:
    """What a worker does: play, and tell a page and a terminal of it. Raises BlockedPlacementError."""
    os.nice(MANNERS)
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system), recorder=recorder)
    result = judged(case, trace)
    run = view_of(case, trace, recorder.recording(), result)
    return Played(told(run), run_text(trace, result), result)


def margin_lines(case: Case) -> Sequence[str]:
    """What a worker does: tell what the proofs would survive, and what is nearest to failing."""
    os.nice(MANNERS)
    timeline = as_played(case.timeline, system_named(case.system).modification)
    count = sum(not placement.hits for placement in timeline.placements)
    knobs = Knobs(case.scenario, case.variant)
    lines = proven_lines(proofs_of(timeline), timeline, count, Extent(margins=True), knobs)
    return tuple(line.strip() for line in lines)
