"""Diagnostics as text: position, message, source line, remedy; and the meaning of each code."""

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span

# A diagnostic as plain text: position, message, source line with a caret, remedy.


TAB: Final = "    "
GUTTER: Final = 5  # [columns] for the line number; files of 99,999 lines align


def diagnostic_text(diagnostic: Diagnostic) -> str:
    """Return a diagnostic as lines of text without a final newline."""
    where = f" ({diagnostic.span.where})" if diagnostic.span.where else ""
    key = f"`{diagnostic.span.key}`: " if diagnostic.span.key else ""
    head = f"{diagnostic.span}: {diagnostic.code} {key}{diagnostic.message}{where}"
    excerpt = _excerpt_lines(diagnostic.span) if _visible(diagnostic.span.excerpt).strip() else []
    hint = [f"{'':{GUTTER}} = {diagnostic.hint}"] if diagnostic.hint else []
    return "\n".join((_visible(head), *excerpt, *map(_visible, hint)))


def _excerpt_lines(span: Span) -> list[str]:
    start = span.column - span.excerpt_column
    marked = span.excerpt[start : start + span.end_column - span.column]
    indent = " " * _width(span.excerpt[:start])
    carets = "^" * max(1, _width(marked))
    return [f"{span.line:>{GUTTER}} | {_visible(span.excerpt)}", f"{'':{GUTTER}} | {indent}{carets}"]


def _visible(text: str) -> str:
    """Return text with expanded tabs and visible control characters."""
    spread = text.replace("\t", TAB).replace("\n", " ")
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in spread)


def _width(text: str) -> int:
    """Return the number of terminal columns of a text."""
    return sum(_character_width(character) for character in _visible(text))


def _character_width(character: str) -> int:
    if unicodedata.combining(character) or unicodedata.category(character) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in ("W", "F") else 1


# The entry of a diagnostic code in `diagnostics.md`: meaning, an example that causes it, remedy.


CODE: Final = re.compile(r"SD\d{3}")

_ENTRY = re.compile(r"^## (?P<code>SD\d{3}): (?P<title>.+)\n(?P<body>(?:(?!^## ).*\n)*)", re.MULTILINE)
_EXAMPLE = re.compile(r"(?:<!-- .*? -->\n)?```yaml\n(?P<text>.*?)```\n", re.DOTALL)
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_INDENT = "    "


@dataclass(frozen=True, slots=True)
class CodeEntry:
    """The entry of a diagnostic code."""

    code: str
    title: str
    body: str  # Markdown

    @property
    def example(self) -> str | None:
        """Return a scenario with this mistake; None if no short one has it."""
        found = _EXAMPLE.search(self.body)
        return found["text"] if found else None


def entries() -> Mapping[str, CodeEntry]:
    """Return all codes in the order of the page."""
    page = files("stackdsl").joinpath("diagnostics.md").read_text(encoding="utf-8")
    return {found["code"]: CodeEntry(found["code"], found["title"], found["body"].strip()) for found in _each(page)}


def _each(page: str) -> Iterator[re.Match[str]]:
    return _ENTRY.finditer(page if page.endswith("\n") else f"{page}\n")


def code_text(entry: CodeEntry) -> str:
    """Return an entry for a terminal, without Markdown, with its example indented."""
    plain = _EXAMPLE.sub(lambda found: _set_in(found["text"]), entry.body)
    plain = _LINK.sub(r"\1", plain).replace("**", "")
    return f"{entry.code}: {entry.title}\n\n{plain}\n"


def _set_in(text: str) -> str:
    return "".join(f"{_INDENT}{line}\n" if line else "\n" for line in text.splitlines())
