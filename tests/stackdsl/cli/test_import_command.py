"""`stackdsl import`: what it prints is a scenario that says the same as the file, and plays."""

import shlex
from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, ended, stackdsl_in_folder, write
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
        "friction between boxes assumed: 0.5; measure it, and set --friction",
        "deck from [0 mm, 0 mm] to [800 mm, 1200 mm], not built: the ground continues around it; "
        "--surface closed builds it",
    ]
    assert printed.err.splitlines() == told
    assert printed.out.splitlines()[:5] == [f"# {line}" for line in told]


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
    assert "= write --map name=ID --map 'width=widht [mm]'" in asked.err
    assert asked.err.endswith("load.csv --point corner --map name=ID --map 'width=widht [mm]' --mass kg\n")


@pytest.mark.parametrize("header", ["Weight", "Gewicht", "gross weight", "Gross weight [kg]"])
def test_a_column_of_weights_gives_the_masses_and_the_proposed_command_works(
    stackdsl: Stackdsl, tmp_path: Path, header: str
) -> None:
    write(tmp_path, f"Name,Length,Width,Height,{header},X,Y,Z\nA1,400,300,200,9,0,0,0\n", "load.csv")
    asked = stackdsl("import", "load.csv").err
    assert "`mass`" not in asked
    assert "'mass'" not in asked
    printed = stackdsl(*shlex.split(asked.splitlines()[-1])[1:])
    assert (printed.code, "mass: 9 kg" in printed.out) == (ExitCode.OK, True)


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


# A German Excel export: byte order mark, semicolons, decimal commas, an empty line and a row of totals.
EXCEL = """\ufeffKarton-Nr.;Länge (cm);Breite (cm);Höhe (cm);Gewicht (kg);X (cm);Y (cm);Z (cm);Bemerkung
4711;60;40;30,5;12,5;0;0;0;
4712;60;40;30,5;12,5;0;0;30,5;

;;;;25,0;;;;Summe
"""


def test_a_german_table_has_all_its_questions_asked_at_once(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, EXCEL, "load.csv")
    asked = stackdsl("import", "load.csv")
    assert asked.code == ExitCode.INVALID
    columns = "--map name=Karton-Nr. --map 'length=Länge (cm)' --map 'width=Breite (cm)' --map 'height=Höhe (cm)'"
    assert f"write {columns};" in asked.err
    assert "z of the lowest boxes is 0, so write --point corner" in asked.err
    assert "load.csv:5:1: SD114 the row has no size and no position, as in a row of totals ('Summe')" in asked.err
    lines = EXCEL.splitlines()
    write(tmp_path, "\n".join(lines[:-1]), "load.csv")
    printed = stackdsl(*shlex.split(asked.err.splitlines()[-1])[1:])
    assert printed.code == ExitCode.OK
    assert "at: [300 mm, 200 mm, 457.5 mm], brick: {size: [600 mm, 400 mm, 305 mm], mass: 12.5 kg}" in printed.out


def test_an_export_in_windows_1252_with_a_row_of_totals_is_read_as_it_is(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "load.csv").write_bytes(EXCEL.removeprefix("\ufeff").encode("windows-1252"))
    refused = stackdsl("import", "load.csv")
    assert refused.code == ExitCode.INVALID
    assert "load.csv:1:13: SD002 the byte 0xe4 is not UTF-8" in refused.err
    assert "or write --encoding windows-1252" in refused.err
    options = ["--encoding", "windows-1252"]
    asked = stackdsl("import", "load.csv", *options)
    assert "or write --ignore totals" in asked.err
    asked = stackdsl("import", "load.csv", *options, "--ignore", "totals")
    printed = stackdsl(*shlex.split(asked.err.splitlines()[-1])[1:])
    assert printed.code == ExitCode.OK
    assert printed.out.count("mass: 12.5 kg") == 2
    (tmp_path / "load.csv").write_bytes(b"\x81")
    assert "the byte 0x81 is not windows-1252" in stackdsl("import", "load.csv", *options).err


def test_a_table_in_inches_may_give_units_in_a_row(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "name,length,width,height,mass,x,y,z\n,in,in,in,lb,in,in,in\na,20,15,12,10,10,7.5,6\n", "load.csv")
    asked = stackdsl("import", "load.csv")
    assert "z of the lowest boxes is half their height, so write --point centre" in asked.err
    printed = stackdsl(*shlex.split(asked.err.splitlines()[-1])[1:])
    assert "at: [254 mm, 190.5 mm, 152.4 mm], brick: {size: [508 mm, 381 mm, 304.8 mm], mass: 4.5359237 kg}" in (
        printed.out
    )


