"""The characters that may stand in a scenario: those that every YAML version and both parsers see alike."""

import re
import unicodedata
from collections.abc import Iterator

from stackdsl.diagnostics import Diagnostic, Page, Span

# Control characters and surrogates, as YAML demands; besides, what YAML versions or the two parsers see differently:
# tabs, NEL, LS and PS (line breaks in YAML 1.1, text in 1.2), a byte order mark inside the text.
UNREADABLE = re.compile("[^\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]")


def unreadable_characters(page: Page) -> Iterator[Diagnostic]:
    """The first character of each line that cannot stand in a scenario."""
    for line, text in enumerate(page.lines):
        if found := UNREADABLE.search(text):
            yield _unreadable(found.group(), page.span(line, found.start()))


def _unreadable(character: str, span: Span) -> Diagnostic:
    if character == "\t":
        return Diagnostic("SD004", span, "a tab", "use spaces; in a double-quoted text, write \\t")
    name = f"U+{ord(character):04X} {unicodedata.name(character, '')}".rstrip()
    return Diagnostic("SD004", span, f"the character {name} cannot stand in a scenario", "delete it")
