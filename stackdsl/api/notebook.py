"""HTML of scenarios and runs, for notebooks: the verdict with its cause, and the replay in a frame of its own."""

from html import escape
from typing import Final

from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.judge import stop_condition_of
from stackdsl.report.outline import failure_lines, result_text, status_of
from stackdsl.simulation.recording import Recorder
from stackdsl.trace import Trace

LONGEST: Final = 10.0  # [s] wall time of a run that is played once more for its replay
LARGEST: Final = 4_000_000  # [characters] of a replay within a notebook, which keeps each output
HEIGHT: Final = 520  # [px] of the replay
COLOURS: Final = {"passed": "#17683f", "failed": "#b3261e"}  # of the verdict; others are grey


def run_html(case: Case, trace: Trace) -> str:
    """Return the verdict of a run, the lines of its failure, and its replay."""
    result = judged(case, trace)
    status = str(status_of(result))
    head = f'<b style="color: {COLOURS.get(status, "#565b62")}">{escape(status)}</b> {escape(case.name)}'
    lines = [*failure_lines(result)] or [("result", result_text(result))]
    rows = "".join(
        f'<tr><td>{label}</td><td style="text-align: left">{escape(text)}</td></tr>' for label, text in lines
    )
    return f"<div>{head}<table>{rows}</table>{_replay(case, trace)}</div>"


def _replay(case: Case, trace: Trace) -> str:
    """Return the replay in a frame that can reach neither the notebook nor a network; else why there is none."""
    if trace.cost.wall_time > LONGEST:
        return _none(f"the run took {trace.cost.wall_time:.0f} s, and a replay plays it once more")
    from stackdsl.viewing.replay.page import replay_page  # noqa: PLC0415 -- only notebooks need pages
    from stackdsl.viewing.run_view import view_of  # noqa: PLC0415 -- likewise

    recorder = Recorder()
    again = play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), recorder=recorder)
    page = replay_page([view_of(case, again, recorder.recording(), judged(case, again))], case.name)
    if len(page) > LARGEST:
        return _none(f"its replay has {len(page) / 1e6:.0f} MB")
    frame = f'width="100%" height="{HEIGHT}" style="border: 1px solid #82827a; border-radius: 8px"'
    return f'<iframe sandbox="allow-scripts" srcdoc="{escape(page)}" title="replay" {frame}></iframe>'


def _none(why: str) -> str:
    return f"<p>No replay is shown: {escape(why)}. <code>stackdsl run FILE --html run.html</code> writes one.</p>"
