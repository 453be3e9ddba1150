"""`stackdsl find`: the largest or the least number with which a scenario stands, proven from both sides."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from stackdsl.checking.gathering import Case
from stackdsl.checking.selection import Selection
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE, Number
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write, write_data
from stackdsl.exits import ExitCode
from stackdsl.finding.find_limit import ACCURACY, FINEST, FoundLimit, Want, Wish, find_in
from stackdsl.finding.sought import SoughtError
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.quantities import ANGLE, parse_quantity
from stackdsl.report.limit_text import limit_csv, limit_json, limit_lines

USUALLY = 60  # numbers that are tried; a bar has to end somewhere


def _bearing(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    try:
        return None if value is None else parse_quantity(value, ANGLE)
    except MistakeError as mistake:
        raise click.BadParameter(f"{mistake.message}; {mistake.hint}", context, parameter) from mistake


@click.command("find")
@ONE_FILE
@click.option("--largest", metavar="NAME", multiple=True, help="The largest number with which it stands.")
@click.option("--least", metavar="NAME", multiple=True, help="The least number with which it stands.")
@click.option("--most", metavar="NAME", multiple=True, help="The largest whole number with which it stands.")
@click.option("--from", "low", metavar="VALUE", default="", help="Search from here.")
@click.option("--to", "high", metavar="VALUE", default="", help="Search up to here.")
@click.option(
    "--within",
    "accuracy",
    type=Number(FINEST, 0.5),
    default=ACCURACY,
    show_default=True,
    help="Share by which both sides of a limit may be apart.",
)
@click.option("--bearing", callback=_bearing, metavar="ANGLE", help="Of a tilt or an acceleration; default: the worst.")
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.pass_context
def find_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    largest: tuple[str, ...],
    least: tuple[str, ...],
    most: tuple[str, ...],
    low: str,
    high: str,
    accuracy: float,
    bearing: float | None,
    systems: tuple[str, ...],
    keyword: str,
    form: str,
) -> None:
    """Find the largest or the least number with which FILE stands, proven from both sides; nothing is played."""
    wanted = [*((Want.LARGEST, name) for name in largest), *((Want.LEAST, name) for name in least)]
    wanted += [(Want.MOST, name) for name in most]
    if not wanted:
        raise click.UsageError("say what to find, such as --largest step, --least friction or --most levels")
    wishes = [Wish(want, name.strip(), low, high, accuracy, bearing) for want, name in wanted]
    gathered, selected = selected_of(file, Selection(systems, keyword))
    found: list[FoundLimit] = []
    try:
        for finding in _found(selected, wishes):
            found.append(finding)
            if form == "text":
                write("\n".join(limit_lines(finding)) + "\n")
    finally:  # also of what is interrupted
        if form == "csv":
            write_data(limit_csv(found), "csv")
        elif form == "json":
            write_data(json.dumps(limit_json(found), indent=2) + "\n", "json")
    context.exit(code_without_runs(gathered, selected) if found or not selected else ExitCode.USAGE)


def _found(selected: Sequence[Case], wishes: Sequence[Wish]) -> Iterator[FoundLimit]:
    """What is found of each case that can be asked; why others cannot is told."""
    for wish in wishes:
        for name, case in variants_of(selected, wish.name).items():
            try:
                with counted(USUALLY, f"{name}: {wish.want} {wish.name}") as tried:
                    finding = find_in(case, name, wish, tried)
            except SoughtError as error:
                tell(f"{name}: {error}")
                continue
            yield finding
