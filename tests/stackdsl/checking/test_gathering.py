"""Which files are read: all that are meant, and what cannot be read is told, never passed over in silence."""

import os
from pathlib import Path

import pytest

from stackdsl.checking.cases import files_under, gather
from tests.command_line import GOOD, Stackdsl, write


@pytest.fixture
def closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory that may not be read; a superuser may read all, so that the call itself refuses."""
    folder = tmp_path / "scenarios" / "closed"
    write(tmp_path, GOOD, "scenarios/closed/good.yaml")
    scan = os.scandir

    def refuse(path: str | os.PathLike[str] = ".") -> object:
        if Path(path) == folder:
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", refuse)
    return folder


def test_a_directory_that_cannot_be_read_is_a_mistake_in_its_place(closed: Path) -> None:
    write(closed.parent.parent, GOOD.replace("good", "other"), "scenarios/other.yaml")
    gathered = gather([closed.parent])
    assert [case.scenario.scenario for case in gathered.cases] == ["other"]
    (mistake,) = gathered.diagnostics
    assert mistake.span.file == str(closed)
    assert "Permission denied" in mistake.message
    assert mistake.hint


def test_a_pipe_among_scenarios_is_told_and_not_waited_for(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    os.mkfifo(tmp_path / "scenarios" / "pipe.yaml")
    result = stackdsl("check", "scenarios", "--list")
    assert result.code == 2
    assert "good[exact]" in result.out
    assert "pipe.yaml:1:1" in result.out + result.err
    assert "not a regular file" in result.out + result.err


def test_nothing_is_removed_unless_all_was_read(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    os.mkfifo(tmp_path / "scenarios" / "pipe.yaml")
    gone = write(tmp_path, '{"format": 1}', "golden/gone/exact.json")
    assert stackdsl("check", "scenarios", "--update").code == 2
    assert gone.exists()
    (tmp_path / "scenarios" / "pipe.yaml").unlink()
    assert stackdsl("check", "scenarios", "--update").code == 0
    assert not gone.exists()


def test_files_come_by_name_within_a_directory_and_each_once(tmp_path: Path) -> None:
    for name in ("b/2.yaml", "b/1.yml", "a.yaml", "b/note.txt", "c.yaml"):
        write(tmp_path, GOOD, name)
    found, unreadable = files_under([tmp_path, tmp_path / "b" / "2.yaml"])
    assert [file.relative_to(tmp_path).as_posix() for file in found] == ["a.yaml", "b/1.yml", "b/2.yaml", "c.yaml"]
    assert unreadable == []


def test_links_between_directories_are_followed_and_each_file_is_called_by_where_it_is(tmp_path: Path) -> None:
    write(tmp_path, "", "stackdsl.toml")
    for name in ("scenarios/z/here.yaml", "elsewhere/deep/there.YML"):
        write(tmp_path, GOOD, name)
    for link, target in [
        ("scenarios/a", "z"),  # inside, and before it in the alphabet
        ("scenarios/out", "../elsewhere"),
        ("scenarios/z/loop", ".."),
        ("elsewhere/deep/back", "../../scenarios"),
        ("elsewhere/self", "self"),
        ("scenarios/nowhere", "gone"),
    ]:
        (tmp_path / link).symlink_to(target)
    found, unreadable = files_under([tmp_path / "scenarios"])
    names = [file.relative_to(tmp_path).as_posix() for file in found]
    assert names == ["scenarios/out/deep/there.YML", "scenarios/z/here.yaml"]
    assert unreadable == []
