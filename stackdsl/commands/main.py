"""The command line: reads arguments, calls the pipeline, prints, and says with its exit code how it went."""

import os
import shlex
import signal
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.resources import files
from io import TextIOWrapper
from itertools import groupby
from math import isnan
from pathlib import Path
from types import FrameType

import click

from stackdsl.checking.check import TIME_LIMIT, Terms, check, held_up, is_whole_set, judged, play_case
from stackdsl.checking.gathering import Case, Gathered, cases_of, gather
from stackdsl.checking.processes import INTERRUPTS
from stackdsl.checking.selection import Selection, why_nothing
from stackdsl.commands.bench import bench_command
from stackdsl.commands.options import SYSTEM_CHOICE, playable
from stackdsl.commands.terminal import paper, progress, show_error, silence, tell, write
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.validation import schema_text
from stackdsl.outcome import ExitCode, Report, VariantResult, exit_code
from stackdsl.playing.clearance import BlockedPlacementError
from stackdsl.reading.source import parse
from stackdsl.report.diagnostic_text import diagnostic_text
from stackdsl.report.event_text import event_text
from stackdsl.report.json import report_json
from stackdsl.report.run_text import run_text
from stackdsl.report.text import report_text
from stackdsl.snapshots.golden import GoldenWriteRefusedError, refuse_in_ci

FilePath = click.Path(path_type=Path)
ONE_FILE = click.argument("file", type=FilePath)
ON_SYSTEMS = click.option(
    "--system",
    "systems",
    multiple=True,
    type=SYSTEM_CHOICE,
    callback=lambda *given: playable(given[-1]),
    help="Only these systems. Those on other engines than PyBullet are played wherever they are asked for.",
)
ON_KEYWORD = click.option("-k", "keyword", default="", help="Only cases whose name contains this.")
LONGEST_LIMIT = 1e6  # [s] eleven days; waiting takes a number of milliseconds in 31 bits
GOLDEN = Path("golden")
FORMATS: Mapping[str, Callable[[Report], str]] = {
    "text": lambda report: report_text(report, *paper()),
    "json": report_json,
}  # of the report of `check`


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="stackdsl")
def app() -> None:
    """Play scenarios of stacked bricks, judge them, and compare them with their snapshots."""


@app.command("check")
@click.argument("paths", nargs=-1, type=FilePath)
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--tag", "tags", multiple=True, help="Only scenarios with this tag; with ! in front, without it.")
@click.option("--list", "list_only", is_flag=True, help="Print the names of the selected cases and stop.")
@click.option("--format", "form", type=click.Choice(list(FORMATS)), default="text", show_default=True)
@click.option("--update", is_flag=True, help="Accept what comes out as the new snapshots. Refused in CI.")
@click.option("--refine", is_flag=True, help="Play again at half the step and twice the iterations; tell what moves.")
@click.option("--golden", type=FilePath, default=GOLDEN, show_default=True, help="Directory of the snapshots.")
@click.option("--jobs", type=click.IntRange(1, 256), default=os.cpu_count() or 1, help="Processes; default: all cores.")
@click.option(
    "--time-limit",
    type=click.FloatRange(0.001, LONGEST_LIMIT),
    callback=lambda *given: _number(given[-1]),
    default=TIME_LIMIT,
    show_default=True,
    help="Seconds a case.",
)
@click.pass_context
def check_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    paths: Sequence[Path],
    systems: tuple[str, ...],
    keyword: str,
    tags: tuple[str, ...],
    list_only: bool,
    form: str,
    update: bool,
    refine: bool,
    golden: Path,
    jobs: int,
    time_limit: float,
) -> None:
    """Play and judge everything under PATHS (default: scenarios), and compare it with its snapshots."""
    if update:
        _refuse_refined(refine)
        refuse_in_ci(os.environ)
    selection = Selection(systems, keyword, tags)
    terms = Terms(golden, update, jobs, time_limit, _update_command(paths, selection, golden, time_limit), refine)
    paths = paths or (Path("scenarios"),)
    gathered = gather(paths)
    selected = selection.of(gathered.cases)
    _warn_of_nothing(selection, gathered, selected, paths)
    if list_only:
        _list(gathered, selected)
        context.exit(_code_without_runs(gathered, selected))
    with progress(len(selected)) as on_result:
        report = check(gathered, selected, is_whole_set(paths, golden), terms, on_result)
    write(FORMATS[form](report))
    context.exit(exit_code(report))


@app.command("run")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.pass_context
def run_command(context: click.Context, file: Path, systems: tuple[str, ...], keyword: str) -> None:
    """Play FILE, print what happens as it happens, and judge it; snapshots are not looked at."""
    gathered, selected = _selected(file, Selection(systems, keyword))
    results = tuple(_run(case) for case in selected)
    context.exit(exit_code(Report(results, gathered.diagnostics)))


@app.command("explain")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--margins/--no-margins", default=None, help="What the proofs would survive; default: of few bricks.")
@click.pass_context
def explain_command(
    context: click.Context, file: Path, systems: tuple[str, ...], keyword: str, margins: bool | None
) -> None:
    """Print what FILE was compiled to, and what statics says of it."""
    from stackdsl.report.explanation import explanation_text  # noqa: PLC0415 -- statics brings numpy, the rest does not

    gathered, selected = _selected(file, Selection(systems, keyword))
    for _, cases in groupby(selected, key=lambda case: (case.scenario.scenario, case.variant.parameters)):
        write(explanation_text(list(cases), margins))
    context.exit(_code_without_runs(gathered, selected))


