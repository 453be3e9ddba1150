"""`stackdsl export`: converts a scenario to a file of another program."""

from pathlib import Path

import click

from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import ON_KEYWORD, ONE_FILE, code_without_runs, selected_of
from stackdsl.cli.terminal import tell, write
from stackdsl.compiler.bricks import resolved_bricks
from stackdsl.compiler.schedule import planes_of
from stackdsl.importers.ldraw import LdrawBrick, NoPartError, ldraw_text


@click.command("export", cls=ExplainedCommand)
@ONE_FILE
@ON_KEYWORD
@click.pass_context
def export_command(context: click.Context, file: Path, keyword: str) -> None:
    """Convert the bricks of one case of FILE to an LDraw model, and print it."""
    gathered, selected = selected_of(file, Selection((), keyword))
    if not selected:
        context.exit(code_without_runs(gathered, selected))
    case = selected[0]
    if any(other.variant is not case.variant for other in selected):
        tell(f"exporting {case.name}, the first of {len(selected)}; choose another with -k")
    bricks = [
        LdrawBrick(brick.name, brick.written.shape, brick.written.pose, brick.level, brick.written.kind.smooth)
        for brick in resolved_bricks(case.scenario, tuple(planes_of(case.scenario)))
        if not brick.written.inserted
    ]
    try:
        write(ldraw_text(case.scenario_name, bricks))
    except NoPartError as error:
        raise click.UsageError(str(error)) from error
