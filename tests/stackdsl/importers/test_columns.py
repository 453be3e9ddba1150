"""Columns of tables of any header, orientation and sign of decimals are read as one load."""

from collections.abc import Sequence
from itertools import permutations
from typing import Any

import pytest

from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Import

PLAIN = "name,length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm]\na,400,300,200.5,8.4,1250,0,0\n"
OTHER = "Karton;L;B;H;G;PX;PY;PZ\na;400;300;200,5;8,4;1250;0;0\n"
MAP = {"name": "Karton", "length": "L", "width": "B", "height": "H", "mass": "G", "x": "PX", "y": "PY", "z": "PZ"}
UNITS = {"length": "mm", "mass": "kg"}


def read(text: str, **asked: Any) -> ImportedLoad:  # noqa: ANN401 -- as in YAML
    options = Import.model_validate({"file": "a.csv", "format": "table", "point": "corner", **asked})
    return read_load(text.encode(), "a.csv", options)


def boxes(load: ImportedLoad) -> list[tuple[object, ...]]:
    return [(box.name, box.size, box.centre, box.mass) for box in load.boxes]


def mistake(text: str, **asked: Any) -> str:  # noqa: ANN401 -- as in YAML
    with pytest.raises(UnreadableLoadError) as refused:
        read(text, **asked)
    (one,) = refused.value.diagnostics
    return f"{one}"


def test_mapped_columns_are_those_of_the_usual_headers() -> None:
    assert boxes(read(OTHER, map=MAP, units=UNITS)) == boxes(read(PLAIN))
    rows = '[{"Karton": "a", "L": 400, "B": 300, "H": 200.5, "G": 8.4, "PX": 1250, "PY": 0, "PZ": 0}]'
    assert boxes(read(rows, map=MAP, units=UNITS)) == boxes(read(PLAIN))


@pytest.mark.parametrize("header", ["L [cm]", "L (cm)", "L/cm", "L_cm"])
def test_a_mapped_header_keeps_its_unit_and_may_be_named_without_it(header: str) -> None:
    text = PLAIN.replace("length [mm]", header).replace("a,400", "a,40")
    assert boxes(read(text, map={"length": "L"})) == boxes(read(text, map={"length": header})) == boxes(read(PLAIN))


@pytest.mark.parametrize(
    ("text", "asked", "told"),
    [
        (PLAIN, {"map": {"length": "L"}}, "`map` names the column 'L', which the table does not have"),
        (PLAIN, {"map": {"length": "width"}}, "the table also has the column 'length [mm]'"),
        (PLAIN, {"map": {"yaw": "mass", "rotated": "mass"}}, "`map` says that 'mass' is the"),
        (OTHER, {"map": MAP, "units": UNITS, "ignore": ["L"]}, "but it is also a column of `ignore`"),
    ],
)
def test_a_map_that_cannot_be_right_is_refused(text: str, asked: dict[str, Any], told: str) -> None:
    assert told in mistake(text, **asked)


def test_a_column_that_is_ignored_gives_way_to_the_mapped_one() -> None:
    text = PLAIN.replace("name,", "name,L [mm],").replace("a,", "a,400,").replace("a,400,400", "a,400,1")
    assert boxes(read(text, map={"length": "L"}, ignore=["length [mm]"])) == boxes(read(PLAIN))


@pytest.mark.parametrize(
    ("sign", "number"), [("comma", "1,250"), ("comma", "1,25"), ("point", "1.25"), ("point", "1.250")]
)
def test_the_sign_of_decimals_decides_what_1_250_is(sign: str, number: str) -> None:
    text = PLAIN.replace(",", ";").replace("1250;", f"{number};").replace("200.5", "200").replace("8.4", "8")
    assert read(text, decimals=sign).boxes[0].centre[0] * 1000 == 1.25 + 200
    other = {"comma": "point", "point": "comma"}[sign]
    if number in {"1,250", "1.250"}:
        assert read(text, decimals=other).boxes[0].centre[0] * 1000 == 1250 + 200


