"""A decimal comma has a remedy, in every kind of value."""

import pytest

from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse

BASE = "scenario: c\n{head}build:\n  - column: {column}\n{tail}"
POINT = "replace the decimal comma by a point"


@pytest.mark.parametrize(
    ("parts", "hint"),
    [
        ({"head": "friction: 0,5\n"}, f"{POINT}: 0.5"),
        ({"column": "\n      levels: 3\n      step: 0,5 mm"}, f"{POINT}: 0.5 mm"),
        ({"head": 'let: {shift: "3,5 mm"}\n', "column": '{levels: 3, step: "${shift}"}'}, f"{POINT}: 3.5 mm"),
        ({"tail": "expect:\n  - drift: <= 0,4 mm\n"}, f"{POINT}: <= 0.4 mm"),
        ({"tail": "expect:\n  - height: 23,4 mm\n"}, f"{POINT}: 23.4 mm"),
        ({"column": "{levels: 3, step: 1,5 mm}"}, POINT),
        ({"column": "{levels: 3,5}"}, POINT),
        ({"column": "{levels: 3, origin: [0, 0, 3,9 mm]}"}, "write decimals with a point instead of a comma"),
    ],
)
def test_decimal_comma_has_a_remedy(parts: dict[str, str], hint: str) -> None:
    text = BASE.format(**{"head": "", "column": "{levels: 3}", "tail": "", **parts})
    _, mistakes = cases_of(parse(text, "c.yaml"))
    assert any(hint in mistake.hint for mistake in mistakes), mistakes
