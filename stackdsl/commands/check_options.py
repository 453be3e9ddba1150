"""The options of `stackdsl check`, and what each may be."""

import os
import re
from collections.abc import Callable
from math import isnan
from pathlib import Path
from typing import Final, TypedDict, TypeVar

import click

from stackdsl.checking.check import TIME_LIMIT
from stackdsl.checking.selection import Shard
from stackdsl.commands.formats import Output, OutputChoice
from stackdsl.commands.options import LONGEST_LIMIT, ON_KEYWORD, ON_SYSTEMS, ON_TAGS, FilePath, Number

Command = TypeVar("Command", bound=Callable[..., object])

_SHARD: Final = re.compile(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})")


class Asked(TypedDict):
    """What was asked for."""

    paths: tuple[Path, ...]
    systems: tuple[str, ...]
    keyword: str
    tags: tuple[str, ...]
    shard: Shard | None
    only_failed: bool
    only_changed: bool
    list_only: bool
    statics: bool
    first_failure: bool
    strict: bool
    watch: bool
    outputs: tuple[Output, ...]
    verbosity: int
    durations: int
    update: bool
    though_it_fails: bool
    refine: bool
    golden: Path | None
    no_golden: bool
    cache: bool
    html: Path | None
    jobs: int
    time_limit: float


def _number(value: float) -> float:
    """A number that is one: no range excludes nan."""
    if isnan(value):
        raise click.BadParameter("nan is no number.")
    return value


def _shard(text: str | None) -> Shard | None:
    if text is None:
        return None
    found = _SHARD.fullmatch(text)
    if found is None or int(found[1]) > int(found[2]):
        raise click.BadParameter(f"'{text}' is no part of a whole; write it like 1/4, up to 4/4")
    return Shard(int(found[1]), int(found[2]))


OPTIONS: Final = (
    click.argument("paths", nargs=-1, type=FilePath),
    ON_SYSTEMS,
    ON_KEYWORD,
    ON_TAGS,
    click.option("--shard", callback=lambda *given: _shard(given[-1]), help="Only this part of all cases, as 1/4."),
    click.option("--failed", "only_failed", is_flag=True, help="Only what failed when it was last played."),
    click.option("--changed", "only_changed", is_flag=True, help="Only what is not known to pass as it stands."),
    click.option("--list", "list_only", is_flag=True, help="Print the names of the selected cases and stop."),
    click.option("--statics", is_flag=True, help="Play nothing: tell what the proofs say, and stop."),
    click.option("-x", "first_failure", is_flag=True, help="Stop at the first failure."),
    click.option("--strict", is_flag=True, help="Let also fail of what nothing is expected: what is unchecked."),
    click.option("--watch", is_flag=True, help="Check again whenever a scenario is saved, until interrupted."),
    click.option(
        "--format",
        "outputs",
        multiple=True,
        type=OutputChoice(),
        help="How the report is written, and to which file: text, json, junit=report.xml; may be given several times.",
    ),
    click.option(
        "--html", type=FilePath, help="Also write pages into this folder: an index, and a replay of each case."
    ),
    click.option("-q", "--quiet", "verbosity", flag_value=-1, type=int, help="Only what failed, and the sums."),
    click.option("-v", "--verbose", "verbosity", flag_value=1, type=int, default=0, help="All there is to tell."),
    click.option("--durations", type=click.IntRange(0), default=0, metavar="N", help="Also the N slowest cases."),
    click.option("--update", is_flag=True, help="Accept what comes out as the new golden files. Refused in CI."),
    click.option("--though-it-fails", is_flag=True, help="With --update, accept also what fails its expectations."),
    click.option("--refine", is_flag=True, help="Play again, half the step and twice the iterations; tell what moves."),
    click.option("--golden", type=FilePath, help="Directory of the golden files; default: that of the project."),
    click.option("--no-golden", is_flag=True, help="Neither compare with golden files nor write any."),
    click.option("--cache/--no-cache", default=True, help="Whether what is known to pass need not be played again."),
    click.option(
        "--jobs", type=click.IntRange(1, 256), default=os.cpu_count() or 1, help="Processes; default: one a core."
    ),
    click.option(
        "--time-limit",
        type=Number(0.001, LONGEST_LIMIT),
        callback=lambda *given: _number(given[-1]),
        default=TIME_LIMIT,
        show_default=True,
        help="Seconds a case.",
    ),
)


def with_options(command: Command) -> Command:
    """A command with all these options, in this order."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command
