"""Displays of results for notebooks, in the words and the order of the reports; a run has its replay as well."""

import shlex
from collections.abc import Container, Iterable
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from typing import Final, TypeVar

from stability.notebook import Display, Displayed, Printer, bundle, display_of
from stability.work_limit import TooMuchWorkError, limited
from stackdsl.api.written import yaml_text
from stackdsl.checking.cases import SUFFIXES, Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.judge import stop_condition_of
from stackdsl.report.golden_differences import folded_differences
from stackdsl.report.outline import MARKS, Status, failure_lines, result_text, status_of
from stackdsl.report.text import margin_text
from stackdsl.results import GOLDEN_FAILURES, ClaimOutcome, FailureCause, GoldenResult, GoldenStatus, VariantResult
from stackdsl.simulation.recording import Recorder
from stackdsl.trace import Trace
from stackdsl.work import limit

LONGEST: Final = 10.0  # [s] wall time of a run that is played once more for its replay
LARGEST: Final = 4_000_000  # [characters] of a replay within a notebook, which keeps each output
PICTURE: Final = (480.0, 320.0)  # [px] of a planned build
HEIGHT: Final = 720  # [px] of the replay

REMEDIES: Final = {
    GoldenStatus.MISSING: "golden(directory, update=True) writes it",
    GoldenStatus.DIFFERENT: "golden(directory, update=True) accepts the run; stackdsl golden review shows both",
}
GOOD: Final = {Status.PASSED: True, Status.FAILED: False}  # other statuses are neither
Shown = TypeVar("Shown", bound=Displayed)


class Several(tuple[Shown, ...]):
    """Values that a notebook shows below each other."""

    __slots__ = ()

    def _repr_mimebundle_(self, include: Container[str] | None = None, exclude: object = None) -> dict[str, str]:
        """Return all values as text and as HTML, for notebooks."""
        return bundle([*map(display_of, self)], include)

    def _repr_pretty_(self, printer: Printer, cycle: bool) -> None:
        """Print the text, for which IPython asks a tuple in this way."""
        printer.text(bundle([*map(display_of, self)], ())["text/plain"])


def _display(status: Status, title: str, lines: Iterable[tuple[str, str]]) -> Display:
    return Display(title, [*lines], f"{MARKS[status]} {status}", GOOD.get(status))


@display_of.register
def _(case: Case) -> Display:
    """Return the values of a case, where its scenario is, and its YAML."""
    bricks = sum(not placement.hits for placement in case.timeline.placements)
    place = case.written.span_of(("scenario",))
    lines = [*case.parameters, ("system", case.system), ("bricks", str(bricks)), ("scenario", str(place))]
    return Display(case.name, lines, aligned=yaml_text(case.written.values).splitlines(), more=partial(_design, case))


def _design(case: Case) -> str:
    """Return a picture of the planned build; none of a build that takes long to draw."""
    from stackdsl.viewing.pictures import design  # noqa: PLC0415 -- only notebooks need pictures

    try:
        with limited(limit()):
            return design(case.timeline, *PICTURE)
    except TooMuchWorkError:
        return ""


@display_of.register
def _(outcome: ClaimOutcome) -> Display:
    lines = {"expected": outcome.expected, "measured": f"{outcome.measured}{margin_text(outcome)}"}
    lines |= {"why": outcome.why} if outcome.why else {}
    return _display(Status.PASSED if outcome.passed else Status.FAILED, outcome.name, lines.items())


@display_of.register
def result_display(result: VariantResult) -> Display:
    """Return the display of a result: its status, and the lines of its failure."""
    lines = [*failure_lines(result)] or [("result", result_text(result))]
    if result.unchecked:
        why = [(label, text) for label, text in lines if label not in ("expected", "measured", "result")]
        lines = [("result", _verdict_text(result)), *why, ("note", "no expectations, so nothing is checked")]
    return _display(status_of(result), result.name, lines)


def _verdict_text(result: VariantResult) -> str:
    """Return whether the structure stands, and where it collapsed."""
    if result.ensemble is not None:
        return result.ensemble.summary
    return result.collapse.text if result.collapse is not None else result.verdict


@display_of.register
def _(why: FailureCause) -> Display:
    lines = {"why": why.why, "after": why.before, "first": why.first}
    return Display("cause", [(label, text) for label, text in lines.items() if text])


@display_of.register
def _(golden: GoldenResult) -> Display:
    good = False if golden.status in GOLDEN_FAILURES else None
    note = [("note", golden.note)] if golden.note else []
    remedy = REMEDIES.get(golden.status, "") if not note else ""
    helps = [("helps", remedy)] if remedy else []
    changes = folded_differences(golden)
    return Display(golden.file, [*changes, *note, *helps], f"golden file {golden.status}", good)


def lines_display(lines: Iterable[str]) -> Display:
    """Return the display of a study by the lines of its command, of which the first has the answer."""
    answer, *evidence = (line for line in lines if line)
    return Display(answer, aligned=evidence)


def run_display(case: Case, trace: Trace) -> Display:
    """Return the display of a run: its result with the replay."""
    return replace(result_display(judged(case, trace)), more=partial(_replay, case, trace))


def _replay(case: Case, trace: Trace) -> str:
    """Return the replay in a frame that can reach neither the notebook nor a network; else why there is none."""
    if trace.cost.wall_time > LONGEST:
        took = f"computing the run took {trace.cost.wall_time:.0f} s, more than {LONGEST:g} s"
        return _none(f"{took}, and a replay plays it once more", case)
    from stackdsl.viewing.replay.page import replay_page  # noqa: PLC0415 -- only notebooks need pages
    from stackdsl.viewing.run_view import view_of  # noqa: PLC0415 -- likewise

    recorder = Recorder()
    again = play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), recorder=recorder)
    page = replay_page([view_of(case, again, recorder.recording(), judged(case, again))], case.name, framed=True)
    if len(page) > LARGEST:
        return _none(f"it has {len(page) / 1e6:.0f} MB, and a notebook would keep it", case)
    frame = f'width="100%" height="{HEIGHT}" style="border: 1px solid #82827a; border-radius: 8px; margin-top: 8px"'
    return f'<iframe sandbox="allow-scripts" srcdoc="{escape(page)}" title="replay" {frame}></iframe>'


def _none(why: str, case: Case) -> str:
    """Return why there is no replay, and the command that writes one as a page."""
    in_yaml = Path(case.file).suffix in SUFFIXES
    if in_yaml and not case.is_in_file:  # no command selects it
        return f"<p>No replay is shown: {escape(why)}.</p>"
    file = case.file if in_yaml else "scenario.yaml"
    command = escape(shlex.join(["stackdsl", "run", file, "-k", case.name, "--html", "run.html"]))
    first = "" if in_yaml else "<code>Path(&quot;scenario.yaml&quot;).write_text(scenario.to_yaml())</code> and "
    return f"<p>No replay is shown: {escape(why)}. {first}<code>{command}</code> writes it as a page.</p>"
