"""`stackdsl order`: an order in which a finished structure can be built, and the least props."""

from pathlib import Path
from typing import Any

import click

from stability.statics.assembly import Assembly
from stability.statics.orders.building import BuildingOrder, OrderSearch
from stability.statics.orders.parts import Parts
from stability.statics.orders.props import props_of
from stackdsl.checking.selection import Selection
from stackdsl.commands.asking_statics import AS, Rows, told
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, ONE_FILE
from stackdsl.commands.selecting import code_without_runs, selected_of, variants_of
from stackdsl.commands.terminal import counted, tell, write
from stackdsl.exits import ExitCode
from stackdsl.judging.designs import design_of
from stackdsl.report.orders_text import order_lines, order_rows
from stackdsl.wording import how_many

MOST = 1500


@click.command("order")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--props/--no-props", default=True, show_default=True, help="Whether bricks may be propped for a while.")
@click.option("--most", type=click.IntRange(min=1), default=MOST, show_default=True, help="Verdicts asked in all.")
@AS
@click.pass_context
def order_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context, file: Path, systems: tuple[str, ...], keyword: str, props: bool, most: int, form: str
) -> None:
    """Find an order in which the finished structure of FILE can be built, standing at each step, or the least props."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    orders: list[dict[str, Any]] = []
    interrupted = False
    for name, case in variants_of(selected).items():
        found = design_of(case.timeline)
        if found.why_not:
            tell(f"{name}: {found.why_not}")
            continue
        if found.left_out:
            tell(f"{name}: {how_many(found.left_out, 'brick')} left to the engine, and left out here")
        order, interrupted = _searched(name, found.assembly, props, most)
        if form == "text":
            write("\n".join([name, *order_lines(order, interrupted)]) + "\n")
        rows += [(name, row) for row in order_rows(order)]
        orders.append({"case": name, **_summary(order), "interrupted": interrupted})
        if interrupted:
            break
    told(rows, form, orders)
    context.exit(ExitCode.INTERRUPTED if interrupted else code_without_runs(gathered, selected))


def _summary(order: BuildingOrder) -> dict[str, Any]:
    return {"impossible": order.impossible, "props": list(order.props), "props_at_least": order.props_at_least}


def _searched(name: str, design: Assembly, props: bool, most: int) -> tuple[BuildingOrder, bool]:
    """The best order that is found, and whether the search was interrupted."""
    most = max(most, len(design.bricks))
    with counted(most, f"{name}: parts") as known:
        search = OrderSearch(Parts(design, props_of(design) if props else None), most, known)
        try:
            return search.run(), False
        except KeyboardInterrupt:
            return search.best, True
