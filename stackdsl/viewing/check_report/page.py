"""Writes the HTML report of a check: a table of cases with pictures and replays."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from html import escape
from importlib.metadata import version as version_of
from importlib.resources import files
from pathlib import Path
from typing import Final
from urllib.parse import quote

from stackdsl.checking.cases import Case
from stackdsl.checking.check import CheckConfig
from stackdsl.checking.play_case import play_case, played_or_blocked
from stackdsl.checking.results import judged
from stackdsl.diagnostics import Diagnostic
from stackdsl.judging.judge import stop_condition_of
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.report.golden_differences import folded_differences
from stackdsl.report.outline import (
    CaseRow,
    Group,
    Status,
    counts_of,
    engine_warning,
    failure_lines,
    headline,
    nearest,
    outline,
    result_text,
    see_line,
)
from stackdsl.report.text import ending_text
from stackdsl.report.warnings import unclear_text
from stackdsl.results import GoldenResult, Report, RunStatus, VariantResult
from stackdsl.shown_text import harmless
from stackdsl.simulation.known_systems import unplayable
from stackdsl.simulation.recording import Recorder
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task, TaskResult
from stackdsl.trace import Trace
from stackdsl.user_files import make_user_folder, write_user_file
from stackdsl.viewing.check_report.charts import charts
from stackdsl.viewing.drawing import VIEWS, Frame
from stackdsl.viewing.golden_view import golden_view
from stackdsl.viewing.pictures import thumbnail
from stackdsl.viewing.replay.page import page_of, policy_of, run_json, shown_run
from stackdsl.viewing.run_view import view_of
from stackdsl.viewing.style import icon, icon_sprite, shared_style
from stackdsl.viewing.svg import dark_rules
from stackdsl.wording import how_many

# A case played once more for the report: its replay goes to a page, its small picture into the table.


SMALL = (240.0, 180.0)  # [px] size of a small picture
FALLING = 0.12  # [s] from the start of a collapse to its picture
MOST_DRAWN = 300  # bricks of a small picture; more would not be visible


@dataclass(frozen=True, slots=True)
class PlayedCase:
    """A case that was played once more."""

    json: tuple[str, ...]  # for a page: the run, and the view of its golden file, if there is one
    still: str  # HTML for browsers without JavaScript
    picture: str  # SVG; empty if there are too many bricks for a small one
    about: str  # time of the picture


@dataclass(frozen=True, slots=True)
class ShownCase:
    """The replay and picture of one case."""

    replay: str  # link from the index to the page and the run on it
    picture: str  # SVG; empty if there are too many bricks for a small one
    about: str = ""  # time of the picture


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
        small = thumbnail(run, Frame(VIEWS["three-quarter"], _telling(trace)), *SMALL)
    shown = shown_run(run)
    views = (shown.json,) if expected is None else (shown.json, run_json(expected))
    return PlayedCase(views, shown.still, small, f"at {seconds(_telling(trace))}")


def _telling(trace: Trace) -> float:
    """Return the time of the picture [s]: during a collapse, or the end."""
    end = trace.cost.simulated_time
    return end if trace.collapse is None else min(end, trace.collapse.time + FALLING)


def seconds(time: float) -> str:
    """Format a time [s] for people."""
    return f"{time:.1f} s" if time >= 1.0 else f"{time:.2f} s"


# The report of a check as one page: the verdict, charts, and the cases by scenario, failures first and open.
#
# The page is plain HTML, readable without scripts; a small script filters and sorts it. Names and texts are escaped,
# and the policy of the page allows only that script.


@dataclass(frozen=True, slots=True)
class Origin:
    """The origin of a report."""

    project: str = ""
    commit: str = ""
    date: str = ""
    command: str = ""
    shard: str = ""  # such as `1/4`; empty for all cases


ICONS: Final = {
    Status.FAILED: ("failed", "failed"),
    Status.DIFFERS: ("differs", "differs"),
    Status.EXPECTED_FAILURE: ("disagrees", "disagrees"),
    Status.UNCHECKED: ("disagrees", "differs"),
    Status.NOT_RUN: ("skipped", "skipped"),
    Status.SKIPPED: ("skipped", "skipped"),
    Status.PASSED: ("passed", "passed"),
}  # icon and style class of each status
OPEN: Final = (Status.FAILED, Status.DIFFERS)  # statuses that the page shows at first
MOST_OPEN = 3  # rows whose details are open at first
AROUND = 1  # lines of YAML shown above and below the claim
MOST_NEAREST = 5  # cases listed as nearest to failing
NEAR = 0.5  # share of the limit within which a margin is near


@dataclass(frozen=True, slots=True)
class ReportPage:
    """The data of the page: the report, and by name of a case its replay or the reason why there is none."""

    report: Report
    shown: Mapping[str, ShownCase]
    unseen: Mapping[str, str]
    sources: Mapping[str, str] = field(default_factory=dict)  # texts of scenario files
    origin: Origin = Origin()

    def html(self) -> str:
        """Return the page."""
        script, style = script_and_style()
        title = self._title()
        lines = [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy_of((script,), (style,))}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)} - StackDSL check</title><style>{style}</style></head><body>",
            icon_sprite(),
            self._top(),
            "<main>",
            self._hero(title),
            *(self._mistake(found) for found in self.report.diagnostics),
            charts(self.report.results),
            "" if self._failed else self._cards(),
            *(self._cases() if self.report.results else ()),
            self._cards() if self._failed else "",
            self._notes(),
            f"</main><script>{script}</script></body></html>",
        ]
        return harmless("\n".join(filter(None, lines)))

    def _title(self) -> str:
        title = headline(self.report)
        return f"Shard {self.origin.shard}: {title[0].lower()}{title[1:]}" if self.origin.shard else title

    def _cases(self) -> Iterator[str]:
        yield '<section id="cases"><h2>Cases</h2>'
        yield self._tools()
        yield from (self._group(group) for group in outline(self.report))
        yield '<p class="none" hidden>No case matches. <button class="button" id="reset">Show all</button></p>'
        yield "</section>"

    @property
    def _failed(self) -> bool:
        """Return True if a case failed or a golden file differs; the page then begins with charts and these cases."""
        counts = counts_of(self.report.results)
        return any(counts[status] for status in OPEN)

    def _top(self) -> str:
        command = self.origin.command
        copied = f'<span class="command"><code>{escape(command)}</code>{_copy(command)}</span>' if command else ""
        return f'<header class="top"><b>{escape(self.origin.project or "StackDSL")}</b> check report{copied}</header>'

    def _hero(self, title: str) -> str:
        report, counts = self.report, counts_of(self.report.results)
        worst = next((status for status in Status if counts[status]), Status.SKIPPED)
        if report.diagnostics:
            worst = Status.FAILED
        elif report.interrupted and worst not in OPEN:
            worst = Status.UNCHECKED
        elif worst in (Status.EXPECTED_FAILURE, Status.UNCHECKED) and counts[Status.PASSED]:
            worst = Status.PASSED
        name, style = ICONS[worst]
        systems = ", ".join(dict.fromkeys(result.system for result in report.results))
        remembered = sum(result.remembered for result in report.results)
        facts = [
            f"StackDSL {version_of('stackdsl')}",
            self.origin.date,
            f"took {seconds(report.wall_time)}",
            f"{how_many(report.scenarios, 'scenario')} in {how_many(len({r.file for r in report.results}), 'file')}",
            f"on {systems}" if systems else "",
            f"{how_many(remembered, 'result')} remembered, not played again" if remembered else "",
            f"commit {self.origin.commit}" if self.origin.commit else "",
            f"{report.left} not run after a failure" if report.left else "",
            "without replays, since the check was interrupted" if report.interrupted else "",
        ]
        told = "".join(f"<li>{escape(fact)}</li>" for fact in facts if fact)
        bar, at = "", 0
        legend = ", ".join(f"{count} {status}" for status, count in counts.items() if count)
        for status, count in counts.items():
            bar += f'<rect class="{ICONS[status][1]}" x="{at}" width="{count}" height="1"/>' if count else ""
            at += count
        return (
            f'<div class="hero"><h1 class="{style}">{icon(name).replace("icon", "icon large", 1)} {escape(title)}</h1>'
            f'<ul class="facts">{told}</ul><svg class="bar" viewBox="0 0 {max(at, 1)} 1" preserveAspectRatio="none"'
            f' role="img" aria-label="{legend}"><title>{legend}</title>{bar}</svg></div>'
        )

    def _mistake(self, found: Diagnostic) -> str:
        text = diagnostic_text(found)
        return f'<pre class="mistake">{escape(text)}</pre>'

    def _cards(self) -> str:
        near = [each for each in nearest(self.report.results) if each.share is not None and each.share < NEAR]
        rows = "".join(
            f"<tr><td>{_name(each.result.name)}</td><td>{escape(each.text)}</td>"
            f'<td class="number">{100.0 * (each.share or 0.0):.1f} % of its limit</td></tr>'
            for each in near[:MOST_NEAREST]
        )
        slow = sorted((r for r in self.report.results if r.cost), key=lambda r: -(r.cost.wall_time if r.cost else 0.0))
        slowest = "".join(
            f'<tr><td>{_name(result.name)}</td><td class="number">{seconds(result.cost.wall_time)}</td></tr>'
            for result in slow[:MOST_NEAREST]
            if result.cost is not None
        )
        cards = {"Nearest to failing": rows, "Slowest": slowest}
        told = "".join(
            f'<div class="card"><h3>{title}</h3><table>{body}</table></div>' for title, body in cards.items() if body
        )
        return f'<section class="cards">{told}</section>' if told else ""

    def _tools(self) -> str:
        counts = counts_of(self.report.results)
        chips = "".join(
            f'<button class="button {ICONS[status][1]}" data-status="{status}"'
            f' aria-pressed="{_said(self._shows(status))}">{icon(ICONS[status][0])}{count} {status}</button>'
            for status, count in counts.items()
            if count
        )
        systems = dict.fromkeys(result.system for result in self.report.results)
        choices = "".join(f"<option>{escape(system)}</option>" for system in systems)
        chosen = f'<label>System <select id="system"><option value="">all</option>{choices}</select></label>'
        return (
            f'<div class="tools" hidden><div class="chips">{chips}</div>'
            f'<label class="find">{icon("search")}<input type="search" id="search" aria-label="Search"'
            f' placeholder="Name, brick, file or word"></label>{chosen if len(systems) > 1 else ""}'
            '<label>Order <select id="order"><option value="rank">worst first</option>'
            '<option value="name">name</option><option value="time">slowest first</option></select></label></div>'
        )

    def _shows(self, status: Status) -> bool:
        counts = counts_of(self.report.results)
        if any(counts[each] for each in OPEN):
            return status in OPEN
        return status is not Status.NOT_RUN or counts[Status.NOT_RUN] == len(self.report.results)

    def _group(self, group: Group) -> str:
        counts = "".join(
            f'<span class="{ICONS[status][1]}">{icon(ICONS[status][0])}{group.count(status)} {status}</span>'
            for status in Status
            if group.count(status)
        )
        rows = "".join(self._row(row, number < MOST_OPEN) for number, row in enumerate(group.rows))
        return (
            f'<article class="group" data-name="{escape(group.scenario)}" data-time="{group.wall_time:.6f}">'
            f"<header><h3>{_name(group.scenario)}</h3><code>{_name(group.file)}</code>"
            f'<span class="counts">{counts}<span class="number">{_took(group.wall_time)}</span></span></header>'
            f"{rows}</article>"
        )

    def _row(self, row: CaseRow, early: bool) -> str:
        result, (name, style) = row.first, ICONS[row.status]
        values = "".join(f'<span class="tag">{escape(key)}={escape(text)}</span>' for key, text in result.parameters)
        systems = "".join(f'<span class="tag system">{escape(each.system)}</span>' for each in row.results)
        word = result.conclusion if row.status is Status.FAILED else str(row.status)
        count = f"{len(row.results)} {word}" if len(row.results) > 1 else word
        told = result_text(result)
        words = " ".join(each.name for each in row.results)
        opened = " open" if early and row.status in OPEN else ""
        return (
            f'<details class="row" data-status="{row.status}" data-words="{escape(f"{words} {result.file}")}"'
            f' data-systems="{escape(" ".join(each.system for each in row.results))}"{opened}>'
            f'<summary><span class="status {style}">{icon(name)}{escape(count)}</span>'
            f"<span>{values}{systems}</span><span>{'' if told == word else escape(told)}</span>"
            f'<span class="margin">{escape(self._margin(row))}</span>'
            f'<span class="number">{_took(row.wall_time)}</span></summary>{self._details(row)}</details>'
        )

    def _margin(self, row: CaseRow) -> str:
        failed = next((outcome for outcome in row.first.outcomes if not outcome.passed), None)
        if failed is not None:
            return f"{failed.name}: {failed.expected}"
        near = nearest(row.results)
        return near[0].text if near else ""

    def _details(self, row: CaseRow) -> str:
        result, shown = row.first, self.shown.get(row.first.name)
        lines = [(label, escape(text)) for label, text in failure_lines(result)]
        if not lines:
            lines = [
                ("expected", escape(f"{outcome.name}: {outcome.expected}") + f"<br>measured {escape(outcome.measured)}")
                for outcome in result.outcomes
            ]
        told = "".join(f"<dt>{label.capitalize()}</dt><dd>{text}</dd>" for label, text in lines)
        told = f"<dl>{told}</dl>" if told else ""
        picture = (
            f"<figure>{shown.picture}<figcaption>{escape(shown.about)}</figcaption></figure>"
            if shown and shown.picture
            else ""
        )
        return (
            f'<div class="details {ICONS[row.status][1]}">{picture}<div>{told}{self._excerpt(row)}'
            f"{_differences(result)}{self._see(row)}{_facts(row)}</div></div>"
        )

    def _excerpt(self, row: CaseRow) -> str:
        """Return the lines of the YAML around the first failed claim."""
        failed = next((outcome for outcome in row.first.outcomes if not outcome.passed), None)
        if failed is None or failed.span.file not in self.sources:
            return ""
        lines, number = self.sources[failed.span.file].splitlines(), failed.span.line
        shown = "".join(
            f"<div{' class=meant' if each == number else ''}><i>{each}</i>{escape(lines[each - 1])}</div>"
            for each in range(max(1, number - AROUND), min(len(lines), number + AROUND) + 1)
        )
        return f'<div class="source"><b>{escape(str(failed.span))}</b>{shown}</div>'

    def _see(self, row: CaseRow) -> str:
        links = [
            f'<a class="button primary" href="{escape(self.shown[each.name].replay)}">{icon("play")}'
            f"Replay{f' on {escape(each.system)}' if len(row.results) > 1 else ''}</a>"
            for each in row.results
            if each.name in self.shown
        ]
        links += [
            f"<span>no replay: {escape(self.unseen[each.name])}</span>"
            for each in row.results
            if each.name in self.unseen and each.status is RunStatus.DONE  # else the failure is told already
        ]
        _, command = see_line(row.first, "run.html")
        see = f'<p class="see">{"".join(links)}<code>{escape(command)}</code>{_copy(command)}</p>'
        if not row.first.traceback:
            return see
        traceback = f"<summary>Traceback</summary><pre>{escape(row.first.traceback)}</pre>"
        return f'{see}<details class="traceback">{traceback}</details>'

    def _notes(self) -> str:
        notes = [
            ("disagree with the reference", [r for r in self.report.results if r.truth_agrees is False]),
            ("have a warning on the engine", [r for r in self.report.results if _engine_warning(r)]),
            ("ended early, as every claim was decided", [r for r in self.report.results if r.early_end is not None]),
            (
                "have a claim that rests on bricks whose fate is unclear",
                [r for r in self.report.results if _unclear(r)],
            ),
            ("have a warning on their files", [r for r in self.report.results if r.warnings]),
        ]
        cards = "".join(
            f'<details class="card"><summary>{icon("disagrees")}{how_many(len(found), "case")} {text}</summary><ul>'
            + "".join(f"<li>{_name(each.name)}{escape(_note(each))}</li>" for each in found)
            + "</ul></details>"
            for text, found in notes
            if found
        )
        return f'<section class="notes"><h2>Notes that fail nothing</h2>{cards}</section>' if cards else ""


def _unclear(result: VariantResult) -> list[str]:
    return [unclear_text(outcome) for outcome in result.outcomes if outcome.passed and outcome.unclear]


def _engine_warning(result: VariantResult) -> str:
    return f"a numerical collapse: {result.numerical}" if result.numerical else engine_warning(result)


def _note(result: VariantResult) -> str:
    texts = [
        f"{outcome.name}: {outcome.expected}, measured {outcome.measured}"
        for outcome in result.truths
        if not outcome.passed
    ]
    texts += [_engine_warning(result), *map(str, result.warnings), *_unclear(result)]
    texts += [ending_text(result.early_end)] if result.early_end is not None else []
    told = "; ".join(filter(None, texts))
    return f": {told}" if told else ""


def _took(time: float) -> str:
    return seconds(time) if time else ""


def _said(true: bool) -> str:
    return "true" if true else "false"


def _name(text: str) -> str:
    """Return a name that may wrap after its separators and nowhere within a word."""
    return re.sub(r"([\[,/])", r"\1<wbr>", escape(text))


def _copy(text: str) -> str:
    return f'<button class="button copy" hidden data-copy="{escape(text)}" title="copy">{icon("copy", "copy")}</button>'


def _differences(result: VariantResult) -> str:
    """Return the differences from a golden file as a table of observations, with equal changes together."""
    if result.golden is None or not result.golden.differences:
        return ""
    rows = "".join(
        f"<tr><td>{escape(quantity)}</td><td>{_name(told)}</td></tr>"
        for quantity, told in folded_differences(result.golden)
    )
    head = "<tr><th>observation</th><th>golden file -&gt; this run</th></tr>"
    review = "stackdsl golden review"
    decide = f'<p class="see">Decide: <code>{review}</code>{_copy(review)}</p>'
    return f'<table class="differences">{head}{rows}</table>{decide}'


def _facts(row: CaseRow) -> str:
    result, facts = row.first, list[str]()
    if result.cost is not None and result.is_one_run:
        facts.append(f"played {seconds(result.cost.simulated_time)}")
        facts.append(
            f"{result.cost.steps} steps of {result.engine or 'no engine'}" if result.cost.steps else "no engine needed"
        )
    if result.early_end is not None:
        facts.append(ending_text(result.early_end))
    if result.golden is not None:
        facts.append(f"golden file: {result.golden.status.value}")
    if result.xfail is not None:
        facts.append(f"xfail: {result.xfail}")
    return f'<ul class="facts">{"".join(f"<li>{escape(fact)}</li>" for fact in facts)}</ul>' if facts else ""


def index_page(
    report: Report,
    shown: Mapping[str, ShownCase],
    unseen: Mapping[str, str],
    sources: Mapping[str, str] | None = None,
    origin: Origin = Origin(),
) -> str:
    """Return the page. By name of a case, `shown` has its replay and `unseen` the reason why there is none."""
    return ReportPage(report, shown, unseen, sources or {}, origin).html()


def script_and_style() -> tuple[str, str]:
    """Return the script and the style of the page."""
    return _packaged("report.js"), shared_style() + dark_rules() + _packaged("report.css")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.check_report").joinpath(name).read_text(encoding="utf-8")


# Writes the report of a check to a folder: all cases are played once more and recorded, in supervised processes.


REPLAYS: Final = "replays"


def write_folder(  # noqa: PLR0913, PLR0917 -- what the page says, and how it is made
    report: Report,
    cases: Sequence[Case],
    folder: Path,
    terms: CheckConfig,
    on_done: Callable[[Case], None] = lambda case: None,
    origin: Origin = Origin(),
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
    page = index_page(report, pages.shown, pages.unseen, _sources(report), origin)
    write_user_file(index, page.encode(), folder)
    return index


def _sources(report: Report) -> Mapping[str, str]:
    """Return the texts of the files with failed claims; a file that cannot be read has none."""
    texts = {}
    for file in {each.span.file for result in report.results for each in result.outcomes if not each.passed}:
        try:
            texts[file] = Path(file).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            continue
    return texts


@dataclass
class _Pages:
    """The pages of replays; each is written as soon as all its cases are played."""

    folder: Path
    cases: Sequence[Case]
    shown: dict[str, ShownCase] = field(default_factory=dict)  # by case
    unseen: dict[str, str] = field(default_factory=dict)  # reason why there is no replay, by case
    _played: dict[int, PlayedCase | None] = field(
        default_factory=dict
    )  # by number of a case, until its page is written
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
            self._played[number] = result.value
            self.shown[case.name] = ShownCase(
                f"{quote(file)}#{quote(case.name)}", result.value.picture, result.value.about
            )
        else:
            self._played[number] = None
            self.unseen[case.name] = result.message or result.status.value
        group = self._groups[page]
        if self._played.keys() >= {*group}:
            played = [one for each in group if (one := self._played.pop(each)) is not None]
            runs, stills = [text for one in played for text in one.json], [one.still for one in played]
            write_user_file(self.folder / file, page_of(runs, page, stills=stills).encode(), self.folder)


def _page_name(case: Case) -> str:
    """Return the name of the page of a case, which all systems share."""
    chosen = ",".join(f"{name}={text}" for name, text in case.parameters)
    return f"{case.scenario_name}[{chosen}]" if chosen else case.scenario_name
