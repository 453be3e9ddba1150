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

from stackdsl.asked_files import make_asked, write_asked
from stackdsl.checking.cases import Case
from stackdsl.checking.check import CheckConfig
from stackdsl.checking.play_case import play_case, played_or_blocked
from stackdsl.checking.results import judged
from stackdsl.judging.judge import known_of
from stackdsl.report.text import closing_line, outcome_text, significant, unchecked_text
from stackdsl.results import UNCHECKED, ClaimOutcome, GoldenResult, Report, VariantResult
from stackdsl.shown_text import harmless
from stackdsl.simulation.known_systems import unplayable
from stackdsl.simulation.recording import Recorder
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task, TaskResult
from stackdsl.viewing.check_report.charts import charts
from stackdsl.viewing.drawing import VIEWS, Frame
from stackdsl.viewing.golden_view import golden_view
from stackdsl.viewing.pictures import Panel, picture
from stackdsl.viewing.replay.page import page_of, policy_of, told
from stackdsl.viewing.run_view import view_of

# A case played once more to be looked at: its replay goes to a page, its small picture into the report.


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


# The report of a check as one page: a table of all cases, failures first, each with its picture and its replay.
#
# The table is plain HTML, which needs no script; a small one filters it. Names and texts are escaped, and the policy of
# the page lets nothing run but that script.


COLUMNS: Final = ("", "case", "verdict", "expectations", "golden file", "speed, error")


def index_page(report: Report, shown: Mapping[str, ShownCase], unseen: Mapping[str, str]) -> str:
    """The page; `shown` and `unseen` say by the name of a case what there is to look at, or why there is nothing."""
    script, style = script_and_style()
    policy = policy_of((script,), (style,))
    found = sorted(report.results, key=lambda result: (result.conclusion == "passed", result.conclusion == UNCHECKED))
    head = "".join(f"<th>{name}</th>" for name in COLUMNS)
    rows = "\n".join(_row(result, shown.get(result.name), unseen.get(result.name, "")) for result in found)
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
        '<input type="search" id="search" placeholder="words of a case" aria-label="filter">',
        '<label><input type="checkbox" id="only"> only what did not pass</label></p>',
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
    told = "".join(f"<li>{_outcome(outcome)}</li>" for outcome in result.outcomes)
    count = f"{result.met} of {len(result.outcomes)} hold"
    return f"<details{' open' if not result.passed else ''}><summary>{count}</summary><ul>{told}</ul></details>"


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
        yield "as known from outside" if result.truth_agrees else "other than known from outside"


def script_and_style() -> tuple[str, str]:
    """What every such page is made of."""
    return _packaged("report.js"), _packaged("report.css")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.check_report").joinpath(name).read_text(encoding="utf-8")


# Writes the report of a check into a folder: cases are played once more, recorded, in supervised processes.


REPLAYS: Final = "replays"


def write_folder(
    report: Report,
    cases: Sequence[Case],
    folder: Path,
    terms: CheckConfig,
    on_done: Callable[[Case], None] = lambda case: None,
) -> Path:
    """Write the replays of all cases and the index of them; returns the index. Raises OSError.

    All systems that play the same share a page, where any two of them can be seen side by side.
    """
    make_asked(folder / REPLAYS)
    playable = [case for case in cases if case.skip is None and not unplayable(case.system)]
    golden = {result.name: result.golden for result in report.results}
    tasks = [Task(played_or_blocked, (show_case, case, golden.get(case.name)), terms.time_limit) for case in playable]
    pages = _Pages(folder, playable)

    def done(number: int, result: TaskResult) -> None:
        pages.take(number, result)
        on_done(playable[number])

    run_supervised(tasks, terms.workers, done, terms.on_wait)
    index = folder / "index.html"
    write_asked(index, index_page(report, pages.shown, pages.unseen).encode(), folder)
    return index


@dataclass
class _Pages:
    """The pages of replays, each written once all that belongs on it is there."""

    folder: Path
    cases: Sequence[Case]
    shown: dict[str, ShownCase] = field(default_factory=dict)  # by case
    unseen: dict[str, str] = field(default_factory=dict)  # why there is nothing to look at, by case
    _told: dict[int, tuple[str, ...]] = field(default_factory=dict)  # by number of a case, until its page is written
    _groups: dict[str, list[int]] = field(default_factory=dict)  # cases of a page, by what it is called

    def __post_init__(self) -> None:
        for number, case in enumerate(self.cases):
            self._groups.setdefault(_page_name(case), []).append(number)

    def take(self, number: int, result: TaskResult) -> None:
        """What became of a case that was to be played."""
        case = self.cases[number]
        page = _page_name(case)
        file = f"{REPLAYS}/{file_name(page)}"
        if isinstance(result.value, PlayedCase):
            self._told[number] = result.value.told
            self.shown[case.name] = ShownCase(f"{quote(file)}#{quote(case.name)}", result.value.picture)
        else:
            self._told[number] = ()
            self.unseen[case.name] = result.message or result.status.value
        group = self._groups[page]
        if self._told.keys() >= {*group}:
            told = [text for each in group for text in self._told.pop(each)]
            write_asked(self.folder / file, page_of(told, page).encode(), self.folder)


def _page_name(case: Case) -> str:
    """What the page of a case is called, which all systems that play the same share."""
    chosen = ",".join(f"{name}={text}" for name, text in case.parameters)
    return f"{case.scenario_name}[{chosen}]" if chosen else case.scenario_name
