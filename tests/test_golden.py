"""A snapshot against its golden file: what counts as different, how it is told, and when the file is written."""

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stackdsl.outcome import GoldenDifference, GoldenStatus
from stackdsl.snapshots.canonical import canonical_text, document
from stackdsl.snapshots.comparison import MalformedSnapshotError, compare, compare_documents
from stackdsl.snapshots.golden import (
    GoldenWriteRefusedError,
    check_golden,
    current_stamp,
    golden_name,
    obsolete,
    refuse_in_ci,
    remove_obsolete,
)
from stackdsl.snapshots.record import FORMAT, Identity, Snapshot
from stackdsl.trace import BrickState
from tests.test_snapshot import FALL, IDENTITY, taken, tower, track

Document: TypeAlias = dict[str, Any]  # the tests change it in many places
Change: TypeAlias = Callable[[Document], object]

STANDS = taken(tower())
FALLS = taken(tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL))


@pytest.fixture(autouse=True)
def _at_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)


def changed(change: Change, snapshot: Snapshot = STANDS) -> Document:
    whole: Document = json.loads(canonical_text(snapshot))
    change(whole)
    return whole


def put(*path: str | int, value: object) -> Change:
    def change(whole: Document) -> None:
        inner: Any = whole
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value

    return change


def drop(*path: str | int) -> Change:
    def change(whole: Document) -> None:
        inner: Any = whole
        for key in path[:-1]:
            inner = inner[key]
        del inner[path[-1]]

    return change


@pytest.mark.parametrize("snapshot", [STANDS, FALLS])
def test_a_snapshot_agrees_with_its_own_text(snapshot: Snapshot) -> None:
    assert compare(json.loads(canonical_text(snapshot)), snapshot) == ()


BRICK = ("bricks", "L2.1")
PLACED = ("events", 1, "placed", "L2.1")
WITHIN = [
    (STANDS, put(*BRICK, "at_mm", value=[0.5, -0.5, 12.5])),
    (STANDS, put(*BRICK, "rests_on", "L1.1", value=0.98)),
    (STANDS, put(*PLACED, "at_mm", value=[0.5, -0.5, 11.5])),
    (STANDS, put("events", 1, "time_s", value=1.005)),
    (STANDS, put("events", 1, "margin_mm", value=12.2)),
    (STANDS, put("height_mm", value=24.5)),
    (FALLS, put("collapse", "time_s", value=2.55)),
    (STANDS, put(*BRICK, "state", value="unclear")),
    (STANDS, put("height_mm", value="unclear")),
    (STANDS, put("levels_standing", value="unclear")),
]
BEYOND = [
    (STANDS, put(*BRICK, "at_mm", 0, value=0.51), ("L2.1", "x", "0.51 mm", "0.00 mm", "± 0.5 mm")),
    (STANDS, put(*BRICK, "at_mm", 2, value=11.49), ("L2.1", "z", "11.49 mm", "12.00 mm", "± 0.5 mm")),
    (STANDS, put(*BRICK, "rests_on", "L1.1", value=0.97), ("L2.1", "share on L1.1", "0.970", "1.000", "± 0.02")),
    (STANDS, put(*BRICK, "state", value="fallen"), ("L2.1", "state", "fallen", "frozen", "exact")),
    (STANDS, put(*BRICK, "level", value=7), ("L2.1", "level", "7", "2", "exact")),
    (STANDS, drop(*BRICK), ("L2.1", "brick", "none", "present", "exact")),
    (STANDS, put("bricks", "top", value={}), ("top", "brick", "present", "none", "exact")),
    (STANDS, put(*BRICK, "rests_on", "X", value=0.0), ("L2.1", "rests on", "X (share 0.000)", "none", "exact")),
    (STANDS, put(*BRICK, "rests_on", value={}), ("L2.1", "rests on", "none", "L1.1 (share 1.000)", "exact")),
    (STANDS, put(*PLACED, "at_mm", 1, value=1.0), ("L2.1", "y when placed", "1.00 mm", "0.00 mm", "± 0.5 mm")),
    (
        STANDS,
        put(*PLACED, "rests_on", "L1.1", value=0.5),
        ("L2.1", "share on L1.1 when placed", "0.500", "1.000", "± 0.02"),
    ),
    (STANDS, drop(*PLACED, "rests_on"), ("L2.1", "rests on when placed", "none", "L1.1 (share 1.000)", "exact")),
    (STANDS, put("events", 1, "time_s", value=1.006), ("L2.1", "placed at", "1.006 s", "1.000 s", "± 0.005 s")),
    (
        STANDS,
        put("events", 1, "margin_mm", value=12.21),
        ("event 2 (1.000 s)", "margin", "12.21 mm", "12.00 mm", "± 0.2 mm"),
    ),
    (STANDS, drop("events", 1), ("L2.1", "placed at", "none", "1.000 s", "exact")),
    (FALLS, put("verdict", value="stands"), ("structure", "verdict", "stands", "collapses", "exact")),
    (FALLS, put("collapse", "level", value=4), ("structure", "collapse level", "4", "3", "exact")),
    (FALLS, put("collapse", "time_s", value=2.551), ("structure", "collapse time", "2.551 s", "2.500 s", "± 0.05 s")),
    (FALLS, put("collapse", "gave_way", value="L2.1"), ("structure", "gave way", "L2.1", "L1.1", "exact")),
    (STANDS, put("height_mm", value=24.51), ("structure", "height", "24.51 mm", "24.00 mm", "± 0.5 mm")),
    (STANDS, drop("height_mm"), ("structure", "height", "none", "24.00 mm", "± 0.5 mm")),
    (STANDS, put("levels_standing", value=2), ("structure", "levels standing", "2", "3", "exact")),
    (STANDS, put("variant", value="stock"), ("snapshot", "variant", "stock", "thesis", "exact")),
]  # fmt: skip


