"""Golden files belong to the project that a file marks, wherever the command is called."""

from pathlib import Path

import pytest

from stackdsl.project_file import Project, ProjectError, project_of
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`


@pytest.mark.parametrize("marked", ["stackdsl.toml", "pyproject.toml"])
def test_the_nearest_file_upwards_marks_the_root(tmp_path: Path, marked: str, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "[tool.stackdsl]\n" if marked == "pyproject.toml" else "", f"project/{marked}")
    file = write(tmp_path, GOOD, "project/scenarios/deep/good.yaml")
    monkeypatch.chdir(tmp_path)
    assert project_of([file]) == Project(Path("project/golden"), Path("project/scenarios"), Path("project"))
    monkeypatch.chdir(file.parent)
    assert project_of([]) == Project(Path("../../golden"), Path(".."), Path("../.."))


def test_what_says_nothing_of_stackdsl_marks_no_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "[tool.other]\n", "pyproject.toml")
    monkeypatch.chdir(tmp_path)
    assert project_of([]) == Project(Path("golden"), Path("scenarios"), None)


def test_the_file_may_say_where_things_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, 'golden = "locked"\nscenarios = "scenes"\n', "stackdsl.toml")
    monkeypatch.chdir(tmp_path)
    assert project_of([]) == Project(Path("locked"), Path("scenes"), Path())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("golden = 7", "golden must be a directory below the file"),
        ('golden = "/elsewhere"', "golden must be a directory below the file"),
        ('goldne = "golden"', "unknown key 'goldne' of stackdsl; the keys are golden and scenarios"),
        ("golden = ", "is not valid TOML"),
        (
            "# it\n" + r'  golden = "a\u0000b"',
            r"stackdsl.toml:2:3: golden has the invisible character U\+0000",
        ),
        (r'scenarios = "a\u202eb"', r"stackdsl.toml:1:1: scenarios has the invisible character U\+202E"),
        (r'"go\u001b[31mld" = 1', r"unknown key 'go\\x1b\[31mld' of stackdsl"),
        (f"x = {'[' * 500}", "its values are nested too deeply"),
        (f"x = {'9' * 5000}", "is not valid TOML: Exceeds the limit"),
    ],
)
def test_what_the_file_cannot_mean_is_told(tmp_path: Path, text: str, told: str) -> None:
    write(tmp_path, text, "stackdsl.toml")
    with pytest.raises(ProjectError, match=told):
        project_of([tmp_path / "scene.yaml"])


def test_a_call_from_elsewhere_locks_in_the_project(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "", "project/stackdsl.toml")
    write(tmp_path, GOOD, "project/scenarios/good.yaml")
    assert stackdsl("check", "project/scenarios").code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["project"]
    assert len(list((tmp_path / "project" / "golden").rglob("*.json"))) == 1
    assert stackdsl("check", "project/scenarios/good.yaml", CI="true").code == 0


def test_a_mistake_in_the_file_is_wrong_usage(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "golden = 7", "stackdsl.toml")
    write(tmp_path, GOOD)
    result = stackdsl("check", "scene.yaml")
    assert result.code == 4
    assert "stackdsl.toml:1:1: golden must be" in result.err


def test_a_directory_whose_name_no_disk_takes_is_told_and_no_fault_of_the_program(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, f'golden = "{"g" * 400}"', "stackdsl.toml")
    write(tmp_path, GOOD)
    result = stackdsl("check", "scene.yaml")
    assert result.code == 3
    assert "golden unreadable" in result.out