@pytest.mark.parametrize("number", ["1.25,0", "1,2,5", "1.250.00", "12,50.5"])
def test_a_number_of_neither_sign_is_refused(number: str) -> None:
    text = PLAIN.replace(",", ";").replace("1250;", f"{number};").replace("200.5", "200").replace("8.4", "8")
    assert "is not a number" in mistake(text, decimals="comma")


def laid(rotated: Sequence[str]) -> list[tuple[float, ...]]:
    """The sides of boxes of 400 x 300 x 200 mm as they lie, which all have the same lower corner."""
    head = "length [mm],width [mm],height [mm],mass [kg],x [mm],y [mm],z [mm],rotated\n"
    load = read(head + "".join(f"400,300,200,8,10,20,30,{each}\n" for each in rotated))
    corners = {tuple(centre - side / 2 for centre, side in zip(b.centre, b.size, strict=True)) for b in load.boxes}
    assert len(corners) == 1
    return [tuple(float(1000 * side) for side in box.size) for box in load.boxes]


def test_a_rotated_carton_has_its_length_along_y() -> None:
    assert laid(["no", "yes", "", "1", "Ja", "false"]) == [
        (400, 300, 200), (300, 400, 200), (400, 300, 200), (300, 400, 200), (300, 400, 200), (400, 300, 200),
    ]  # fmt: skip


def test_a_label_of_sides_gives_what_lies_along_x_y_and_z() -> None:
    sides = {"L": 400.0, "W": 300.0, "H": 200.0}
    labels = ["".join(each) for each in permutations("LWH")]
    assert laid(labels) == [tuple(sides[letter] for letter in label) for label in labels]
    assert laid(["hbl"]) == laid(["HWL"])


def test_an_unknown_orientation_is_refused() -> None:
    text = PLAIN.replace("z [mm]", "z [mm],rotated").replace(",0,0\n", ",0,0,LLH\n")
    assert "`rotated`: 'LLH' is not an orientation" in mistake(text)


def test_json_says_with_true_and_false_whether_a_carton_is_rotated() -> None:
    sides = '"length [mm]": 400, "width [mm]": 300, "height [mm]": 200, "mass [kg]": 8, "x [mm]": 0, "y [mm]": 0'
    load = read(f'[{{{sides}, "z [mm]": 0, "rotated": true}}, {{{sides}, "z [mm]": 200, "rotated": false}}]')
    assert [tuple(float(1000 * side) for side in box.size) for box in load.boxes] == [(300, 400, 200), (400, 300, 200)]


PACKED = "Line,Carton ID,SKU,L (in),W (in),H (in),Weight (lbs),X (in),Y (in),Z (in)\n1,C-1,A7,10,20,30,100,0,0,0\n"


def test_pounds_are_read_in_the_plural_too() -> None:
    sides = {"length": "L", "width": "W", "height": "H"}
    (box,) = read(PACKED, map=sides, ignore=["Line", "Carton ID", "SKU"]).boxes
    assert (float(box.mass), float(box.size[0])) == (45.359237, 0.254)
    assert boxes(
        read(PACKED.replace("Weight (lbs)", "Weight_lbs"), map=sides, ignore=["Line", "Carton ID", "SKU"])
    ) == [(box.name, box.size, box.centre, box.mass)]


@pytest.mark.parametrize("header", ["Carton ID", "Colli-Nr.", "Box ID", "Package ID", "Carton Number"])
def test_numbers_of_cartons_are_proposed_as_names(header: str) -> None:
    text = PACKED.replace("Carton ID", header)
    with pytest.raises(UnreadableLoadError) as refused:
        read(text)
    assert refused.value.proposed["map"]["name"] == header
    assert refused.value.proposed["ignore"] == ["Line", "SKU"]


def test_an_unknown_unit_of_a_mapped_column_is_reported_at_its_header() -> None:
    header, row = OTHER.replace(";G;", ";G [st];").splitlines()
    with pytest.raises(UnreadableLoadError) as refused:
        read(f"{header}\n{row}\n", map=MAP, units=UNITS)
    (one,) = refused.value.diagnostics
    assert "'st' is not a known unit of mass" in one.message
    assert (one.span.line, one.span.column) == (1, 14)
