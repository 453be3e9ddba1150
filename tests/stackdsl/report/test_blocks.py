"""What is printed without a library is what the library would have printed."""

from hypothesis import given
from hypothesis import strategies as st

from stackdsl.report.blocks import Line, Table, drawn_text, plain_text

PRINTABLE = st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=12).map(str.strip)
NAMES = st.lists(PRINTABLE.filter(bool), min_size=1, max_size=4, unique=True)


def without_trailing_spaces(text: str) -> str:
    return "\n".join(line.rstrip() for line in text.split("\n"))


@st.composite
def tables(draw: st.DrawFn) -> Table:
    names = draw(NAMES)
    cells = draw(st.lists(st.lists(PRINTABLE, min_size=len(names), max_size=len(names)), min_size=1, max_size=4))
    rows = [dict(zip(names, row, strict=True)) for row in cells]
    return Table(rows, draw(st.lists(st.sampled_from(names), unique=True)))


@given(tables())
def test_a_plain_table_is_drawn_alike_with_and_without_rich(table: Table) -> None:
    plain = plain_text(table, width=160)
    assert plain is not None
    assert without_trailing_spaces(plain) == without_trailing_spaces(drawn_text(table, width=160, colour=False))


@given(st.text(st.characters(exclude_categories=["C"]), max_size=40))
def test_a_line_is_printed_alike_with_and_without_rich(text: str) -> None:
    assert plain_text(Line(text, "bold"), width=20) == drawn_text(Line(text, "bold"), width=20, colour=False)


def test_a_table_too_wide_or_with_wide_characters_is_left_to_rich() -> None:
    assert plain_text(Table([{"name": "a" * 30}], ["name"]), width=20) is None
    assert plain_text(Table([{"name": "積木"}], ["name"]), width=20) is None
    assert plain_text(Table([{"name": "two\nlines"}], ["name"]), width=20) is None
