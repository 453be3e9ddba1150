"""A load lies on the real deck of its pallet, and settles on it and on all that earlier steps place."""

import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.model import GROUND, Plane
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl import Case, ScenarioError, load, loads
from stackdsl.diagnostics import Span
from stackdsl.importers.built_deck import on_deck
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedBox, ImportedLoad
from stackdsl.importers.settling import settled
from stackdsl.judging.proofs import proofs_of
from stackdsl.language.imports import Import, parse_settle
from tests.command_line import Stackdsl, write

HEAD = "name,length_mm,width_mm,height_mm,mass_kg,x_mm,y_mm,z_mm"
MM = Fraction(1, 1000)
GAP = (800 - 3 * 145 - 2 * 100) / 4  # [mm] between the boards of an EUR pallet


def read(rows: str, **asked: Any) -> tuple[ImportedLoad, Import]:  # noqa: ANN401 -- as in YAML
    options = Import.model_validate({"file": "a.csv", "format": "table", "point": "corner", **asked})
    return read_load(f"{HEAD}\n{rows}".encode(), "a.csv", options), options


def box(x: int, bottom: int, height: int, length: int = 100) -> ImportedBox:
    size = (length * MM, 100 * MM, height * MM)
    return ImportedBox(None, size, (x * MM, Fraction(0), (bottom + Fraction(height, 2)) * MM), Fraction(1), SPAN)


SPAN = Span("a", 1, 1, 1)


def bottoms(settle: str, *boxes: ImportedBox, on: tuple[ImportedBox, ...]) -> list[float]:
    found = settled(ImportedLoad(boxes, MM), parse_settle(settle), supports=on)
    return [float(each.bottom / MM) for each in found.load.boxes]


def test_boxes_above_a_deck_come_down_on_it_and_those_beside_it_on_the_ground() -> None:
    deck = box(0, 0, 144, length=1200)
    assert bottoms("down", box(0, 147, 50), box(0, 199, 50), box(900, 147, 50), on=(deck,)) == [144, 194, 0]


def test_what_lies_on_a_mat_and_beside_it_keeps_the_height_of_each() -> None:
    mat = box(0, 0, 3)
    assert bottoms("within 5 mm", box(0, 4, 50), box(200, 1, 50), on=(mat,)) == [3, 0]
    # One of a pair of mats ends lower, and does not grow.
    mats = (box(0, 0, 3), box(200, 0, 5))
    assert bottoms("within 5 mm", box(100, 5, 50, length=300), box(-40, 3, 50, length=20), on=mats) == [5, 3]


@given(
    st.lists(st.tuples(st.integers(-3, 3), st.integers(0, 250), st.sampled_from([20, 47, 50])), max_size=8),
    st.sampled_from(["down", "within 5 mm"]),
)
def test_a_load_settles_on_a_wide_deck_as_on_the_ground(rows: list[tuple[int, int, int]], settle: str) -> None:
    boxes = [box(60 * x, z, height) for x, z, height in rows]
    raised = [box(60 * x, z + 144, height) for x, z, height in rows]
    deck = box(0, 0, 144, length=3000)
    found = settled(ImportedLoad(tuple(boxes), MM), parse_settle(settle)).load
    on_ground = [float(each.bottom / MM) for each in found.boxes]
    assert bottoms(settle, *raised, on=(deck,)) == [height + 144 for height in on_ground]


def built(folder: Path, rows: str, steps: str, more: str = "") -> Case:
    """The case of a scenario whose steps import `a.csv` with these rows."""
    (folder / "a.csv").write_text(f"{HEAD}\n{rows}\n", "utf-8")
    text = f"scenario: s\nfriction: 0.4\n{more}build:\n{steps}\nexpect:\n  - stands: all\n"
    (folder / "s.yaml").write_text(text, "utf-8")
    return next(iter(load(folder / "s.yaml")))


def moving(case: Case) -> set[str]:
    """The bricks that begin to fall if all are placed at once on the ground; by statics alone."""
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.4)
    placed = [Placed(each.brick, each.pose) for each in case.timeline.placements]
    verdict = Assembly((ground,), friction=0.4).add_all(placed)
    assert verdict.stability is not Stability.UNDECIDED
    return set(verdict.moving)


FALLING = "a,600,400,300,12,0,0,3\nb,600,400,300,12,920,0,2"  # the centre of b is 20 mm beyond the edge of the deck


