"""Plain scalars: values, traps, and linear time of reading."""

from itertools import product

import pytest

from stackdsl.language.yaml.parsing import Trap, plain_value

MANY = 300_000  # characters: what takes quadratic time would take hours


@pytest.mark.parametrize(
    "text",
    [
        f"{sign}{digit * MANY}{rest}"
        for sign, digit, rest in product(("", "-"), ("1", "1_", "0"), ("x", ".x", "e", ":x"))
    ],
    ids=range(24),
)
def test_a_very_long_text_that_is_nearly_a_number_is_read_at_once(text: str) -> None:
    assert plain_value(text) == text


@pytest.mark.parametrize("text", ["+12", "012", "1_000", "1_000.", ".5", "1.e3", "1_0.0_1", "1."])
def test_what_only_some_readers_take_for_a_number_is_a_trap(text: str) -> None:
    assert isinstance(plain_value(text), Trap)
