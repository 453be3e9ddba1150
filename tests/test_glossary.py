"""The glossary: in order, each term once, and each where it says that it lives."""

import re

from tests.paths import ROOT

LINES = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").splitlines()
ROWS = [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in LINES if line.startswith("|")][2:]


def test_terms_stand_in_alphabetical_order_each_once() -> None:
    terms = [term.lower() for term, _, _ in ROWS]
    assert len(terms) > 50
    assert terms == sorted(set(terms))


def test_each_term_names_a_module_that_exists() -> None:
    modules = {term: re.fullmatch(r"`([\w/]+\.py)`", module) for term, _, module in ROWS}
    assert [term for term, path in modules.items() if path is None or not (ROOT / path[1]).is_file()] == []
