"""A command loads what it needs and no more, which is what decides how soon it answers (benchmarks/start.py)."""

import json
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from stackdsl.cli.main import COMMANDS, app
from tests.command_line import GOOD, write
from tests.paths import ROOT

# Calls the command, and tells on the last line what was imported.
TELLING = """
import json, sys
from stackdsl.__main__ import main
try:
    main()
finally:
    print(json.dumps(sorted(sys.modules)))
"""
ENGINES = {"pybullet", "mujoco"}
PROGRAMS = {"scipy", "clarabel"}


def imported_by(folder: Path, *arguments: str) -> set[str]:
    done = subprocess.run(
        [sys.executable, "-c", TELLING, *arguments],
        cwd=folder,
        env={"PYTHONPATH": str(ROOT)},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_help_imports_no_command_and_nothing_that_commands_need(tmp_path: Path) -> None:
    modules = imported_by(tmp_path, "--help")
    needed = {"numpy", "pydantic", "pint", "yaml", "rich", "multiprocessing", "importlib.metadata"}
    ours = {name for name in modules if name.startswith(("stackdsl.", "stability."))}
    assert not modules & needed
    told = {"stackdsl.entry_points", "stackdsl.exits"}  # the errors that end a command
    assert ours == {"stability.process_settings", "stackdsl.__main__", "stackdsl.cli"} | told | {
        f"stackdsl.cli.{name}" for name in ("main", "terminal")
    }


# `run` plays in its own process, and so shows what a worker of `check` imports as well. It asks the programs how far
# what stands is from falling, which `check` does where something failed.
@pytest.mark.parametrize(("command", "spared"), [("check --update", ENGINES | PROGRAMS | {"numpy"}), ("run", ENGINES)])
def test_a_standing_case_is_played_without_importing_engine_units_and_tables(
    tmp_path: Path, command: str, spared: set[str]
) -> None:
    write(tmp_path, GOOD + "  - height: 23.4 mm ± 1 mm\n")
    modules = imported_by(tmp_path, *command.split(), "scene.yaml")
    assert not modules & (spared | {"pint", "rich"})
    # What mistakes need, what falls need, and what other systems and formats need.
    assert not modules & {"stackdsl.language.json_schema", "stability.dynamics.toppling"}
    assert not modules & {"stability.stabilizers.published", "stackdsl.report.formats"}


def test_an_expression_is_what_units_are_made_for(tmp_path: Path) -> None:
    write(tmp_path, GOOD.replace("levels: 3", "levels: 3, step: '${1 mm + 1 mm}'"))
    assert "pint" in imported_by(tmp_path, "run", "scene.yaml")


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_says_of_each_command_what_its_own_help_begins_with(name: str) -> None:
    command = app.get_command(click.Context(app), name)
    assert command is not None
    assert (command.name, command.help) == (name, COMMANDS[name])


def test_a_command_that_there_is_not_is_wrong_usage() -> None:
    assert app.get_command(click.Context(app), "chekc") is None


def test_the_help_says_all_of_it() -> None:
    said = " ".join(CliRunner().invoke(app, ["--help"]).output.split())
    assert all(text in said for text in COMMANDS.values())
