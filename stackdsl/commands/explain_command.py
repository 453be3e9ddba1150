"""`stackdsl explain`: prints what a file was compiled to, and what statics says of it; or what a diagnostic means."""

import os
from itertools import groupby
from pathlib import Path

import click

from stackdsl.checking.selection import Selection
from stackdsl.commands.options import ON_KEYWORD, ON_SYSTEMS, FilePath
from stackdsl.commands.selecting import code_without_runs, selected_of
from stackdsl.commands.terminal import write
from stackdsl.diagnostics import did_you_mean
from stackdsl.report.code_text import CODE, code_text, entries
from stackdsl.report.explanation import explanation_text
from stackdsl.report.proof_text import Extent


@click.command("explain")
@click.argument("file", metavar="FILE|CODE", type=FilePath)
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--margins/--no-margins", default=None, help="What the proofs would survive; default: of few bricks.")
@click.option("--remedies/--no-remedies", default=None, help="What would mend a fall; default: of few bricks.")
@click.option("--times", is_flag=True, help="What each proof cost, which differs from run to run.")
@click.pass_context
def explain_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    margins: bool | None,
    remedies: bool | None,
    times: bool,
) -> None:
    """Print what FILE was compiled to, and what statics says of it; or what a CODE such as SD104 means."""
    if CODE.fullmatch(str(file)) and not os.path.exists(file):
        write(_meaning(str(file)))
        return
    gathered, selected = selected_of(file, Selection(systems, keyword))
    for _, cases in groupby(selected, key=lambda case: (case.scenario.scenario, case.variant.parameters)):
        write(explanation_text(list(cases), Extent(margins, remedies, times)))
    context.exit(code_without_runs(gathered, selected))


def _meaning(code: str) -> str:
    """What a code of a diagnostic means. Raises a usage error for one that there is not."""
    known = entries()
    if code not in known:
        raise click.UsageError(f"there is no code {code}; {did_you_mean(code, list(known))}")
    return code_text(known[code])
