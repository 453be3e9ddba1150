"""The characters that may stand in a scenario: those that every YAML version and both parsers see alike."""

import re
import unicodedata
from collections.abc import Iterator
from functools import cache
from typing import Final

from stackdsl.diagnostics import Diagnostic, Page, Span
from stackdsl.disk import visible

# What turns the direction of text, or takes no room: with it a line reads otherwise than it is.
UNSEEN: Final = (
    "\xad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b\u200e\u200f\u202a-\u202e\u2060-\u206f\u3164\uffa0"
    "\ufff0-\ufffb\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff"
)
# Joiners and variation selectors, which Persian, Hindi and emoji need; behind ASCII nobody does.
JOINERS: Final = "\u200c\u200d\ufe00-\ufe0f"
# What a terminal obeys or an eye cannot see, if it came in by an escape such as "\\e": control characters but for tabs
# and line breaks, and what is unseen.
COMMANDING = re.compile(f"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029{UNSEEN}]|(?<![^\x00-\x7f])[{JOINERS}]")

# The same in a text of many lines, which may end as those of CSV do; besides, byte order marks, and halves of
# characters, which no file holds.
_IN_LINES = re.compile(f"\r(?!\n)|(?!\r){COMMANDING.pattern}|[\ufeff\ud800-\udfff]")

UNSEEN_PATTERN = re.compile(f"[{UNSEEN}{JOINERS}]")


def commanding_character(text: str) -> str:
    """The name of the first character of a value that a terminal would obey; empty if there is none."""
    found = COMMANDING.search(text)
    return _name(found.group()) if found else ""


def harmless(text: str) -> str:
    """A text of many lines, such as a report, in which nothing turns the text, steers a terminal or has no UTF-8."""
    if text.isascii() and not _IN_LINES.search(text):
        return text
    return _IN_LINES.sub(lambda found: visible(found.group()), text)


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
