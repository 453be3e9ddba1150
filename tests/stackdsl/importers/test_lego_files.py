"""Structures of LEGO bricks from other programs: places, kinds, hostile files, and the way back to LDraw."""

import json
from pathlib import Path

import pytest

from stackdsl.diagnostics import Diagnostic
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError, written_box
from stackdsl.importers.supervised_reading import load_supervised
from stackdsl.language.imports import Import
from tests.command_line import Stackdsl
from tests.stackdsl.importers.loads import LDRAW, TEXTS

UPRIGHT = "1 0 0 0 1 0 0 0 1"


def read(text: str, others: dict[str, str] | None = None, **options: object) -> ImportedLoad:
    def beside(name: str) -> bytes:
        if name not in (others or {}):
            raise FileNotFoundError(2, "No such file or directory")
        return (others or {})[name].encode()

    return read_load(text.encode(), "a", Import.model_validate({"file": "a", **options}), beside)


def written(text: str, **options: object) -> list[object]:
    """The bricks as items of YAML, without their names."""
    boxes = [written_box(box) for box in read(text, **options).boxes]  # type: ignore[arg-type]  # files beside it
    return [{key: value for key, value in box.items() if key != "name"} for box in boxes]


def mistakes(text: str, others: dict[str, str] | None = None, **options: object) -> tuple[Diagnostic, ...]:
    with pytest.raises(UnreadableLoadError) as told:
        read(text, others, **options)
    assert all(each.hint for each in told.value.diagnostics)
    return told.value.diagnostics


def only_mistake(text: str, others: dict[str, str] | None = None, **options: object) -> str:
    (mistake,) = mistakes(text, others, **options)
    return f"{mistake.span.line}:{mistake.span.column} {mistake.message}"


@pytest.mark.parametrize("format_", ["stablelego", "apex-mr", "brickgpt", "ldraw"])
def test_the_format_of_a_file_is_recognised(format_: str) -> None:
    assert read(TEXTS[format_]).boxes == read(TEXTS[format_], format=format_).boxes  # type: ignore[index]  # a format


def test_a_structure_is_read_in_studs_and_kinds_of_the_catalogue() -> None:
    wall = [
        {"stud": [3, 4, 0], "brick": "lego_2x4"},
        {"stud": [7, 4, 0], "turned": True, "brick": "lego_2x2"},
        {"stud": [5, 4, "1 brick"], "turned": True, "brick": "lego_1x2"},
    ]
    assert written(TEXTS["stablelego"]) == written(TEXTS["apex-mr"]) == wall
    assert written("2x4 (0,0,0)\n4x2 (0,4,3)\n") == [
        {"stud": [0, 0, 0], "turned": True, "brick": "lego_2x4"},
        {"stud": [0, 4, "3 bricks"], "brick": "lego_2x4"},
    ]


def test_a_model_is_read_with_the_models_in_it() -> None:
    assert written(LDRAW) == [
        {"stud": [-1, -1, 0], "brick": "lego_2x2"},
        {"at": ["4.2 mm", "4 mm", "14.4 mm"], "rotate": ["0 deg", "0 deg", "90 deg"], "brick": "lego_1x2"},
        {"stud": [2, 0, 0], "brick": "lego_2x2"},
        {"at": ["28 mm", "3.8 mm", "14.4 mm"], "brick": "lego_1x2"},
        {"stud": [0, -1, "1 brick"], "brick": "lego_plate_2x4"},
    ]


