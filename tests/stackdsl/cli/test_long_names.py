"""Every command reports a file name longer than the system allows as an unreadable file."""

from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

LONG = "a" * 700
UNREAD = "cannot read the file: File name too long"


@pytest.mark.parametrize("command", ["run", "check", "survive", "suggest", "sensitivities", "order", "pull", "explain"])
def test_a_file_whose_name_is_too_long_cannot_be_read(stackdsl: Stackdsl, command: str) -> None:
    done = stackdsl(command, f"{LONG}.yaml")
    assert (done.code, UNREAD in done.text) == (ExitCode.INVALID, True)


@pytest.mark.parametrize("name", [LONG, "SD" + "9" * 800])
def test_explain_refuses_names_of_no_file_and_no_code(stackdsl: Stackdsl, name: str) -> None:
    done = stackdsl("explain", name)
    assert (done.code, UNREAD in done.text) == (ExitCode.INVALID, True)


def test_a_file_whose_name_is_too_long_is_not_there_to_be_watched(stackdsl: Stackdsl) -> None:
    done = stackdsl("run", "--watch", f"{LONG}.yaml")
    assert (done.code, "does not exist" in done.err) == (ExitCode.USAGE, True)


def test_a_new_scenario_is_not_written_to_a_folder_whose_name_is_too_long(stackdsl: Stackdsl) -> None:
    done = stackdsl("new", "b", "--to", LONG)
    assert (done.code, "cannot be created: File name too long" in done.err) == (ExitCode.USAGE, True)


def test_a_project_whose_directory_has_a_name_that_is_too_long_is_told_so(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "stackdsl.toml").write_text(f'scenarios = "{LONG}"\n', encoding="utf-8")
    done = stackdsl("check")
    assert (done.code, UNREAD in done.text) == (ExitCode.INVALID, True)


def test_a_name_that_is_too_long_keeps_no_other_file_from_being_checked(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "good.yaml")
    done = stackdsl("check", "good.yaml", f"{LONG}.yaml")
    assert (done.code, "1 passed, 1 mistake" in done.text) == (ExitCode.INVALID, True)


@pytest.mark.parametrize("command", ["check", "run", "survive"])
def test_an_empty_path_is_no_name_of_the_current_directory(stackdsl: Stackdsl, tmp_path: Path, command: str) -> None:
    write(tmp_path, GOOD, "good.yaml")
    done = stackdsl(command, "")
    assert (done.code, "the path is empty" in done.text) == (ExitCode.USAGE, True)
    assert not (tmp_path / "golden").exists()


def test_a_directory_of_golden_files_that_is_not_there_has_no_pending_changes(stackdsl: Stackdsl) -> None:
    done = stackdsl("golden", "--golden", "nope", "status")
    assert (done.code, "there is no directory 'nope'" in done.text) == (ExitCode.USAGE, True)
