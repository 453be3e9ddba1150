"""The example of a workflow and the hooks of pre-commit call what there is; examples of scenarios are short."""

import re
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

from stackdsl.cli.main import COMMANDS
from tests.command_line import StackdslIn
from tests.docs.test_shell_shown import TARGETS
from tests.paths import ROOT

WORKFLOW = ROOT / "docs" / "examples" / "github-workflow.yml"
OFFERED = ROOT / ".pre-commit-hooks.yaml"
HOOKS = ROOT / ".pre-commit-config.yaml"


def test_the_workflow_calls_targets_that_there_are() -> None:
    jobs = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))["jobs"]
    runs = [step["run"] for job in jobs.values() for step in job["steps"] if "run" in step]
    assert runs
    assert {re.match(r"make ([a-z-]+)", run)[1] for run in runs} <= TARGETS  # type: ignore[index]


def test_hooks_need_no_network_and_nothing_but_the_environment() -> None:
    repositories = yaml.safe_load(HOOKS.read_text(encoding="utf-8"))["repos"]
    assert [each["repo"] for each in repositories] == ["local"]
    for hook in repositories[0]["hooks"]:
        assert hook["language"] == "system"
        assert hook["entry"].startswith(".venv/bin/")


def test_hooks_for_other_projects_call_the_command() -> None:
    hooks = yaml.safe_load(OFFERED.read_text(encoding="utf-8"))
    assert {hook["id"] for hook in hooks} == {"stackdsl-check", "stackdsl-valid"}
    for hook in hooks:
        program, name, *_ = hook["entry"].split()
        assert program == "stackdsl"
        assert name in COMMANDS


def test_examples_of_scenarios_are_short_and_named_in_the_tutorial() -> None:
    tutorial = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    files = sorted((ROOT / "scenarios" / "examples").iterdir())
    assert files
    for file in files:
        lines = [line for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
        assert len(lines) <= 25, file.name
        assert "truth:" in lines
        assert f"../scenarios/examples/{file.name}" in tutorial


@pytest.mark.parametrize(
    ("library", "prints"),
    [
        ("py3dbp", ["box 10 of the load, small-5: small-5 tips over wide-1"]),
        (
            "ortools",
            [
                "all 8 boxes stand when they are placed",
                "box 5 of the load, c1-1: c1-1 falls: nothing is under it",
            ],
        ),
    ],
)
def test_the_loads_of_packing_libraries_are_checked(
    library: str, prints: list[str], stackdsl_in: StackdslIn, tmp_path: Path
) -> None:
    if find_spec(library) is None:
        pytest.skip(f"needs {library}")
    text = (ROOT / "docs" / "examples" / f"pack_{library}.py").read_text(encoding="utf-8")
    done = stackdsl_in(tmp_path, program=text)
    assert (done.code, done.out.splitlines()) == (0, prints), done.err
