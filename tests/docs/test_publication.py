"""The page that goes through the publication leaves nothing out, and names only what is there."""

import re
from functools import cache
from itertools import chain

import pytest
from stackdsl_sapien import SAPIEN_THESIS

from stackdsl.language.bricks import CATALOGUE
from stackdsl.simulation.known_systems import KNOWN
from tests.paths import ROOT
from tests.test_scenarios import GATHERED

PAGE = ROOT / "docs" / "publication.md"
ROW = re.compile(r"^\| (?!where \|)(.+) \|$", re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")
PATH = re.compile(r"[\w.-]+(?:/[\w.-]+)+/?(?:::\w+)?")  # with a test of a module, if one is named
SCENARIO = re.compile(r"[a-z]+(?:-[a-z0-9]+)+")
NO_SCENARIOS = {*KNOWN, SAPIEN_THESIS.name, *CATALOGUE}  # systems and bricks, some of which are called like scenarios
ABSENT = "not carried out, because "

# What the publication is made of.
SECTIONS = (
    *("1", "1.1", "1.2", "1.3", "1.4", "2.1", "2.2", "3.1", "3.2"),
    *("3.3", "3.3.1", "3.3.2", "3.3.3", "3.3.4", "3.3.5", "3.3.6", "3.3.7"),
    *("3.4", "3.4.1", "3.4.2", "3.4.3", "3.5", "3.6", "3.6.1", "3.6.2"),
    *("4.1", "4.2", "4.3", "5.1", "5.2", "5.3", "6", "6.1", "7", "8"),
)
FIGURES = range(1, 15)
EQUATIONS = range(1, 14)


@cache
def rows() -> list[list[str]]:
    """The cells of every row, of all tables of the page."""
    return [found.split(" | ") for found in ROW.findall(PAGE.read_text(encoding="utf-8"))]


def named(kind: str) -> set[str]:
    """The numbers of the sections, figures or equations that have a row."""
    cells = (cells[0].removeprefix(f"{kind} ") for cells in rows() if cells[0].startswith(f"{kind} "))
    return set(chain.from_iterable(cell.split(", ") for cell in cells))


@pytest.mark.parametrize(("kind", "numbers"), [("section", SECTIONS), ("Fig.", FIGURES), ("Eq.", EQUATIONS)])
def test_every_section_figure_and_equation_has_a_row(kind: str, numbers: tuple[str, ...] | range) -> None:
    assert named(kind) == {str(number) for number in numbers}


def test_every_row_says_what_is_published_where_it_is_played_and_what_comes_out() -> None:
    assert [cells for cells in rows() if len(cells) != 4 or not all(cell.strip() for cell in cells)] == []


def test_every_row_names_a_path_or_says_why_there_is_none() -> None:
    where = [cells[2] for cells in rows()]
    assert [cell for cell in where if not cell.startswith(ABSENT) and not re.match(r"`[\w/.-]+(?:::\w+)?`", cell)] == []


def test_what_is_named_is_there() -> None:
    lost = []
    for name in CODE.findall(re.sub(r"<!--.*?-->", "", PAGE.read_text(encoding="utf-8"))):
        if PATH.fullmatch(name) and not is_there(name):
            lost.append(name)
        if SCENARIO.fullmatch(name) and name not in scenarios() | NO_SCENARIOS:
            lost.append(name)
    assert lost == []


def is_there(name: str) -> bool:
    path, _, test = name.partition("::")
    file = ROOT / path
    return file.exists() and (not test or f"def {test}(" in file.read_text(encoding="utf-8"))


@cache
def scenarios() -> set[str]:
    return {case.scenario.scenario for case in GATHERED.cases}
