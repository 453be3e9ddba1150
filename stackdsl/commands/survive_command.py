"""`stackdsl survive`: what a structure survives when it is shaken or tilted, by bearing, and what gives way first."""

import json
from pathlib import Path

import click

from stackdsl.asked_files import write_asked
from stackdsl.checking.gathering import Case
from stackdsl.checking.selection import Selection
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE, FilePath, Number
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write, write_data
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.survival import Survival, survival_of
from stackdsl.report.matplotlib_figures import HINT
from stackdsl.report.survival_plot import drawn
from stackdsl.report.survival_text import survival_csv, survival_json, survival_lines

PLOTS = (".svg", ".png")
FEWEST, MOST = 4, 3600


@click.command("survive")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option(
    "--bearings", type=click.IntRange(FEWEST, MOST), default=72, show_default=True, help="Directions, evenly around."
)
@click.option("--accuracy", type=Number(1e-6, 0.5), default=0.01, show_default=True, help="Share that may be unproven.")
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.option("--plot", type=FilePath, help="Draw it to this .svg or .png; of one case.")
@click.pass_context
def survive_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    bearings: int,
    accuracy: float,
    form: str,
    plot: Path | None,
) -> None:
    """Tell what the finished structure of FILE survives when it is shaken or tilted, and what gives way first."""
    if plot is not None and plot.suffix.lower() not in PLOTS:
        raise click.UsageError(f"{plot}: write to a file that ends in {' or '.join(PLOTS)}")
    gathered, selected = selected_of(file, Selection(systems, keyword))
    cases = list(variants_of(selected).items())
    if plot is not None and len(cases) > 1:
        raise click.UsageError(f"--plot draws one case, and there are {len(cases)}: choose one with -k")
    found: list[tuple[str, Survival]] = []
    for name, case in cases:
        survival = _survival(name, case, bearings, accuracy)
        if survival is not None:
            found.append((name, survival))
            if form == "text":
                write("\n".join(survival_lines(name, survival)) + "\n")
    if form == "csv":
        write_data(survival_csv(found), "csv")
    elif form == "json":
        write_data(json.dumps(survival_json(found), indent=2) + "\n", "json")
    if plot is not None and found:
        _draw(*found[0], plot)
    context.exit(code_without_runs(gathered, selected))


def _survival(name: str, case: Case, bearings: int, accuracy: float) -> Survival | None:
    """What a case survives; why it is not known is told."""
    proofs = proofs_of(case.timeline)
    verdict, standing = proofs.verdict, len(proofs.assembly.bricks)
    count = sum(not placement.hits for placement in case.timeline.placements)
    if standing == 0:
        tell(f"{name}: nothing is set down at rest, so there is nothing that statics could judge")
        return None
    if verdict.reason:
        tell(f"{name}: {verdict.stability.upper()}: {verdict.reason}; what does not stand survives nothing")
        return None
    if standing < count:
        tell(
            f"{name}: this is what {standing} of {count} bricks survive; the engine has a word in all that comes after"
        )
    with counted(bearings, f"{name}: bearings") as known:
        survival = survival_of(proofs.assembly, bearings, accuracy, known)
    if survival is None:
        tell(f"{name}: no forces were found deep enough within friction to say what it survives")
    return survival


def _draw(name: str, survival: Survival, path: Path) -> None:
    try:
        write_asked(path, drawn(name, survival, path.suffix))
    except ModuleNotFoundError as error:
        raise click.ClickException(f"--plot needs {error.name}, which is not installed; try: {HINT}") from error
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}") from error
