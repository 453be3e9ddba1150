"""A case played once more to be looked at: its replay goes to a file, its small picture into the report."""

import re
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.known import known_of
from stackdsl.recording.recorder import Recorder
from stackdsl.viewing.pictures.drawing import Frame
from stackdsl.viewing.pictures.picture import Panel, picture
from stackdsl.viewing.pictures.views import VIEWS
from stackdsl.viewing.replay.replay_page import replay_page
from stackdsl.viewing.run_view import view_of

SMALL = 150.0  # [px] wide
MOST_DRAWN = 300  # bricks of a small picture; of more nobody sees any


@dataclass(frozen=True, slots=True)
class ShownCase:
    """What there is to look at of one case."""

    replay: str  # the file, from the index on
    picture: str  # SVG; empty where there are too many bricks for a small one


def file_name(case: str) -> str:
    """A name for the replay of a case, that every file system takes and no other case has."""
    plain = re.sub(r"[^A-Za-z0-9.=-]+", "-", case).strip("-.")[:80]
    return f"{plain}-{sha256(case.encode()).hexdigest()[:8]}.html"


def show_case(case: Case, folder: Path) -> ShownCase:
    """What a worker does: play, and write the replay into a folder that is there."""
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system), recorder=recorder)
    run = view_of(case, trace, recorder.recording(), judged(case, trace))
    file = folder / file_name(case.name)
    file.write_text(replay_page([run], case.name), encoding="utf-8")
    small = ""
    if len(run.recording.bricks) <= MOST_DRAWN:
        panel = Panel(Frame(VIEWS["three-quarter"], trace.cost.simulated_time), "")
        small = picture(run, [panel], width=SMALL)
    return ShownCase(f"{folder.name}/{file.name}", small)
