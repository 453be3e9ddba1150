"""Control characters in a file do not reach the terminal."""

import json
import re
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


HOSTILE = "\x1b[2Jgone\nok\n::error::forged\u202e"


def test_no_report_prints_what_a_golden_file_would_have_it_print(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "s/good.yaml")
    assert stackdsl("check", "s").code == 0
    golden = tmp_path / "golden" / "good" / "exact.json"
    for key in ('"stands"', '"L1.1"', '"stackdsl": '):
        assert key in golden.read_text()
    text = golden.read_text().replace('"stands"', json.dumps(HOSTILE)).replace('"L1.1"', json.dumps(HOSTILE))
    golden.write_text(re.sub(r'"stackdsl": "[^"]*"', lambda _: f'"stackdsl": {json.dumps(HOSTILE)}', text))
    write(tmp_path, '{"format": 1}', "golden/x\x1b[2J\n::error::y/exact.json")
    forms = ("text", "github", "markdown", "junit")
    for told in (*(stackdsl("check", "s", "--format", form).out for form in forms), stackdsl("golden", "review").out):
        assert "gone" in told
        assert "\x1b[2J" not in told
        assert "\u202e" not in told
        assert not any(line.startswith(("ok", "::error::forged", "::error::y")) for line in told.splitlines())
    stackdsl("check", "s", "--html", "pages")
    page = (tmp_path / "pages" / "index.html").read_text()
    assert "gone" in page
    assert not {"\x1b", "\u202e"} & set(page)
