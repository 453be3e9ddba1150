"""A case played once more to be looked at: its replay goes to a page, its small picture into the report."""

import re
from dataclasses import dataclass
from hashlib import sha256

from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.known import known_of
from stackdsl.outcome import GoldenResult
from stackdsl.recording.recorder import Recorder
from stackdsl.viewing.golden_view import golden_view
from stackdsl.viewing.pictures.drawing import Frame
from stackdsl.viewing.pictures.picture import Panel, picture
from stackdsl.viewing.pictures.views import VIEWS
from stackdsl.viewing.replay.replay_page import told
from stackdsl.viewing.run_view import view_of

SMALL = 150.0  # [px] wide
MOST_DRAWN = 300  # bricks of a small picture; of more nobody sees any


@dataclass(frozen=True, slots=True)
class PlayedCase:
    """A case that was played once more."""

    told: tuple[str, ...]  # JSON for a page: the run, and what its golden file tells, if there is one
    picture: str  # SVG; empty where there are too many bricks for a small one


@dataclass(frozen=True, slots=True)
class ShownCase:
    """What there is to look at of one case."""

    replay: str  # the file, from the index on, and which of its runs
    picture: str  # SVG; empty where there are too many bricks for a small one


def file_name(name: str) -> str:
    """A name for a page of replays, that every file system takes and nothing that is called otherwise has."""
    plain = re.sub(r"[^A-Za-z0-9.=-]+", "-", name).strip("-.")[:80]
    return f"{plain}-{sha256(name.encode()).hexdigest()[:8]}.html"


def show_case(case: Case, golden: GoldenResult | None) -> PlayedCase:
    """What a worker does: play, and tell what a page shows of it, beside its golden file."""
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system), recorder=recorder)
    run = view_of(case, trace, recorder.recording(), judged(case, trace))
    before = golden_view(golden, run) if golden is not None else None
    small = ""
    if len(run.recording.bricks) <= MOST_DRAWN:
        panel = Panel(Frame(VIEWS["three-quarter"], trace.cost.simulated_time), "")
        small = picture(run, [panel], width=SMALL)
    return PlayedCase(tuple(told(each) for each in (run, before) if each is not None), small)