@pytest.mark.parametrize(("snapshot", "change"), WITHIN)
def test_within_its_tolerance_an_observation_is_the_same(snapshot: Snapshot, change: Change) -> None:
    assert changed(change, snapshot) != document(snapshot)
    assert compare(changed(change, snapshot), snapshot) == ()


@pytest.mark.parametrize(("snapshot", "change", "told"), BEYOND, ids=[told[1] for _, _, told in BEYOND])
def test_beyond_its_tolerance_an_observation_is_named_with_its_unit(
    snapshot: Snapshot, change: Change, told: tuple[str, str, str, str, str]
) -> None:
    assert compare(changed(change, snapshot), snapshot) == (GoldenDifference(*told),)


def test_an_event_more_does_not_shift_those_after_it() -> None:
    early = {"time_s": 0.5, "placed": {"extra": {"at_mm": [0.0, 0.0, 50.0]}}}
    assert compare(changed(lambda whole: whole["events"].insert(1, early)), STANDS) == (
        GoldenDifference("extra", "placed at", "0.500 s", "none", "exact"),
    )


def test_bricks_placed_in_other_groups_are_told_by_when_each_was_placed() -> None:
    # Once L1.1 and L2.1 were placed together; now L2.1 comes 1 s later, alone.
    def together(whole: Document) -> None:
        first, second = whole["events"][:2]
        whole["events"][:2] = [{**second, "time_s": 0.0, "placed": first["placed"] | second["placed"]}]

    told = [one for one in compare(changed(together), STANDS) if one.quantity == "placed at"]
    assert told == [GoldenDifference("L2.1", "placed at", "0.000 s", "1.000 s", "± 0.005 s")]


def test_bricks_placed_at_the_same_time_in_other_groups_are_the_same() -> None:
    def apart(whole: Document) -> None:
        event = whole["events"][1]
        whole["events"].append({**event, "placed": {"L9.1": {"at_mm": [0.0, 0.0, 90.0]}}})

    def together(whole: Document) -> None:
        whole["events"][1]["placed"]["L9.1"] = {"at_mm": [0.0, 0.0, 90.0]}

    assert compare_documents(changed(apart), changed(together)) == ()


@pytest.mark.parametrize("change", [put(*BRICK, "at_mm", value=None), put(*BRICK, "at_mm", value=[1.0, 2.0])])
def test_where_an_unclear_brick_lies_is_not_compared(change: Change) -> None:
    whole = changed(change)
    whole["bricks"]["L2.1"]["state"] = "unclear"
    assert compare(whole, STANDS) == ()


def test_a_brick_that_ended_otherwise_is_not_told_again_by_its_place() -> None:
    whole = changed(put(*BRICK, "at_mm", value=[99.0, 0.0, 12.0]))
    whole["bricks"]["L2.1"]["state"] = "standing"
    assert [one.quantity for one in compare(whole, STANDS)] == ["state"]


ODD_VALUES: list[object] = [None, True, "high", 10**400, float("nan"), float("inf"), [], {"mm": 24}]


@pytest.mark.parametrize("value", ODD_VALUES)
def test_an_odd_value_in_a_golden_file_is_a_difference(value: object) -> None:
    (found,) = compare(changed(put("height_mm", value=value)), STANDS)
    assert (found.quantity, found.got) == ("height", "24.00 mm")


def test_jsons_true_is_not_its_one() -> None:
    one_level = taken(tower(track("L2.1", 2, BrickState.FALLEN, shift=1.0), collapse=FALL))
    assert [one.expected for one in compare(changed(put("levels_standing", value=True), one_level), one_level)] == [
        "True"
    ]


