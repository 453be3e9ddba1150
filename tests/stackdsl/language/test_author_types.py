"""The values that an author writes, as pydantic reads them and as editors are told of them."""

import re

import pytest
from pydantic import TypeAdapter, ValidationError

from stackdsl.language.author_types import BrickName, LengthTolerance


@pytest.mark.parametrize("name", ["a", "L3.2", "key-stone_1", "Wall", "wall", "walls", "grounded"])
def test_a_brick_may_be_called(name: str) -> None:
    assert TypeAdapter(BrickName).validate_python(name) == name


@pytest.mark.parametrize("name", ["", "1a", "a b", "ground", "wall1", "ä", "a" * 65, "a\n", "L3.2+1"])
def test_a_brick_may_not_be_called(name: str) -> None:
    with pytest.raises(ValidationError, match="not a name"):
        TypeAdapter(BrickName).validate_python(name)


@pytest.mark.parametrize("written", ["200 mm ± 1 mm", "200 ± 1 mm", "> 5 mm", "5 .. 7 cm", "≤ 2.5 mm", "1 +- .5 m"])
def test_editors_accept_tolerances(written: str) -> None:
    pattern = str(TypeAdapter(LengthTolerance).json_schema()["pattern"])
    assert re.search(pattern, written)
    assert not re.search(pattern, "12 mm")
    assert not re.search(pattern, "5 ± 1")
