"""Figures of README and docs are those of the data that benchmarks wrote."""

import re
from pathlib import Path

import pytest

from benchmarks.figures.columns import Column, Table
from benchmarks.figures.data import Data, load, save
from benchmarks.figures.forms import written
from benchmarks.figures.markdown import FIGURE, TABLE, rendered, table_text
from benchmarks.figures.pages import pages
from benchmarks.figures.tables import TABLES
from tests.paths import ROOT

# Tables with numbers in them that nobody measured: a comment before the table says what they are.
OTHER = re.compile(r"<!-- not measured: [^>]+-->\n(?:\|[^\n]*\n)+")
MARKED = re.compile(r"<!-- figure: [^>]+ -->[^<]*<!-- end -->")
MARKDOWN_TABLE = re.compile(r"(?:^\|[^\n]*\n)+", re.MULTILINE)
FIGURE_CELL = re.compile(r"\|\s*(?:about |up to |[<>≤≥±+-])?\s*\d")  # a cell that begins with a number
CODE = re.compile(r"`[^`\n]*`|```.*?```|\[[^\]]*\]\([^)]*\)", re.DOTALL)

DATA = Data("creep", "python -m creep", {"systems": {"a b": {"drift_mm": 0.1536, "steps": 51840, "none": None}}})


@pytest.mark.parametrize("page", list(pages()), ids=lambda page: str(page.relative_to(ROOT)))
def test_the_figures_of_a_page_are_those_that_were_measured(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert rendered(text) == text, "write them anew with `python -m benchmarks.figures`"


def unmarked(text: str) -> list[str]:
    """The tables with numbers that come neither from data nor say what they are."""
    left = OTHER.sub("", TABLE.sub("", text))
    tables = MARKDOWN_TABLE.findall(CODE.sub("", MARKED.sub("", left)))
    return [table for table in tables if FIGURE_CELL.search(table)]


@pytest.mark.parametrize("page", list(pages()), ids=lambda page: str(page.relative_to(ROOT)))
def test_no_table_of_figures_is_written_by_hand(page: Path) -> None:
    assert unmarked(page.read_text(encoding="utf-8")) == []


def test_every_table_is_shown_somewhere_and_every_file_of_data_is_used() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in pages())
    assert {found["name"] for found in TABLE.finditer(text)} == set(TABLES)
    used = {found["path"].split("/")[0] for found in FIGURE.finditer(text)} | {t.data for t in TABLES.values()}
    assert {path.stem for path in (ROOT / "docs" / "data").glob("*.json")} == used


def test_a_figure_that_is_out_of_date_is_written_anew() -> None:
    text = "creeps <!-- figure: creep/systems/a b/drift_mm sig2 -->0.52<!-- end --> mm"
    assert rendered(text, lambda _: DATA) == text.replace("0.52", "0.15")


def test_the_name_of_a_row_may_have_a_unit_with_a_slash() -> None:
    data = Data("creep", "python -m creep", {"scenes": {"gravity 1 m/s2": {"level": 20}}})
    text = "falls at level <!-- figure: creep/scenes/gravity 1 m/s2/level -->?<!-- end -->"
    assert rendered(text, lambda _: data) == text.replace("?", "20")


def test_a_figure_that_nobody_measured_is_an_error_that_says_which() -> None:
    with pytest.raises(KeyError, match="creep/systems/a b/speed"):
        rendered("<!-- figure: creep/systems/a b/speed -->1<!-- end -->", lambda _: DATA)


def test_a_table_has_a_row_for_each_that_was_measured() -> None:
    table = Table("creep", "systems", (Column("", "{row}"), Column("mm", "{drift_mm:sig2}"), Column("no", "{none}")))
    assert table_text(table, lambda _: DATA) == "|  | mm | no |\n|---|---|---|\n| a b | 0.15 | - |\n"


def test_a_table_of_words_may_tell_numbers_in_passing() -> None:
    assert unmarked("| key | what it does |\n|---|---|\n| `tilt` | up to 90 deg |\n") != []
    assert unmarked("| key | what it does |\n|---|---|\n| `tilt` | it turns the scene, by 90 deg at most |\n") == []


def test_a_table_of_figures_written_by_hand_is_found() -> None:
    table = "| system | mm |\n|---|---|\n| `tuned` | 0.5 |\n"
    assert unmarked(table) == [table.replace("`tuned`", "")]
    assert unmarked(f"<!-- not measured: a closed form -->\n{table}") == []
    assert unmarked(table.replace("0.5", "<!-- figure: creep/systems/a b/drift_mm -->0.5<!-- end -->")) == []


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (0.1536, "sig2", "0.15"),
        (1760.3, "sig2", "1,800"),
        (0.0996, "sig2", "0.10"),
        (8.17e-12, "sig2", "8.2e-12"),
        (0.0, "sig3", "0"),
        (51840, ",", "51,840"),
        (0.1536, ".2f", "0.15"),
        (None, "sig2", "-"),
        ("stands", "", "stands"),
    ],
)
def test_values_are_written_as_people_write_them(value: float | str | None, form: str, text: str) -> None:
    assert written(value, form) == text


def test_data_are_the_same_when_read_again(tmp_path: Path) -> None:
    save(DATA, tmp_path)
    assert load("creep", tmp_path).tables == DATA.tables