def test_a_library_gives_sizes_and_masses() -> None:
    library = json.dumps({"2": {"height": 2, "width": 4, "mass": 0.0025, "inventory": 3}})
    brick = '{"1": {"x": 0, "y": 0, "z": 0, "ori": 1, "brick_id": %d}}'
    (box,) = read(brick % 2, {"own.json": library}, library="own.json").boxes
    assert (float(box.mass), [float(side) for side in box.size]) == (0.0025, [0.032, 0.016, 0.0096])
    assert only_mistake(brick % 7, {"own.json": library}, library="own.json") == "1:7 the library has no brick 7"
    assert "cannot read 'own.json'" in only_mistake(brick % 2, library="own.json")
    assert only_mistake(brick % 7) == "1:7 the number 7 is not one of the published bricks"
    odd = library.replace("0.0025", "NaN")
    assert only_mistake(brick % 2, {"own.json": odd}, library="own.json") == "1:41 NaN is not valid in JSON"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("2x4 (0,0,0)\n2x5 (0,0,1)\n", "2:1 there is no brick of 2x5 studs in the catalogue"),
        ("2x4 (0,0,0)\n  2x4 (0,0,-1)\n", "2:3 the line is not a brick"),
        ("2x4 (0,0,0)\n2x4 (0,0,99999)\n", "2:1 the place is further than 10000 studs"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 0 0 0 {UPRIGHT} 3039.dat", "2:1 '3039.dat' is not supported"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n 4 16 0 0 0 1 0 0 1 1 0 0 1 0", "2:2 'geometry' is not supported"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 0 NaN 0 {UPRIGHT} 3001.dat", "2:1 'NaN' is not a number"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 0 1e99 0 {UPRIGHT} 3001.dat", "2:1 '1e99' is not a number"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 0 1e9 0 {UPRIGHT} 3001.dat", "2:1 a number of the part exceeds 10 km"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n1 4 0 0 0 3001.dat", "2:1 a part needs a colour, twelve numbers and a file"),
        (f"1 4 0 0 0 {UPRIGHT} 3001.dat\n7 4", "2:1 a line begins with a digit from 0 to 5"),
        (f"0 a\n1 4 0 0 0 {UPRIGHT} up.ldr", "2:1 cannot read 'up.ldr': No such file or directory"),
        ("0 a\n1 4 0 0 0 0.7071 0 0.7071 0 1 0 -0.7071 0 0.7071 3001.dat", "2:1 the part is tilted, scaled, or turned"),
        ("0 a\n1 4 0 0 0 1 0 0 0 -1 0 0 0 -1 3001.dat", "2:1 the part is tilted, scaled, or turned"),
        ("0 a\n1 4 0 0 0 2 0 0 0 1 0 0 0 1 3001.dat", "2:1 the part is tilted, scaled, or turned"),
    ],
)
def test_a_mistake_is_told_with_its_place(text: str, message: str) -> None:
    assert only_mistake(text).startswith(message)


def test_a_part_that_the_catalogue_lacks_is_told_once_and_may_be_left_out() -> None:
    lines = [f"1 4 0 {-24 * z} 0 {UPRIGHT} {part}" for z, part in enumerate(("3001.dat", "3039.dat", "3039.DAT"))]
    assert only_mistake("\n".join(lines)).startswith("2:1 '3039.dat' is not supported")
    for ignore in ("3039.dat", "other parts"):
        left = read("\n".join(lines), ignore=[ignore])
        assert (len(left.boxes), left.skipped) == (1, ("3039.dat",) if ignore == "other parts" else ())


def test_several_parts_that_the_catalogue_lacks_are_told_in_one_message() -> None:
    lines = [
        f"1 4 0 {-24 * z} 0 {UPRIGHT} {part}" for z, part in enumerate(("3001.dat", "3039.dat", "3040.dat", "3641.dat"))
    ]
    assert only_mistake("\n".join(lines)).startswith("2:1 the catalogue lacks 3 parts: 3039.dat, 3040.dat, 3641.dat")
    left = read("\n".join(lines), ignore=["other parts"])
    assert (len(left.boxes), left.skipped) == (1, ("3039.dat", "3040.dat", "3641.dat"))
    only = read("\n".join(lines), ignore=["3039.dat", "3040.dat", "3641.dat"])
    assert len(only.boxes) == 1


def test_a_rotation_that_is_written_with_few_digits_is_one_of_90_degrees() -> None:
    turned = "1 4 40.0002 -24 20 -4e-05 0 -1 0 1 0 0.99999 0 -4e-05 3001.dat"
    assert written(turned) == [{"stud": [1, -1, 0], "turned": True, "brick": "lego_2x4"}]


