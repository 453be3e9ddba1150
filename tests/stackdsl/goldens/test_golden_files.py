"""Golden files: when they are read, written, rewritten and removed, and what is told of one that is broken."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from stackdsl.goldens.file_format import canonical_text, document, golden_name
from stackdsl.goldens.golden import GoldenWriteRefusedError, check_golden, obsolete, refuse_in_ci, remove_obsolete
from stackdsl.goldens.snapshot import FORMAT
from stackdsl.results import GoldenStatus
from stackdsl.trace import BrickState
from tests.command_line import write
from tests.stackdsl.goldens.changes import BRICK, STANDS, Change, changed, drop, put
from tests.stackdsl.goldens.towers import IDENTITY, taken, tower, track


@pytest.fixture(autouse=True)
def _at_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)


def test_the_file_is_missing_then_written_then_the_same(tmp_path: Path) -> None:
    def check(update: bool) -> GoldenStatus:
        return check_golden(STANDS, tmp_path / "golden", update).status

    assert [check(False), check(True), check(False)] == [
        GoldenStatus.MISSING,
        GoldenStatus.WRITTEN,
        GoldenStatus.SAME,
    ]
    assert [*(tmp_path / "golden").rglob("*.json")] == [tmp_path / "golden" / "tower" / "thesis.json"]
    assert (tmp_path / "golden" / "tower" / "thesis.json").read_bytes() == canonical_text(STANDS).encode()


@pytest.mark.parametrize("update", [True, False])
def test_bricks_that_only_slid_are_unclear_whether_displaced(update: bool, tmp_path: Path) -> None:
    slid = taken(tower(replace(track("L2.1", 2, BrickState.DISPLACED, shift=0.006), sunk=0.0)))
    told = [check_golden(slid, tmp_path, True), check_golden(slid, tmp_path, update)]
    assert [each.unclear.text.partition("; in this run, ")[2] for each in told] == ["only whether displaced: L2.1"] * 2


def place(directory: Path) -> Path:
    """Where the golden file is to be, in a directory that is there."""
    path = directory / golden_name(IDENTITY)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def golden_file(directory: Path, text: str) -> Path:
    path = place(directory)
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_within_tolerance_is_not_rewritten(tmp_path: Path) -> None:
    near = json.dumps(changed(put("height_mm", value=24.4)))
    path = golden_file(tmp_path, near)
    assert check_golden(STANDS, tmp_path, update=True).status is GoldenStatus.SAME
    assert path.read_text(encoding="utf-8") == near


def test_a_different_file_is_rewritten_only_when_told_to(tmp_path: Path) -> None:
    path = golden_file(tmp_path, far := json.dumps(changed(put("height_mm", value=30.0))))
    seen = check_golden(STANDS, tmp_path, update=False)
    assert (seen.status, path.read_text(encoding="utf-8")) == (GoldenStatus.DIFFERENT, far)
    written = check_golden(STANDS, tmp_path, update=True)
    assert (written.status, written.differences) == (GoldenStatus.WRITTEN, seen.differences)
    assert path.read_text(encoding="utf-8") == canonical_text(STANDS)


@pytest.mark.parametrize("ends", ["\r\n", "\r"])
def test_line_ends_that_git_changed_are_the_same(ends: str, tmp_path: Path) -> None:
    place(tmp_path).write_bytes(canonical_text(STANDS).replace("\n", ends).encode())
    assert check_golden(STANDS, tmp_path, update=False).status is GoldenStatus.SAME


UNREADABLE = {
    "nothing": (b"", "Expecting value"),
    "a merge conflict": (b"<<<<<<< HEAD\n{}", "a merge conflict at line 1"),
    "half a file": (canonical_text(STANDS)[:200].encode(), "line"),
    "not UTF-8": (b"\xff\xfe{}", "not UTF-8"),
    "no object": (b"[1]", "is not a JSON object"),
    "no format": (b"{}", "it has format none, and this version reads 1"),
    "another format": (
        b'{"format": 0}',
        "it has format 0, and this version reads 1; accept the result to write it again",
    ),
    "a format that is no number": (b'{"format": true}', "it has format True, and this version reads 1"),
    "a key that nobody reads": (b'{"format": 1, "verdicts": "stands"}', "the file has an unknown key 'verdicts'"),
    "one of a brick": (b'{"format": 1, "bricks": {"a": {"stat": 1}}}', "'a' has an unknown key 'stat'"),
    "one of an event": (b'{"format": 1, "events": [{"placed": {}, "when": 1}]}', "an event has an unknown key 'when'"),
    "bricks in an array": (b'{"format": 1, "bricks": []}', "'bricks' is not a JSON object"),
    "a brick that is none": (canonical_text(STANDS).replace('"bricks": {', '"bricks": {"L1.1": 0, ').encode(), "twice"),
    "a number for a brick": (json.dumps(changed(put(*BRICK, value=0))).encode(), "'L2.1' is not a JSON object"),
    "events in an object": (b'{"format": 1, "events": {}}', "'events' is not a JSON array"),
    "a number for an event": (b'{"format": 1, "events": [3]}', "event 1 is not a JSON object"),
    "an event of nothing": (b'{"format": 1, "events": [{}]}', "event 1 places no brick"),
    "a brick placed twice": (
        b'{"format": 1, "events": [{"placed": {"a": {}}}, {"placed": {"a": {}}}]}',
        "event 2 places 'a', which event 1 placed already",
    ),
    "a place with two numbers": (json.dumps(changed(put(*BRICK, "at_mm", value=[1, 2]))).encode(), "at_mm of L2.1"),
    "a place that is text": (json.dumps(changed(put(*BRICK, "at_mm", value="here"))).encode(), "'at_mm'"),
    "a key written twice": (b'{"format": 1, "format": 1}', "a key is written twice"),
    "half a surrogate pair": (b'{"format": 1, "verdict": "\\ud800"}', "surrogates not allowed"),
    "too deep": (b"[" * 100_000, "recursion"),
    "too large a number": (b'{"format": ' + b"1" * 5000 + b"}", "limit"),
}


@pytest.mark.parametrize(("content", "reason"), UNREADABLE.values(), ids=UNREADABLE)
def test_a_file_that_holds_no_snapshot_says_why_and_can_be_rewritten(
    content: bytes, reason: str, tmp_path: Path
) -> None:
    place(tmp_path).write_bytes(content)
    result = check_golden(STANDS, tmp_path, update=False)
    assert result.status is GoldenStatus.UNREADABLE
    assert reason in result.note
    assert check_golden(STANDS, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert check_golden(STANDS, tmp_path, update=False).status is GoldenStatus.SAME


def test_a_directory_in_place_of_the_file_is_told(tmp_path: Path) -> None:
    place(tmp_path).mkdir()
    assert check_golden(STANDS, tmp_path, update=False).note == "it cannot be read: Is a directory"
    result = check_golden(STANDS, tmp_path, update=True)
    assert (result.status, result.note.split(";")[0]) == (GoldenStatus.UNREADABLE, "cannot be written: Is a directory")
    assert len(list(tmp_path.iterdir())) == 1


def test_a_write_that_fails_half_way_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    path = golden_file(tmp_path, "old")
    result = check_golden(STANDS, tmp_path, update=True)
    assert (result.status, result.note.split(";")[0]) == (
        GoldenStatus.UNREADABLE,
        "cannot be written: No space left on device",
    )
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]
    assert path.read_text(encoding="utf-8") == "old"


@pytest.mark.parametrize(("status", "height"), [(GoldenStatus.SAME, 24.0), (GoldenStatus.DIFFERENT, 30.0)])
def test_another_stamp_is_a_note_and_never_a_failure(status: GoldenStatus, height: float, tmp_path: Path) -> None:
    whole = changed(put("stamp", "pybullet", value="3.2.6"))
    golden_file(tmp_path, json.dumps(whole | {"height_mm": height}))
    result = check_golden(STANDS, tmp_path, update=False)
    assert (result.status, result.note) == (status, "made with pybullet 3.2.6 (now 3.2.7)")


def test_accepting_what_comes_out_brings_the_stamp_up_to_date_and_leaves_what_agrees(tmp_path: Path) -> None:
    near = canonical_text(STANDS).replace('"height_mm": 24.0', '"height_mm": 24.4')
    assert near != canonical_text(STANDS)
    path = golden_file(tmp_path, near.replace("3.2.7", "3.2.6"))
    seen = [check_golden(STANDS, tmp_path, update) for update in (False, True, True, False)]
    assert [result.status for result in seen] == [GoldenStatus.SAME, GoldenStatus.WRITTEN, *2 * [GoldenStatus.SAME]]
    assert [bool(result.note) for result in seen] == [True, False, False, False]
    assert path.read_text(encoding="utf-8") == near


def test_accepting_a_stamp_keeps_hand_written_layout(tmp_path: Path) -> None:
    snapshot = replace(STANDS, identity=replace(IDENTITY, variant="a=5 °,thesis"), stamp={"python": "3.11"})
    text = canonical_text(snapshot)
    by_hand = text.replace("\\u00b0", "°").replace('"3.11"', '"3.10"')
    path = tmp_path / golden_name(snapshot.identity)
    path.parent.mkdir()
    path.write_text(by_hand, encoding="utf-8")
    assert check_golden(snapshot, tmp_path, update=False).status is GoldenStatus.SAME
    assert check_golden(snapshot, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert path.read_text(encoding="utf-8") == text.replace("\\u00b0", "°") != text


def test_a_file_whose_stamp_cannot_be_read_is_written_anew(tmp_path: Path) -> None:
    path = golden_file(tmp_path, json.dumps(changed(put("stamp", value=7))))
    assert check_golden(STANDS, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert path.read_text(encoding="utf-8") == canonical_text(STANDS)


@pytest.mark.parametrize("change", [drop("stamp"), put("stamp", value=7)])
def test_a_file_without_a_stamp_is_the_same(change: Change, tmp_path: Path) -> None:
    golden_file(tmp_path, json.dumps(changed(change)))
    result = check_golden(STANDS, tmp_path, update=False)
    assert (result.status, "python none (now " in result.note) == (GoldenStatus.SAME, True)


@pytest.mark.parametrize("value", ["true", "1", "True", "yes", "woodpecker"])
def test_ci_reads_golden_files_and_writes_none(value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", value)
    with pytest.raises(GoldenWriteRefusedError, match="update them locally"):
        check_golden(STANDS, tmp_path, update=True)
    path = golden_file(tmp_path, canonical_text(STANDS))
    with pytest.raises(GoldenWriteRefusedError):
        remove_obsolete([str(path)])
    assert check_golden(STANDS, tmp_path, update=False).status is GoldenStatus.SAME


@pytest.mark.parametrize("value", ["", "false", "0", "no"])
def test_a_ci_variable_that_says_no_is_no_ci(value: str) -> None:
    refuse_in_ci({"CI": value})


def test_obsolete_files_are_those_of_no_variant(tmp_path: Path) -> None:
    names = (
        "a/thesis.json",
        "gone/thesis.json",
        "gone/package.json",
        "gone/README.md",
        "gone/thesis.json.orig",
        "thesis.json",
    )
    for name in names:
        write(tmp_path, '{"format": 1}', name)
    (tmp_path / "a" / "exact.json").mkdir()
    gone = (tmp_path / "gone" / "thesis.json").as_posix()
    assert obsolete(tmp_path, ["a/thesis.json", "new/thesis.json"], whole_set=True) == (gone,)
    assert obsolete(tmp_path, [], whole_set=False) == ()
    assert obsolete(tmp_path / "nowhere", [], whole_set=True) == ()
    assert remove_obsolete([gone, gone]) == (gone, gone)
    assert not Path(gone).exists()
    assert [name for name in names if not (tmp_path / name).exists()] == ["gone/thesis.json"]


def test_an_obsolete_golden_that_cannot_be_removed_does_not_keep_others(tmp_path: Path) -> None:
    (tmp_path / "stays" / "x.json").mkdir(parents=True)  # unlink refuses a directory to everybody, even to root
    goes = str(write(tmp_path, "", "goes/x.json"))
    assert remove_obsolete([str(tmp_path / "stays" / "x.json"), goes]) == (goes,)
    assert [entry.name for entry in tmp_path.iterdir()] == ["stays"]


def test_a_golden_behind_a_link_is_not_obsolete(tmp_path: Path) -> None:
    elsewhere, golden = tmp_path / "elsewhere", tmp_path / "golden"
    elsewhere.mkdir()
    golden.mkdir()
    (elsewhere / "exact.json").write_text('{"format": 1}', encoding="utf-8")
    (golden / "linked").symlink_to(elsewhere)
    assert obsolete(golden, [], whole_set=True) == ()


def test_a_directory_that_cannot_be_read_has_nothing_known_as_obsolete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", refuse)
    assert obsolete(tmp_path, [], whole_set=True) == ()


def test_the_format_is_part_of_the_file() -> None:
    assert document(replace(STANDS, stamp={}))["format"] == FORMAT


@pytest.mark.parametrize("number", [1, 7])
def test_runs_with_one_process_id_write_files_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    # Two containers that share a volume: the other is in the midst of writing when this one begins.
    monkeypatch.setattr(os, "getpid", lambda: number)
    written: list[str] = []
    sync = os.fsync

    def another_writes_meanwhile(file: int) -> None:
        monkeypatch.setattr(os, "fsync", sync)
        written.extend(entry.name for entry in (tmp_path / "tower").iterdir())
        other = replace(STANDS, identity=replace(IDENTITY, scenario="other"))
        assert check_golden(other, tmp_path, update=True).status is GoldenStatus.WRITTEN
        sync(file)

    monkeypatch.setattr(os, "fsync", another_writes_meanwhile)
    assert check_golden(STANDS, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert len(written) == 1
    for identity in (IDENTITY, replace(IDENTITY, scenario="other")):
        text = (tmp_path / golden_name(identity)).read_text(encoding="utf-8")
        assert f'"scenario": "{identity.scenario}"' in text
    assert len([*tmp_path.rglob("*.*")]) == 2


def test_temporary_files_of_a_killed_run_are_removed_and_fresh_ones_kept(tmp_path: Path) -> None:
    folder = place(tmp_path).parent
    left, fresh = folder / ".0123.golden.tmp", folder / ".4567.golden.tmp"
    for file in (left, fresh):
        file.touch()
    os.utime(left, (0.0, 0.0))
    check_golden(STANDS, tmp_path, update=True)
    assert {entry.name for entry in folder.iterdir()} == {Path(golden_name(IDENTITY)).name, fresh.name}


@pytest.mark.parametrize("update", [False, True])
def test_a_golden_that_has_no_end_is_not_read(tmp_path: Path, update: bool) -> None:
    place(tmp_path).symlink_to("/dev/zero")
    result = check_golden(STANDS, tmp_path, update=False)
    assert (result.status, "a link leads out of" in result.note) == (GoldenStatus.UNREADABLE, True)
    if update:
        assert check_golden(STANDS, tmp_path, update).status is GoldenStatus.WRITTEN


def test_a_pipe_in_place_of_a_golden_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(place(tmp_path))
    assert check_golden(STANDS, tmp_path, update=False).note == "it is not a regular file"


def test_a_golden_of_a_newer_version_is_left_alone(tmp_path: Path) -> None:
    path = place(tmp_path)
    path.write_text('{"format": 3}', encoding="utf-8")
    for update in (False, True):
        result = check_golden(STANDS, tmp_path, update)
        assert result.status is GoldenStatus.NEWER
        assert "update stackdsl" in result.note
    assert path.read_text(encoding="utf-8") == '{"format": 3}'
