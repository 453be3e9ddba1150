"""`stackdsl sweep`: writes a row for each variant and sample to a file, which the next call continues."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import click
from click.core import ParameterSource

from stackdsl.checking.cases import Case
from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import LONGEST_LIMIT, ON_JOBS, ON_KEYWORD, ON_SYSTEMS, ONE_FILE, FilePath, Number, selected_of
from stackdsl.cli.terminal import counted, tell, write, write_data
from stackdsl.exits import ExitCode
from stackdsl.report.studies import sweep_lines, sweep_table
from stackdsl.simulation.known_systems import unplayable
from stackdsl.studies.sweep import SweepError, SweptCase, sweep, swept_cases
from stackdsl.studies.sweep_plan import NothingToSweepError, SweepPlan, plan_of
from stackdsl.studies.sweep_rows import Counts, RowsError
from stackdsl.studies.sweep_workers import NoClusterError, Workers, dask_cluster, own_processes
from stackdsl.supervising.executors import TIME_LIMIT

MOST_SAMPLES = 10**12


@click.command("sweep", cls=ExplainedCommand)
@ONE_FILE
@click.option(
    "--out", "-o", required=True, type=FilePath, help="File of the rows: a .jsonl or .csv file, or a .parquet folder."
)
@ON_SYSTEMS
@ON_KEYWORD
@click.option(
    "--samples",
    type=click.IntRange(1, MOST_SAMPLES),
    help="Number of samples of each case. Default: that of the scenario.",
)
@click.option(
    "--executor",
    type=click.Choice(["processes", "dask"]),
    default="processes",
    show_default=True,
    help="Workers: processes of this machine, or an existing Dask cluster.",
)
@click.option(
    "--scheduler", default="", metavar="ADDRESS", help="Address of the Dask cluster. Default: from the Dask settings."
)
@ON_JOBS
@click.option(
    "--time-limit",
    type=Number(0.001, LONGEST_LIMIT),
    default=TIME_LIMIT,
    show_default=True,
    help="Time limit of a sample, or of a case without samples [s].",
)
@click.option(
    "--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="Format of the summary."
)
@click.pass_context
def sweep_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    out: Path,
    systems: tuple[str, ...],
    keyword: str,
    samples: int | None,
    executor: str,
    scheduler: str,
    jobs: int,
    time_limit: float,
    form: str,
) -> None:
    """Judge every variant and every sample of FILE, and write a row for each, or continue such a file."""
    if scheduler and executor != "dask":
        raise click.UsageError("--scheduler needs a Dask cluster; add --executor dask")
    if executor == "dask" and context.get_parameter_source("jobs") is not ParameterSource.DEFAULT:
        raise click.UsageError("--jobs does not apply to a Dask cluster, which has its own workers; remove --jobs")
    try:
        under_way = _UnderWay(_planned(context, file, Selection(systems, keyword), samples, time_limit), out, form)
    except KeyboardInterrupt:
        tell(f"interrupted before the sweep began: {_kept(out)}")
        context.exit(ExitCode.INTERRUPTED)
    if executor == "dask":
        context.exit(under_way.run(lambda: _cluster(scheduler)))
    context.exit(under_way.run(lambda: own_processes(jobs)))


def _planned(
    context: click.Context, file: Path, selection: Selection, samples: int | None, time_limit: float
) -> SweepPlan:
    gathered, selected = selected_of(file, selection)
    if gathered.diagnostics:
        context.exit(ExitCode.INVALID)
    cases = [*_playable(selected)]
    if not cases:
        context.exit(ExitCode.USAGE)
    try:
        return plan_of(cases, samples, time_limit)
    except NothingToSweepError as error:
        raise click.UsageError(str(error)) from error


def _kept(out: Path) -> str:
    """Describe the rows of earlier calls, which are not counted yet."""
    if out.exists():
        return f"{out} is as it was; the same call continues it"
    return "no row was written; the same call starts again"


def _playable(cases: Sequence[Case]) -> Iterator[Case]:
    """Yield the cases that can be played here; report why the others cannot."""
    for case in cases:
        why = case.skip if case.skip is not None else unplayable(case.system)
        if why:
            tell(f"{case.name}: skipped: {why}")
        else:
            yield case


@contextmanager
def _cluster(scheduler: str) -> Iterator[Workers]:
    with dask_cluster(scheduler) as workers:
        if not workers.capacity():
            tell("the cluster has no workers yet; waiting for workers")
        yield workers


class _UnderWay:
    """A running sweep, with its progress."""

    def __init__(self, plan: SweepPlan, out: Path, form: str) -> None:
        self.plan, self.out, self.form = plan, out, form
        self.counts = Counts()
        self.has_begun = False  # whether existing rows are counted

    def run(self, workers: Callable[[], AbstractContextManager[Workers]]) -> ExitCode:
        """Run the sweep, report its summary, and return the exit code. Raises click.ClickException."""
        code = ExitCode.OK
        try:
            with counted(self.plan.total, "rows") as done:
                sweep(self.plan, self.out, workers, done, self._begins)
        except (RowsError, NoClusterError) as error:
            if not self.counts.rows:
                raise click.ClickException(str(error)) from error
            tell(str(error))
            code = ExitCode.USAGE
        except SweepError as error:
            tell(str(error))
            code = ExitCode.CRASHED
        except KeyboardInterrupt:
            if not self.has_begun:
                tell(f"interrupted before the sweep began: {_kept(self.out)}")
                return ExitCode.INTERRUPTED
            if self.counts.rows < self.plan.total:
                tell("interrupted")
                code = ExitCode.INTERRUPTED
        found = swept_cases(self.plan, self.counts)
        self._tell(found)
        failed = code is ExitCode.OK and any(each.failed for each in found)
        return ExitCode.CRASHED if failed else code

    def _begins(self, counts: Counts) -> None:
        self.counts, self.has_begun = counts, True
        if counts.rows:
            tell(f"{self.out} has {counts.rows} of {self.plan.total} rows")

    def _tell(self, found: Sequence[SweptCase]) -> None:
        if self.form != "text":
            write_data(sweep_table(found).written_as(self.form), self.form)
        elif self.counts.rows:
            write("".join(f"{line}\n" for line in sweep_lines(found)))
        if self.counts.rows < self.plan.total:
            rows = f"{self.counts.rows} of {self.plan.total} rows are in {self.out}"
            tell(f"{rows}; the same call continues them")
