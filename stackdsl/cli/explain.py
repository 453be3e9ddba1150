"""`stackdsl explain`, `schema` and `completion`."""

import os
import re
from itertools import groupby
from pathlib import Path

import click
from click.shell_completion import get_completion_class

from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.one_file import refusing
from stackdsl.cli.options import ON_KEYWORD, ON_SYSTEMS, FilePath, code_without_runs, selected_of
from stackdsl.cli.terminal import paper, staged, write
from stackdsl.exits import ExitCode
from stackdsl.report.diagnostics import code_text, entries
from stackdsl.report.statics import Extent, explanation_text

LIKE_CODE = re.compile(r"SD[0-9]{1,4}")


# `stackdsl explain`: prints a compiled scenario with its proofs, or the meaning of a diagnostic code.


@click.command("explain", cls=ExplainedCommand)
@click.argument("file", metavar="FILE|CODE", type=FilePath)
@ON_SYSTEMS
@ON_KEYWORD
@click.option(
    "--margins/--no-margins", default=None, help="Print the margins of the proofs. Default: only for few bricks."
)
@click.option("--remedies/--no-remedies", default=None, help="Print remedies for a fall. Default: only for few bricks.")
@click.option("--times", is_flag=True, help="Print the time of each proof, which differs between runs.")
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
    """Print the compiled scenario in FILE with its proofs, or the meaning of a CODE such as SD104."""
    if LIKE_CODE.fullmatch(str(file).upper()) and not os.path.exists(file):
        write(_meaning(str(file).upper()))
        return
    gathered, selected = selected_of(file, Selection(systems, keyword))
    code = code_without_runs(gathered, selected)
    for _, cases in groupby(selected, key=lambda case: (case.scenario.scenario, case.variant.parameters)):
        explained = list(cases)
        with refusing(f"{explained[0].scenario_name}: `explain`", "remove --margins and --remedies") as refused:
            with staged(explained[0].scenario_name) as on_stage:
                text = explanation_text(explained, Extent(margins, remedies, times, on_stage), paper()[0])
            write(text)
        code = ExitCode.INVALID if refused else code
    context.exit(code)


def _meaning(code: str) -> str:
    """Return the meaning of a diagnostic code. Raises a usage error for an unknown code."""
    known = entries()
    if code not in known:
        hundreds = [list(codes) for _, codes in groupby(known, key=lambda each: each[:-2])]
        ranges = ", ".join(f"{codes[0]} to {codes[-1]}" for codes in hundreds)
        raise click.UsageError(f"unknown diagnostic code {code}; the codes are {ranges}")
    return code_text(known[code])


# `stackdsl schema`: prints the JSON Schema of scenarios, or of reports.


@click.command("schema")
@click.option("--report", "of_report", is_flag=True, help="Print the schema of `check --format json` instead.")
def schema_command(of_report: bool) -> None:
    """Print the JSON Schema of scenarios, for editors."""
    if of_report:
        from importlib.resources import files  # noqa: PLC0415 -- rarely needed

        write(files("stackdsl").joinpath("report.schema.json").read_text(encoding="utf-8"))
        return
    from stackdsl.language.json_schema import schema_text  # noqa: PLC0415 -- likewise

    write(schema_text())


# `stackdsl completion`: prints the completion script for a shell.


VARIABLE = "_STACKDSL_COMPLETE"  # the shell sets it to get completions from the command
WHERE = {
    "bash": 'eval "$(stackdsl completion bash)" in ~/.bashrc',
    "zsh": 'eval "$(stackdsl completion zsh)" in ~/.zshrc, after compinit',
    "fish": "stackdsl completion fish > ~/.config/fish/completions/stackdsl.fish",
}


@click.command("completion", epilog="; ".join(f"{shell}: {where}" for shell, where in WHERE.items()))
@click.argument("shell", type=click.Choice(list(WHERE)))
@click.pass_context
def completion_command(context: click.Context, shell: str) -> None:
    """Print a completion script for a shell: commands, options, systems and files."""
    completion = get_completion_class(shell)
    assert completion is not None  # click knows all of WHERE
    write(completion(context.find_root().command, {}, "stackdsl", VARIABLE).source())
