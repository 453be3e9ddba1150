"""A snapshot against its golden text: what counts as different, and how it is told."""

import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stackdsl.goldens.comparison import compare, compare_documents, fallen_in
from stackdsl.goldens.file_format import canonical_text, document
from stackdsl.goldens.snapshot import MalformedSnapshotError, Snapshot
from stackdsl.results import GoldenDifference
from stackdsl.trace import BrickState
from tests.stackdsl.goldens.changes import BRICK, FALLS, PLACED, STANDS, Change, Document, changed, drop, put
from tests.stackdsl.goldens.towers import FALL, taken, tower, track


@pytest.mark.parametrize("snapshot", [STANDS, FALLS])
def test_a_snapshot_agrees_with_its_own_text(snapshot: Snapshot) -> None:
    assert compare(json.loads(canonical_text(snapshot)), snapshot) == ()


@pytest.mark.parametrize(("time", "told"), [(2.52, "2.520 s -> 2.500 s"), (2.5, ""), (3.0, "")])
def test_a_first_fall_at_another_time_is_told_unless_it_is_a_difference(time: float, told: str) -> None:
    was = changed(put("collapse", "time_s", value=time), FALLS)
    assert fallen_in(was, document(FALLS)).first == told


def test_an_unclear_state_may_be_a_fall_only_after_a_collapse() -> None:
    unclear = put(*BRICK, "state", value="unclear")
    assert fallen_in(changed(unclear, STANDS), document(STANDS)).text == ""
    assert fallen_in(changed(unclear, FALLS), document(FALLS)).text.endswith("and up to 1 more")


WITHIN = [
    (STANDS, put(*BRICK, "at_mm", value=[0.5, -0.5, 12.5])),
    (STANDS, put(*BRICK, "rests_on", "L1.1", value=0.98)),
    (STANDS, put(*PLACED, "at_mm", value=[0.01, -0.01, 11.99])),
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
    (STANDS, put(*PLACED, "at_mm", 1, value=0.02), ("L2.1", "y when placed", "0.02 mm", "0.00 mm", "± 0.01 mm")),
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


def test_after_a_collapse_it_is_no_matter_whether_what_stands_was_proven_by_the_end() -> None:
    fell = {"collapse": {"level": 2}, "bricks": {"a": {"state": "frozen"}}}
    alike = {"collapse": {"level": 2}, "bricks": {"a": {"state": "standing"}}}
    other = {"collapse": {"level": 2}, "bricks": {"a": {"state": "fallen"}}}
    assert compare_documents(fell, alike) == ()
    assert [found.quantity for found in compare_documents(fell, other)] == ["state"]
    stood = [{"bricks": {"a": {"state": state}}} for state in ("frozen", "standing")]
    assert [found.quantity for found in compare_documents(*stood)] == ["state"]


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


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=6,
)
PLACES = [(), ("collapse",), ("collapse", "level"), ("events",), ("events", 1), ("events", 1, "placed"), PLACED,
          (*PLACED, "at_mm"), (*PLACED, "rests_on"), ("bricks",), BRICK, (*BRICK, "state"), (*BRICK, "at_mm"),
          (*BRICK, "rests_on"), (*BRICK, "rests_on", "L1.1"), ("stamp",)]  # fmt: skip


@settings(max_examples=60)
@given(st.sampled_from(PLACES), JSON)
@example(("events", 1, "placed"), {"": None})
def test_no_content_whatever_breaks_the_comparison(place: tuple[str | int, ...], value: object) -> None:
    whole = changed(put(*place, value=value), FALLS) if place else value
    if isinstance(whole, dict):
        with suppress(MalformedSnapshotError):
            compare(whole, FALLS)


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


@pytest.mark.parametrize("key", ["verdict", "statics", "scenario"])
def test_a_verdict_is_never_too_close_to_call(key: str) -> None:
    expected = {**document(STANDS), key: "unclear"}
    assert [found.expected for found in compare(expected, STANDS)] == ["unclear"]


NEVER_UNCLEAR = [
    ("gravity", put("world", "gravity", value="unclear")),
    ("friction", put("world", "friction", value="unclear")),
    ("friction", put("world", "planes", "ground", "friction", value="unclear")),
    ("x", put("world", "planes", "ground", "at_mm", 0, value="unclear")),
    ("z of the normal", put("world", "planes", "ground", "normal", 2, value="unclear")),
    ("x size", put(*PLACED, "size_mm", 0, value="unclear")),
    ("mass", put(*PLACED, "mass_g", value="unclear")),
    ("z of the turn", put(*PLACED, "turn_deg", 2, value="unclear")),
    ("x when placed", put(*PLACED, "at_mm", 0, value="unclear")),
    ("placed at", put("events", 1, "time_s", value="unclear")),
    ("margin", put("events", 1, "margin_mm", value="unclear")),
    ("collapse time", put("collapse", "time_s", value="unclear")),
]


@pytest.mark.parametrize(("quantity", "change"), NEVER_UNCLEAR)
def test_a_golden_cannot_declare_other_values_too_close_to_call(quantity: str, change: Change) -> None:
    snapshot = FALLS if quantity == "collapse time" else STANDS
    (found,) = compare(changed(change, snapshot), snapshot)
    assert (found.quantity, found.expected) == (quantity, "unclear")


@pytest.mark.parametrize("state", ["removed", "thrown"])
def test_whether_a_brick_was_pulled_out_or_thrown_is_never_too_close_to_call(state: str) -> None:
    whole: Document = {"bricks": {"a": {"state": "unclear"}}}
    assert [found.got for found in compare_documents(whole, {"bricks": {"a": {"state": state}}})] == [state]


JUNK: list[object] = [True, [], {}, "nowhere", ["unclear"], None]
NUMBERS: list[object] = [10**30, -1.5]
UNCLEAR_NUMBERS: list[tuple[str | int, ...]] = [("height_mm",), (*BRICK, "at_mm", 0), (*BRICK, "rests_on", "L1.1")]


@pytest.mark.parametrize(
    ("place", "junk"),
    [
        *((place, JUNK) for place in UNCLEAR_NUMBERS),
        (("levels_standing",), [*JUNK, -1, 1.5]),
        ((*BRICK, "state"), [*JUNK, *NUMBERS]),
    ],
)
def test_a_value_too_close_to_call_agrees_with_no_invalid_value(
    place: tuple[str | int, ...], junk: list[object]
) -> None:
    unclear = changed(put(*place, value="unclear"))
    for value in junk:
        assert len(compare_documents(changed(put(*place, value=value)), unclear)) == 1, value


@pytest.mark.parametrize("place", UNCLEAR_NUMBERS)
@pytest.mark.parametrize("value", NUMBERS)
def test_a_value_too_close_to_call_agrees_with_every_valid_value(place: tuple[str | int, ...], value: object) -> None:
    assert compare_documents(changed(put(*place, value=value)), changed(put(*place, value="unclear"))) == ()


def test_gave_way_is_a_brick_or_too_close_to_call() -> None:
    unclear = changed(put("collapse", "gave_way", value="unclear"), FALLS)
    assert compare_documents(changed(put("collapse", "gave_way", value="L2.1"), FALLS), unclear) == ()
    assert compare_documents(changed(drop("collapse", "gave_way"), FALLS), unclear) == ()
    odd: list[object] = [7, [], {}, True]
    for junk in odd:
        (found,) = compare_documents(changed(put("collapse", "gave_way", value=junk), FALLS), unclear)
        assert found.quantity == "gave way"
