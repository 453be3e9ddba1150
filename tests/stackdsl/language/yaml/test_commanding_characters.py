"""Control characters in a file do not reach the terminal."""

from pathlib import Path

import pytest

from stackdsl.language.yaml.source import load, parse
from tests.command_line import GOOD, Stackdsl, write

ESCAPED = [
    r"\e[31mred",
    r"\x1b]0;title\a",
    r"\a",
    r"\b",
    r"\r",
    r"\0",
    r"\x9b31m",
    r"\u202e",
    r"\u2066",
    r"\L",
    r"\u200f",
    r"\u200b",
]


@pytest.mark.parametrize("escaped", ESCAPED)
def test_control_characters_in_escapes_are_rejected(escaped: str) -> None:
    (mistake,) = parse(f'scenario: good\ndescription: "it is {escaped}"\n', "a.yaml").diagnostics
    assert (mistake.code, mistake.span.line, mistake.span.column) == ("SD004", 2, 14)
    assert "control character" in mistake.message
    assert mistake.hint


def test_a_control_character_in_a_key_is_refused() -> None:
    (mistake,) = parse('scenario: good\n"\\e[2J": 1\n', "a.yaml").diagnostics
    assert (mistake.code, mistake.span.line, mistake.span.column) == ("SD004", 2, 1)


def test_tabs_and_line_breaks_are_text() -> None:
    (source,) = parse('scenario: good\ndescription: "two\\tcolumns\\nand lines"\n', "a.yaml").sources
    assert source.values["description"] == "two\tcolumns\nand lines"


def test_the_name_of_a_file_is_shown_with_its_control_characters_escaped(tmp_path: Path) -> None:
    path = write(tmp_path, "scenario: [", "\x1b[31mred.yaml")
    (mistake,) = load(path).diagnostics
    assert "\x1b" not in mistake.span.file
    assert mistake.span.file.endswith(r"\x1b[31mred.yaml")


def test_no_command_prints_an_escape_of_a_file_name(stackdsl: Stackdsl, tmp_path: Path) -> None:
    path = write(tmp_path, GOOD, "\x1b[31mred.yaml")
    for command in ("run", "explain", "check"):
        result = stackdsl(command, path.name)
        assert "\x1b" not in result.out + result.err
