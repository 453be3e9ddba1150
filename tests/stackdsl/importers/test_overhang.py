"""A carton that reaches beyond the deck of its pallet is warned of: how far, to which side, and what to do."""

import json
from pathlib import Path
from typing import Any

import pytest

from stackdsl.importers.formats import read_load
from stackdsl.importers.overhang import overhang_warnings, overhangs
from stackdsl.language.imports import Import
from tests.command_line import Stackdsl, write

HEAD = "name,length_mm,width_mm,height_mm,mass_kg,x_mm,y_mm,z_mm"
ASKED = {"file": "a.csv", "format": "table", "point": "corner"}


def order(x: float = 0.0, deck: object = None) -> str:
    """An order of one box of 400 x 300 mm on a pallet of 800 x 1200 mm."""
    box = {
        "product_code": "0",
        "anchor": {"x": x, "y": 0.0, "z": 0.0},
        "dimension": {"x": 400.0, "y": 300.0, "z": 200.0},
    }
    pallet = {"palletNr": "1", "palletDimension": deck or {"x": 800.0, "y": 1200.0}, "boxes": [box]}
    return json.dumps({"pallets": [pallet], "articles": {"0": {"weight": 9000.0}}})


def told(text: str, **asked: Any) -> list[str]:  # noqa: ANN401 -- as in YAML
    whole = Import.model_validate({"file": "a.json", **asked})
    return [str(each) for each in overhang_warnings(read_load(text.encode(), "a.json", whole), whole)]


def sides(rows: str, deck: object, **asked: Any) -> list[tuple[str | None, str, float]]:  # noqa: ANN401 -- as in YAML
    whole = Import.model_validate({**ASKED, "deck": deck, **asked})
    load = read_load(f"{HEAD}\n{rows}".encode(), "a.csv", whole)
    return [(each.box.name, each.side, float(1000 * each.amount)) for each in overhangs(load, whole)]


def test_the_deck_that_an_order_says_it_has_is_asked_of() -> None:
    assert told(order(400.0)) == []
    (warning,) = told(order(490.0))
    assert "'box-1' overhangs the deck of 800 x 1200 mm by 90 mm towards +x" in warning
    assert warning.endswith("move 'box-1' 90 mm towards -x, or permit the overhang: `deck: {overhang: 90 mm}`")
    assert warning.startswith("a.json:1:")


def test_as_much_as_is_allowed_is_not_told_and_a_millimetre_more_is() -> None:
    assert told(order(490.0), deck={"overhang": "90 mm"}) == []
    assert told(order(492.0), deck={"overhang": "90 mm"}) != []
    assert told(order(401.0)) == []  # the last digit of the file is a millimetre


def test_the_deck_of_the_scenario_overrides_that_of_the_file() -> None:
    assert told(order(490.0), deck="EUR") == []
    assert "the deck of 390 x 800 mm by 100 mm towards +x" in told(order(90.0), deck={"size": ["390 mm", "0.8 m"]})[0]


@pytest.mark.parametrize(
    ("x", "y", "side", "amount"),
    [(-30, 0, "-x", 30.0), (830, 0, "+x", 30.0), (0, -20, "-y", 20.0), (0, 530, "+y", 30.0), (2000, 0, "+x", 1200.0)],
)
def test_an_overhang_names_its_side(x: float, y: float, side: str, amount: float) -> None:
    assert sides(f"c,400,300,200,5,{x},{y},0", "EUR") == [("c", side, amount)]


def test_a_box_over_a_corner_is_told_with_both_sides() -> None:
    (warning,) = told_of_rows("c,400,300,200,5,830,540,0")
    assert "by 40 mm towards +y and 30 mm towards +x;" in warning
    assert (
        "; move 'c' 30 mm towards -x and 40 mm towards -y, or permit the overhang: `deck: {overhang: 40 mm}`" in warning
    )


def told_of_rows(rows: str, **asked: Any) -> list[str]:  # noqa: ANN401 -- as in YAML
    whole = Import.model_validate({**ASKED, "deck": "EUR", **asked})
    return [str(each) for each in overhang_warnings(read_load(f"{HEAD}\n{rows}".encode(), "a.csv", whole), whole)]


ROW_AT_THE_EDGE = "a,300,400,200,5,300,0,0\nb,300,400,200,5,850,0,0\nc,300,400,200,5,1000,0,0"