def test_the_file_is_missing_then_written_then_the_same(tmp_path: Path) -> None:
    def check(update: bool) -> GoldenStatus:
        return check_golden(STANDS, tmp_path / "golden", update).status

    assert [check(False), check(True), check(False)] == [
        GoldenStatus.MISSING,
        GoldenStatus.WRITTEN,
        GoldenStatus.SAME,
    ]
    assert [entry.name for entry in (tmp_path / "golden").iterdir()] == ["tower[thesis].json"]
    assert (tmp_path / "golden" / "tower[thesis].json").read_bytes() == canonical_text(STANDS).encode()


def golden_file(directory: Path, text: str) -> Path:
    path = directory / golden_name(IDENTITY)
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
    (tmp_path / golden_name(IDENTITY)).write_bytes(canonical_text(STANDS).replace("\n", ends).encode())
    assert check_golden(STANDS, tmp_path, update=False).status is GoldenStatus.SAME


UNREADABLE = {
    "nothing": (b"", "Expecting value"),
    "a merge conflict": (b"<<<<<<< HEAD\n{}", "Expecting value: line 1 column 1"),
    "half a file": (canonical_text(STANDS)[:200].encode(), "line"),
    "not UTF-8": (b"\xff\xfe{}", "not UTF-8"),
    "no object": (b"[1]", "no object"),
    "no format": (b"{}", "its format is none, this version reads 1"),
    "another format": (b'{"format": 2}', "its format is 2, this version reads 1; write it anew with --update"),
    "bricks in an array": (b'{"format": 1, "bricks": []}', "'bricks' is not an object"),
    "a brick that is none": (canonical_text(STANDS).replace('"bricks": {', '"bricks": {"L1.1": 0, ').encode(), "twice"),
    "a number for a brick": (json.dumps(changed(put(*BRICK, value=0))).encode(), "'L2.1' is not an object"),
    "events in an object": (b'{"format": 1, "events": {}}', "'events' is not an array"),
    "a number for an event": (b'{"format": 1, "events": [3]}', "event 1 is not an object"),
    "an event of nothing": (b'{"format": 1, "events": [{}]}', "event 1 places no brick"),
    "a brick placed twice": (
        b'{"format": 1, "events": [{"placed": {"a": {}}}, {"placed": {"a": {}}}]}',
        "event 2 places 'a' of event 1 again",
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
    (tmp_path / golden_name(IDENTITY)).write_bytes(content)
    result = check_golden(STANDS, tmp_path, update=False)
    assert result.status is GoldenStatus.UNREADABLE
    assert reason in result.note
    assert check_golden(STANDS, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert check_golden(STANDS, tmp_path, update=False).status is GoldenStatus.SAME


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=6,
)
PLACES = [(), ("collapse",), ("collapse", "level"), ("events",), ("events", 1), ("events", 1, "placed"), PLACED,
          (*PLACED, "at_mm"), (*PLACED, "rests_on"), ("bricks",), BRICK, (*BRICK, "state"), (*BRICK, "at_mm"),
          (*BRICK, "rests_on"), (*BRICK, "rests_on", "L1.1"), ("stamp",)]  # fmt: skip


@given(st.sampled_from(PLACES), JSON)
@example(("events", 1, "placed"), {"": None})
def test_no_content_whatever_breaks_the_comparison(place: tuple[str | int, ...], value: object) -> None:
    whole = changed(put(*place, value=value), FALLS) if place else value
    if isinstance(whole, dict):
        with suppress(MalformedSnapshotError):
            compare(whole, FALLS)


def test_a_directory_in_place_of_the_file_is_told(tmp_path: Path) -> None:
    (tmp_path / golden_name(IDENTITY)).mkdir()
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
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]
    assert path.read_text(encoding="utf-8") == "old"


@pytest.mark.parametrize(("status", "height"), [(GoldenStatus.SAME, 24.0), (GoldenStatus.DIFFERENT, 30.0)])
def test_another_stamp_is_a_note_and_never_a_failure(status: GoldenStatus, height: float, tmp_path: Path) -> None:
    whole = changed(put("stamp", "pybullet", value="3.2.6"))
    golden_file(tmp_path, json.dumps(whole | {"height_mm": height}))
    result = check_golden(STANDS, tmp_path, update=False)
    assert (result.status, result.note) == (status, "made with pybullet 3.2.6 (now 3.2.7)")


@pytest.mark.parametrize("change", [drop("stamp"), put("stamp", value=7)])
def test_a_file_without_a_stamp_is_the_same(change: Change, tmp_path: Path) -> None:
    golden_file(tmp_path, json.dumps(changed(change)))
    result = check_golden(STANDS, tmp_path, update=False)
    assert (result.status, "pybullet none (now 3.2.7)" in result.note) == (GoldenStatus.SAME, True)


def test_the_stamp_names_python_and_pybullet() -> None:
    assert current_stamp().keys() >= {"python", "pybullet"}


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


NAMES = {
    ("tower", "thesis"): "tower[thesis].json",
    ("tower", "step=10mm,thesis"): "tower[step=10mm,thesis].json",
    ("tower", "step=1.5mm,stock"): "tower[step=1.5mm,stock].json",
    ("Tower", "N=4"): "%54ower[%4e=4].json",
    ("tower", ""): "tower[].json",
    ("a/b\\c", "x:y*?"): "a%2fb%5cc[x%3ay%2a%3f].json",
    ("..", "100%"): "%2e%2e[100%25].json",
    ("con.txt", "a b"): "con%2etxt[a%20b].json",
    ("a[b]", "c"): "a%5bb%5d[c].json",
    ("tårn", "c"): "t%c3%a5rn[c].json",
}


@pytest.mark.parametrize(("names", "file"), NAMES.items(), ids=NAMES.values())
def test_a_golden_file_is_named_after_its_scenario_and_variant(names: tuple[str, str], file: str) -> None:
    assert golden_name(Identity(*names, system="")) == file


PAIRS = st.tuples(st.text(max_size=80), st.text(max_size=80))


@given(PAIRS, PAIRS)
@example(("a[b", "c"), ("a", "b[c"))
@example(("a", "b"), ("A", "b"))
@example(("a", "b"), ("a", "B"))
@example(("x" * 80, ""), ("x" * 79 + "y", ""))
@example(("%41", ""), ("A", ""))
def test_no_two_variants_share_a_file_on_any_disk(one: tuple[str, str], other: tuple[str, str]) -> None:
    names = [golden_name(Identity(*names, system="")) for names in (one, other)]
    assert (names[0].casefold() == names[1].casefold()) is (one == other)
    assert all(len(name) <= 143 and name.isascii() and "/" not in name for name in names)


def test_obsolete_files_are_those_of_no_variant(tmp_path: Path) -> None:
    for name in ("a[thesis].json", "gone[thesis].json", "package.json", "README.md", "gone[thesis].json.orig"):
        (tmp_path / name).write_text("", encoding="utf-8")
    (tmp_path / "directory[x].json").mkdir()
    gone = (tmp_path / "gone[thesis].json").as_posix()
    assert obsolete(tmp_path, ["a[thesis].json", "new[thesis].json"], whole_set=True) == (gone,)
    assert obsolete(tmp_path, [], whole_set=False) == ()
    assert obsolete(tmp_path / "nowhere", [], whole_set=True) == ()
    assert remove_obsolete([gone, gone]) == (gone, gone)
    assert not Path(gone).exists()
    assert len(list(tmp_path.iterdir())) == 5


def test_what_the_disk_refuses_to_remove_is_left_and_the_rest_removed(tmp_path: Path) -> None:
    (tmp_path / "stays[x].json").mkdir()  # unlink refuses a directory to everybody, even to root
    (tmp_path / "goes[x].json").touch()
    goes = str(tmp_path / "goes[x].json")
    assert remove_obsolete([str(tmp_path / "stays[x].json"), goes]) == (goes,)
    assert [entry.name for entry in tmp_path.iterdir()] == ["stays[x].json"]


def test_a_directory_that_cannot_be_read_has_nothing_known_as_obsolete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", refuse)
    assert obsolete(tmp_path, [], whole_set=True) == ()


def test_the_format_is_part_of_the_file() -> None:
    assert document(replace(STANDS, stamp={}))["format"] == FORMAT


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda d: d["world"].update(friction=0.4), ("world", "friction")),
        (lambda d: d["world"].update(gravity=1.62), ("world", "gravity")),
        (lambda d: d["world"]["planes"]["ground"].update(friction=0.1), ("ground", "friction")),
        (lambda d: d["world"]["planes"]["ground"].update(normal=[0.1, 0.0, 0.99]), ("ground", "x of the normal")),
        (lambda d: d["world"]["planes"].pop("ground"), ("ground", "plane")),
        (lambda d: d["events"][0]["placed"]["L1.1"].update(turn_deg=[0.0, 0.0, 20.0]), ("L1.1", "z of the turn")),
        (lambda d: d["events"][0]["placed"]["L1.1"].update(size_mm=[100.0, 24.0, 8.0]), ("L1.1", "x size")),
        (lambda d: d["events"][0]["placed"]["L1.1"].update(mass_g=13.0), ("L1.1", "mass")),
    ],
)
def test_another_scene_is_never_the_same(change: Callable[[Any], object], told: tuple[str, str]) -> None:
    golden = json.loads(canonical_text(taken(tower())))
    change(golden)
    assert told in [(difference.subject, difference.quantity) for difference in compare(golden, taken(tower()))]
