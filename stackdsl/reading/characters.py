"""The characters that may stand in a scenario: those that every YAML version and both parsers see alike."""

import re
import unicodedata
from collections.abc import Iterator
from functools import cache

from stackdsl.diagnostics import Diagnostic, Page, Span
from stackdsl.shown_text import COMMANDING, JOINERS, UNSEEN

UNSEEN_PATTERN = re.compile(f"[{UNSEEN}{JOINERS}]")


def commanding_character(text: str) -> str:
    """The name of the first character of a value that a terminal would obey; empty if there is none."""
    found = COMMANDING.search(text)
    return _name(found.group()) if found else ""


def unreadable_characters(page: Page) -> Iterator[Diagnostic]:
    """The first character of each line that cannot stand in a scenario."""
    for line, text in enumerate(page.lines):
        if text.isascii() and text.isprintable():  # as most are; the pattern takes long to make
            continue
        if found := _unreadable_pattern().search(text):
            yield _unreadable(found.group(), page.span(line, found.start()))


@cache
def _unreadable_pattern() -> re.Pattern[str]:
    # Control characters and surrogates, as YAML demands; besides, what YAML versions or the two parsers see
    # differently: tabs, NEL, LS and PS (line breaks in YAML 1.1, text in 1.2), a byte order mark inside the text.
    unlike = "[^\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
    return re.compile(f"{unlike}|[{UNSEEN}]|(?<![^\x00-\x7f])[{JOINERS}]")


def _unreadable(character: str, span: Span) -> Diagnostic:
    if character == "\t":
        return Diagnostic("SD004", span, "a tab", "use spaces; in a double-quoted text, write \\t")
    if UNSEEN_PATTERN.fullmatch(character):
        message = f"the character {_name(character)} is not seen, or lets the line read otherwise than it is"
        return Diagnostic("SD004", span, message, "delete it")
    return Diagnostic("SD004", span, f"the character {_name(character)} cannot stand in a scenario", "delete it")


def _name(character: str) -> str:
    return f"U+{ord(character):04X} {unicodedata.name(character, '')}".rstrip()
