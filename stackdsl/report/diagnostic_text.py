"""A diagnostic as plain text: where, what, the line with a caret, and the remedy."""

import unicodedata
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span

TAB: Final = "    "
GUTTER: Final = 5  # [columns] for the line number; files of 99,999 lines align


def diagnostic_text(diagnostic: Diagnostic) -> str:
    """Several lines of text without a newline at the end."""
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
    """The text with tabs spread out, and with marks for characters that would steer the terminal."""
    spread = text.replace("\t", TAB).replace("\n", " ")
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in spread)


def _width(text: str) -> int:
    """Columns that the text takes on a terminal."""
    return sum(_character_width(character) for character in _visible(text))


def _character_width(character: str) -> int:
    if unicodedata.combining(character) or unicodedata.category(character) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in ("W", "F") else 1
