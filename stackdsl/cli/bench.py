"""`stackdsl bench`: reads arguments, plays, prints, and writes what came of it."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import click

from stackdsl.asked_files import write_asked
from stackdsl.bench.conduct import Bench, Job, Plan, bench, jobs_of
from stackdsl.bench.entrants import ENTRANTS, entrant_named, installed
from stackdsl.bench.journal import Journal
from stackdsl.bench.page import bench_page
from stackdsl.bench.plot import PlotMissingError, drawn
from stackdsl.bench.summary import bench_json
from stackdsl.bench.table import bench_text
from stackdsl.checking.cases import gather
from stackdsl.checking.selection import Selection, why_nothing
from stackdsl.cli.options import LONGEST_LIMIT, ON_KEYWORD, ON_TAGS, FilePath, Number, SystemChoice, refuse_missing
from stackdsl.cli.terminal import paper, progress, tell, write
from stackdsl.exits import ExitCode
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.results import RunStatus

RESOLUTIONS = "2,1,1/2,1/4"
FINEST, COARSEST = Fraction(1, 64), Fraction(64)
TIME_LIMIT = 300.0  # [s] a run


def _playable(names: tuple[str, ...]) -> tuple[str, ...]:
    refuse_missing((name, entrant_named(name).package) for name in names)
    return tuple(dict.fromkeys(names))


def _installed() -> tuple[str, ...]:
    from stackdsl.simulation.plugins import ForeignSystemError  # noqa: PLC0415 -- where all systems are asked for

    try:
        return installed()
    except ForeignSystemError as error:
        raise click.UsageError(f"{error}; or name the systems to play on by --system") from error


def _factors(context: click.Context, parameter: click.Parameter, text: str) -> tuple[float, ...]:
    """Times the time step of each system, such as `2,1,1/2`."""
    try:
        factors = [Fraction(part.strip()) for part in text.split(",")]
    except (ValueError, ZeroDivisionError) as error:
        raise click.BadParameter(f"'{text}' is no list of numbers; write it like {RESOLUTIONS}") from error
    if not all(FINEST <= factor <= COARSEST for factor in factors):
        raise click.BadParameter(f"steps are from {FINEST} to {COARSEST} times as long; write it like {RESOLUTIONS}")
    return tuple(float(factor) for factor in dict.fromkeys(factors))


@click.command("bench")
@click.argument("paths", nargs=-1, type=FilePath)
@click.option(
    "--system",
    "systems",
    multiple=True,
    type=SystemChoice(list(ENTRANTS)),
    callback=lambda *given: _playable(given[-1]),
    help="Only these systems; default: all that are installed.",
)
@ON_KEYWORD
@ON_TAGS
@click.option(
    "--resolutions",
    default=RESOLUTIONS,
    show_default=True,
    callback=_factors,
    help="Time steps, as so many times each system's own.",
)
@click.option("--output", type=FilePath, default=Path("bench"), show_default=True, help="Directory of what comes out.")
@click.option("--resume", is_flag=True, help="Go on with what is missing in the output directory.")
@click.option(
    "--workers",
    type=click.IntRange(1, 256),
    default=1,
    show_default=True,
    help="Runs at a time; two disturb each other's times.",
)
@click.option(
    "--time-limit",
    type=Number(0.001, LONGEST_LIMIT),
    default=TIME_LIMIT,
    show_default=True,
    help="Seconds a run.",
)
@click.pass_context
def bench_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    paths: Sequence[Path],
    systems: tuple[str, ...],
    keyword: str,
    tags: tuple[str, ...],
    resolutions: tuple[float, ...],
    output: Path,
    resume: bool,
    workers: int,
    time_limit: float,
) -> None:
    """Play everything under PATHS (default: scenarios) on every system at several time steps: speed against error."""
    paths = paths or (Path("scenarios"),)
    gathered = gather(paths)
    for diagnostic in gathered.diagnostics:
        tell(diagnostic_text(diagnostic))
    selection = Selection(keyword=keyword, tags=tags)
    cases = [case for case in gathered.cases if selection.takes(case) and not case.is_sampled]
    jobs = jobs_of(cases, systems or _installed(), resolutions)
    if not jobs:
        mistaken = "nothing to play: what is selected has mistakes, or has another name"
        tell(mistaken if gathered.diagnostics else why_nothing(selection, gathered.cases, paths))
        context.exit(ExitCode.INVALID if gathered.diagnostics else ExitCode.USAGE)
    plan = Plan(Journal(output), resume, workers, time_limit)
    try:
        if resume:
            _tell_of_other_jobs(plan.journal, jobs)
        with progress(len(jobs)) as bar:
            found = bench(jobs, plan, bar.tell, bar.wait)
        _write_down(found, output)
    except OSError as error:
        raise click.ClickException(f"{output} cannot be written: {error.strerror}; use another --output") from error
    write(bench_text(found, *paper()))
    if gathered.diagnostics:
        count = len(gathered.diagnostics)
        tell(f"{count} mistake{'s' * (count > 1)} in scenarios, told above: these were not played")
    context.exit(_exit_code(found, bool(gathered.diagnostics)))


def _tell_of_other_jobs(journal: Journal, jobs: Sequence[Job]) -> None:
    """A directory may hold runs that are not asked for: some are put aside, but if all are, it is the wrong one."""
    held = {record.id: record.name for record in journal.held()}
    others = [name for number, name in held.items() if number not in {job.id for job in jobs}]
    if not others:
        return
    what = f"{journal.folder} holds {_some(others)}, and asked for are {_some([job.title for job in jobs])}"
    if len(others) == len(held):
        raise click.UsageError(
            f"nothing to resume: {what}; ask for the same scenarios, systems and resolutions as before (what has "
            f"changed since is another), use another --output, or leave out --resume to begin anew"
        )
    tell(f"{what}; the runs that are not asked for are kept in {journal.aside}")


def _some(names: Sequence[str]) -> str:
    """How many runs, and the first by name."""
    count = f"{len(names)} run{'s' * (len(names) > 1)}"
    return f"{count} ({names[0]}{', ...' * (len(names) > 1)})"


def _write_down(found: Bench, output: Path) -> None:
    write_asked(output / "bench.json", bench_json(found).encode(), output)
    try:
        pictures = drawn(found.points)
    except PlotMissingError as error:
        pictures = {}
        tell(str(error))
    for name, picture in pictures.items():
        write_asked(output / name, picture, output)
    write_asked(output / "speed-against-error.md", bench_page(found, bool(pictures)).encode(), output)


def _exit_code(found: Bench, mistakes: bool) -> ExitCode:
    """A wrong verdict or a run out of time is what a bench is to find; a crash is not."""
    if found.interrupted:
        return ExitCode.INTERRUPTED
    if mistakes:
        return ExitCode.INVALID
    crashed = any(score.record.status == RunStatus.CRASHED for score in found.scores)
    return ExitCode.CRASHED if crashed else ExitCode.OK
