"""`stackdsl schema`: prints the JSON Schema of scenarios."""

import click

from stackdsl.commands.terminal import write
from stackdsl.language.editor_schema import schema_text


@click.command("schema")
def schema_command() -> None:
    """Print the JSON Schema of scenarios, for editors."""
    write(schema_text())
