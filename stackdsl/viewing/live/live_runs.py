"""What a live page is told of a case: at once what statics says of it, then how it was played, then its margins."""

import os
from dataclasses import dataclass

from stability.model import BodyId
from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.knobs import Knobs
from stackdsl.judging.known import known_of
from stackdsl.judging.margins import margins_of_assembly
from stackdsl.judging.proofs import proofs_of
from stackdsl.outcome import VariantResult
from stackdsl.proof_margins import Margins
from stackdsl.reading.uncollected import uncollected
from stackdsl.recording.recorder import Recorder
from stackdsl.report.proof_text import TOLD, Extent, proven_lines
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


@dataclass(frozen=True, slots=True)
class Margined:
    """What the proofs of a case would survive."""

    lines: tuple[str, ...]
    weakest: BodyId | None  # the brick that the lines call so


@uncollected()  # what is made is small, and who looks waits
def preview(case: Case) -> str:
    """What a page is told at once."""
    return told(preview_of(case), hurried=True)


def played(case: Case) -> Played:
    """What a worker does: play, and tell a page and a terminal of it. Raises BlockedPlacementError."""
    os.nice(MANNERS)
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system), recorder=recorder)
    result = judged(case, trace)
    run = view_of(case, trace, recorder.recording(), result)
    return Played(told(run, hurried=True), run_text(trace, result), result)


def margined(case: Case) -> Margined:
    """What a worker does: tell what the proofs would survive, and what gives way first."""
    os.nice(MANNERS)
    timeline = as_played(case.timeline, system_named(case.system).modification)
    count = sum(not placement.hits for placement in timeline.placements)
    knobs, proofs = Knobs(case.scenario, case.variant), proofs_of(timeline)
    is_whole = sum(len(judged.bricks) for judged in proofs.judged) == count
    margins = margins_of_assembly(proofs.assembly, TOLD) if is_whole else Margins()
    lines = proven_lines(proofs, timeline, count, Extent(margins=True), knobs, margins)
    weakest = margins.weakest.brick if margins.weakest is not None else None
    return Margined(tuple(line.strip() for line in lines), weakest)
