"""Boxes of a file come to touch what is below them: by how much each moves has closed forms."""

from fractions import Fraction

from stackdsl.diagnostics import Span
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad
from stackdsl.importers.settling import SettledLoad, first_unsettleable, moved_lines, settled
from stackdsl.language.imports import Settle, parse_settle

MM = Fraction(1, 1000)


def box(  # noqa: PLR0913, PLR0917 -- in the order of their importance
    name: str, x: int, bottom: float, height: int, length: int = 100, yaw: int = 0
) -> ImportedBox:
    """A box 100 mm wide whose lower left edge is at x, all in mm."""
    size: Exact3 = (length * MM, 100 * MM, height * MM)
    centre: Exact3 = ((x + Fraction(length, 2)) * MM, Fraction(0), (Fraction(bottom) + Fraction(height, 2)) * MM)
    turn: Exact3 = (Fraction(0), Fraction(0), Fraction(yaw))
    return ImportedBox(name, size, centre, Fraction(1), Span("a", 1, 1, 1), turn)


def settle(how: str, *boxes: ImportedBox) -> SettledLoad:
    return settled(ImportedLoad(boxes, MM), parse_settle(how))


def heights(found: SettledLoad) -> list[float]:
    """Of the lower faces [mm]."""
    return [float(each.bottom / MM) for each in found.load.boxes]


def test_as_written_nothing_moves() -> None:
    found = settle("as written", box("a", 0, 3, 50), box("b", 0, 60, 50))
    assert heights(found) == [3, 60]
    assert list(moved_lines(found)) == ["no box was moved (2 boxes)"]


def test_down_each_box_falls_onto_the_highest_below_it_however_far() -> None:
    found = settle("down", box("low", 0, 2, 40), box("high", 200, 0, 50), box("beam", 0, 90, 20, length=300))
    assert heights(found) == [0, 0, 50]
    assert list(moved_lines(found)) == ["2 of 3 boxes were lowered, by at most 40 mm (beam)"]


def test_what_stands_higher_falls_after_what_it_falls_on_in_whatever_order_they_are_listed() -> None:
    assert heights(settle("down", box("top", 0, 70, 10), box("middle", 0, 30, 10), box("low", 0, 3, 10))) == [20, 10, 0]


def test_boxes_that_only_touch_in_plan_do_not_carry_each_other() -> None:
    assert heights(settle("down", box("a", 0, 0, 50), box("b", 100, 60, 50))) == [0, 0]


def test_an_overlap_of_one_unit_of_the_last_digit_carries_nothing_and_is_cut_where_boxes_stand_side_by_side() -> None:
    found = settle("down", box("a", 0, 0, 50), box("b", 99, 5, 50))
    assert heights(found) == [0, 0]
    assert [float(each.size[0] / MM) for each in found.load.boxes] == [100, 99]
    assert found.load.boxes[1].centre[0] == Fraction(299, 2) * MM
    assert "1 of 2 boxes was reduced in length or width, by at most 1 mm (b)" in moved_lines(found)


def test_a_box_one_unit_of_the_last_digit_too_low_is_raised_and_one_that_is_deeper_inside_stays() -> None:
    assert heights(settle("down", box("a", 0, 0, 50), box("b", 0, 49, 50))) == [0, 50]
    assert heights(settle("down", box("a", 0, 0, 50), box("b", 0, 40, 50))) == [0, 40]


def test_within_a_gap_a_beam_on_two_boxes_that_differ_by_less_rests_on_both() -> None:
    found = settle("within 5 mm", box("low", 0, 0, 47), box("high", 200, 0, 50), box("beam", 0, 50, 20, length=300))
    assert [float(each.top / MM) for each in found.load.boxes] == [50, 50, 70]
    assert list(moved_lines(found)) == ["1 of 3 boxes was increased in height, by at most 3 mm (low)"]


def test_within_a_gap_what_differs_by_more_stays_as_it_is() -> None:
    found = settle("within 5 mm", box("low", 0, 0, 44), box("high", 200, 0, 50), box("beam", 0, 50, 20, length=300))
    assert [float(each.top / MM) for each in found.load.boxes] == [44, 50, 70]
    assert heights(settle("within 5 mm", box("a", 0, 0, 50), box("b", 0, 56, 50))) == [0, 56]


def test_what_else_stands_on_a_box_that_is_taken_as_higher_is_raised_with_it() -> None:
    low, high = box("low", 0, 0, 47), box("high", 100, 0, 50)
    found = settle("within 5 mm", low, high, box("beam", 50, 50, 20), box("rider", -60, 47, 10))
    assert heights(found) == [0, 0, 50, 50]
    assert "1 of 4 boxes was raised, by at most 3 mm (rider)" in moved_lines(found)


def test_a_sheet_as_thin_as_the_gap_stays_as_thin_as_it_is() -> None:
    found = settle("within 5 mm", box("sheet", 0, 0, 3), box("beam", 0, 3, 20, length=300))
    assert [float(each.size[2] / MM) for each in found.load.boxes] == [3, 20]
    assert heights(found) == [0, 3]


def test_boxes_that_are_turned_about_the_vertical_carry_by_their_outlines() -> None:
    turned = box("turned", 0, 50, 10, yaw=45)  # reaches 71 mm from its centre along x, and 0 at its corner
    assert heights(settle("down", box("a", 110, 0, 20), turned)) == [0, 20]
    assert heights(settle("down", box("a", 125, 0, 20), turned)) == [0, 0]


def test_masses_are_those_of_the_file_whatever_is_taken_as_higher() -> None:
    found = settle("within 5 mm", box("low", 0, 0, 47), box("high", 200, 0, 50), box("beam", 0, 50, 20, length=300))
    assert {each.mass for each in found.load.boxes} == {1}


def test_a_box_that_leans_cannot_settle() -> None:
    leaning = ImportedBox(
        "a", (MM, MM, MM), (MM, MM, MM), MM, Span("a", 1, 1, 1), (Fraction(5), Fraction(0), Fraction(0))
    )
    assert first_unsettleable(ImportedLoad((leaning,), MM), Settle(lowered=True)) is leaning
    assert first_unsettleable(ImportedLoad((leaning,), MM), Settle()) is None


def test_boxes_in_a_wall_with_a_gap_under_each_layer_come_down_by_all_gaps_below() -> None:
    boxes = [box(f"b{n}", 100 * (n % 10), 11 * (n // 10), 10) for n in range(100)]
    found = settle("within 1 mm", *boxes)
    assert heights(found) == [10 * (n // 10) for n in range(100)]
