"""`stackdsl schema`: prints the JSON Schema of scenarios, or of reports."""

import click

from stackdsl.commands.terminal import write


@click.command("schema")
@click.option("--report", "of_report", is_flag=True, help="That of `check --format json` instead.")
def schema_command(of_report: bool) -> None:
    """Print the JSON Schema of scenarios, for editors."""
    if of_report:
        from importlib.resources import files  # noqa: PLC0415 -- rarely asked for

        write(files("stackdsl").joinpath("report.schema.json").read_text(encoding="utf-8"))
        return
    from stackdsl.language.editor_schema import schema_text  # noqa: PLC0415 -- likewise the other one

    write(schema_text())
