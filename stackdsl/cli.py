"""The command line: reads arguments, calls the pipeline, prints, and says with its exit code how it went."""

import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from itertools import groupby
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from stackdsl.check import TIME_LIMIT, OnResult, Terms, check, is_whole_set, judged, play_case
from stackdsl.diagnostics import Diagnostic
from stackdsl.gathering import Case, Gathered, Selection, cases_of, gather
from stackdsl.language.author_types import SYSTEMS
from stackdsl.language.validation import schema_text
from stackdsl.outcome import ExitCode, Report, VariantResult, exit_code
from stackdsl.reading.source import parse
from stackdsl.report.diagnostic_text import diagnostic_text
from stackdsl.report.event_text import event_text
from stackdsl.report.explanation import explanation_text
from stackdsl.report.json import report_json
from stackdsl.report.outcome_text import outcome_text
from stackdsl.report.text import report_text
from stackdsl.snapshots.golden import GoldenWriteRefusedError, refuse_in_ci

FilePath = click.Path(path_type=Path)
ONE_FILE = click.argument("file", type=FilePath)
ON_SYSTEMS = click.option("--system", "systems", multiple=True, type=click.Choice(SYSTEMS), help="Only these systems.")
ON_KEYWORD = click.option("-k", "keyword", default="", help="Only cases whose name contains this.")
GOLDEN = Path("golden")


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
@click.option("--format", "form", type=click.Choice(["text", "json"]), default="text", show_default=True)
@click.option("--update", is_flag=True, help="Accept what comes out as the new snapshots. Refused in CI.")
@click.option("--golden", type=FilePath, default=GOLDEN, show_default=True, help="Directory of the snapshots.")
@click.option("--jobs", type=click.IntRange(1, 256), default=os.cpu_count() or 1, help="Processes; default: all cores.")
@click.option(
    "--time-limit", type=click.FloatRange(min=0.001), default=TIME_LIMIT, show_default=True, help="Seconds a case."
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
    golden: Path,
    jobs: int,
    time_limit: float,
) -> None:
    """Play and judge everything under PATHS (default: scenarios), and compare it with its snapshots."""
    if update:
        refuse_in_ci(os.environ)
    selection = Selection(systems, keyword, tags)
    terms = Terms(golden, update, jobs, time_limit, _update_command(paths, selection, golden, time_limit))
    paths = paths or (Path("scenarios"),)
    gathered = gather(paths)
    selected = [case for case in gathered.cases if selection.takes(case)]
    if list_only:
        _list(gathered, selected)
        context.exit(_exit_code(Report(diagnostics=gathered.diagnostics), selected))
    with _progress(len(selected)) as on_result:
        report = check(gathered, selected, is_whole_set(paths, golden), terms, on_result)
    _print(report_json(report) if form == "json" else report_text(report, *_paper()))
    context.exit(_exit_code(report, selected))


@app.command("run")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.pass_context
def run_command(context: click.Context, file: Path, systems: tuple[str, ...], keyword: str) -> None:
    """Play FILE, print what happens as it happens, and judge it; snapshots are not looked at."""
    gathered, selected = _selected(file, Selection(systems, keyword))
    results = []
    for case in selected:
        click.echo(case.name)
        trace = play_case(case.timeline, case.system, lambda event: click.echo(event_text(event)))
        fell = trace.collapse and f"collapses at level {trace.collapse.level} after {trace.collapse.time:.3f} s"
        cost = f"{trace.cost.simulated_time:g} s played in {trace.cost.wall_time:.3f} s, {trace.cost.steps} steps"
        click.echo(f"{fell or 'stands'}; {cost}")
        results.append(judged(case, trace))
        for outcome in results[-1].outcomes:
            click.echo(f"{'passed' if outcome.passed else 'failed'}: {outcome.span}: {outcome_text(outcome)}")
        click.echo()
    context.exit(_exit_code(Report(tuple(results), gathered.diagnostics), selected))


@app.command("explain")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.pass_context
def explain_command(context: click.Context, file: Path, systems: tuple[str, ...], keyword: str) -> None:
    """Print what FILE was compiled to."""
    gathered, selected = _selected(file, Selection(systems, keyword))
    for _, cases in groupby(selected, key=lambda case: (case.scenario.scenario, case.variant.parameters)):
        _print(explanation_text(list(cases)))
    context.exit(_exit_code(Report(diagnostics=gathered.diagnostics), selected))


@app.command("schema")
def schema_command() -> None:
    """Print the JSON Schema of scenarios, for editors."""
    _print(schema_text())


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
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise click.UsageError(f"{path} exists already; choose another name") from error
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error
    click.echo(f"wrote {path}; next: stackdsl check {path}")


def _selected(file: Path, selection: Selection) -> tuple[Gathered, Sequence[Case]]:
    """What one file holds, and the cases selected of it; its mistakes are told."""
    gathered = gather([file])
    _complain(gathered.diagnostics)
    return gathered, [case for case in gathered.cases if selection.takes(case)]


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
        click.echo(case.name)


def _complain(diagnostics: Sequence[Diagnostic]) -> None:
    for diagnostic in diagnostics:
        click.echo(diagnostic_text(diagnostic), err=True)


def _exit_code(report: Report, selected: Sequence[Case]) -> int:
    if not selected and not report.diagnostics:
        click.echo("nothing selected", err=True)
        return ExitCode.USAGE
    return exit_code(report)


def _print(text: str) -> None:
    click.echo(text, nl=not text.endswith("\n"))


def _paper() -> tuple[int, bool]:
    """Width of the paper, and whether it takes colour."""
    console = Console()
    return (console.width if console.is_terminal else 160), console.is_terminal and "NO_COLOR" not in os.environ


@contextmanager
def _progress(total: int) -> Iterator[OnResult]:
    """A bar on a terminal, a line a case elsewhere; both on the error stream, so that output stays clean."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _line_by_line(total)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("playing", total=total)
        yield lambda result: bar.update(task, advance=1, description=result.name)


def _line_by_line(total: int) -> OnResult:
    done = 0

    def tell(result: VariantResult) -> None:
        nonlocal done
        done += 1
        click.echo(f"[{done}/{total}] {result.name}: {result.conclusion}", err=True)

    return tell


def main() -> None:
    """Run the command; no traceback reaches a user."""
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]  # text streams both, unless a test swaps them
    sys.exit(_code_of_run())


def _code_of_run() -> int:
    try:
        return app.main(prog_name="stackdsl", standalone_mode=False) or ExitCode.OK
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        error.show()
        return ExitCode.USAGE
    except GoldenWriteRefusedError as error:
        click.echo(f"Error: {error}", err=True)
        return ExitCode.USAGE
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        return ExitCode.INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return ExitCode.OK
    except Exception as error:
        if "STACKDSL_DEBUG" in os.environ:
            raise
        click.echo(f"internal error: {type(error).__name__}: {error}", err=True)
        click.echo("This is a fault of stackdsl. Set STACKDSL_DEBUG=1 to see where, and please report it.", err=True)
        return ExitCode.CRASHED
