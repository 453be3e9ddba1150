"""`stackdsl import`: what it prints is a scenario that says the same as the file, and plays."""

from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.stackdsl.importers.loads import PALLET, PLAN, TABLE

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`


@pytest.mark.parametrize(
    ("text", "options", "bricks"),
    [(TABLE, ("--point", "corner"), 3), (PALLET, (), 3), (PLAN, ("--name", "My Plan"), 3)],
)
def test_the_output_of_import_is_a_scenario_that_plays(
    stackdsl: Stackdsl, tmp_path: Path, text: str, options: tuple[str, ...], bricks: int
) -> None:
    write(tmp_path, text, "load.txt")
    printed = stackdsl("import", "load.txt", *options)
    assert printed.code == ExitCode.OK
    write(tmp_path, printed.out, "scene.yaml")
    done = stackdsl("run", "scene.yaml")
    assert (done.code, f"measured {bricks} bricks stand" in done.out) == (ExitCode.OK, True)


def test_import_lists_moved_and_ignored_parts_at_the_head(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, '"z": 144.0'.join(PALLET.rsplit('"z": 140.0', 1)), "order.json")
    printed = stackdsl("import", "order.json", "--settle", "within 5 mm")
    told = [
        "3 boxes in order.json, written to 1 mm",
        "1 of 3 boxes was lowered, by at most 4 mm (box-3)",
        "left out: orderID, description, shippingGroup, palletType, approach",
    ]
    assert printed.err.splitlines() == told
    assert printed.out.splitlines()[:3] == [f"# {line}" for line in told]


CROWDED = """\
name,length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm]
a,240,400,200,8.4,0,0,0
b,240,400,200,8.4,100,0,0
c,240,400,200,8.4,0,0,500
"""


def test_boxes_inside_one_another_and_in_the_air_are_told_in_their_places_as_check_will(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, CROWDED, "load.csv")
    printed = stackdsl("import", "load.csv", "--point", "corner")
    assert printed.code == ExitCode.OK
    write(tmp_path, printed.out, "scene.yaml")
    refused = [line.partition(" SD")[2] for line in stackdsl("check", "scene.yaml").out.splitlines() if " SD20" in line]
    told = [line for line in printed.err.splitlines() if line.startswith("load.csv:")]
    assert [line.partition(" SD")[2] for line in told] == refused
    assert [line.split()[:2] for line in told] == [["load.csv:3:1:", "SD201"], ["load.csv:4:1:", "SD202"]]
    assert "the scenario has 2 mistakes, so `check` will refuse it" in printed.err
    assert "--settle 'within 5 mm'" in printed.err
    assert "SD202" not in stackdsl("import", "load.csv", "--point", "corner", "--settle", "down").err


def test_a_row_that_is_too_short_hides_no_other_mistake(stackdsl: Stackdsl, tmp_path: Path) -> None:
    lines = CROWDED.replace("c,240,400,200", "c,240,400,high").splitlines()
    lines[2] = lines[2].rpartition(",")[0]
    write(tmp_path, "\n".join(lines), "load.csv")
    told = [line for line in stackdsl("import", "load.csv").err.splitlines() if line.startswith("load.csv")]
    assert [line.partition(" ")[0] for line in told] == ["load.csv:1:65:", "load.csv:3:1:", "load.csv:4:11:"]
    assert "the row has 7 cells" in told[1]
    assert "`height`: 'high' is not a number" in told[2]


def test_headers_that_others_use_are_asked_about(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, CROWDED.replace("name", "ID").replace("mass [kg]", "weight").replace("width", "widht"), "load.csv")
    asked = stackdsl("import", "load.csv", "--point", "corner")
    assert (asked.code, asked.out) == (ExitCode.INVALID, "")
    assert "replace the line of headers by `name,length [mm],width [mm],height [mm],mass,x [mm]," in asked.err
    assert asked.err.endswith("  stackdsl import load.csv --point corner --mass kg\n")


def test_a_file_that_is_wrong_is_told_in_its_place(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TABLE.replace("5200", "5,200"), "load.csv")
    printed = stackdsl("import", "load.csv", "--point", "corner")
    assert (printed.code, printed.out) == (ExitCode.INVALID, "")
    assert printed.err.startswith("load.csv:2:1: SD114 the row has 9 cells, but the header has 8\n")


@pytest.mark.parametrize(
    "options", [("--settle", "sideways"), ("--format", "lorry"), ("--format", "bed-bpp", "--point", "corner")]
)
def test_a_wrong_option_is_a_wrong_usage(stackdsl: Stackdsl, tmp_path: Path, options: tuple[str, ...]) -> None:
    write(tmp_path, TABLE, "load.csv")
    assert stackdsl("import", "load.csv", *options).code == ExitCode.USAGE
    assert stackdsl("import", "nowhere.csv").code == ExitCode.USAGE


def test_import_of_an_unknown_file_asks_for_its_format(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "<lorry/>", "load.xml")
    printed = stackdsl("import", "load.xml")
    assert printed.code == ExitCode.INVALID
    assert "SD115 the format of the file cannot be recognised" in printed.err
