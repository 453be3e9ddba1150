"""Writes the HTML report of a check: a table of cases with pictures and replays."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Final
from urllib.parse import quote

from stackdsl.checking.cases import Case
from stackdsl.checking.check import CheckConfig
from stackdsl.checking.play_case import play_case, played_or_blocked
from stackdsl.checking.results import judged
from stackdsl.judging.judge import stop_condition_of
from stackdsl.report.text import closing_line, outcome_text, significant, unchecked_text
from stackdsl.results import UNCHECKED, ClaimOutcome, GoldenResult, Report, VariantResult
from stackdsl.shown_text import harmless
from stackdsl.simulation.known_systems import unplayable
from stackdsl.simulation.recording import Recorder
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task, TaskResult
from stackdsl.user_files import make_user_folder, write_user_file
from stackdsl.viewing.check_report.charts import charts
from stackdsl.viewing.drawing import VIEWS, Frame
from stackdsl.viewing.golden_view import golden_view
from stackdsl.viewing.pictures import Panel, picture
from stackdsl.viewing.replay.page import page_of, policy_of, run_json
from stackdsl.viewing.run_view import view_of

# A case played once more for the report: its replay goes to a page, its small picture into the table.


SMALL = 150.0  # [px] width of a small picture
MOST_DRAWN = 300  # bricks of a small picture; more would not be visible


@dataclass(frozen=True, slots=True)
class PlayedCase:
    """A case that was played once more."""

    json: tuple[str, ...]  # for a page: the run, and the view of its golden file, if there is one
    picture: str  # SVG; empty if there are too many bricks for a small one


@dataclass(frozen=True, slots=True)
class ShownCase:
    """The replay and picture of one case."""

    replay: str  # link from the index to the page and the run on it
    picture: str  # SVG; empty if there are too many bricks for a small one


def file_name(name: str) -> str:
    """Return a unique file name for a page of replays, valid on every file system."""
    plain = re.sub(r"[^A-Za-z0-9.=-]+", "-", name).strip("-.")[:80]
    return f"{plain}-{sha256(name.encode()).hexdigest()[:8]}.html"


def show_case(case: Case, golden: GoldenResult | None) -> PlayedCase:
    """Play a case for its page, with the view of its golden file; runs in a worker."""
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), recorder=recorder)
    run = view_of(case, trace, recorder.recording(), judged(case, trace))
    expected = golden_view(golden, run) if golden is not None else None
    small = ""
    if len(run.recording.bricks) <= MOST_DRAWN:
        panel = Panel(Frame(VIEWS["three-quarter"], trace.cost.simulated_time), "")
        small = picture(run, [panel], width=SMALL)
    return PlayedCase(tuple(run_json(view) for view in (run, expected) if view is not None), small)


# The report of a check as one page: a table of all cases, failures first, each with its picture and its replay.
#
# The table is plain HTML, readable without scripts; a small script filters it. Names and texts are escaped, and the
# policy of the page allows only that script.


COLUMNS: Final = ("", "case", "verdict", "expectations", "golden file", "speed, error")


def index_page(report: Report, shown: Mapping[str, ShownCase], unseen: Mapping[str, str]) -> str:
    """Return the page. By name of a case, `shown` has its replay and `unseen` the reason why there is none."""
    script, style = script_and_style()
    policy = policy_of((script,), (style,))
    ranked = sorted(report.results, key=lambda result: (result.conclusion == "passed", result.conclusion == UNCHECKED))
    head = "".join(f"<th>{name}</th>" for name in COLUMNS)
    rows = "\n".join(_row(result, shown.get(result.name), unseen.get(result.name, "")) for result in ranked)
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(closing_line(report))}</title><style>{style}</style></head><body>",
        f"<h1>{escape(closing_line(report))}</h1>",
        *(f'<p class="failed">{escape(str(d.span))}: {escape(d.message)}</p>' for d in report.diagnostics),
        charts(report.results),
        '<p class="filter" hidden>',
        '<input type="search" id="search" placeholder="filter cases by words" aria-label="filter">',
        '<label><input type="checkbox" id="only"> only cases that did not pass</label></p>',
        f'<table id="cases"><thead><tr>{head}</tr></thead><tbody>',
        rows,
        "</tbody></table>",
        f"<script>{script}</script></body></html>",
    ]
    return harmless("\n".join(lines))


def _row(result: VariantResult, shown: ShownCase | None, unseen: str) -> str:
    passed = result.conclusion == "passed"
    name = escape(result.name)
    if shown is not None:
        name = f'<a href="{escape(shown.replay)}">{name}</a>'
    about = "" if shown is not None else f"<br>no replay: {escape(unseen)}" if unseen else ""
    cells = (
        shown.picture if shown is not None else "",
        f"{name}<br>{escape(result.file)}{about}",
        f'<span class="{_style(result)}">{escape(result.conclusion)}</span><br>{_verdict(result)}',
        _outcomes(result),
        _golden(result),
        "<br>".join(map(escape, _measures(result))),
    )
    return f'<tr data-passed="{"yes" if passed else "no"}">' + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"


def _style(result: VariantResult) -> str:
    if result.conclusion == UNCHECKED and not result.must_claim:
        return UNCHECKED
    return "passed" if result.conclusion == "passed" else "failed"


def _verdict(result: VariantResult) -> str:
    fell = f"{result.verdict} at level {result.collapse.level}" if result.collapse is not None else result.verdict
    return escape("; ".join(filter(None, [fell, result.message, *(f"warning: {odd}" for odd in result.warnings)])))


def _outcomes(result: VariantResult) -> str:
    if not result.outcomes:
        return escape(unchecked_text(result)) if result.unchecked else ""
    items = "".join(f"<li>{_outcome(outcome)}</li>" for outcome in result.outcomes)
    count = f"{result.met} of {len(result.outcomes)} met"
    return f"<details{' open' if not result.passed else ''}><summary>{count}</summary><ul>{items}</ul></details>"


def _outcome(outcome: ClaimOutcome) -> str:
    text = f"{outcome.span}: {outcome_text(outcome)}"
    return escape(text) if outcome.passed else f'<span class="failed">{escape(text)}</span>'


def _golden(result: VariantResult) -> str:
    golden = result.golden
    if golden is None:
        return ""
    listed = "".join(
        f"<li>{escape(f'{d.subject} {d.quantity}: expected {d.expected}, got {d.got}')}</li>"
        for d in golden.differences
    )
    return escape(golden.status.value) + (f"<ul>{listed}</ul>" if listed else "")


def _measures(result: VariantResult) -> Iterator[str]:
    if result.cost is not None:
        yield f"{significant(result.cost.wall_time)} s for {significant(result.cost.simulated_time)} s"
    if result.verdict:
        yield f"drift {significant(1000.0 * result.drift)} mm"
    if result.truths:
        yield "agrees with the reference" if result.truth_agrees else "disagrees with the reference"


def script_and_style() -> tuple[str, str]:
    """Return the script and the style of the page."""
    return _packaged("report.js"), _packaged("report.css")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.check_report").joinpath(name).read_text(encoding="utf-8")


# Writes the report of a check to a folder: all cases are played once more and recorded, in supervised processes.


REPLAYS: Final = "replays"


def write_folder(
    report: Report,
    cases: Sequence[Case],
    folder: Path,
    terms: CheckConfig,
    on_done: Callable[[Case], None] = lambda case: None,
) -> Path:
    """Write the replays of all cases and their index; return the path of the index. Raises OSError.

    All systems of a case share a page, where two of them can be shown side by side.
    """
    make_user_folder(folder / REPLAYS)
    playable = [case for case in cases if case.skip is None and not unplayable(case.system)]
    golden = {result.name: result.golden for result in report.results}
    tasks = [Task(played_or_blocked, (show_case, case, golden.get(case.name)), terms.time_limit) for case in playable]
    pages = _Pages(folder, playable)

    def done(number: int, result: TaskResult) -> None:
        pages.take(number, result)
        on_done(playable[number])

    run_supervised(tasks, terms.workers, done, terms.on_wait)
    index = folder / "index.html"
    write_user_file(index, index_page(report, pages.shown, pages.unseen).encode(), folder)
    return index


@dataclass
class _Pages:
    """The pages of replays; each is written as soon as all its cases are played."""

    folder: Path
    cases: Sequence[Case]
    shown: dict[str, ShownCase] = field(default_factory=dict)  # by case
    unseen: dict[str, str] = field(default_factory=dict)  # reason why there is no replay, by case
    _json: dict[int, tuple[str, ...]] = field(default_factory=dict)  # by number of a case, until its page is written
    _groups: dict[str, list[int]] = field(default_factory=dict)  # cases of a page, by its name

    def __post_init__(self) -> None:
        for number, case in enumerate(self.cases):
            self._groups.setdefault(_page_name(case), []).append(number)

    def take(self, number: int, result: TaskResult) -> None:
        """Take the result of a played case; write its page if it was the last one of it."""
        case = self.cases[number]
        page = _page_name(case)
        file = f"{REPLAYS}/{file_name(page)}"
        if isinstance(result.value, PlayedCase):
            self._json[number] = result.value.json
            self.shown[case.name] = ShownCase(f"{quote(file)}#{quote(case.name)}", result.value.picture)
        else:
            self._json[number] = ()
            self.unseen[case.name] = result.message or result.status.value
        group = self._groups[page]
        if self._json.keys() >= {*group}:
            runs = [text for each in group for text in self._json.pop(each)]
            write_user_file(self.folder / file, page_of(runs, page).encode(), self.folder)


def _page_name(case: Case) -> str:
    """Return the name of the page of a case, which all systems share."""
    chosen = ",".join(f"{name}={text}" for name, text in case.parameters)
    return f"{case.scenario_name}[{chosen}]" if chosen else case.scenario_name
