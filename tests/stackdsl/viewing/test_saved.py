"""Detection of saved files: half-written files are ignored, and the last content is read."""

from collections.abc import Callable
from pathlib import Path

import pytest

from stackdsl.viewing import live
from stackdsl.viewing.live import is_saved_since, read_whole


def read(file: Path) -> Callable[[], str]:
    return lambda: file.read_text(encoding="utf-8")


def test_a_file_that_an_editor_empties_before_it_writes_it_is_read_once_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "tower.yaml"
    file.write_text("", encoding="utf-8")
    naps = 0

    def editor(_: float) -> None:
        """Writes while the reader waits for a file that makes no sense."""
        nonlocal naps
        naps += 1
        if naps == 2:
            file.write_text("whole", encoding="utf-8")

    monkeypatch.setattr(live, "sleep", editor)
    stamps, found = read_whole([file], read(file), bool)
    assert found == "whole"
    assert not is_saved_since(stamps)


def test_a_file_that_is_saved_while_it_is_read_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "tower.yaml"
    file.write_text("first", encoding="utf-8")
    found: list[str] = []

    def slowly() -> str:
        found.append(file.read_text(encoding="utf-8"))
        if len(found) == 1:
            file.write_text("second one", encoding="utf-8")
        return found[-1]

    assert read_whole([file], slowly, bool)[1] == "second one"
    assert found == ["first", "second one"]


def test_a_file_that_stays_empty_is_told_as_it_is(tmp_path: Path) -> None:
    file = tmp_path / "tower.yaml"
    file.write_text("", encoding="utf-8")
    assert read_whole([file], read(file), bool)[1] == ""
