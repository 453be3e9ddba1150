"""The glossary: in order, each term once, and each where it says that it lives."""

import re

import pytest

from tests.paths import ROOT

LINES = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
ROWS = [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in LINES if line.startswith("|")][2:]


def test_terms_stand_in_alphabetical_order_each_once() -> None:
    terms = [term.lower() for term, _, _ in ROWS]
    assert len(terms) > 50
    assert terms == sorted(set(terms))


@pytest.mark.parametrize(("term", "meaning", "module"), ROWS)
def test_a_term_is_one_sentence_and_names_a_module_that_exists(term: str, meaning: str, module: str) -> None:
    assert re.fullmatch(r"[A-Z]?[^.]*(\.\d[^.]*)*\.", meaning), f"{term} is not one sentence"
    path = re.fullmatch(r"`([\w/]+\.py)`", module)
    assert path is not None, f"{term} names no module"
    assert (ROOT / path[1]).is_file(), f"{term} lives in {path[1]}, which is not there"