def test_models_that_contain_themselves_or_grow_without_end_are_refused() -> None:
    once = f"1 4 0 0 0 {UPRIGHT} {{1}}.ldr\n"
    twice = "0 FILE {0}.ldr\n" + 2 * once
    loop = twice.format("a", "b") + twice.format("b", "A")
    assert {each.message for each in mistakes(loop)} == {"the model 'a.ldr' contains itself"}
    doubling = "".join(twice.format(level, level + 1) for level in range(30)) + "0 FILE 30.ldr\n"
    assert "more than 20000 parts" in mistakes(doubling)[0].message
    deep = "".join(("0 FILE {0}.ldr\n" + once).format(level, level + 1) for level in range(60))
    assert any("nested more than 40 deep" in each.message for each in mistakes(deep))


def test_a_model_in_a_file_of_its_own_is_read_beside_it() -> None:
    asked = Import.model_validate({"file": "a.ldr"})
    inner = f"1 4 0 0 0 {UPRIGHT} 3005.dat\n".encode()
    whole = f"1 4 20 0 0 {UPRIGHT} Inner.ldr\n1 4 20 -24 0 {UPRIGHT} Inner.ldr\n".encode()
    load = load_supervised(whole, "a.ldr", asked, {"Inner.ldr": inner}.__getitem__)
    assert [[float(part) for part in box.centre] for box in load.boxes] == [[0.008, 0, 0.0048], [0.008, 0, 0.0144]]


SCENE = """\
scenario: wall
%s
build:
  - import: {file: wall.json}
expect:
  - stands: all
"""


def test_an_import_needs_the_base_plate_that_its_file_has(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "wall.json").write_text(TEXTS["stablelego"], encoding="utf-8")
    (tmp_path / "a.yaml").write_text(SCENE % "friction: 0.5", encoding="utf-8")
    refused = stackdsl("check", "a.yaml")
    assert "a.yaml:4:20: SD115 the bricks of the file stand on a base plate" in refused.text
    assert "write world: {ground: {studs: lego}}, or ignore: ['base plate']" in refused.text
    (tmp_path / "a.yaml").write_text(SCENE % "world: {ground: {studs: lego}}", encoding="utf-8")
    assert stackdsl("check", "a.yaml").code == 0
    dry = SCENE.replace("wall.json}", "wall.json, ignore: [base plate]}") % "friction: 0.5"
    (tmp_path / "a.yaml").write_text(dry, encoding="utf-8")
    assert stackdsl("check", "a.yaml", "--no-golden").code == 0


def test_an_imported_structure_comes_back_from_ldraw_as_it_was(stackdsl: Stackdsl, tmp_path: Path) -> None:
    (tmp_path / "wall.txt").write_text(TEXTS["brickgpt"], encoding="utf-8")
    (tmp_path / "wall.yaml").write_text(stackdsl("import", "wall.txt").out, encoding="utf-8")
    assert stackdsl("check", "wall.yaml", "--no-golden").code == 0
    model = stackdsl("export", "wall.yaml")
    assert (model.code, model.err) == (0, "")
    (tmp_path / "wall.ldr").write_text(model.out, encoding="utf-8")
    back = stackdsl("import", "wall.ldr").out
    assert back.replace("wall.ldr", "wall.txt") == (tmp_path / "wall.yaml").read_text(encoding="utf-8")


def test_only_lego_bricks_are_exported(stackdsl: Stackdsl, tmp_path: Path) -> None:
    bricks = "[{name: a, on: ground, brick: lego_2x4}, {name: b, on: a}]"
    text = f"scenario: mixed\nbuild: [{{bricks: {bricks}}}]\nexpect: [{{stands: all}}]\n"
    (tmp_path / "mixed.yaml").write_text(text, encoding="utf-8")
    refused = stackdsl("export", "mixed.yaml")
    assert refused.code == 4
    assert "b: no LEGO brick or plate of the catalogue has this size" in refused.err
    assert refused.out == ""
