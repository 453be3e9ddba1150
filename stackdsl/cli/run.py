"""`stackdsl run`: plays one file and prints its events as they happen."""

import os
import shlex
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING, NoReturn

import click

from stackdsl.checking.cases import STDIN, Case, GatheredCases, gather
from stackdsl.checking.play_case import play_case, played_or_blocked
from stackdsl.checking.results import blocked_result, judged, marked_skipped, skipped, stopped
from stackdsl.checking.selection import Selection, nothing_selected_text
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import (
    LONGEST_LIMIT,
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    complain,
    prepare_file,
    selected_of,
    unwritable,
)
from stackdsl.cli.terminal import counted, tell, with_known_marks, write, write_wrapped
from stackdsl.diagnostics import Diagnostic
from stackdsl.entry_points import PluginError
from stackdsl.exits import ExitCode
from stackdsl.judging.judge import stop_condition_of
from stackdsl.report.check_text import LABEL
from stackdsl.report.outline import MARKS, Status, failure_lines, see_line
from stackdsl.report.text import EventLines, claim_lines, run_text
from stackdsl.report.warnings import ensemble_lines
from stackdsl.results import Report, VariantResult, exit_code
from stackdsl.shown_text import harmless
from stackdsl.simulation.brick_tracks import Blocked, BlockedPlacementError
from stackdsl.simulation.known_systems import unplayable
from stackdsl.supervising.processes import EnoughSeenError, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, crash
from stackdsl.trace import Event, Trace
from stackdsl.user_files import write_user_file
from stackdsl.viewing.live import (
    INTERVAL,
    Margined,
    Played,
    RunPage,
    Stamps,
    is_saved_since,
    margined,
    mistake_json,
    played,
    preview,
    read_whole,
    showing,
    stamps_of,
    warm_up,
)
from stackdsl.viewing.replay.page import live_page
from stackdsl.viewing.server import OnePage

if TYPE_CHECKING:
    from stackdsl.simulation.recording import Recorder
    from stackdsl.viewing.run_view import RunView


# Output files of `run`: recorded poses as arrays, a 3D file, and a page with a replay.


ON_RECORD = click.option(
    "--record", type=FilePath, help="Write the poses of the bricks of one case to this .npz file, as numpy arrays."
)
ON_GLB = click.option("--glb", type=FilePath, help="Write the run of one case to this .glb file, for 3D programs.")
ON_HTML = click.option("--html", type=FilePath, help="Write a page with a replay to this .html file.")


@dataclass
class RunOutputs:
    """The requested outputs of `run`, and the runs played so far."""

    record: Path | None
    html: Path | None
    glb: Path | None
    _runs: "list[RunView]" = field(default_factory=list)

    @classmethod
    def of(cls, record: Path | None, html: Path | None, glb: Path | None, selected: Sequence[Case]) -> "RunOutputs":
        """Return the outputs for these cases. Raises UsageError for an impossible output."""
        for option, path in (("--record", record), ("--glb", glb)):
            if path is not None and len(selected) > 1:
                told = f"{option} writes one run, but {len(selected)} are selected"
                raise click.UsageError(f"{told}; choose one with --system or -k, such as -k '{selected[0].name}'")
        if glb is not None and find_spec("pygltflib") is None:
            raise click.UsageError("--glb needs pygltflib, which is not installed; try: pip install 'stackdsl[gltf]'")
        for path, suffix in ((record, ".npz"), (html, ".html"), (glb, ".glb")):
            if path is not None and path.suffix.lower() != suffix:
                valid = path.with_suffix(suffix) if path.name else Path(f"run{suffix}")
                raise click.UsageError(f"{path} must end in {suffix}; write {valid}")
            if path is not None:
                prepare_file(path)
        return cls(record, html, glb)

    def recorder(self) -> "Recorder | None":
        """Return the recorder of the next run, if one is needed."""
        if self.record is self.html is self.glb is None:
            return None
        from stackdsl.simulation.recording import Recorder  # noqa: PLC0415 -- most runs are not recorded

        return Recorder()

    def played(self, case: Case, trace: Trace, recorder: "Recorder | None", result: VariantResult) -> None:
        """Store a run."""
        if recorder is None:
            return
        recording = recorder.recording()
        if self.record is not None:
            buffer = BytesIO()
            recording.save(buffer)
            write_file(self.record, buffer.getvalue())
        if self.glb is not None:
            from stackdsl.viewing.gltf import glb  # noqa: PLC0415 -- an optional extra

            write_file(self.glb, glb(recording))
        if self.html is not None:
            from stackdsl.viewing.run_view import view_of  # noqa: PLC0415 -- most runs have no page

            self._runs.append(view_of(case, trace, recording, result))

    def write(self) -> None:
        """Write the page of all runs."""
        if self.html is None or not self._runs:
            return
        from stackdsl.viewing.replay.page import replay_page  # noqa: PLC0415 -- likewise

        write_file(self.html, replay_page(self._runs, self._runs[0].name).encode())


