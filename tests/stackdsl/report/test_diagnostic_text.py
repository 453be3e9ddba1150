"""A mistake as an author reads it."""

from pathlib import Path

import pytest

from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.language.yaml.source import load, parse
from stackdsl.report.diagnostics import diagnostic_text

STEP = Diagnostic(
    "SD105",
    Span("scenarios/a.yaml", 3, 9, 11, "  step: 11"),
    "a bare number where a length is due",
    "write a unit: 11 mm",
)


def lines_of(excerpt: str, column: int, end_column: int, excerpt_column: int = 1) -> list[str]:
    """The excerpt and the line of carets below it, without the gutter."""
    span = Span("a.yaml", 1, column, end_column, excerpt, excerpt_column)
    return [line.partition(" | ")[2] for line in diagnostic_text(Diagnostic("SD101", span, "m")).splitlines()[1:]]


def test_a_diagnostic_says_where_what_and_what_to_do() -> None:
    expected = """\
scenarios/a.yaml:3:9: SD105 a bare number where a length is due
    3 |   step: 11
      |         ^^
      = write a unit: 11 mm"""
    assert diagnostic_text(STEP) == expected


@pytest.mark.parametrize("excerpt", ["", "   ", "\t"])
def test_a_blank_line_is_not_shown_with_a_caret_below_nothing(excerpt: str) -> None:
    assert lines_of(excerpt, column=1, end_column=2) == []


def test_without_excerpt_and_hint_only_the_head_remains() -> None:
    bare = Diagnostic("SD001", Span("a.yaml", 1, 1, 1), "cannot read the file: No such file or directory")
    assert diagnostic_text(bare) == "a.yaml:1:1: SD001 cannot read the file: No such file or directory"


def test_line_numbers_share_a_gutter() -> None:
    text = diagnostic_text(Diagnostic("SD101", Span("a.yaml", 12345, 1, 2, "a: 1"), "m", "h"))
    assert text.splitlines()[1:] == ["12345 | a: 1", "      | ^", "      = h"]


@pytest.mark.parametrize(
    ("excerpt", "column", "end_column", "carets"),
    [
        ("\ta: 1", 5, 6, "       ^"),  # a tab takes four columns
        ("± 1: no", 6, 8, "     ^^"),
        ("😀: no", 4, 6, "    ^^"),  # an emoji takes two
        ("積: 木", 4, 5, "    ^^"),
        ("e\u0301: no", 5, 7, "   ^^"),  # a combining accent takes none
        ("✔\ufe0f: no", 5, 7, "   ^^"),  # nor does a variation selector
        ("\x1b: no", 4, 6, "   ^^"),
        ("a: b", 5, 6, "    ^"),  # behind the end of the line
        ("a: b", 2, 2, " ^"),  # at least one
        ("a: b", 4, 99, "   ^"),  # no more than there is
    ],
)
def test_carets_stand_below_what_they_mean(excerpt: str, column: int, end_column: int, carets: str) -> None:
    assert lines_of(excerpt, column, end_column)[1] == carets


def test_a_cut_line_keeps_its_carets() -> None:
    assert lines_of("…x, no, y…", 905, 907, excerpt_column=901) == ["…x, no, y…", "    ^^"]


def test_text_of_the_author_cannot_steer_the_terminal() -> None:
    hostile = "\x1b[2J\r\u202e\ud800"
    span = Span(f"{hostile}.yaml", 1, 1, 2, f"{hostile}: 1")
    text = diagnostic_text(Diagnostic("SD101", span, f"unknown key '{hostile}'", f"not {hostile}\nbut x"))
    assert all(line.isprintable() for line in text.splitlines())
    assert text.encode("utf-8")
    assert text.endswith("\N{REPLACEMENT CHARACTER} but x")
    assert len(text.splitlines()) == 4


def test_a_trap_in_a_file_reads_well() -> None:
    (diagnostic,) = parse("systems: [exact]\nfreeze: no  # 😀\n", "a.yaml").diagnostics
    assert diagnostic_text(diagnostic).splitlines() == [
        "a.yaml:2:9: SD009 'no' is read as false by some YAML parsers, and as text by others",
        "    2 | freeze: no  # 😀",
        "      |         ^^",
        "      = write false, or quote it if it is text",
    ]


def test_a_missing_file_reads_well(tmp_path: Path) -> None:
    (diagnostic,) = load(tmp_path / "a.yaml").diagnostics
    assert "a.yaml:1:1: SD001 cannot read the file: No such file or directory\n      = check" in diagnostic_text(
        diagnostic
    )
