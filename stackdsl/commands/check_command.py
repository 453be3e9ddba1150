"""`stackdsl check`: plays and judges scenarios, and holds them against their golden files."""

import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from math import isnan
from pathlib import Path
from typing import Final

import click

from stackdsl.checking.check import TIME_LIMIT, Terms, check, is_whole_set
from stackdsl.checking.gathering import Case, Gathered, gather
from stackdsl.checking.selection import Selection
from stackdsl.commands.options import LONGEST_LIMIT, ON_KEYWORD, ON_SYSTEMS, ON_TAGS, FilePath
from stackdsl.commands.selecting import code_without_runs, complain, warn_of_nothing
from stackdsl.commands.terminal import paper, progress, write
from stackdsl.outcome import Report, exit_code
from stackdsl.snapshots.golden import GoldenWriteRefusedError, refuse_in_ci

GOLDEN = Path("golden")


def _text(report: Report) -> str:
    from stackdsl.report.text import report_text  # noqa: PLC0415 -- only the one that is asked for

    return report_text(report, *paper())


def _json(report: Report) -> str:
    from stackdsl.report.json import report_json  # noqa: PLC0415 -- likewise

    return report_json(report)


FORMATS: Final[Mapping[str, Callable[[Report], str]]] = {"text": _text, "json": _json}  # as docs/command.md lists them


def _number(value: float) -> float:
    """A number that is one: no range excludes nan."""
    if isnan(value):
        raise click.BadParameter("nan is no number.")
    return value


@click.command("check")
@click.argument("paths", nargs=-1, type=FilePath)
@ON_SYSTEMS
@ON_KEYWORD
@ON_TAGS
@click.option("--list", "list_only", is_flag=True, help="Print the names of the selected cases and stop.")
@click.option("--format", "form", type=click.Choice(list(FORMATS)), default="text", show_default=True)
@click.option("--update", is_flag=True, help="Accept what comes out as the new golden files. Refused in CI.")
@click.option("--refine", is_flag=True, help="Play again at half the step and twice the iterations; tell what moves.")
@click.option("--golden", type=FilePath, default=GOLDEN, show_default=True, help="Directory of the golden files.")
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
    """Play and judge everything under PATHS (default: scenarios), and compare it with its golden files."""
    if update:
        _may_write(refine)
    selection = Selection(systems, keyword, tags)
    accept = _update_command(paths, selection, golden, time_limit)
    paths = paths or (Path("scenarios"),)
    gathered = gather(paths)
    selected = selection.of(gathered.cases)
    warn_of_nothing(selection, gathered, selected, paths)
    if list_only:
        _list(gathered, selected)
        context.exit(code_without_runs(gathered, selected))
    with progress(len(selected)) as bar:
        terms = Terms(golden, update, jobs, time_limit, accept, refine, bar.wait)
        report = check(gathered, selected, is_whole_set(paths, golden), terms, bar.tell)
    write(FORMATS[form](report))
    context.exit(exit_code(report))


def _may_write(refine: bool) -> None:
    """Raise a usage error if golden files must not be written."""
    if refine:
        message = (
            "--refine writes no golden files: it asks what of a run would move; leave one of --refine and --update out"
        )
        raise click.UsageError(message)
    try:
        refuse_in_ci(os.environ)
    except GoldenWriteRefusedError as error:
        raise click.ClickException(str(error)) from error


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


def _list(gathered: Gathered, selected: Sequence[Case]) -> None:
    complain(gathered.diagnostics)
    for case in selected:
        write(case.name)
