"""`import` in a step: what becomes of it, where mistakes in the file are told, and what is out of bounds."""

import json
from pathlib import Path

import pytest

from stability.contact_law import as_friction
from stackdsl.checking.cases import Case, gather
from stackdsl.diagnostics import Diagnostic
from tests.stackdsl.importers.loads import PALLET, PLAN, TABLE

SCENARIO = "scenario: load\nbuild:\n  - {import: {file: load.csv, point: corner}, every: 1 s}\n"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The root of a project, in which commands are given."""
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "stackdsl.toml").touch()
    monkeypatch.chdir(tmp_path / "inside")
    return tmp_path / "inside"


pytestmark = pytest.mark.usefixtures("project")


def write(name: str, text: str) -> None:
    Path(name).parent.mkdir(exist_ok=True)
    Path(name).write_text(text, encoding="utf-8")


def case(scenario: str = SCENARIO) -> Case:
    write("a.yaml", scenario)
    gathered = gather([Path("a.yaml")])
    assert gathered.diagnostics == ()
    (found,) = gathered.cases
    return found


def mistake(scenario: str = SCENARIO) -> Diagnostic:
    write("a.yaml", scenario)
    (found,) = gather([Path("a.yaml")]).diagnostics
    return found


def importing(**keys: object) -> str:
    return f"scenario: load\nbuild:\n  - import: {json.dumps(keys)}\n"


def test_the_boxes_of_a_table_are_bricks_of_the_step_in_its_order() -> None:
    write("load.csv", TABLE)
    placements = case().timeline.placements
    assert [placed.brick.id for placed in placements] == ["bottom", "by-side", "top"]
    assert [placed.time for placed in placements] == [0.0, 1.0, 2.0]
    assert placements[2].brick.mass == pytest.approx(0.8)
    assert placements[2].pose.position_W == pytest.approx((0.4, 0.15, 0.2525))


def test_an_item_whose_orientation_is_1_lies_with_its_length_along_y() -> None:
    write("plan.json", PLAN)
    sizes = [placed.brick.shape.size for placed in case(importing(file="plan.json")).timeline.placements]  # type: ignore[attr-defined]
    assert sizes == [(0.3, 0.2, 0.1), (0.2, 0.3, 0.1), (0.2, 0.3, 0.1)]


def test_an_anchor_is_the_lower_corner_and_weights_are_those_of_the_article() -> None:
    write("order.json", PALLET)
    placed = case(importing(file="order.json")).timeline.placements
    assert placed[2].pose.position_W == pytest.approx((0.394, 0.1495, 0.195))
    assert [each.brick.mass for each in placed] == [2.6, 2.6, 8.4]


def test_a_step_that_imports_has_the_other_keys_of_any_step() -> None:
    write("load.csv", TABLE)
    scenario = SCENARIO.replace("every: 1 s", "name: left, at: 2 s")
    first = case(scenario).timeline.placements[0]
    assert (first.brick.id, first.time) == ("left.bottom", 2.0)


def test_a_box_in_the_air_is_told_of_its_line_in_the_file_and_of_the_import() -> None:
    write("load.csv", TABLE.replace("0.1,0,0.2\n", "0.1,0,0.3\n"))
    found = mistake()
    assert (found.code, str(found.span)) == ("SD202", "load.csv:4:1")
    assert found.span.where == "imported from a.yaml:3:6"


def test_with_settle_the_same_box_comes_down() -> None:
    write("load.csv", TABLE.replace("0.1,0,0.2\n", "0.1,0,0.3\n"))
    placed = case(SCENARIO.replace("corner}", "corner, settle: down}")).timeline.placements
    assert placed[2].pose.position_W[2] == pytest.approx(0.2525)


def test_a_file_that_another_scenario_brings_in_is_seen_from_there() -> None:
    write("parts/load.csv", TABLE)
    write("parts/_part.yaml", "build:\n  - import: {file: load.csv, point: corner}\n")
    assert len(case("scenario: load\nbuild:\n  - include: parts/_part.yaml\n").timeline.placements) == 3


@pytest.mark.parametrize("file", ["../load.csv", "/etc/passwd", "~/load.csv", "link.csv", "nowhere.csv"])
def test_a_file_outside_of_the_project_is_not_read(file: str) -> None:
    write("../load.csv", TABLE)
    Path("link.csv").symlink_to("../load.csv")
    found = mistake(importing(file=file, point="corner"))
    assert (found.code, found.span.file) == ("SD113", "a.yaml")


OPEN: dict[str, tuple[str, dict[str, object], str]] = {
    "a header without a unit": (TABLE.replace(" [g]", ""), {}, "the column 'mass' has no unit"),
    "an unknown unit": (TABLE.replace("[g]", "[st]"), {}, "'st' is not a known unit of mass"),
    "an unknown column": (TABLE.replace("name", "colour"), {}, "'colour' is not supported"),
    "a missing column": (
        TABLE.replace("width", "colour"),
        {"ignore": ["colour [mm]"]},
        "the table has no column `width`",
    ),
    "the meaning of a place": (
        TABLE,
        {"point": None},
        "the table does not state whether x, y, z are the lower corner or the centre of a box",
    ),
    "what to ignore": (TABLE, {"ignore": ["colour"]}, "`ignore` lists 'colour', but the file does not contain it"),
}


@pytest.mark.parametrize("what", OPEN)
def test_missing_keys_of_an_import_are_required(what: str) -> None:
    text, keys, message = OPEN[what]
    write("load.csv", text)
    written = {key: value for key, value in ({"file": "load.csv", "point": "corner"} | keys).items() if value}
    found = mistake(importing(**written))
    assert (found.code, found.message) == ("SD115", message)
    assert found.span.file == "load.csv"
    assert found.hint


def test_units_may_be_said_beside_the_file() -> None:
    write("load.csv", TABLE.replace(" [g]", "").replace(" [m]", ""))
    scenario = importing(file="load.csv", point="corner", units={"length": "m", "mass": "g"})
    assert case(scenario).timeline.placements[0].brick.mass == pytest.approx(5.2)


def test_of_several_pallets_or_orders_one_must_be_named() -> None:
    order = json.loads(PALLET)
    order["pallets"].append({**order["pallets"][0], "palletNr": "002", "boxes": order["pallets"][0]["boxes"][:1]})
    write("order.json", json.dumps(order))
    found = mistake(importing(file="order.json"))
    assert (found.code, found.message) == ("SD115", "the file contains 2 pallets: '001', '002'")
    assert len(case(importing(file="order.json", load="002")).timeline.placements) == 1
    assert mistake(importing(file="order.json", load="003")).hint == "choose from: '001', '002'"


def test_a_corner_of_a_box_that_is_turned_is_asked_for() -> None:
    write("load.csv", "length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm],yaw [deg]\n9,9,9,1,0,0,0,45\n")
    assert mistake().message == "the lower corner of a rotated box is ambiguous"
    write(
        "load.csv", "length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm],yaw [deg]\n9,9,9,1,0,0,4.5,45\n"
    )
    assert len(case(SCENARIO.replace("corner", "centre")).timeline.placements) == 1


def test_a_key_that_is_written_twice_is_told_at_the_second() -> None:
    write("order.json", PALLET.replace('"orderID": "1"', '"orderID": "1",\n "orderID": "2"'))
    found = mistake(importing(file="order.json"))
    assert (found.code, found.message) == ("SD114", "the object contains the key 'orderID' twice")
    assert found.span.line == 3


@pytest.mark.parametrize("header", ["{} [{}]", "{}({})", "{}/{}", "{}_{}", "{} {}"])
def test_a_header_says_its_unit_in_any_usual_way(header: str) -> None:
    units = {"length": "mm", "width": "mm", "height": "mm", "mass": "kg", "x": "m", "y": "m", "z": "m"}
    names = [header.format(name, unit) for name, unit in units.items()]
    write("load.csv", ",".join(names) + "\n400,300,200,5.2,0,0,0\n")
    assert case().timeline.placements[0].pose.position_W == pytest.approx((0.2, 0.15, 0.1))


def test_a_table_may_be_a_list_of_objects() -> None:
    row = {"length/mm": 400, "width/mm": 300, "height/mm": 200, "mass/kg": 5.2, "x_m": 0, "y_m": 0, "z_m": 0}
    write("load.csv", json.dumps([row]))
    assert case().timeline.placements[0].pose.position_W == pytest.approx((0.2, 0.15, 0.1))


WRONG = {
    "format: lorry": ("SD104", "a.yaml"),
    "settle: sideways": ("SD104", "a.yaml"),
    "settle: within 5": ("SD105", "a.yaml"),
    "colour: red": ("SD101", "a.yaml"),
    "format: pallet-sim": ("SD108", "a.yaml"),
}


@pytest.mark.parametrize("key", WRONG)
def test_a_mistake_in_how_it_is_asked_for_is_told_there(key: str) -> None:
    write("load.csv", TABLE)
    found = mistake(f"scenario: load\nbuild:\n  - import: {{file: load.csv, point: corner, {key}}}\n")
    assert (found.code, found.span.file) == WRONG[key]


def test_a_step_imports_or_has_bricks_of_its_own() -> None:
    write("load.csv", TABLE)
    assert mistake(SCENARIO.replace("every: 1 s", "bricks: []")).code == "SD108"


def test_a_changed_file_is_imported_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from stackdsl.checking.cache import ResultCache  # noqa: PLC0415 -- as the test below it
    from stackdsl.checking.cases import survey  # noqa: PLC0415

    write("load.csv", TABLE)
    write("a.yaml", SCENARIO)
    memory = ResultCache(Path("cache"))
    first = survey([Path("a.yaml")], memory).digests
    assert survey([Path("a.yaml")], memory).digests == first
    write("load.csv", TABLE.replace("5200", "5300"))
    assert survey([Path("a.yaml")], memory).digests != first


RUBBING = "name,length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm],friction\n"


def test_a_box_of_a_table_may_have_a_friction_of_its_own_and_a_cell_may_be_empty() -> None:
    write("load.csv", RUBBING + "low,300,200,100,5,0,0,0,\nfoil,300,200,2,0.1,0,0,100,0.15\nmat,9,9,9,1,9,9,102,0.7\n")
    law = as_friction(case().timeline.world.friction)
    assert [law.of("low", "foil"), law.of("foil", "mat"), law.of("low", "mat")] == [0.15, 0.15, 0.5]


@pytest.mark.parametrize(
    ("text", "code", "message"),
    [
        (RUBBING + "low,300,200,100,5,0,0,0,-0.1\n", "SD114", "`friction`: '-0.1' is not a friction coefficient"),
        (RUBBING + "low,300,200,100,5,0,0,0,rough\n", "SD114", "`friction`: 'rough' is not a friction coefficient"),
        (
            RUBBING.replace("friction", "friction [%]") + "low,300,200,100,5,0,0,0,5\n",
            "SD115",
            "a friction coefficient has no unit, but this column has the unit '%'",
        ),
        (RUBBING.replace("friction", "mu") + "low,300,200,100,5,0,0,0,0.5\n", "SD115", "'mu' is not supported"),
    ],
)
def test_a_friction_that_means_nothing_is_told_in_the_table(text: str, code: str, message: str) -> None:
    write("load.csv", text)
    found = mistake()
    assert (found.code, found.message) == (code, message)
