"""What is known to pass is not played again, and nothing that is remembered turns a failure green."""

import json
import os
import shutil
import time
from hashlib import sha256
from pathlib import Path

import pytest

from tests.command_line import GOOD, Stackdsl, StackdslIn, write

TWO = GOOD + "---\n" + GOOD.replace("good", "other")


@pytest.fixture(scope="module")
def known(stackdsl_in: StackdslIn, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of a file with two scenarios that pass, and are known to."""
    folder = tmp_path_factory.mktemp("known")
    write(folder, TWO)
    assert stackdsl_in(folder, "check", "scene.yaml").code == 0  # which locks
    first = stackdsl_in(folder, "check", "scene.yaml")
    assert "2 passed in" in first.out
    return folder


@pytest.fixture
def passed(known: Path, tmp_path: Path) -> Path:
    """A copy of that folder, where `stackdsl` is called."""
    return shutil.copytree(known, tmp_path, dirs_exist_ok=True)


def test_a_remembered_pass_is_reported_and_not_played(stackdsl: Stackdsl, passed: Path) -> None:
    again = stackdsl("check", "scene.yaml", "--format", "json")
    assert (again.code, again.err) == (0, "")
    assert [result["remembered"] for result in json.loads(again.out)["results"]] == [True, True]
    assert "2 passed (2 remembered)" in stackdsl("check", "scene.yaml").out
    assert "remembered" not in stackdsl("check", "scene.yaml", "--no-cache").out


def test_a_remembered_report_says_what_the_played_one_said(stackdsl: Stackdsl, passed: Path) -> None:
    def said(*options: str) -> list[object]:
        results = json.loads(stackdsl("check", "scene.yaml", "--format", "json", *options).out)["results"]
        for result in results:
            del result["remembered"], result["cost"], result["speed_up"]
        return [*results]

    assert said() == said("--no-cache")


@pytest.mark.parametrize(
    "change",
    [
        lambda folder: write(folder, TWO.replace("levels: 3", "levels: 4", 1)),
        lambda folder: write(folder, TWO + "# a remark\n"),
        lambda folder: [path.write_text(path.read_text() + "\n") for path in (folder / "golden").rglob("*.json")],
    ],
    ids=["other scenario", "other text", "other golden"],
)
def test_whatever_it_came_from_changes_it_is_played_again(stackdsl: Stackdsl, passed: Path, change: object) -> None:
    assert callable(change)
    change(passed)
    assert "remembered" not in stackdsl("check", "scene.yaml").out


def test_a_golden_that_no_longer_agrees_fails_though_the_pass_is_remembered(stackdsl: Stackdsl, passed: Path) -> None:
    for path in (passed / "golden").rglob("*.json"):
        path.write_text(path.read_text().replace('"verdict": "stands"', '"verdict": "collapses"'))
    assert stackdsl("check", "scene.yaml").code == 3
    assert stackdsl("check", "scene.yaml").code == 3
    for path in (passed / "golden").rglob("*.json"):
        path.unlink()
    assert stackdsl("check", "scene.yaml", CI="true").code == 3


def test_a_failed_case_is_always_played_again(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD + "  - height: 20 mm ± 1 mm\n")
    for _ in range(2):
        result = stackdsl("check", "scene.yaml")
        assert (result.code, "[1/1] good[exact]: failed" in result.err) == (1, True)


def test_a_limit_of_time_that_it_was_not_played_under_is_another_question(stackdsl: Stackdsl, passed: Path) -> None:
    assert "remembered" not in stackdsl("check", "scene.yaml", "--time-limit", "50").out


@pytest.mark.parametrize("spoilt", [b"", b"{", b"[]", b"\xff\xfe", b"0" * 64 + b"\n{}"])
def test_records_that_are_cut_short_or_of_somebody_else_are_none(
    stackdsl: Stackdsl, passed: Path, spoilt: bytes
) -> None:
    records = list((passed / ".stackdsl" / "passed").rglob("*.json"))
    assert len(records) == 3  # two cases, and what the file holds
    for record in records:
        record.write_bytes(spoilt)
    assert "2 passed in" in stackdsl("check", "scene.yaml").out
    assert "2 remembered" in stackdsl("check", "scene.yaml").out


def test_a_record_is_of_no_other_case(stackdsl: Stackdsl, passed: Path) -> None:
    # A pass under the name of another record: the digest is that of the name as well.
    write(passed, GOOD + "  - height: 20 mm ± 1 mm\n", "bad.yaml")
    stackdsl("check", "bad.yaml", "--update", "--golden", "locked")
    good = max((passed / ".stackdsl" / "passed").rglob("*.json"), key=lambda path: path.stat().st_size).read_bytes()
    for record in (passed / ".stackdsl" / "passed").rglob("*.json"):
        record.write_bytes(good)
    assert stackdsl("check", "bad.yaml", "--golden", "locked").code == 1
    assert "2 passed (1 remembered)" in stackdsl("check", "scene.yaml").out  # under its own name it is true


def test_a_record_with_a_flipped_bit_is_ignored(stackdsl: Stackdsl, passed: Path) -> None:
    for record in (passed / ".stackdsl" / "passed").rglob("*.json"):
        data = bytearray(record.read_bytes())
        data[-3] ^= 1
        record.write_bytes(bytes(data))
    assert "2 passed in" in stackdsl("check", "scene.yaml").out


def test_a_record_that_somebody_else_sent_is_none(stackdsl: Stackdsl, passed: Path, tmp_path: Path) -> None:
    # Whoever sent the project may have played it with the same program: only the key is another.
    other = str(tmp_path / "states")
    assert "2 passed in" in stackdsl("check", "scene.yaml", XDG_STATE_HOME=other).out
    assert "2 remembered" in stackdsl("check", "scene.yaml", XDG_STATE_HOME=other).out
    for record in (passed / ".stackdsl" / "passed").rglob("*.json"):
        _, _, text = record.read_bytes().partition(b"\n")
        record.write_bytes(sha256(record.stem.encode() + text).hexdigest().encode() + b"\n" + text)
    assert "2 passed in" in stackdsl("check", "scene.yaml").out


def test_the_key_is_for_its_owner_alone_and_is_made_once(stackdsl: Stackdsl, passed: Path, tmp_path: Path) -> None:
    states = tmp_path / "states"
    stackdsl("check", "scene.yaml", XDG_STATE_HOME=str(states))
    key = states / "stackdsl" / "key"
    first = key.read_bytes()
    assert (len(first), key.stat().st_mode & 0o777, key.parent.stat().st_mode & 0o777) == (32, 0o600, 0o700)
    assert [path.name for path in key.parent.iterdir()] == ["key"]
    stackdsl("check", "scene.yaml", "--no-cache", XDG_STATE_HOME=str(states))
    assert key.read_bytes() == first
    key.chmod(0o644)
    assert "2 passed in" in stackdsl("check", "scene.yaml", XDG_STATE_HOME=str(states)).out


def test_without_a_key_no_pass_is_remembered(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TWO)
    nowhere = str(write(tmp_path, "", "a file"))
    for _ in range(3):
        said = stackdsl("check", "scene.yaml", XDG_STATE_HOME=nowhere)
        assert (said.code, "remembered" in said.out) == (0, False)
    assert not (tmp_path / ".stackdsl" / "passed").exists()


def test_code_that_was_written_after_the_start_is_not_what_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stackdsl.checking import cache  # noqa: PLC0415 -- whose names are replaced

    source = write(tmp_path, "x = 1\n", "package.py")
    monkeypatch.setattr(cache, "_files", lambda: [source])
    monkeypatch.setattr(cache, "program_digest", cache.program_digest)
    os.utime(source, (time.time() - 60.0, time.time() - 60.0))
    monkeypatch.setattr(cache, "LOADED", time.time() - 30.0)
    held = cache.ResultCache(tmp_path / ".stackdsl")
    held.remember(key := held.key("case"), "passed")
    held.settle()
    assert held.recall(key) == "passed"
    assert cache.ResultCache(tmp_path / ".stackdsl").key("case") == key
    source.write_text("x = 2\n")  # while something is played
    held.remember(other := held.key("other"), "passed")
    held.settle()
    assert held.recall(other) is None
    assert cache.ResultCache(tmp_path / ".stackdsl").key("case") != key


def test_two_scenarios_of_one_name_are_told_though_both_files_are_remembered(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, GOOD, "s/a.yaml")
    write(tmp_path, GOOD, "t/b.yaml")
    for folder in ("s", "t", "s"):
        stackdsl("check", folder)
    assert stackdsl("check", "s", "t").out.count("SD203") == 1


def test_the_cache_is_ignored_by_git(passed: Path) -> None:
    assert "*" in (passed / ".stackdsl" / ".gitignore").read_text().splitlines()


TAKING = GOOD.replace("expect:", "  - include: _more.yaml\nexpect:")


def test_the_key_of_a_pass_includes_extended_files(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TAKING)
    part = "build:\n  - name: more\n    bricks:\n      - {name: top, at: [0 mm, 0 mm, 27.3 mm]}\n"
    write(tmp_path, part, "_more.yaml")
    for _ in range(2):
        told = stackdsl("check", "scene.yaml")
        assert told.code == 0, told.text
    assert "remembered" in stackdsl("check", "scene.yaml").out
    write(tmp_path, part.replace("0 mm, 0 mm, 27.3", "4 mm, 0 mm, 27.3"), "_more.yaml")
    changed = stackdsl("check", "scene.yaml")
    assert (changed.code, "more.top" in changed.out) == (3, True)


@pytest.mark.parametrize("moved", ["root", "link"])
def test_a_remembered_pass_does_not_hide_a_link_that_leads_outside(
    stackdsl: Stackdsl, tmp_path: Path, moved: str
) -> None:
    project, elsewhere = tmp_path / "project", tmp_path / "elsewhere.yaml"
    root = write(project, "", "stackdsl.toml")
    part = write(project, "expect:\n  - stands: all\n", "_part.yaml")
    write(project, GOOD.partition("expect")[0] + "expect:\n  - include: ../_part.yaml\n", "below/scene.yaml")
    for _ in range(2):
        assert stackdsl("check", "project/below", "--golden", "golden").code == 0
    if moved == "root":
        root.unlink()
    else:
        part.rename(elsewhere)
        part.symlink_to(elsewhere)
    assert "is outside the project" in stackdsl("check", "project/below", "--golden", "golden").out
