"""Types of YAML values: pydantic parsers and JSON schemas."""

import re

import pytest
from pydantic import TypeAdapter, ValidationError

from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import BrickName, LengthTolerance, read_touching


@pytest.mark.parametrize("name", ["a", "L3.2", "key-stone_1", "Wall", "wall", "walls", "grounded"])
def test_valid_brick_names_are_accepted(name: str) -> None:
    assert TypeAdapter(BrickName).validate_python(name) == name


@pytest.mark.parametrize("name", ["", "1a", "a b", "ground", "wall1", "ä", "a" * 65, "a\n", "L3.2+1"])
def test_invalid_brick_names_are_rejected(name: str) -> None:
    with pytest.raises(ValidationError, match=r"not a valid name|cannot be the name"):
        TypeAdapter(BrickName).validate_python(name)


@pytest.mark.parametrize("written", ["200 mm ± 1 mm", "200 ± 1 mm", "> 5 mm", "5 .. 7 cm", "≤ 2.5 mm", "1 +- .5 m"])
def test_editors_accept_tolerances(written: str) -> None:
    pattern = str(TypeAdapter(LengthTolerance).json_schema()["pattern"])
    assert re.search(pattern, written)
    assert not re.search(pattern, "12 mm")
    assert not re.search(pattern, "5 ± 1")


@pytest.mark.parametrize(
    ("written", "width"), [("exactly", 0.0), ("within 0.1 mm", 1e-4), (" within  50 um ", 5e-5), ("within 1 m", 1.0)]
)
def test_contact_gaps_are_a_word_or_a_width(written: str, width: float) -> None:
    assert read_touching(written) == pytest.approx(width)


@pytest.mark.parametrize(
    "written", ["within", "within 0.1", "within 0 mm", "within -1 mm", "0.1 mm", "Exactly", 0.1, None]
)
def test_invalid_contact_gaps_are_rejected(written: object) -> None:
    with pytest.raises(InputError):
        read_touching(written)