@pytest.mark.parametrize("settle", ["down", "within 5 mm"])
@pytest.mark.parametrize(
    "steps",
    [
        "  - import: {file: a.csv, point: corner, settle: SETTLE, deck: {size: EUR, surface: closed}}",
        "  - import: {file: a.csv, point: corner, settle: SETTLE, deck: {size: EUR, surface: boards}}",
        "  - bricks: [{name: deck, at: [600 mm, 400 mm, 72 mm], brick: {pallet: EUR, mass: 25 kg}}]\n"
        "  - import: {file: a.csv, point: corner, settle: SETTLE, origin: [0 mm, 0 mm, 144 mm]}",
        "  - bricks: [{name: deck, at: [600 mm, 400 mm, 72 mm], rotate: [0 deg, 0 deg, 90 deg],"
        " brick: {size: [800 mm, 1200 mm, 144 mm], centre_of_mass: [10 mm, 0 mm, 20 mm], mass: 25 kg}}]\n"
        "  - import: {file: a.csv, point: corner, settle: SETTLE, origin: [0 mm, 0 mm, 144 mm]}",
    ],
)
def test_the_first_layer_lies_on_the_pallet_and_tips_over_its_edge(steps: str, settle: str, tmp_path: Path) -> None:
    steps = steps.replace("SETTLE", settle)
    case = built(tmp_path, FALLING, steps)
    tops = [each.pose.position_W[2] - 0.15 for each in case.timeline.placements if each.brick.id != "deck"]
    assert tops == pytest.approx([0.144, 0.144], abs=1e-9)
    assert moving(case) == {"b"}
    assert moving(built(tmp_path, FALLING.replace(",920,", ",880,"), steps)) == set()


@pytest.mark.parametrize(("inside", "falls"), [(1, set()), (-1, {"c"})])
def test_a_carton_over_a_gap_between_boards_stands_while_its_centre_is_over_a_board(
    inside: float, falls: set[str], tmp_path: Path
) -> None:
    #   The second board begins at 145 mm and a gap; the carton of 60 mm does not reach the first.
    rows = f"c,300,60,50,5,400,{145 + GAP + inside - 30},0"
    for surface, expected in (
        ("boards", falls),
        ("[145 mm, 100 mm, 145 mm, 100 mm, 145 mm]", falls),
        ("closed", set()),
    ):
        steps = f"  - import: {{file: a.csv, point: corner, deck: {{size: EUR, surface: {surface}}}}}"
        assert moving(built(tmp_path, rows, steps)) == expected


def test_a_load_whose_heights_count_from_the_floor_is_not_raised_again() -> None:
    raised, _ = on_deck(*read("a,600,400,300,12,0,0,144", deck={"size": "EUR", "surface": "closed", "level": "144 mm"}))
    assert raised.boxes[0].bottom == 144 * MM
    on_ground, none = on_deck(*read("a,600,400,300,12,0,0,144", deck={"size": "EUR", "level": "144 mm"}))
    assert on_ground.boxes[0].bottom == 0
    assert none is None


def test_a_load_that_hangs_as_high_as_its_pallet_is_warned_of(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, f"{HEAD}\na,600,400,300,12,0,0,144\n", "a.csv")
    told = stackdsl("import", "a.csv", "--point", "corner", "--deck", "EUR", "--surface", "closed").err
    assert "z of the lowest box is 144 mm, the height of the pallet; if z counts from the floor" in told
    assert "--level '144 mm'" in told
    asked = ("--point", "corner", "--deck", "EUR", "--surface", "closed", "--level", "144 mm")
    assert "warning" not in stackdsl("import", "a.csv", *asked).err


def test_a_usual_pallet_weighs_in_proportion_to_its_area() -> None:
    rows = "a,600,400,300,12,0,0,0"
    for size, mass in (("EUR", "25 kg"), ("ISO-1200x1000", "31.25 kg"), ("EUR6", "12.5 kg")):
        _, deck = on_deck(*read(rows, deck={"size": size, "surface": "closed"}))
        assert deck is not None
        assert deck.written["brick"]["mass"] == mass  # type: ignore[index, call-overload]
    _, deck = on_deck(*read(rows, deck={"size": "EUR", "surface": "closed", "mass": "22 kg"}))
    assert deck is not None
    assert deck.written["brick"]["mass"] == "22 kg"  # type: ignore[index, call-overload]


def test_what_the_command_prints_is_what_the_scenario_builds(stackdsl: Stackdsl, tmp_path: Path) -> None:
    steps = "  - import: {file: a.csv, point: corner, settle: down, deck: {size: EUR, surface: boards}}\n    every: 1 s"
    case = built(tmp_path, FALLING, steps)
    asked = ("--point", "corner", "--settle", "down", "--deck", "EUR", "--surface", "boards", "--friction", "0.4")
    (printed,) = loads(stackdsl("import", "a.csv", *asked, "--name", "s").out)
    assert printed.timeline == case.timeline