def write_file(path: Path, data: bytes) -> None:
    """Write a requested file and report it. Raises click.ClickException if it cannot be written."""
    try:
        write_user_file(path, data)
    except OSError as error:
        raise unwritable(path, error) from error
    tell(f"wrote {path}, {max(1, round(len(data) / 1000)):,} kB")


# `stackdsl run --watch`: plays a file at each save, and shows it in a page that updates itself.
#
# A save during a run ends the run, so that the page shows the current file. If that has a mistake, the page shows the
# last valid version, with the mistake beside it.


MOST_SHOWN = 40_000  # [characters] of a file that go to its page
LONGEST_MARGINS = 60.0  # [s] time limit of margins, which take minutes for hundreds of bricks


def watch_run(file: Path, selection: Selection) -> int:
    """Play now and at every save until interrupted; return the exit code of the last run."""
    if file == STDIN:
        raise click.UsageError("--watch needs a file, not the standard input; remove --watch, or give a file")
    if not os.path.exists(file):
        raise click.UsageError(f"--watch: {file} does not exist")
    try:
        with showing(OnePage(live_page(file.name))) as page:
            tell(f"open {page.url}")
            warm_up()
            live = _Live(file, selection, RunPage(page))
            try:
                live.go_on()
            except KeyboardInterrupt:
                return live.code
    except OSError as error:
        raise click.ClickException(f"the page cannot be served: {error.strerror or error}") from error


@dataclass
class _Live:
    """A watched file."""

    file: Path
    selection: Selection
    page: RunPage
    code: int = 0  # exit code of the last run
    cases: Sequence[Case] = ()  # cases of the current file; empty if it has only mistakes
    files: set[Path] = field(default_factory=set)  # all files of the scenarios
    stamps: Stamps = field(default_factory=dict)

    def go_on(self) -> NoReturn:
        """Play at every save until interrupted."""
        self.files.add(self.file)
        self._read()
        while True:
            while not self._play():
                pass
            tell("watching for changes; press Ctrl-C to stop")
            while not self._is_overtaken():
                sleep(INTERVAL)

    def _is_overtaken(self) -> bool:
        """Return whether a newer save can be played; mistakes in it are reported and stop no run."""
        if not is_saved_since(self.stamps):
            return False
        tell("saved")
        self._read()
        return bool(self.cases)

    def _read(self) -> None:
        self.stamps, gathered = read_whole(self.files, lambda: gather([self.file]), _makes_sense)
        self.cases = self.selection.of(gathered.cases)
        self._watch_also(gathered.diagnostics)
        complain(gathered.diagnostics)
        mistakes: list[Diagnostic | str] = list(gathered.diagnostics)
        if not self.cases and not mistakes:
            mistakes = [told := nothing_selected_text(self.selection, gathered.cases, [self.file])]
            tell(told)
        self.code = exit_code(Report((), gathered.diagnostics)) if gathered.diagnostics else ExitCode.OK
        self.page.show_file(_shown(self.file), map(mistake_json, mistakes))

    def _play(self) -> bool:
        """Play the current cases; return whether they ended and no newer save is there."""
        if not self.cases:
            return True
        self.page.expect(len(self.cases))
        playing = _Playing(self.cases, self.page, self._is_overtaken)
        try:
            return playing.play()
        finally:
            results = tuple(playing.found[number] for number in sorted(playing.found))
            self.code = max(self.code, exit_code(Report(results, ()))) if results else self.code

    def _watch_also(self, mistakes: Iterable[Diagnostic]) -> None:
        """Watch included files and files with mistakes, too."""
        others = {Path(part) for case in self.cases for part in case.source.parts}
        others |= {Path(mistake.span.file) for mistake in mistakes}
        self.stamps = {**stamps_of(others - self.files), **self.stamps}
        self.files |= others


