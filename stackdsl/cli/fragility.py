"""`stackdsl fragility`: share of samples that fall, over an acceleration, tilt, friction, errors or a variable."""

from collections.abc import Iterator, Sequence
from functools import partial
from math import radians
from pathlib import Path

import click

from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case
from stackdsl.checking.selection import Selection
from stackdsl.cli.check import goldens_and_state, project_around
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.one_file import ON_FORM, ON_PLOT, draw, refuse_several
from stackdsl.cli.options import (
    ON_JOBS,
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    Number,
    code_without_runs,
    complain,
    selected_of,
)
from stackdsl.cli.terminal import counted, tell, write, write_data
from stackdsl.exits import ExitCode
from stackdsl.report.studies import capacities_table, fragility_lines, fragility_table
from stackdsl.studies.fragility import CurveResult, FragilityPlan
from stackdsl.studies.fragility import draw as draw_samples
from stackdsl.studies.fragility_curve import FEWEST_POINTS, Fragility
from stackdsl.studies.fragility_request import (
    LEAST_CONFIDENCE,
    MOST_CONFIDENCE,
    MOST_POINTS,
    POINTS,
    FragilityRequest,
    FragilityRequestError,
    NotProvenError,
    plan_of,
)
from stackdsl.viewing.plots import drawn_fragility as drawn_plot

RANDOM = """so all runs would be the same. Add these lines:

  samples: 1000
  build:
    - ...                          # a step of the file
      jitter: {position: 1 mm}     # placement errors of this step
  expect:
    - stands: {share: '>= 95 %'} # in place of claims without a share"""


@click.command("fragility", cls=ExplainedCommand)
@ONE_FILE
@click.option(
    "--over",
    required=True,
    metavar="INTENSITY",
    help="One of acceleration (constant and horizontal, not the peak of a record), tilt, friction, jitter, "
    "or a variable of the file.",
)
@click.option(
    "--from",
    "first",
    help="Least intensity, such as '0.5 mm' or '0.1 g'. Default: a quarter of the value in FILE; for acceleration and "
    "tilt, points where the samples fall.",
)
@click.option("--to", "last", help="Largest intensity. Default: four times the value in FILE.")
@click.option(
    "--points",
    type=click.IntRange(FEWEST_POINTS, MOST_POINTS),
    default=POINTS,
    show_default=True,
    help="Number of points.",
)
@click.option(
    "--samples", type=click.IntRange(1), help="Samples at each point. Default: `samples` of the scenario, at most 1000."
)
@click.option("--seed", type=click.IntRange(0), help="Random seed. Default: that of the scenario.")
@click.option(
    "--confidence",
    type=Number(LEAST_CONFIDENCE, MOST_CONFIDENCE),
    help="Confidence of all intervals. Default: that of the scenario.",
)
@click.option(
    "--bearing", type=float, help="Direction of acceleration or tilt [deg]. Default: the worst of each sample."
)
@ON_SYSTEMS
@ON_KEYWORD
@ON_JOBS
@click.option("--cache/--no-cache", default=True, help="Whether to reuse the results of an interrupted call.")
@click.option(
    "--capacities",
    type=FilePath,
    help="Write the acceleration or tilt that each sample survives to this .csv file.",
)
@ON_FORM
@ON_PLOT
@click.pass_context
def fragility_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    over: str,
    first: str | None,
    last: str | None,
    points: int,
    samples: int | None,
    seed: int | None,
    confidence: float | None,
    bearing: float | None,
    systems: tuple[str, ...],
    keyword: str,
    jobs: int,
    cache: bool,
    capacities: Path | None,
    form: str,
    plot: Path | None,
) -> None:
    """Compute the share of samples of FILE that fall at each intensity, and fit a lognormal curve."""
    direction = None if bearing is None else radians(bearing)
    asked = FragilityRequest(over, first, last, points, samples, seed, confidence, direction)
    gathered, selected = selected_of(file, Selection(systems, keyword))
    plans = list(_plans(selected, asked))
    refuse_several(plot, len(plans))
    if capacities is not None and not all(plan.has_capacities for _, plan in plans):
        raise click.UsageError("--capacities applies only to acceleration and tilt; remove it")
    memory = _memory(file, cache)
    curves: list[tuple[str, Fragility]] = []
    code = code_without_runs(gathered, selected)
    for name, plan in plans:
        found = _drawn(name, plan, jobs, memory)
        fragility = found.fragility()
        if fragility is not None:
            curves.append((name, fragility))
            if form == "text":
                write("\n".join(fragility_lines(name, fragility)) + "\n")
        code = _code(name, found) or code
        if found.interrupted:
            break
    if form != "text":
        write_data(fragility_table(curves).written_as(form), form)
    if plot is not None and curves:
        draw(partial(drawn_plot, *curves[0]), plot)
    if capacities is not None and curves:
        draw(lambda _: capacities_table(curves).csv().encode(), capacities)
    context.exit(code)


# --- requested curves -------------------------------------------------------------------------------------------------


def _plans(cases: Sequence[Case], asked: FragilityRequest) -> Iterator[tuple[str, FragilityPlan]]:
    """Yield the requested curves. Variants that differ only in the varied value share one."""
    seen: set[str] = set()
    sampled = [case for case in cases if case.is_sampled]
    if cases and not sampled:
        name = cases[0].scenario.scenario
        raise click.UsageError(f"the scenario '{name}' has no samples and no random quantities, {RANDOM}")
    for case in sampled:
        try:
            plan = plan_of(case, asked)
        except NotProvenError as error:
            tell(f"{case.name}: skipped: {error}")
            continue
        except FragilityRequestError as error:
            raise click.UsageError(str(error)) from error
        if plan.name not in seen:
            seen.add(plan.name)
            yield plan.name, plan


def _memory(file: Path, used: bool) -> ResultCache:
    return ResultCache(goldens_and_state(project_around((file,)))[1], used)


# --- computation ------------------------------------------------------------------------------------------------------


def _drawn(name: str, plan: FragilityPlan, jobs: int, memory: ResultCache) -> CurveResult:
    tell(f"{name}: {_told(plan)}")
    with counted(plan.work, f"{name}: samples") as known:
        done = 0

        def on_done(count: int) -> None:
            nonlocal done
            done = count
            known(count)

        return draw_samples(plan, jobs, memory, on_done, lambda: known(done))


def _told(plan: FragilityPlan) -> str:
    """Describe the plan, with the default values of options."""
    samples = f"{plan.samples} samples, seed {plan.seed}"
    if plan.has_capacities:
        return f"{samples}; computing the constant {plan.intensity.name} that each survives once built"
    how = "in equal ratios" if plan.values[0] > 0.0 else "at equal distances"
    return f"{len(plan.values)} points over {plan.intensity.name}, {how}; the same {samples}, at each point"


def _code(name: str, found: CurveResult) -> ExitCode | None:
    """Return the exit code of a failure, and report it; None on success."""
    if found.mistake is not None:
        complain([found.mistake])
        return ExitCode.INVALID
    if found.failed is not None:
        tell(f"{name}: {found.failed.status}: {found.failed.message}")
        return ExitCode.CRASHED
    if found.interrupted:
        tell("interrupted: only the finished part is reported; the same call continues it")
        return ExitCode.INTERRUPTED
    return None
