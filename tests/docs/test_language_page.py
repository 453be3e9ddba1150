"""The reference of the language names every keyword there is."""

import re
from collections.abc import Collection, Iterator

import pytest

from stackdsl.language.claims.claim_kind import CLAIMS
from stackdsl.language.impacts import IMPACTS
from stackdsl.language.json_schema import json_schema
from stackdsl.language.layouts.registry import LAYOUTS
from tests.paths import ROOT

PAGE = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
SCHEMA = json_schema()


def keywords(node: object) -> Iterator[str]:
    """Every key that the schema lets an author write."""
    if isinstance(node, dict):
        yield from node.get("properties", {})
        node = list(node.values())
    if isinstance(node, list):
        for each in node:
            yield from keywords(each)


def test_every_keyword_of_the_schema_is_on_the_page() -> None:
    code = " ".join(re.findall(r"`([^`\n]+)`", PAGE) + re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL))
    written = set(re.findall(r"[a-z_]+", code))
    assert len(set(keywords(SCHEMA))) > 60
    assert set(keywords(SCHEMA)) - written == set()


def test_every_keyword_of_a_scenario_has_a_row_of_its_own() -> None:
    rows = set(re.findall(r"^\| `([a-z_]+)`", PAGE, re.MULTILINE))
    assert set(SCHEMA["properties"]) <= rows
    for part in ("BuildStep", "Impact", "Expectation"):
        assert set(SCHEMA["$defs"][part]["properties"]) <= rows | {"system"}


@pytest.mark.parametrize(("section", "kinds"), [("Layouts", LAYOUTS), ("Impacts", IMPACTS), ("Claims", CLAIMS)])
def test_the_list_at_the_head_names_every_kind(section: str, kinds: Collection[str]) -> None:
    (line,) = re.findall(rf"^- \[{section}\]\(#{section.lower()}\): (.*)$", PAGE, re.MULTILINE)
    assert set(re.findall(r"`([a-z_]+)`", line)) == set(kinds)