def test_the_error_of_an_overlap_and_the_warning_of_an_overhang_ask_for_the_same_moves(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    #   c is 150 mm inside b: 150 mm towards +x would part them, and push c further over the edge.
    moves = "move 'b' 250 mm towards -x; move 'c' 100 mm towards -x"
    write(tmp_path, f"{HEAD}\n{ROW_AT_THE_EDGE}\n", "a.csv")
    write(tmp_path, "scenario: s\nbuild:\n  - import: {file: a.csv, point: corner, deck: EUR}\n", "a.yaml")
    (warning,) = told_of_rows(ROW_AT_THE_EDGE)
    assert f"; {moves}, or permit" in warning
    checked, imported = stackdsl("check", "a.yaml"), stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR")
    for told_there in (checked.out + checked.err, imported.err):
        assert "SD201 brick 'c' is 150 mm inside brick 'b'" in told_there
        assert f"or {moves}\n" in told_there
    assert f"; {moves}, or permit the overhang: --overhang '100 mm'" in imported.err


def test_the_moves_of_a_row_mend_both(stackdsl: Stackdsl, tmp_path: Path) -> None:
    mended = ROW_AT_THE_EDGE.replace("b,300,400,200,5,850", "b,300,400,200,5,600").replace("1000,0,0", "900,0,0")
    assert told_of_rows(mended) == []
    write(tmp_path, f"{HEAD}\n{mended}\n", "a.csv")
    told = stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR", "--friction", "0.4").err
    assert [line.partition(" ")[0] for line in told.splitlines()] == ["3", "deck"]  # no warning


def test_a_row_that_is_longer_than_the_deck_has_no_room() -> None:
    rows = "\n".join(f"{name},300,800,200,5,{x},0,0" for name, x in zip("abcde", (0, 300, 600, 900, 1100), strict=True))
    (warning,) = told_of_rows(rows)
    assert "; there is no room for it on the deck beside the other boxes of its layer: take a box out of" in warning
    (warning,) = told_of_rows("a,1300,800,200,5,0,0,0")
    assert "; turn it, or give the right `deck`, since it is larger than the deck, or" in warning


def test_a_box_that_the_ground_beside_the_deck_carries_is_told_with_the_remedy() -> None:
    (warning,) = told_of_rows("a,300,400,200,5,0,0,0\nb,300,400,200,5,1000,0,0")
    assert "the verdict counts on ground beside the deck below b; to judge the real deck, build it" in warning


def test_a_second_pallet_in_a_table_is_no_overhang_to_push_back() -> None:
    (warning,) = told_of_rows("a,300,400,200,5,0,0,0\nb,300,400,200,5,2000,0,0")
    assert "'b' lies beside the deck of 1200 x 800 mm, and reaches 1100 mm towards +x beyond it" in warning
    assert "; import each pallet of a table by itself; if" in warning
    assert "move" not in warning


def test_a_row_that_is_there_twice_is_to_be_deleted(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{HEAD}\na,300,400,200,5,0,0,0\nb,300,400,200,5,0,0,0\n", "a.csv")
    told_of = stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR").err
    assert "brick 'b' is 200 mm inside brick 'a', at the same place" in told_of
    assert (
        "= check the place of 'b' in line 3; or move 'b' 300 mm towards +x; or delete one of them if it is" in told_of
    )
    write(tmp_path, f"{HEAD}\na,300,400,200,5,0,0,0\nb,300,400,200,6,0,0,0\n", "a.csv")
    assert "delete" not in stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR").err  # another mass


def test_a_mistyped_place_comes_before_moves_of_others_with_the_only_free_place(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    rows = [f"c{n},400,400,200,5,{400 * (n % 3)},{400 * (n // 3)},0" for n in range(6)]
    rows[4] = rows[4].replace("5,400,400", "5,40,400")
    write(tmp_path, "\n".join([HEAD, *rows, ""]), "a.csv")
    told_of = stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR").err
    free = "the only free place of its size in this layer is 360 mm towards +x"
    assert f"= check the place of 'c4' in line 6: {free}; or move" in told_of


def test_a_box_that_is_too_low_still_goes_up(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{HEAD}\na,300,400,200,5,0,0,0\nb,300,400,200,5,0,0,195\n", "a.csv")
    assert (
        "= move it by at least 5 mm towards +z" in stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR").err
    )


def test_cartons_further_up_count_as_well_and_the_worst_is_told() -> None:
    rows = "low,400,300,200,5,0,0,0\nhigh,400,300,200,5,-50,0,200\nhigher,400,300,200,5,-80,0,400"
    assert [each[0] for each in sides(rows, "EUR")] == ["high", "higher"]
    asked = Import.model_validate({**ASKED, "deck": "EUR"})
    (warning,) = overhang_warnings(read_load(f"{HEAD}\n{rows}".encode(), "a.csv", asked), asked)
    assert "'higher' overhangs" in warning.message
    assert (
        "and high by at most this amount; every overhanging box lies on other boxes, so the verdict is that of"
        in warning.message
    )
    assert warning.span.line == 4


def test_a_carton_that_is_turned_reaches_with_its_corner() -> None:
    #   400 x 300 mm by 30 deg: 200 cos 30 + 150 sin 30 = 248.2 mm to either side of its middle along x.
    rows = "c,400,300,200,5,240,300,0,30"
    asked = Import.model_validate({**ASKED, "point": "centre", "deck": "EUR"})
    (found,) = overhangs(read_load(f"{HEAD},yaw_deg\n{rows}".encode(), "a.csv", asked), asked)
    assert found.side == "-x"
    assert float(found.amount) == pytest.approx(0.0082051, abs=1e-6)


def test_the_deck_goes_with_the_load_that_is_shifted() -> None:
    assert sides("c,400,300,200,5,0,0,0", "EUR", origin=["-5 m", "0 mm", "0 mm"]) == []
    assert told(order(490.0), origin=["5 m", "1 m", "0 mm"]) != []
    assert told(order(400.0), origin=["5 m", "1 m", "0 mm"]) == []


def test_a_load_without_a_deck_has_no_overhang() -> None:
    asked = Import.model_validate(ASKED)
    assert overhangs(read_load(f"{HEAD}\nc,400,300,200,5,9000,0,0".encode(), "a.csv", asked), asked) == []


@pytest.mark.parametrize("deck", [{"x": 800.0}, {"x": 0.0, "y": 1.0}, {"x": "800", "y": 1.0}, [800.0, 1200.0]])
def test_a_deck_that_is_none_is_a_mistake_of_the_file(deck: object, stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, order(0.0, deck), "a.json")
    refused = stackdsl("import", "a.json")
    assert (refused.code, "SD114" in refused.err, "`palletDimension`" in refused.err) == (2, True, True)


@pytest.mark.parametrize("size", ["EUR9", ["1 m"], ["0 mm", "1 m"], ["1 kg", "1 m"], [1.2, 0.8], ["101 m", "1 m"]])
def test_a_size_that_is_none_is_refused_with_what_to_write(size: object) -> None:
    with pytest.raises(ValueError, match=r"deck|kg"):
        Import.model_validate({**ASKED, "deck": {"size": size}})


def test_check_run_and_import_warn_of_it_and_fail_nothing(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, order(490.0), "a.json")
    imported = "scenario: {name}\nbuild:\n  - import: {{file: a.json}}\nexpect:\n  - stands: all\n"
    write(tmp_path, "---\n".join(imported.format(name=name) for name in ("one", "two")), "a.yaml")
    checked = stackdsl("check", "a.yaml", "--strict", "--no-golden", "--format", "text", "--format", "json=a.report")
    assert checked.code == 0
    assert checked.out.count("a.json:1:") == 1  # of both scenarios
    assert "box-1' overhangs the deck of 800 x 1200 mm by 90 mm towards +x" in checked.out
    results = json.loads((tmp_path / "a.report").read_text())["results"]
    assert [len(each["warnings"]) for each in results] == [1, 1]
    assert "::warning file=a.json,line=1," in stackdsl("check", "a.yaml", "--no-golden", "--format", "github").out
    assert "warning: a.json:1:" in stackdsl("run", "a.yaml", "-k", "one").out
    for deck, count in ((), 1), (("--deck", "EUR"), 0), (("--overhang", "90 mm"), 0), (("--deck", "1 m x 0.2 m"), 1):
        told_of = stackdsl("import", "a.json", *deck)
        assert (told_of.err.count("overhangs"), told_of.out.count("# warning: ")) == (count, count)
