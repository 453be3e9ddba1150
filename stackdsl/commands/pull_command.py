"""`stackdsl pull`: which bricks can be pulled out of what stands, how many one after the other, how soon it falls."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.orders.parts import Parts
from stability.statics.orders.pulls import LongestSearch, Pull, carrying, single_pulls, soonest_fall
from stackdsl.checking.gathering import Case
from stackdsl.checking.selection import Selection
from stackdsl.commands.asking_statics import AS, Rows, told
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write
from stackdsl.judging.designs import design_of
from stackdsl.report.orders_text import longest_lines, pull_lines, pull_row, soonest_line
from stackdsl.wording import how_many

MOST = 5000


@click.command("pull")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--all", "all_bricks", is_flag=True, help="Orders may also take bricks that carry nothing.")
@click.option("--single", is_flag=True, help="Pull each brick by itself only, and look for no orders.")
@click.option(
    "--most", type=click.IntRange(min=1), default=MOST, show_default=True, help="Verdicts asked for each order."
)
@AS
@click.pass_context
def pull_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    all_bricks: bool,
    single: bool,
    most: int,
    form: str,
) -> None:
    """Tell which bricks of the finished structure of FILE can be pulled, and how many one after the other."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    orders: list[dict[str, Any]] = []
    try:
        for name, case in variants_of(selected).items():
            _case(name, case, (all_bricks, single, most, form), rows, orders)
    finally:  # an interruption keeps what is known
        told(rows, form, orders)
    context.exit(code_without_runs(gathered, selected))


def _case(name: str, case: Case, how: tuple[bool, bool, int, str], rows: Rows, orders: list[dict[str, Any]]) -> None:
    all_bricks, single, most, form = how
    found = design_of(case.timeline)
    if found.why_not:
        tell(f"{name}: {found.why_not}")
        return
    if found.left_out:
        tell(f"{name}: {how_many(found.left_out, 'brick')} left to the engine, and left out here")
    _one_at_a_time(name, found.assembly, form == "text", rows)
    may_go = list(found.assembly.bricks) if all_bricks else carrying(found.assembly)
    if may_go and not single:
        orders.append({"case": name})
        _one_after_the_other(found.assembly, may_go, most, form == "text", orders[-1])


def _one_at_a_time(name: str, design: Assembly, show: bool, rows: Rows) -> None:
    pulls: list[Pull] = []
    try:
        with counted(len(design.bricks), f"{name}: pulls") as known:
            for pull in single_pulls(design):
                pulls.append(pull)
                known(len(pulls))
    finally:
        rows += [(name, pull_row(pull)) for pull in pulls]
        if show and pulls:
            write("\n".join([name, *pull_lines(pulls)]) + "\n")


def _one_after_the_other(
    design: Assembly, bricks: Sequence[BodyId], most: int, show: bool, row: dict[str, Any]
) -> None:
    """Look for orders, and add them to a row."""
    parts = Parts(design)
    may_go = parts.part_of(bricks)
    with counted(most, f"{row['case']}: orders") as known:
        search = LongestSearch(parts, may_go, most, known)
        try:
            search.run()
        finally:  # an interruption keeps the best by then
            longest = search.best
            row |= {"longest": list(longest.order), "at_most": longest.at_most, "proven": longest.proven}
            if show:
                write("\n".join(longest_lines(longest)) + "\n")
        parts.asked = 0
        soonest = soonest_fall(parts, may_go, most, known)
    row |= {"falls_soonest": list(soonest.order), "falls_at_least": soonest.at_least}
    if show:
        write(soonest_line(soonest) + "\n")
