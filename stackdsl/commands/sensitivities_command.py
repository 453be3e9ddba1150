"""`stackdsl sensitivities`: on which bricks, joints and numbers the margin of a structure depends most."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from stackdsl.checking.gathering import Case
from stackdsl.checking.selection import Selection
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write, write_data
from stackdsl.finding.sensitivities import CHECKED, Of, Sensitivities, sensitivities_of
from stackdsl.finding.sought import SoughtError
from stackdsl.report.sensitivity_text import sensitivity_csv, sensitivity_json, sensitivity_lines

SHOWN = 15


@click.command("sensitivities")
@ONE_FILE
@click.option("--of", type=click.Choice([each.value for each in Of]), default=Of.ACCELERATION.value, help="The margin.")
@click.option(
    "--check", "checked", type=click.IntRange(0), default=CHECKED, show_default=True, help="So many by differences."
)
@click.option("--top", type=click.IntRange(1), default=SHOWN, show_default=True, help="So many lines of text.")
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.pass_context
def sensitivities_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    of: str,
    checked: int,
    top: int,
    systems: tuple[str, ...],
    keyword: str,
    form: str,
) -> None:
    """Tell on which bricks, joints and numbers of FILE its margin depends most; nothing is played."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    found: list[Sensitivities] = []
    try:
        for each in _found(selected, Of(of), checked):
            found.append(each)
            if form == "text":
                write("\n".join(sensitivity_lines(each, top)) + "\n")
    finally:  # also of what is interrupted
        if form == "csv":
            write_data(sensitivity_csv(found), "csv")
        elif form == "json":
            write_data(json.dumps(sensitivity_json(found), indent=2) + "\n", "json")
    context.exit(code_without_runs(gathered, selected))


def _found(selected: Sequence[Case], of: Of, checked: int) -> Iterator[Sensitivities]:
    """What is found of each case; why of some nothing is, is told."""
    for name, case in variants_of(selected).items():
        try:
            with counted(100, f"{name}: percent") as known:
                each = sensitivities_of(case, name, of, checked, lambda done, total: known(round(100 * done / total)))
        except SoughtError as error:
            tell(f"{name}: {error}")
            continue
        yield each