def _shown(file: Path) -> str:
    """Return the text of a file as far as it can be shown; empty if it cannot be read."""
    try:
        with file.open(encoding="utf-8", errors="replace") as opened:
            return harmless(opened.read(MOST_SHOWN))
    except OSError:
        return ""


def _makes_sense(gathered: GatheredCases) -> bool:
    return bool(gathered.cases) and not gathered.diagnostics


@dataclass
class _Playing:
    """The current content of a watched file, while it is played."""

    cases: Sequence[Case]
    page: RunPage
    is_overtaken: Callable[[], bool]  # whether a newer save replaces these cases
    found: dict[int, VariantResult] = field(default_factory=dict)

    def play(self) -> bool:
        """Preview, play and judge all cases; return False if a newer save came before the end."""
        able = [number for number, case in enumerate(self.cases) if self._is_playable(number, case)]
        self.page.show_activity("playing" if able else "")
        for number in able:
            self.page.note(number, [])  # remove the notes on the version before
        for number in able[:1]:  # of several cases, the page shows the first
            self.page.show(number, preview(self.cases[number]))
        tasks = [Task(played_or_blocked, (played, self.cases[number]), LONGEST_LIMIT) for number in able]
        tasks += [Task(margined, (self.cases[number],), LONGEST_MARGINS) for number in able]
        pool = run_supervised(tasks, 2, lambda place, result: self._done(able, place, result), self._look)
        if pool.interrupted:
            raise KeyboardInterrupt
        if TaskStatus.NOT_RUN in {result.status for result in pool.results}:
            return False
        self.page.show_activity("")
        return True

    def _is_playable(self, number: int, case: Case) -> bool:
        why = case.skip or unplayable(case.system)
        if why:
            self.found[number] = marked_skipped(case) if case.skip is not None else skipped(case, why)
            self.page.note(number, [f"{case.name} is skipped: {why}"])
        return not why

    def _look(self) -> None:
        if self.is_overtaken():
            raise EnoughSeenError

    def _done(self, able: Sequence[int], place: int, result: TaskResult) -> None:
        number = able[place % len(able)]
        case = self.cases[number]
        match result.value:
            case Played():
                self.found[number] = result.value.result
                self.page.show(number, result.value.json)
                if len(self.found) == len(self.cases):
                    self.page.show_activity("computing margins")
                write(f"{case.name}\n{result.value.text}\n\n")
            case Blocked():
                self._held_up(number, blocked_result(case, result.value))
            case Margined():
                self.page.note(number, result.value.lines, result.value.weakest, result.value.helps)
            case _:
                what = "margins" if place >= len(able) else "the run"
                self.page.note(number, [f"{what}: {result.message or result.status.value}"])

    def _held_up(self, number: int, result: VariantResult) -> None:
        self.found[number] = result
        if result.mistake is not None:
            complain([result.mistake])
            self.page.show_mistakes((*self.page.mistakes, mistake_json(result.mistake)))


# `stackdsl run`: plays one file and prints its events as they happen.


