"""`stackdsl init`: writes what a new project needs."""

import os
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Final

import click

from stackdsl.commands.new_command import SCHEMA, first_text, make_folder, write_new
from stackdsl.commands.options import FilePath
from stackdsl.commands.requirement import VENDORED, requirement
from stackdsl.commands.terminal import write

HOW_TO_VENDOR: Final = "put there the wheel that `pip wheel --no-deps -w vendor PATH` makes of the sources"
FIRST: Final = "first-column"  # the scenario to start from
ROOT_FILE: Final = """\
# The root of a project of stackdsl: golden files belong to it, wherever a command is called from.
golden = "golden"
"""
WORKFLOW: Final = """\
# Plays every scenario and compares it with its golden file, which a run in CI never writes. By --strict, a scenario
# of which nothing is expected fails.
name: stackdsl
on: [push, pull_request]

permissions:
  contents: read

jobs:
  check:
    runs-on: ubuntu-latest
    timeout-minutes: 30
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with: {python-version: "3.11"}  # PyBullet has no wheels for newer ones
      - run: pip install {requirement}
      - run: stackdsl check scenarios --strict
"""
EDITOR: Final = """\
{
  "yaml.schemas": {
    "./scenario.schema.json": ["scenarios/**/*.yaml", "scenarios/**/*.yml"]
  }
}
"""


@click.command(
    "init",
    epilog="That is the file that marks its root, a first scenario, the JSON Schema and a setting for editors, and a "
    "workflow for CI.",
)
@click.argument("directory", type=FilePath, default=Path())
def init_command(directory: Path) -> None:
    """Write what a new project in DIRECTORY (default: this one) needs; never over an existing file."""
    told = []
    for path, text in _texts(directory).items():
        if os.path.lexists(path):  # a link that leads nowhere counts: what is written there would be elsewhere
            told.append(f"left   {path}, which is there already")
            continue
        make_folder(path.parent)
        write_new(path, text)
        told.append(f"wrote  {path}")
    write("\n".join(told))
    if requirement() == VENDORED:
        write(f"note: stackdsl is on no package index, so its workflow installs {VENDORED}: {HOW_TO_VENDOR}")
    where = f"cd {directory}, then: " if directory != Path() else ""
    write(f"next: {where}stackdsl check, which writes the first golden file; look at it, and commit it all")


def _texts(directory: Path) -> Mapping[Path, str]:
    """By path, what is written there."""
    return {
        directory / "stackdsl.toml": ROOT_FILE,
        directory / "scenarios" / f"{FIRST}.yaml": first_text(FIRST, f"../{SCHEMA}"),
        directory / SCHEMA: files("stackdsl").joinpath(SCHEMA).read_text(encoding="utf-8"),
        directory / ".vscode" / "settings.json": EDITOR,
        directory / ".github" / "workflows" / "stackdsl.yml": WORKFLOW.replace("{requirement}", requirement()),
    }