@app.command("schema")
def schema_command() -> None:
    """Print the JSON Schema of scenarios, for editors."""
    write(schema_text())


@app.command("new")
@click.argument("name")
@click.option("--to", "folder", type=FilePath, default=Path("scenarios"), show_default=True, help="Where to write it.")
def new_command(name: str, folder: Path) -> None:
    """Write a scenario called NAME to start from; never over an existing file."""
    path = folder / f"{name}.yaml"
    template = files("stackdsl").joinpath("template.yaml").read_text(encoding="utf-8")
    text = template.replace("NAME", name).replace("SCHEMA", _schema_seen_from(folder))
    for mistake in cases_of(parse(text, str(path)))[1]:
        raise click.UsageError(f"{mistake.message}; {mistake.hint}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise click.UsageError(f"{folder} is no directory; write to another one") from error
    except OSError as error:
        raise click.UsageError(f"{folder} cannot be made: {error.strerror}") from error
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise click.UsageError(f"{path} exists already; choose another name") from error
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error
    write(f"wrote {path}; next: stackdsl check {path}")


def _run(case: Case) -> VariantResult:
    """Play a case here, and print what happens and how it ended."""
    write(case.name)
    try:
        trace = play_case(case.timeline, case.system, lambda event: write(event_text(event)))
    except BlockedPlacementError as error:
        result = held_up(case, error.blocked)
        _complain(filter(None, [result.mistake]))
    else:
        result = judged(case, trace)
        write(run_text(trace, result))
    write("\n")
    return result


def _number(value: float) -> float:
    """A number that is one: no range excludes nan."""
    if isnan(value):
        raise click.BadParameter("nan is no number.")
    return value


def _refuse_refined(refine: bool) -> None:
    if refine:
        message = (
            "--refine writes no snapshots: it asks what of a run would move; leave one of --refine and --update out"
        )
        raise click.UsageError(message)


def _selected(file: Path, selection: Selection) -> tuple[Gathered, Sequence[Case]]:
    """What one file holds, and the cases selected of it; its mistakes are told, and why nothing is selected."""
    gathered = gather([file])
    _complain(gathered.diagnostics)
    selected = selection.of(gathered.cases)
    _warn_of_nothing(selection, gathered, selected, [file])
    return gathered, selected


def _update_command(paths: Sequence[Path], selection: Selection, golden: Path, time_limit: float) -> str:
    """The same check with --update, for a shell; it accepts what the check shows, and nothing else."""
    # A path that begins with a dash would be taken for an option.
    words = ["stackdsl", "check", *(f"./{path}" if str(path).startswith("-") else str(path) for path in paths)]
    words += [word for system in selection.systems for word in ("--system", system)]
    words += ["-k", selection.keyword] if selection.keyword else []
    words += [word for tag in selection.tags for word in ("--tag", tag)]
    words += ["--golden", str(golden)] if golden != GOLDEN else []
    words += ["--time-limit", str(time_limit)] if time_limit != TIME_LIMIT else []
    return shlex.join([*words, "--update"])


def _schema_seen_from(folder: Path) -> str:
    """The path of the packaged schema: relative if it is a part of the project at hand, which may be kept anywhere."""
    schema = Path(str(files("stackdsl").joinpath("scenario.schema.json"))).resolve()
    if not schema.is_relative_to(Path.cwd()):
        return schema.as_posix()
    return Path(os.path.relpath(schema, folder)).as_posix()


def _list(gathered: Gathered, selected: Sequence[Case]) -> None:
    _complain(gathered.diagnostics)
    for case in selected:
        write(case.name)


def _complain(diagnostics: Iterable[Diagnostic]) -> None:
    for diagnostic in diagnostics:
        tell(diagnostic_text(diagnostic))


def _warn_of_nothing(selection: Selection, gathered: Gathered, selected: Sequence[Case], paths: Sequence[Path]) -> None:
    if not selected and not gathered.diagnostics:
        tell(why_nothing(selection, gathered.cases, paths))


def _code_without_runs(gathered: Gathered, selected: Sequence[Case]) -> ExitCode:
    """The exit code of a call that plays nothing."""
    if gathered.diagnostics:
        return ExitCode.INVALID
    return ExitCode.OK if selected else ExitCode.USAGE


app.add_command(bench_command)


def main() -> None:
    """Run the command; no traceback reaches a user."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None, if it was closed from the start
            stream.reconfigure(errors="replace")
    for number in INTERRUPTS:
        signal.signal(number, _interrupt)
    sys.exit(_code_of_run())


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Interrupt once: whoever presses again and again still gets the report."""
    for each in INTERRUPTS:
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt


def _code_of_run() -> int:
    try:
        return app.main(prog_name="stackdsl", standalone_mode=False) or ExitCode.OK
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        show_error(error)
        return ExitCode.USAGE
    except GoldenWriteRefusedError as error:
        tell(f"Error: {error}")
        return ExitCode.USAGE
    except (KeyboardInterrupt, click.Abort):
        tell("interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        if isinstance(error.__context__, KeyboardInterrupt):  # click failed to end the line that shows ^C
            silence(sys.stderr)
            return ExitCode.INTERRUPTED
        if "STACKDSL_DEBUG" in os.environ:
            raise
        tell(f"internal error: {type(error).__name__}: {error}")
        tell("This is a fault of stackdsl. Set STACKDSL_DEBUG=1 to see where, and please report it.")
        return ExitCode.CRASHED
