"""Decisions are a page each, and the index tells the status of every one."""

import re
from pathlib import Path

import pytest

from tests.paths import ROOT

FOLDER = ROOT / "docs" / "decisions"
DECISIONS = sorted(FOLDER.glob("0*.md"))
INDEX = (FOLDER / "README.md").read_text(encoding="utf-8")
LINES = 66  # of a page


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_a_decision_is_one_page(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= LINES, "move what was measured to docs/measurements"
    assert text.startswith(f"# {page.name[:4]} ")


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.stem)
def test_the_index_tells_the_status_of_every_decision(page: Path) -> None:
    row = re.search(rf"^\| \[{page.name[:4]}\]\({page.name}\) \| ([^|]+) \| ([^|]+) \|$", INDEX, re.MULTILINE)
    assert row is not None, "docs/decisions/README.md has no row for it"
    assert row[1] in page.read_text(encoding="utf-8").splitlines()[0]
    assert re.match(r"accepted|superseded", row[2])


def test_numbers_are_used_once() -> None:
    numbers = [page.name[:4] for page in DECISIONS]
    assert len(numbers) == len(set(numbers))
