"""A project from nothing: what `init`, `new`, `doctor` and `completion` write and tell."""

import json
from importlib.metadata import distribution
from pathlib import Path

import pytest
import yaml

from stackdsl.cli.options import VENDORED, requirement
from tests.command_line import Stackdsl, StackdslIn


def test_a_new_project_is_checked_and_green(stackdsl: Stackdsl, stackdsl_in: StackdslIn, tmp_path: Path) -> None:
    begun = stackdsl("init", "towers")
    assert begun.code == 0, begun.text
    home = tmp_path / "towers"
    assert json.loads((home / ".vscode" / "settings.json").read_text())["yaml.schemas"]
    workflow = yaml.safe_load((home / ".github" / "workflows" / "stackdsl.yml").read_text())
    assert workflow["jobs"]["check"]["steps"][-1]["run"] == "stackdsl check scenarios --strict"
    assert "then stackdsl check, which writes the first golden file" in begun.out
    first = stackdsl_in(home, "check")
    assert first.code == 0, first.text
    assert list((home / "golden").rglob("*.json"))
    assert stackdsl_in(home, "check").code == 0


def test_the_workflow_installs_what_is_installed_here(
    stackdsl: Stackdsl, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = stackdsl("init")
    workflow = yaml.safe_load((tmp_path / ".github" / "workflows" / "stackdsl.yml").read_text())
    runs = [step.get("run", "") for step in workflow["jobs"]["check"]["steps"]]
    assert "pip install stackdsl" not in runs  # which no index has
    assert any(run == f"pip install {requirement()}" for run in runs)
    assert ("note: stackdsl is not on a package index" in told.out) == (requirement() == VENDORED)
    origin = {"url": "https://example.org/s.git", "vcs_info": {"vcs": "git", "commit_id": "0a1b"}}
    monkeypatch.setattr(type(distribution("stackdsl")), "read_text", lambda self, name: json.dumps(origin))
    assert requirement() == "'stackdsl @ git+https://example.org/s.git@0a1b'"


def test_a_line_beyond_the_end_of_a_file_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("scenario: a\nbuild:\n  - column: {levels: 2}\n")
    told = stackdsl("check", "a.yaml:4", "--list")
    assert (told.code, told.out) == (4, "")
    assert "a.yaml has only 3 lines, so line 4 does not exist" in told.err
    assert stackdsl("check", "a.yaml:3", "--list").code == 0


@pytest.mark.parametrize(
    ("line", "meant"),
    [("extends: bse.yaml\n", "base.yaml"), ("impacts: [{after: build, remove: {brick: L1.1}}]\n", "built")],
)
def test_a_file_and_an_event_that_are_misspelt_are_named(
    line: str, meant: str, stackdsl: Stackdsl, tmp_path: Path
) -> None:
    (tmp_path / "base.yaml").write_text("scenario: base\nbuild:\n  - column: {levels: 2}\n")
    (tmp_path / "a.yaml").write_text(f"scenario: a\n{line}build:\n  - column: {{levels: 2}}\n")
    assert f"did you mean '{meant}'?" in stackdsl("check", "a.yaml").out


def test_the_schema_that_a_scenario_names_is_there(stackdsl: Stackdsl, tmp_path: Path) -> None:
    stackdsl("init")
    stackdsl("new", "second", "--to", "scenarios/deep")
    for path in ("scenarios/first-column.yaml", "scenarios/deep/second.yaml"):
        line = (tmp_path / path).read_text().splitlines()[0]
        relative = line.partition("$schema=")[2]
        assert relative
        assert not Path(relative).is_absolute()
        assert json.loads((tmp_path / path).parent.joinpath(relative).read_text())["title"] == "StackDSL scenario"


def test_without_a_schema_in_the_project_none_is_named(stackdsl: Stackdsl, tmp_path: Path) -> None:
    assert stackdsl("new", "alone").code == 0
    assert "$schema" not in (tmp_path / "scenarios" / "alone.yaml").read_text()


def test_nothing_is_written_over(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "stackdsl.toml").write_text("# mine\n")
    told = stackdsl("init")
    assert told.code == 0
    assert "kept   stackdsl.toml" in told.out
    assert (tmp_path / "stackdsl.toml").read_text() == "# mine\n"
    assert (tmp_path / "scenarios" / "first-column.yaml").exists()


def test_a_place_that_cannot_be_written_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    told = stackdsl("init", "file")
    assert told.code == 4
    assert "Traceback" not in told.text


def test_doctor_tells_what_is_there_and_what_is_not(stackdsl: Stackdsl, tmp_path: Path) -> None:
    told = stackdsl("doctor")
    assert told.code == 0, told.text
    assert "ok     numpy " in told.out
    assert "note   there is no directory scenarios here; create one with: stackdsl init" in told.out
    stackdsl("init")
    (tmp_path / "scenario.schema.json").write_text("{}")
    again = stackdsl("doctor")
    assert "ok     1 files in scenarios" in again.out
    assert "scenario.schema.json is from another version of stackdsl; update it with: stackdsl schema >" in again.out


def test_doctor_looks_where_the_project_says_from_wherever_it_is_called(
    stackdsl_in: StackdslIn, tmp_path: Path
) -> None:
    (tmp_path / "pyproject.toml").write_text('[tool.stackdsl]\nscenarios = "towers"\ngolden = "locked"\n')
    (tmp_path / "towers").mkdir()
    (tmp_path / "towers" / "one.yaml").write_text("scenario: one\nbuild: [column: {levels: 1}]\n")
    told = stackdsl_in(tmp_path / "towers", "doctor")
    assert f"the root of the project is {tmp_path.resolve()}" in told.out
    assert "ok     1 files in ." in told.out
    (tmp_path / "pyproject.toml").write_text("[tool.stackdsl]\ngoldens = 'locked'\n")
    wrong = stackdsl_in(tmp_path, "doctor")
    assert (wrong.code, "unknown key 'goldens'" in wrong.out) == (1, True)


def test_extended_files_are_inside_the_project_of_the_scenario(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "stackdsl.toml").write_text("")
    (tmp_path / "_part.yaml").write_text("build: [column: {levels: 1}]\n")
    inner = tmp_path / "package"
    inner.mkdir()
    (inner / "pyproject.toml").write_text("[project]\nname = 'other'\n")  # marks no project of ours
    (inner / "one.yaml").write_text("scenario: one\nbuild: [include: ../_part.yaml]\n")
    assert stackdsl("check", "package/one.yaml", "--statics").code == 0
    (inner / "pyproject.toml").write_text("[tool.stackdsl]\n")
    told = stackdsl("check", "package/one.yaml", "--statics")
    assert (told.code, "is outside the project" in told.text) == (2, True)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_a_shell_is_told_how_to_complete(shell: str, stackdsl: Stackdsl) -> None:
    told = stackdsl("completion", shell)
    assert told.code == 0
    assert "_STACKDSL_COMPLETE" in told.out


@pytest.mark.parametrize(
    ("words", "offered"),
    [("stackdsl ", "check"), ("stackdsl check --sys", "--system"), ("stackdsl check --system ex", "exact")],
)
def test_shell_completion_offers_names(words: str, offered: str, stackdsl: Stackdsl) -> None:
    parts = words.split(" ")
    asking = {"_STACKDSL_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(len(parts) - 1)}
    told = stackdsl(**asking)
    assert f"plain,{offered}" in told.out.splitlines()
