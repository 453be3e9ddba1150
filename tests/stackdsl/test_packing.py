"""A packing library's load is checked box by box: the first box without support, with closed forms of balance."""

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stackdsl.packing import PackedBox, PackingResult, check

LOW = PackedBox("low", (200, 200, 0), (400, 300, 200), 8)


def on_low(beyond: float, **changes: Any) -> PackedBox:  # noqa: ANN401 -- fields of a box
    """A box on `low` whose centre is by so much beyond its end at x = 600 [mm]."""
    return replace(PackedBox("high", (600 + beyond - 150, 200, 200), (300, 300, 100), 3), **changes)


def test_a_box_stands_while_its_centre_is_over_the_box_below() -> None:
    assert check([LOW, on_low(-0.1)])
    lost = check([LOW, on_low(0.1)]).lost
    assert lost is not None
    assert (lost.index, lost.name, lost.moving, lost.stability) == (1, "high", ("high",), "unstable")
    assert lost.reason.startswith("high tips over low")


def test_the_deck_ends_where_a_box_tips_over_its_edge_and_a_floor_does_not() -> None:
    box = PackedBox("a", (1199.9 - 150, 0, 0), (300, 200, 200), 5)
    beyond = replace(box, corner=(1200.1 - 150, 0, 0))
    assert check([box])
    assert not check([beyond])
    assert check([beyond], deck=None)
    assert check([beyond], deck=(1201, 800))
    assert check([box]).overhang_mm == pytest.approx(149.9)
    assert check([LOW]).overhang_mm == 0.0


def test_a_box_over_a_gap_between_boards_tips_and_stands_on_a_closed_deck() -> None:
    box = PackedBox("a", (300, 145 + 41.25 - 30.1, 0), (300, 60, 50), 5)  # its centre 0.1 mm before the second board
    assert check([box])
    assert str(check([box], surface="boards")) == "box 1 of the load, a: a tips over deck"
    assert not check([box], surface=[145, 100, 145, 100, 145])
    assert check([replace(box, corner=(300, 145 + 41.25 - 29.9, 0))], surface="boards")


def test_boxes_are_judged_when_they_are_placed_so_a_counterweight_must_come_first() -> None:
    lever = PackedBox("lever", (550, 200, 200), (300, 300, 100), 3)  # its centre is 100 mm beyond the end of `low`
    weight = PackedBox("weight", (550, 200, 300), (50, 300, 200), 30)  # over `low`
    result = check([LOW, lever, weight])
    assert result.lost is not None
    assert result.lost.name == "lever"
    assert result.placed == 1
    long = PackedBox("long", (200, 200, 200), (900, 300, 100), 9)  # its centre is 50 mm beyond the end
    held = PackedBox("held", (200, 200, 300), (300, 300, 200), 9)
    assert not check([LOW, long, held])


def test_neighbours_hold_a_box_over_the_edge_only_if_they_are_counted() -> None:
    row = [PackedBox("a", (600, 0, 0), (600, 400, 300), 12), PackedBox("b", (920, 400, 0), (600, 400, 300), 12)]
    assert str(check(row)).startswith("box 2 of the load, b: b tips over deck")
    assert check(row, neighbours=True)


def test_a_box_inside_another_or_the_deck_is_named_with_its_depth() -> None:
    assert str(check([LOW, on_low(-100, corner=(300, 200, 190))])) == "box 2 of the load, high: it is 10 mm inside low"
    assert str(check([replace(LOW, corner=(0, 0, -5))])) == "box 1 of the load, low: it is 5 mm inside deck"


def test_a_box_in_the_air_falls() -> None:
    lost = check([LOW, on_low(-100, corner=(300, 200, 250))]).lost
    assert lost is not None
    assert lost.reason == "high falls: nothing is under it"


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 8), st.integers(0, 5), st.integers(0, 2)), min_size=1, max_size=8, unique=True),
    st.sampled_from(["cm", "m", "in"]),
)
def test_the_result_is_the_same_in_every_unit_mirrored_and_for_other_masses(
    places: list[tuple[int, int, int]], unit: str
) -> None:
    boxes = [
        PackedBox(f"b{n}", (100.0 * x, 100.0 * y, 150.0 * z), (220.0, 140.0, 150.0), 2.0)
        for n, (x, y, z) in enumerate(sorted(places, key=lambda place: place[2]))
    ]
    usual = _told(check(boxes))
    factor = {"cm": 10.0, "m": 1000.0, "in": 25.4}[unit]
    scaled = [
        replace(
            box,
            corner=(box.corner[0] / factor, box.corner[1] / factor, box.corner[2] / factor),
            size=(box.size[0] / factor, box.size[1] / factor, box.size[2] / factor),
        )
        for box in boxes
    ]
    assert _told(check(scaled, unit=unit)) == usual  # type: ignore[arg-type]
    assert _told(check([replace(box, mass=7.0 * box.mass) for box in boxes])) == usual
    mirrored = [replace(box, corner=(1200.0 - box.corner[0] - box.size[0], *box.corner[1:])) for box in boxes]
    assert _told(check(mirrored)) == usual


def _told(result: PackingResult) -> tuple[int, str]:
    return result.placed, result.lost.stability if result.lost else ""


@pytest.mark.parametrize(
    ("boxes", "asked", "message"),
    [
        ([LOW, LOW], {}, "'low' is that of two boxes"),
        ([replace(LOW, name="deck")], {}, "'deck' is that of the deck or the floor"),
        ([replace(LOW, mass=0.0)], {}, "not greater than zero"),
        ([replace(LOW, size=(1, -1, 1))], {}, "not greater than zero"),
        ([replace(LOW, corner=(float("nan"), 0, 0))], {}, "not finite"),
        ([LOW], {"deck": "EUR9"}, "'EUR9' is not the size of a deck"),
        ([LOW], {"deck": "EUR2", "surface": "boards"}, "is that of an EUR pallet"),
        ([LOW], {"unit": "ft"}, "'ft' is not a unit of lengths"),
    ],
)
def test_what_is_no_load_is_refused(boxes: list[PackedBox], asked: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check(boxes, **asked)
