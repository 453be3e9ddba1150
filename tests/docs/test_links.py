"""A page begins with its purpose, and every link to another file of the project leads to one."""

import re
from pathlib import Path

import pytest

from tests.docs.pages import PAGES
from tests.paths import ROOT

LINK = re.compile(r"\]\((?!https?:|mailto:)([^)#\s]*)(?:#([^)\s]*))?\)")
# Modules, tests and rooms by their path.
CODE = re.compile(r"(?<![\w/.])((?:stability|stackdsl|tests|benchmarks)/(?:[\w/]*/|[\w/]+\.(?:py|json|yaml)))(?![\w<])")


def headings(page: Path) -> set[str]:
    """As they are linked to."""
    found = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in found}


@pytest.mark.parametrize(
    "page",
    [*PAGES, ROOT / "SECURITY.md", ROOT / "stackdsl" / "diagnostics.md"],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_a_page_says_in_a_sentence_what_it_is_for_before_anything_else(page: Path) -> None:
    first = page.read_text(encoding="utf-8").split("\n\n")[1]
    assert first.rstrip().endswith((".", ":")), "a paragraph comes before tables, code and further headings"
    assert first[0].isalpha() or first[0] in "`*["


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    lost = []
    for target, heading in LINK.findall(page.read_text(encoding="utf-8")):
        to = (page.parent / target).resolve() if target else page
        if not to.exists() or (heading and heading not in headings(to)):
            lost.append(f"{target}#{heading}")
    assert lost == []


def test_the_index_names_every_page() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {page.name for page in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert {name for name in pages if f"({name})" not in index} == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_paths_of_code_lead_somewhere(page: Path) -> None:
    named = CODE.findall(page.read_text(encoding="utf-8"))
    assert [path for path in named if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("room", ["stability", "stackdsl", "tests", "benchmarks"])
def test_paths_that_comments_name_lead_somewhere(room: str) -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / room).rglob("*.py")}
    lost = {
        path: [named for named in CODE.findall(text) if not (ROOT / named).exists()] for path, text in texts.items()
    }
    assert {path.name: named for path, named in lost.items() if named} == {}
