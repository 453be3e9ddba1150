"""Messages on first attempts of a new user name the form to write."""

import re
from pathlib import Path

import pytest

from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from tests.command_line import Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("build: [{jenga: {levels: 8}}]\nimpacts: [{remove: L4.1}]", "write {brick: L4.1}"),
        ("build: [{import: cartons.csv}]", "write {file: cartons.csv}; the keys are file"),
        (
            "brick: [117 mm, 23 mm, 8 mm]\nbuild: [{column: {levels: 2}}]",
            "write {size: [117 mm, 23 mm, 8 mm], density: 500 kg/m3}; the",
        ),
        (
            "build: [{column: {levels: 2}}]\nexpect: [{margin: '>= 3 deg'}]",
            'write {tilt: ">= 3 deg"}; the keys are acceleration',
        ),
        ("brick: 117 x 23 x 8 mm\nbuild: [{column: {levels: 2}}]", "write {size: [117 mm, 23 mm, 8 mm], density: 500"),
        ("build: [{column: {levels: 2, step: 0.5 in}}]", "write 12.7 mm"),
        ("friction: 50 %\nbuild: [{column: {levels: 2}}]", "write 0.5, without '%'"),
        ('build: [{column: {levels: "2"}}]', "write 2, without quotes"),
        ("friction = 0.4\nbuild: [{column: {levels: 2}}]", "write `friction: 0.4`"),
        ("build:\n  - column {levels: 2}", "write `column: {levels: 2}`"),
        ("build:\n  - column levels: 2", "put a colon after it: `column: {levels: 2}`"),
        ("build:\n  - - column: {levels: 2}", "write the mapping itself, without the list around it"),
        ("build: [{bricks: [{on: grond}]}]", "did you mean 'ground'?"),
        ("build: [{column: {levels: 2}}]\nimpacts: [{remove: {brick: [L1.1]}}]", "write `bricks` in place of `brick`"),
        ("build: [{four_stack: {levels: 2, spacing: 10 mm}}]", "increase `spacing` by at least 13.4 mm"),
        ("friction: lognormal 0.5\nsamples: 9\nbuild: [{column: {levels: 2}}]", "lognormal 0.5 dispersion 0.2"),
        ("build:\u00a0[{column: {levels: 2}}]", "replace it by an ordinary space"),
        ("build:\n  - column: {levels:\u00a02}", "replace it by an ordinary space"),
        ("build:\n \u00a0- column: {levels: 2}", "replace it by an ordinary space"),
        ("samples: 1,000\nbuild: [{column: {levels: 2}}]", "write 1000, without commas"),
        (
            "build: [{bricks: [{name: a, at: [0 m, 0 m, 3.9 mm]}, {name: b, at: [50 mm, 0 m, 3.9 mm]}]}]",
            "write `at: [50 mm, 0 mm, 11.7 mm]` or beside it `at: [50 mm, 23.4 mm, 3.9 mm]`",
        ),
        ("build: [{column: {levels: 2}}]\nexpect: [{hits: {brick: L1.1}}]", "`stackdsl run` prints when, where and"),
    ],
)
def test_a_shorter_form_is_told_with_what_to_write(written: str, told: str) -> None:
    _, mistakes = cases_of(parse(f"scenario: first\n{written}\n", "first.yaml"))
    assert told in mistakes[0].hint


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("sphere: {radius: 15 mm}", "write `diameter: 30 mm`, twice the radius, in place of `radius`"),
        ("ball: 30 mm", "write `sphere: {diameter: 30 mm}` in place of `ball`"),
        ("ball: {radius: 15 mm}", "write `sphere: {diameter: 30 mm}` in place of `ball`"),
        ("can: {radius: 33 mm, height: 115 mm}", "write `cylinder: {diameter: 66 mm, height: 115 mm}` in place of"),
        ("shape: sphere, radius: 15 mm", "write `sphere: {diameter: 30 mm}` in place of `shape`, `radius`"),
        ("shape: {ball: {diameter: 30 mm}}", "write `sphere: {diameter: 30 mm}` in place of `shape`"),
        (
            "type: cylinder, diameter: 66 mm, height: 115 mm",
            "write `cylinder: {diameter: 66 mm, height: 115 mm}` in place of `type`, `diameter`, `height`",
        ),
        ("radius: 15 mm, length: 6 cm", "write `cylinder: {diameter: 30 mm, height: 6 cm}` in place of `radius`, `len"),
        ("diameter: 30 mm", "write `sphere: {diameter: 30 mm}`, or `cylinder: {diameter: 30 mm, height: 60 mm}`, in"),
        ("cylinder: {diameter: 30 mm, length: 60 mm}", "write `height` in place of `length`"),
        ("cone: {radius: 15 mm, height: 60 mm}", "write `bottom: 30 mm`, twice the radius"),
        ("pipe: {diameter: 30 mm, thickness: 2 mm, height: 60 mm}", "write `wall` in place of `thickness`"),
    ],
)
def test_a_round_brick_in_other_words_has_one_message_with_what_to_write(written: str, told: str) -> None:
    kind = f"{{{written}, mass: 60 g}}"
    text = f"scenario: first\nbrick_types: {{round: {kind}}}\nbrick: round\nbuild: [{{column: {{levels: 1}}}}]\n"
    _, mistakes = cases_of(parse(text, "first.yaml"))
    assert len(mistakes) == 1
    assert told in mistakes[0].hint


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (
            "at: [0 m, 0 m, 1 m], sphere: {radius: 5 mm}",
            "write `brick: {sphere: {diameter: 10 mm}, density: 500 kg/m3}`",
        ),
        (
            "on: ground, radius: 5 mm, mass: 4 g",
            "write `brick: {sphere: {diameter: 10 mm}, mass: 4 g}` in place of `radius`",
        ),
        ("on: ground, brick: ball", "write {sphere: {diameter: 30 mm}, density: 500 kg/m3}"),
    ],
)
def test_a_round_brick_in_its_place_is_told_as_a_kind_of_brick(written: str, told: str) -> None:
    text = f"scenario: first\nbuild: [{{bricks: [{{{written}}}]}}]\n"
    _, mistakes = cases_of(parse(text, "first.yaml"))
    assert told in mistakes[0].hint


