"""`stackdsl sheet`: writes the page of a packed load that a person signs."""

from datetime import UTC, datetime
from pathlib import Path

import click

from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.one_file import refusing
from stackdsl.cli.options import (
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    code_without_runs,
    prepare_file,
    selected_of,
)
from stackdsl.cli.run import write_file
from stackdsl.cli.terminal import tell
from stackdsl.exits import ExitCode
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import unplayable
from stackdsl.studies.survival import margins_in
from stackdsl.viewing.packing_sheet import sheet_page


@click.command("sheet", cls=ExplainedCommand)
@ONE_FILE
@click.option("-o", "--output", type=FilePath, required=True, help="File to write: .html.")
@ON_SYSTEMS
@ON_KEYWORD
@click.pass_context
def sheet_command(context: click.Context, file: Path, output: Path, systems: tuple[str, ...], keyword: str) -> None:
    """Write the sheet of a load in FILE that a person signs: limits, layers, order of placing, weakest carton."""
    if output.suffix.lower() != ".html":
        raise click.UsageError(f"{output}: the file name must end in .html; a browser prints it to paper or PDF")
    prepare_file(output)
    gathered, selected = selected_of(file, Selection(systems, keyword))
    if not selected:
        context.exit(code_without_runs(gathered, selected))
    case = selected[0]
    if len(selected) > 1:
        tell(f"the sheet is that of {case.name}, the first of {len(selected)}; choose another with -k or --system")
    if why := unplayable(case.system):
        raise click.ClickException(f"{case.name} cannot be played: {why}")
    try:
        trace = play_case(case.timeline, case.system)
    except BlockedPlacementError as error:
        raise click.ClickException(f"{case.name} was blocked: {error}") from error
    with refusing(f"{case.name}: `sheet`", "divide the load") as refused:
        result = judged(case, trace)
        page = sheet_page(case, trace, result, margins_in(case, case.name), datetime.now(UTC))
        write_file(output, page.encode())
        context.exit(ExitCode.OK if result.passed else ExitCode.FAILED)
    if refused:
        context.exit(ExitCode.INVALID)
