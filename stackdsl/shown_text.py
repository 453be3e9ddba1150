"""Makes texts that others wrote safe to show: on a terminal, in a report, in the log of a workflow."""

import re
from typing import Final

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
# Also behind blanks, as the runner of GitHub reads lines.
_COMMAND: Final = re.compile(r"(^\s*)::", re.MULTILINE)


def visible(text: str) -> str:
    """A text, such as the name of a file, with every character escaped that cannot be printed."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def harmless(text: str) -> str:
    """A text of many lines with bidirectional marks, control characters and halves of characters escaped."""
    if text.isascii() and not _IN_LINES.search(text):
        return text
    return _IN_LINES.sub(lambda found: visible(found.group()), text)


def without_commands(text: str) -> str:
    """A text in which GitHub finds no workflow command; it obeys those in whatever a workflow prints."""
    return _COMMAND.sub(r"\1./::", text).replace("##[", "# #[")


def data_without_commands(text: str, form: str) -> str:
    """The same of data, with characters escaped as the format does, so that it says what it said.

    CSV has no escapes: its writers let no row begin as a command. What is written for GitHub has commands of its own.
    """
    if form == "json":
        return text.replace("##[", r"\u0023#[")  # which only strings can hold, and those are in one line
    if form == "junit":
        return _COMMAND.sub(r"\1&#58;:", text).replace("##[", "&#35;#[")
    return text
