"""What is wrong with a scenario, as values: code, place, cause, remedy.

Nothing here raises or prints. Every stage of the pipeline returns its diagnostics, and all of them are shown at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches

CODES = {
    "SD001": "the file cannot be read",
    "SD002": "the file is not UTF-8 text",
    "SD003": "a key is written twice",
    "SD004": "the YAML is malformed",
    "SD005": "there is no scenario in the file",
    "SD006": "the file is too large",
    "SD007": "the YAML is nested too deeply",
    "SD008": "aliases expand to too many values",
    "SD009": "a plain value that YAML versions read differently",
    "SD010": "a YAML feature that scenarios do without (tags, merge keys, complex keys)",
    "SD101": "unknown key",
    "SD102": "missing key",
    "SD103": "wrong type of value",
    "SD104": "value out of range or not one of the choices",
    "SD105": "a number without its unit",
    "SD106": "a unit of the wrong dimension, or an unknown one",
    "SD107": "malformed tolerance",
    "SD108": "exactly one of several keys is needed",
    "SD109": "malformed or failing expression",
    "SD110": "malformed anchor (a time tied to an event)",
    "SD201": "a brick is placed inside another body",
    "SD202": "a brick is placed in the air",
    "SD203": "two bricks or two scenarios share a name",
    "SD204": "unknown brick",
    "SD205": "unknown level or event",
    "SD206": "the scenario is too large",
}


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of a file. Lines and columns count from 1; `end_column` is exclusive."""

    file: str
    line: int
    column: int
    end_column: int
    excerpt: str = ""  # the text of the line, for the caret

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One mistake: what is wrong (`message`), and what to do about it (`hint`)."""

    code: str  # a key of CODES
    span: Span
    message: str
    hint: str = ""


def did_you_mean(word: str, choices: Sequence[str]) -> str:
    """A hint that names the closest choice, or else all of them if they are few."""
    close = get_close_matches(word, choices, n=1, cutoff=0.6)
    if close:
        return f"did you mean '{close[0]}'?"
    return f"choose from: {', '.join(choices)}" if 0 < len(choices) <= 16 else ""  # noqa: PLR2004 -- what fits a line
