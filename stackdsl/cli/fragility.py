"""`stackdsl fragility`: the share of samples that fall, over friction, shaking, tilt, errors of hands or a variable."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import radians
from pathlib import Path

import click

from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case
from stackdsl.checking.selection import Selection
from stackdsl.cli.check import goldens_and_state, project_around
from stackdsl.cli.one_file import ON_FORM, ON_PLOT, draw, refuse_several
from stackdsl.cli.options import (
    ON_JOBS,
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    Number,
    code_without_runs,
    complain,
    selected_of,
)
from stackdsl.cli.terminal import counted, tell, write, write_data
from stackdsl.exits import ExitCode
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import InputError
from stackdsl.report.plots import drawn_fragility as drawn_plot
from stackdsl.report.studies import fragility_lines, fragility_table
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.studies.fragility import CurveResult, FragilityPlan
from stackdsl.studies.fragility import draw as draw_samples
from stackdsl.studies.fragility_curve import Fragility, spaced
from stackdsl.studies.fragility_intensity import SHAKING, Intensity, IntensityKind, NoIntensityError, intensity_of

MOST_POINTS = 1000
USUAL = 1000  # samples at each point at most, unless more are asked for
AROUND = 4.0  # times less and more than what is written, unless a range is asked for


@dataclass(frozen=True, slots=True)
class _Asked:
    """The options of `fragility`."""

    over: str
    first: str | None
    last: str | None
    points: int
    samples: int | None
    seed: int | None
    confidence: float | None
    bearing: float | None


@click.command("fragility")
@ONE_FILE
@click.option("--over", required=True, metavar="INTENSITY", help="friction, acceleration, tilt, jitter, or a variable.")
@click.option("--from", "first", help="The least of it, such as 0.5 mm. Default: a quarter of what is written.")
@click.option("--to", "last", help="The most of it. Default: four times what is written.")
@click.option("--points", type=click.IntRange(2, MOST_POINTS), default=11, show_default=True, help="How many between.")
@click.option(
    "--samples", type=click.IntRange(1), help="At each point. Default: the scenario's `samples`, at most 1000."
)
@click.option("--seed", type=click.IntRange(0), help="Default: the scenario's.")
@click.option("--confidence", type=Number(0.5, 0.999999), help="Of all intervals. Default: the scenario's.")
@click.option(
    "--bearing", type=float, help="Of acceleration and tilt [deg]: bricks are pulled so. Default: each sample's worst."
)
@ON_SYSTEMS
@ON_KEYWORD
@ON_JOBS
@click.option(
    "--cache/--no-cache", default=True, help="Take over what an earlier call judged before it was interrupted."
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
    form: str,
    plot: Path | None,
) -> None:
    """Tell which share of the samples of FILE falls, point by point over an intensity, with a lognormal curve."""
    asked = _Asked(over, first, last, points, samples, seed, confidence, bearing)
    gathered, selected = selected_of(file, Selection(systems, keyword))
    plans = list(_plans(selected, asked))
    refuse_several(plot, len(plans))
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
    context.exit(code)


# --- what is asked for ------------------------------------------------------------------------------------------------


def _plans(cases: Sequence[Case], asked: _Asked) -> Iterator[tuple[str, FragilityPlan]]:
    """Yield the curves: variants that differ only in the varied value, or in their system, are one."""
    seen: set[str] = set()
    sampled = [case for case in cases if case.is_sampled]
    if cases and not sampled:
        message = "nothing is uncertain, so that all samples would be the same"
        raise click.UsageError(
            f"{message}: say `samples: 1000`, and `jitter: {{position: 1 mm}}` in a step of the build"
        )
    for case in sampled:
        try:
            intensity = intensity_of(asked.over, case.variant, case.timeline)
        except NoIntensityError as error:
            raise click.UsageError(f"--over {asked.over}: {error}") from error
        shakes = intensity.kind in SHAKING
        if shakes and system_named(case.system).method is not Method.PROVEN:
            tell(f"{case.name}: what is survived is a matter of statics, and not of '{case.system}'")
            continue
        chosen = [f"{key}={text}" for key, text in case.variant.parameters if key != intensity.name]
        name = f"{case.scenario.scenario}[{','.join([*chosen, case.system])}]"
        if name not in seen:
            seen.add(name)
            yield name, _plan(case, intensity, asked)


def _plan(case: Case, intensity: Intensity, asked: _Asked) -> FragilityPlan:
    written = case.scenario
    if asked.bearing is not None and intensity.kind not in SHAKING:
        raise click.UsageError("--bearing is of acceleration and tilt; leave it out")
    return FragilityPlan(
        case,
        intensity,
        _values(intensity, asked),
        asked.points,
        asked.samples or min(USUAL, written.samples or USUAL),
        written.seed if asked.seed is None else asked.seed,
        asked.confidence or written.confidence,
        None if asked.bearing is None else radians(asked.bearing),
    )


def _values(intensity: Intensity, asked: _Asked) -> tuple[float, ...]:
    """Return the values of the points in SI; none if they follow from the survived capacities."""
    ends = [_end(key, text, intensity) for key, text in (("--from", asked.first), ("--to", asked.last))]
    if ends == [None, None] and intensity.kind in SHAKING:
        return ()
    written = intensity.written
    if intensity.kind in SHAKING and ends[0] is None:
        ends[0] = 0.0
    if None in ends and (written is None or written <= 0.0):
        raise click.UsageError(f"--over {asked.over}: say --from and --to, as nothing above zero is written to go by")
    assert written is not None or None not in ends
    first, last = (
        end if end is not None else (written or 0.0) * times
        for end, times in zip(ends, (1 / AROUND, AROUND), strict=True)
    )
    if first >= last:
        raise click.UsageError(f"--from and --to: {asked.first or first} is not less than {asked.last or last}")
    if intensity.kind is IntensityKind.JITTER and first <= 0.0:
        raise click.UsageError("--from: errors of hands are more than zero; without any, all samples are the same")
    return tuple(float(f"{value:.15g}") for value in spaced(first, last, asked.points))


def _end(key: str, text: str | None, intensity: Intensity) -> float | None:
    if text is None:
        return None
    try:
        amount = constant(text)
    except InputError as mistake:
        raise click.UsageError(f"{key}: {mistake.message}; {mistake.hint}") from mistake
    value = float(amount.magnitude)
    if unit_text(amount) != intensity.unit and value != 0.0:
        wanted = f"a quantity in {intensity.unit}" if intensity.unit else "a number"
        wanted += ", in units of g" if intensity.kind is IntensityKind.ACCELERATION else ""
        raise click.UsageError(f"{key}: {text} is of another kind: {intensity.name} is {wanted}")
    if value < 0.0 and intensity.kind is not IntensityKind.VARIABLE:
        raise click.UsageError(f"{key}: {intensity.name} is not less than zero")
    return value


def _memory(file: Path, used: bool) -> ResultCache:
    return ResultCache(goldens_and_state(project_around((file,)))[1], used)


# --- carried out ------------------------------------------------------------------------------------------------------


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
    """Return the progress, with the options that were chosen by default."""
    samples = f"{plan.samples} samples, seed {plan.seed}"
    if plan.shakes:
        which = "each in its worst direction" if plan.bearing is None else "along the bearing"
        return f"what {samples} survive once they are built, {which}, is over {plan.intensity.name} how many fall"
    how = "alike in ratio" if plan.values[0] > 0.0 else "alike in distance"
    return f"{len(plan.values)} points, {how}, over {plan.intensity.name}; the same {samples}, at each"


def _code(name: str, found: CurveResult) -> ExitCode | None:
    """Return the exit code of a failure, and report it; None on success."""
    if found.mistake is not None:
        complain([found.mistake])
        return ExitCode.INVALID
    if found.failed is not None:
        tell(f"{name}: {found.failed.status}: {found.failed.message}")
        return ExitCode.CRASHED
    if found.interrupted:
        tell("interrupted: what is told is what was done; the same call goes on from there")
        return ExitCode.INTERRUPTED
    return None