def test_numbers_of_layers_are_no_heights(stackdsl: Stackdsl, tmp_path: Path) -> None:
    rows = "".join(f"c{n},{n},400,300,{height},9,0,0\n" for n, height in ((1, 350), (2, 200), (3, 100)))
    write(tmp_path, f"carton,layer,length_mm,width_mm,height_mm,weight_kg,x_mm,y_mm\n{rows}", "load.csv")
    asked = stackdsl("import", "load.csv").err
    assert "add the column 'z [mm]' with 0 for layer 1, 350 for layer 2, 550 for layer 3" in asked


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("1,250", "7", "'1,250' is 1250 with a thousands separator, or 1.250 with a decimal comma"),
        ("1,250.5", "7", "'1,250.5' has a thousands separator"),
        ("12,5", "7.25", "the point in '7.25' is unclear, since the table has decimal commas, such as '12,5'"),
    ],
)
def test_a_comma_that_may_separate_thousands_is_asked_about(
    stackdsl: Stackdsl, tmp_path: Path, first: str, second: str, message: str
) -> None:
    rows = "".join(f"c{n};400;300;200;{mass};0;0;{200 * n}\n" for n, mass in enumerate((first, second)))
    write(tmp_path, f"name;length_mm;width_mm;height_mm;mass_kg;x_mm;y_mm;z_mm\n{rows}", "load.csv")
    asked = stackdsl("import", "load.csv", "--point", "corner").err
    assert message in asked
    assert asked.count("SD114") == 1


def test_a_comma_of_three_digits_is_decimal_beside_another_decimal_comma(stackdsl: Stackdsl, tmp_path: Path) -> None:
    rows = "".join(f"c{n};400;300;200;{mass};0;0;{200 * n}\n" for n, mass in enumerate(("1,250", "0,5")))
    write(tmp_path, f"name;length_mm;width_mm;height_mm;mass_kg;x_mm;y_mm;z_mm\n{rows}", "load.csv")
    printed = stackdsl("import", "load.csv", "--point", "corner").out
    assert "mass: 1.25 kg" in printed
    assert "mass: 0.5 kg" in printed


def test_a_long_import_shows_its_progress_in_a_terminal(tmp_path: Path) -> None:
    rows = "".join(f"c{n},100,100,100,2,{100 * n},0,0\n" for n in range(300))
    write(tmp_path, f"name,length_mm,width_mm,height_mm,mass_kg,x_mm,y_mm,z_mm\n{rows}", "load.csv")
    shown = ended(
        tmp_path, "import", "load.csv", "--point", "corner", "--settle", "down", FORCE_COLOR="1", NO_COLOR="1"
    ).err
    assert "importing load.csv: percent" in shown
    assert "left" in shown


def test_names_that_cannot_be_used_are_left_out_by_the_proposed_command(stackdsl: Stackdsl, tmp_path: Path) -> None:
    rows = "".join(f"box {n},400,300,200,9,0,0,{200 * n}\n" for n in range(2))
    write(tmp_path, f"name,length_mm,width_mm,height_mm,mass_kg,x_mm,y_mm,z_mm\n{rows}", "load.csv")
    asked = stackdsl("import", "load.csv").err
    assert "'box 0' is not a valid name" in asked
    assert stackdsl(*shlex.split(asked.splitlines()[-1])[1:]).code == ExitCode.OK


def test_numbers_of_cartons_become_their_names_with_a_prefix(stackdsl: Stackdsl, tmp_path: Path) -> None:
    rows = "".join(f"3401{n};A-1040;{n + 1};0;0;{250 * n};300;400;250;12\n" for n in range(2))
    write(tmp_path, f"NVE;Artikel;Lage;Pos_X;Pos_Y;Pos_Z;Länge;Breite;Höhe;Gewicht_kg\n{rows}", "load.csv")
    asked = stackdsl("import", "load.csv").err
    assert "write --map name=NVE --map x=Pos_X --map y=Pos_Y --map z=Pos_Z --map length=Länge" in asked.replace("'", "")
    assert "add the column" not in asked  # Pos_Z is the z
    assert "--ignore NVE" not in asked
    printed = stackdsl(*shlex.split(asked.splitlines()[-1])[1:]).out
    assert "name: c34010" in printed
    assert "names that begin with a digit have the prefix 'c'" in printed
