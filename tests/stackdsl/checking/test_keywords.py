"""`-k` reads words as pytest does: and, or, not, parentheses; what cannot be read is told with its column."""

import pytest

from stackdsl.checking.selection import KeywordError, expression_of

NAMES = ("tower[step=10mm,exact]", "tower[step=10mm,tuned]", "wall[exact]", "wall[stock]")
TAKEN = {
    "": {0, 1, 2, 3},
    "tower": {0, 1},
    "TOWER": {0, 1},
    "not tower": {2, 3},
    "not not tower": {0, 1},
    "tower or stock": {0, 1, 3},
    "tower and exact": {0},
    "not tower and exact": {2},
    "tower and exact or wall and stock": {0, 3},
    "tower and (exact or wall)": {0},
    "not (exact or stock)": {1},
    "tower[step=10mm,exact]": {0},
    "'step=10mm' and not \"tuned\"": {0},
    "wall and '[stock]'": {3},
}
MISTAKES = {
    "tower wall": "'and' or 'or' is expected instead of 'wall' at column 7",
    "tower and": "a word is expected instead of its end",
    "and tower": "a word is expected instead of 'and' at column 1",
    "(tower": "')' is expected instead of its end",
    "tower)": "'and' or 'or' is expected instead of ')' at column 6",
    "()": "a word is expected instead of ')' at column 2",
    "tower and 'wall": "the quote at column 11 is not closed",
    "(" * 70 + "a" + ")" * 70: "nested more than 64 levels deep",
}


@pytest.mark.parametrize(("text", "taken"), TAKEN.items(), ids=TAKEN)
def test_an_expression_takes_the_names_that_it_is_true_of(text: str, taken: set[int]) -> None:
    assert {number for number, name in enumerate(NAMES) if expression_of(text)(name)} == taken


@pytest.mark.parametrize(("text", "told"), MISTAKES.items(), ids=range(len(MISTAKES)))
def test_what_is_no_expression_is_told_with_its_column(text: str, told: str) -> None:
    with pytest.raises(KeywordError) as error:
        expression_of(text)
    assert told in str(error.value)