@pytest.mark.parametrize(
    ("deck", "message"),
    [
        ("{size: EUR2, surface: boards}", "`surface: boards` is that of an EUR pallet"),
        ("{surface: closed}", "the size of the deck is missing, and the file gives none"),
        ("{size: EUR, height: 150 mm}", "`height` applies only to a deck that is built"),
        (
            "{size: EUR, surface: [500 mm, 500 mm]}",
            "the boards are 1000 mm wide in total, wider than the deck of 800 mm",
        ),
        ("{size: EUR, surface: [500 mm]}", "a deck has 2 to 50 boards, not 1"),
        ("{size: EUR, surface: [0 mm, 5 mm]}", "a board must be wider than zero"),
        ("{size: EUR, surface: wood}", "'wood' is not the surface of a deck"),
        ("{size: [200 mm, 800 mm], surface: [90 mm, 90 mm]}", "a length of 200 mm has no room for 3 bearers"),
        ("{size: EUR, surface: boards, height: 20 mm}", "a height of 20 mm leaves nothing below boards of 22 mm"),
    ],
)
def test_a_deck_that_cannot_be_built_is_refused_with_the_reason(deck: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=re.escape(message)):
        built(tmp_path, "a,100,100,100,1,0,0,0", f"  - import: {{file: a.csv, point: corner, deck: {deck}}}")


def test_a_load_settles_on_layouts_and_on_earlier_loads(tmp_path: Path) -> None:
    first = "  - column: {levels: 3}\n    brick: {size: [600 mm, 400 mm, 100 mm], mass: 5 kg}\n"
    load = "  - import: {file: a.csv, point: centre, settle: down}\n"
    again = "  - name: upper\n    import: {file: a.csv, point: centre, settle: down, origin: [0 mm, 0 mm, 400 mm]}"
    case = built(tmp_path, "a,300,200,100,3,0,0,500", first + load + again)
    middles = [each.pose.position_W[2] for each in case.timeline.placements]
    assert middles == pytest.approx([0.05, 0.15, 0.25, 0.35, 0.45], abs=1e-9)


SETTLED = "  - import: {file: a.csv, point: corner, settle: down}"


def test_a_load_does_not_settle_over_what_is_no_box(tmp_path: Path) -> None:
    log = "{name: log, at: [300 mm, 200 mm, 100 mm], brick: {cylinder: {diameter: 200 mm, height: 200 mm}, mass: 9 kg}}"
    with pytest.raises(ScenarioError, match="'a' lies over 'log', which is none"):
        built(tmp_path, "a,600,400,300,12,0,0,202", f"  - bricks: [{log}]\n{SETTLED}")


def test_a_load_does_not_settle_on_bricks_whose_place_depends_on_the_variant(tmp_path: Path) -> None:
    low = "{name: d, at: [0 mm, 0 mm, '${h} mm'], brick: {size: [1 m, 1 m, 100 mm], mass: 9 kg}}"
    with pytest.raises(ScenarioError, match="whose places depend on the variant"):
        built(tmp_path, "a,600,400,300,12,0,0,202", f"  - bricks: [{low}]\n{SETTLED}", "matrix: {h: [50, 60]}\n")


def test_a_pallet_is_a_kind_of_brick() -> None:
    text = (
        "scenario: s\nbuild:\n  - column: {levels: 2}\n    brick: {pallet: {size: EUR, surface: boards}, mass: 25 kg}\n"
    )
    (case,) = loads(text)
    assert [round(each.pose.position_W[2], 4) for each in case.timeline.placements] == pytest.approx(
        [0.0872, 0.2312], abs=1e-4
    )


@pytest.mark.parametrize(("stack", "stability"), [("21 kg", "stable"), ("19 kg", "unstable")])
def test_imported_cartons_have_the_strength_of_the_import_and_the_deck_has_none(
    stack: str, stability: str, tmp_path: Path
) -> None:
    rows = "a,600,400,300,12,0,0,0\nb,600,400,300,12,0,0,300\nc,600,400,300,8,0,0,600"  # 20 kg lie on a
    steps = f"  - import: {{file: a.csv, point: corner, deck: {{size: EUR}}, strength: {{stack: {stack}}}}}"
    steps = steps.replace("size: EUR", "size: EUR, surface: closed")
    verdict = proofs_of(built(tmp_path, rows, steps).timeline).verdict
    assert verdict.stability.value == stability
    assert (verdict.crushing is not None and verdict.crushing.brick) == (stability == "unstable" and "a")