def test_a_sphere_may_be_its_diameter() -> None:
    text = "scenario: first\nbrick: {{sphere: {}, mass: 60 g}}\nbuild: [{{bricks: [{{on: ground}}]}}]\n"
    short, long = (cases_of(parse(text.format(each), "f.yaml"))[0][0] for each in ("30 mm", "{diameter: 30 mm}"))
    assert short.scenario.brick.form == long.scenario.brick.form


@pytest.mark.parametrize("unit", ["", " g"])
def test_a_margin_of_acceleration_may_have_its_unit_g(unit: str) -> None:
    text = f"scenario: first\nbuild: [column: {{levels: 3}}]\nexpect: [margin: {{acceleration: '>= 0.3{unit}'}}]\n"
    cases, mistakes = cases_of(parse(text, "first.yaml"))
    assert mistakes == []
    (claim,) = cases[0].scenario.expect
    assert "0.3" in str(claim)


def test_a_table_without_units_has_one_message_with_the_options_to_add(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "name,length,width,height,mass,x,y,z\na,100,100,100,2,0,0,0\n", "cartons.csv")
    told = stackdsl("import", "cartons.csv", "--point", "corner")
    assert told.err.count("SD115") == 1
    assert "the columns 'length', 'width', 'height', 'mass', 'x', 'y', 'z' have no unit" in told.err
    assert "or set --length mm --mass kg" in told.err
    assert stackdsl("import", "cartons.csv", "--point", "corner", "--length", "mm", "--mass", "kg").code == 0
    assert (
        "so write --point corner, or --point centre if that is not so"
        in stackdsl("import", "cartons.csv", "--length", "mm", "--mass", "kg").err
    )


@pytest.mark.parametrize(
    ("name", "text", "parts"),
    [
        ("cartons.dae", "<COLLADA/>\n", ("files of type .dae are not supported", "save it as OBJ, STL or PLY")),
        ("cartons.xlsx", "PK\x03\x04", ("files of type .xlsx are not supported", "save it as CSV")),
        (
            "cartons.csv",
            "a,0,0,0,4,3,2,8\nb,0,0,2,4,3,2,8\n",
            ("the table has no line of headers", "write one above it"),
        ),
        ("cartons.json", '{"a": [1,2', ("the JSON ends too early", "complete it, or export it again")),
        ("cartons.txt", "some notes\n", ("the format of the file cannot be recognised", "--format: table, ")),
    ],
)
def test_a_file_that_is_no_load_has_one_message(
    stackdsl: Stackdsl, tmp_path: Path, name: str, text: str, parts: tuple[str, str]
) -> None:
    write(tmp_path, text, name)
    told = stackdsl("import", name, "--point", "corner").err
    assert all(part in told for part in parts)
    assert told.count(": SD") == 1


def test_a_table_in_another_unit_has_a_warning_with_the_unit_to_try(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "length,width,height,mass,x,y,z\n400,300,200,8,0,0,0\n", "cartons.csv")
    units = ("--point", "corner", "--mass", "kg", "--length")
    told = stackdsl("import", "cartons.csv", *units, "m").err
    assert "this box has a longest side of 400 m and a density of 3.33e-07 kg/m3, which is implausible" in told
    assert "with --length mm this side is 0.4 m" in told
    assert "warning" not in stackdsl("import", "cartons.csv", *units, "mm").err
    told = stackdsl("import", "cartons.csv", "--point", "centre", "--mass", "kg", "--length", "mm").err
    assert "so x, y, z are hardly the centre of a box; write --point corner if that is so" in told


def test_columns_of_a_warehouse_have_one_message_with_the_columns_to_map(stackdsl: Stackdsl, tmp_path: Path) -> None:
    header = "SSCC,L_mm,W_mm,H_mm,weight_kg,pos_x,pos_y,pos_z\n"
    write(tmp_path, header + "003001,400,300,200,5,0,0,0\n" * 3, "wms.csv")
    told = stackdsl("import", "wms.csv")
    places = "--map x=pos_x --map y=pos_y --map z=pos_z"
    assert f"write --map length=L_mm --map width=W_mm --map height=H_mm {places};" in told.err
    assert "to ignore the others, write --ignore SSCC" in told.err
    assert "  stackdsl import wms.csv --ignore SSCC --map length=L_mm" in told.err
    assert told.err.endswith(f"{places} --length mm --point corner\n")
    assert stackdsl(*told.err.splitlines()[-1].split()[1:]).code == 0


@pytest.mark.parametrize("way", ["beside", "on top"])
def test_the_origins_that_are_told_for_a_second_layout_at_one_place_leave_it_free(way: str) -> None:
    text = "scenario: two\nbuild:\n  - column: {levels: 3}\n  - column: {levels: 3}\n"
    _, mistakes = cases_of(parse(text, "two.yaml"))
    origin = re.findall(rf"{way},.*?`(origin: [^`]*)`", mistakes[0].hint)[0]
    cases, mistakes = cases_of(parse(text.removesuffix("}\n") + f", {origin}}}\n", "two.yaml"))
    assert (len(cases), mistakes) == (1, [])