@click.command("run", cls=ExplainedCommand)
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@ON_RECORD
@ON_HTML
@ON_GLB
@click.option("--watch", is_flag=True, help="Show FILE in a page on this machine, updated at each save.")
@click.option("--all-names", is_flag=True, help="List every brick of an event, and all fallen bricks.")
@click.option("--table", is_flag=True, help="Also print a table with a row for each brick: state, place, shift, tilt.")
@click.pass_context
def run_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    record: Path | None,
    html: Path | None,
    glb: Path | None,
    watch: bool,
    all_names: bool,
    table: bool,
) -> None:
    """Play FILE, print each event as it happens, and judge the claims. Golden files are not read."""
    if watch:
        if any(path is not None for path in (record, html, glb)):
            raise click.UsageError("--watch writes no files; remove --watch, or --record, --html and --glb")

        context.exit(watch_run(file, Selection(systems, keyword)))
    gathered, selected = selected_of(file, Selection(systems, keyword))
    keeping = RunOutputs.of(record, html, glb, selected)
    results = tuple(_run(case, keeping, all_names, table) for case in selected)
    keeping.write()
    context.exit(exit_code(Report(results, gathered.diagnostics)))


def _run(case: Case, keeping: RunOutputs, all_names: bool, table: bool) -> VariantResult:
    """Play a case in this process and print its events and its result."""
    write(case.name)
    if case.skip is not None:
        write(f"  skipped: {case.skip}\n\n")
        return marked_skipped(case)
    if why := unplayable(case.system):
        write(f"  skipped: {why}\n\n")
        return skipped(case, why)
    if case.is_sampled and keeping.recorder() is None:
        return _sampled(case)
    try:
        may_stop = stop_condition_of(case.scenario, case.system)
        recorder = keeping.recorder()

        lines = EventLines(all_names)

        def told(event: Event) -> None:
            for text in lines.after(event):
                write_wrapped(text)

        trace = play_case(case.timeline, case.system, may_stop, told, recorder)
        for text in lines.rest():
            write_wrapped(text)
    except (BlockedPlacementError, PluginError) as error:
        result = _without_end(case, error)
    else:
        result = judged(case, trace)
        write_wrapped(with_known_marks(run_text(trace, _seen_by(result, keeping.html), all_names)))
        if table:
            from stackdsl.api.run import Run  # noqa: PLC0415 -- most runs have no table

            write(f"\n{Run(case, trace).table()}\n")
        keeping.played(case, trace, recorder, result)
    write("\n")
    return result


def _seen_by(result: VariantResult, html: Path | None) -> VariantResult:
    """Return a result whose `see it` is the page of the run, or the command that writes one."""
    why = result.why
    if why is None or not (html is not None or why.see.startswith("stackdsl run ")):
        return result
    page = f"{shlex.quote(str(html))}, the page of this run" if html is not None else ""
    return replace(result, why=replace(why, see=page or f"{why.see} --html run.html"))


def _without_end(case: Case, error: BlockedPlacementError | PluginError) -> VariantResult:
    """Print why a run did not end, and return its result."""
    if isinstance(error, BlockedPlacementError):
        result = blocked_result(case, error.blocked)
        complain(filter(None, [result.mistake]))
        return result
    if "STACKDSL_DEBUG" in os.environ:
        raise error
    result = stopped(case, crash(error))
    write_wrapped(_stopped_text(result))
    return result


def _stopped_text(result: VariantResult) -> str:
    """Return the lines about a run that did not end."""
    (_, what), *others = failure_lines(result)
    lines = [*others, see_line(result, "run.html")]
    return f"{MARKS[Status.FAILED]} {what}\n" + "".join(f"  {label:<{LABEL}}{text}\n" for label, text in lines)


def _sampled(case: Case) -> VariantResult:
    """Judge the samples of a case and print their outcomes. The recorded run is that of the design."""
    from stackdsl.checking.ensembles import sampled_result  # noqa: PLC0415 -- it brings scipy

    with counted(case.scenario.samples or 0, f"{case.name}: samples") as known:
        result = sampled_result(case, os.cpu_count() or 1, on_drawn=lambda _, drawn, __: known(drawn))
    complain(filter(None, [result.mistake]))
    if result.ensemble is not None:
        write_wrapped("".join(f"{line}\n" for line in (*ensemble_lines(result.ensemble), *claim_lines(result))) + "\n")
    else:
        write_wrapped(f"{_stopped_text(result)}\n")
    return result
