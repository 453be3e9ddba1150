"""Makes untrusted text safe to show: on a terminal, in a report, in the log of a workflow."""

import re
from typing import Final

# Characters of bidirectional control or zero width, which make a line look different from its content.
UNSEEN: Final = (
    "\xad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b\u200e\u200f\u202a-\u202e\u2060-\u206f\u3164\uffa0"
    "\ufff0-\ufffb\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff"
)
# Joiners and variation selectors. Persian, Hindi and emoji need them; after an ASCII character nothing does.
JOINERS: Final = "\u200c\u200d\ufe00-\ufe0f"
# Control characters except tabs and line breaks, and invisible characters. They can come in by an escape such as "\\e",
# and a terminal may obey them.
COMMANDING = re.compile(f"[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029{UNSEEN}]|(?<![^\x00-\x7f])[{JOINERS}]")

# The same in a text of many lines, which may end in CRLF as in CSV; also byte order marks and lone surrogates, which no
# valid file holds.
_IN_LINES = re.compile(f"\r(?!\n)|(?!\r){COMMANDING.pattern}|[\ufeff\ud800-\udfff]")
# The runner of GitHub also reads commands after leading blanks.
_COMMAND: Final = re.compile(r"(^\s*)::", re.MULTILINE)


def visible(text: str) -> str:
    """Escape every unprintable character of a text, such as the name of a file."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def harmless(text: str) -> str:
    """Escape bidirectional marks, control characters and lone surrogates of a text of many lines."""
    if text.isascii() and not _IN_LINES.search(text):
        return text
    return _IN_LINES.sub(lambda match: visible(match.group()), text)


def without_commands(text: str) -> str:
    """Break workflow commands of GitHub in a text; its runner obeys those in all output of a workflow."""
    return _COMMAND.sub(r"\1./::", text).replace("##[", "# #[")


def data_without_commands(text: str, form: str) -> str:
    """Break workflow commands in data by the escapes of its format, so that the data stay the same.

    CSV has no escapes: its writers never begin a row like a command. Output for GitHub has its own commands.
    """
    if form == "json":
        return text.replace("##[", r"\u0023#[")  # `##[` can only be within a string, and a string is one line
    if form == "junit":
        return _COMMAND.sub(r"\1&#58;:", text).replace("##[", "&#35;#[")
    return text
