"""Completion, hover and diagnostics in editors: yaml-language-server with the published schema."""

from collections.abc import Iterator

import pytest

from stackdsl.language.json_schema import schema_text
from tests.paths import ROOT
from tests.stackdsl.language.language_server import AT_HAND, LanguageServer, serving

HEAD = "# yaml-language-server: $schema=scenario.schema.json\n"

pytestmark = pytest.mark.skipif(not AT_HAND, reason="yaml-language-server is not installed: make editor")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LanguageServer]:
    """One server for all tests, as in an editor."""
    folder = tmp_path_factory.mktemp("edited")
    (folder / "scenario.schema.json").write_text(schema_text(), encoding="utf-8")
    with serving(folder) as running:
        yield running


@pytest.mark.parametrize("path", ["columns.yaml", "jenga.yaml", "capabilities/card-house.yaml", "hard/turned.yaml"])
def test_editor_accepts_all_scenarios(path: str, server: LanguageServer) -> None:
    text = (ROOT / "scenarios" / path).read_text(encoding="utf-8").split("\n---\n")[0]
    body = "".join(line for line in text.splitlines(keepends=True) if "yaml-language-server" not in line)
    server.open(HEAD + body)
    assert server.mistakes == []


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        ("sce", {"scenario"}),
        ("scenario: a\nbuild:\n  - ", {"column", "four_stack", "bricks", "every"}),
        ("scenario: a\nbuild:\n  - column: {levels: 2}\nimpacts:\n  - ", {"throw", "push", "drop", "remove"}),
        ("scenario: a\nbuild:\n  - column: {levels: 2}\nexpect:\n  - ", {"stands", "collapses", "margin"}),
        ("scenario: a\nbuild:\n  - column:\n      ", {"levels", "step", "origin", "heading"}),
        ("scenario: a\nbuild:\n  - column: {levels: 2}\nsystems: [", {"exact", "thesis"}),
        ("scenario: a\nbrick: ", {"kapla", "kapla-ideal"}),
    ],
)
def test_editor_completes_keys_and_values(text: str, offered: set[str], server: LanguageServer) -> None:
    server.open(HEAD + text)
    lines = (HEAD + text).split("\n")
    assert offered <= server.completions(len(lines) - 1, len(lines[-1]))


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("scenario: a\nbuild:\n  - column: {levls: 2}\n", "levls"),
        ("scenario: a\nbuild:\n  - column: {levels: 2, origin: [0 mm, 0 mm]}\n", "3"),
        ("scenario: a\nbuild:\n  - column: {levels: 2, origin: [0 mm, 0 mm, 7]}\n", "write a length with its unit"),
        ("scenario: a\nbuild:\n  - column: {levels: 2, step: 5}\n", "write a length with its unit"),
    ],
)
def test_editor_marks_a_mistake(wrong: str, told: str, server: LanguageServer) -> None:
    server.open(HEAD + wrong)
    assert any(told in mistake["message"] for mistake in server.mistakes or ())


def test_editor_shows_the_description_of_a_key(server: LanguageServer) -> None:
    server.open(HEAD + "scenario: a\nfriction: 0.4\nbuild:\n  - column: {levels: 2}\n")
    assert "Coulomb friction coefficient between bricks" in server.hover(2, 3)
