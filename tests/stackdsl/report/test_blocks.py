"""What is printed without a library is what the library would have printed."""

from hypothesis import given
from hypothesis import strategies as st

from stackdsl.report.blocks import Line, Table, drawn_text, folded_text, plain_text

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


def test_a_table_too_wide_for_the_paper_is_folded_and_no_cell_is_cut() -> None:
    row = {"case": "c" * 50, "verdict": "stands", "drift": "1.5", "golden": "same", "note": "n" * 30}
    lines = folded_text(Table([row], ["case", "verdict", "golden", "note"]), width=80, colour=False).splitlines()
    assert lines == [
        "case" + " " * 48 + "verdict  drift  golden",
        "    note",
        "c" * 50 + "  stands     1.5  same",
        "    " + "n" * 30,
    ]
    assert all(len(line) <= 80 for line in lines)
    assert "\x1b[32mstands\x1b[0m" in folded_text(Table([row], ["case"]), width=80, colour=True)


def test_a_table_too_wide_or_with_wide_characters_is_left_to_rich() -> None:
    assert plain_text(Table([{"name": "a" * 30}], ["name"]), width=20) is None
    assert plain_text(Table([{"name": "積木"}], ["name"]), width=20) is None
    assert plain_text(Table([{"name": "two\nlines"}], ["name"]), width=20) is None
