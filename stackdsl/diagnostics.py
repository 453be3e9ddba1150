"""Diagnostics of a scenario as values: code, place, cause, remedy.

Nothing here raises or prints. Every stage of the pipeline returns its diagnostics, and all of them are shown at once.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from itertools import islice
from types import MappingProxyType
from typing import Final

MOST_REPORTED: Final = 100  # mistakes of a variant; nobody reads more
MOST_COMPARED: Final = 300  # choices compared with a word: some milliseconds for each of up to a hundred mistakes
NO_SYNONYMS: Final[Mapping[str, str]] = MappingProxyType({})
EXCERPT_WIDTH: Final = 200  # [characters] of a long line that are shown around the column

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
    "SD010": "an unsupported YAML feature (tags, merge keys, complex keys)",
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
    "SD111": "more mistakes than are reported",
    "SD112": "a variable or a kind of brick that is used nowhere",
    "SD113": "a file that cannot be included",
    "SD114": "an imported file that does not match its format",
    "SD115": "an imported file that needs another key to be read",
    "SD201": "a brick is placed inside another body",
    "SD202": "a brick is placed in the air",
    "SD203": "two bricks or two scenarios share a name",
    "SD204": "unknown brick",
    "SD205": "unknown level or event",
    "SD206": "the scenario is too large",
    "SD207": "a thrown, dropped or pushed brick, or a load, misses its target",
    "SD208": "another brick has moved into the place of a brick before it is placed",
    "SD209": "a hand cannot act: its path is blocked, or another hand holds the brick",
    "SD210": "a hand presses bricks together that cannot give way",
    "SD211": "not everything is played with joints or several parts, or judged under loads",
    "SD212": "not everything is played or computed for round bricks",
    "SD213": "not everything is judged for bricks with a strength",
    "SD214": "not everything is judged for tied bricks",
}


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of a file. Lines and columns count from 1; `end_column` is exclusive."""

    file: str
    line: int
    column: int
    end_column: int
    excerpt: str = ""  # the text of the line, for the caret
    excerpt_column: int = 1  # where in the line the excerpt begins: above 1 when a long line is cut
    # The repetition of a repeated item, such as `i = 3`. A mistake is reported once, for the first repetition.
    where: str = field(default="", compare=False)
    key: str = ""  # key of the value, such as `column.step`, where one line of a program holds several values

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"

    @property
    def text(self) -> str:
        """The text of the stretch, as far as the excerpt has it."""
        start = self.column - self.excerpt_column
        return self.excerpt[start : start + self.end_column - self.column]

    def seen_from(self, other: "Span") -> str:
        """Return the place, without the file name if `other` is in the same file, and the repetition."""
        place = f"{self.line}:{self.column}" if self.file == other.file else str(self)
        return f"{place} ({self.where})" if self.where else place


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One mistake: its cause (`message`) and its remedy (`hint`)."""

    code: str  # a key of CODES
    span: Span
    message: str
    hint: str = ""


@dataclass(frozen=True, slots=True)
class ScenarioWarning:
    """A warning and its remedy. It does not fail the scenario."""

    span: Span
    message: str
    hint: str = ""

    def __str__(self) -> str:
        return f"{self.span}: {self.message}{f'; {self.hint}' if self.hint else ''}"


def capped(mistakes: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return at most `MOST_REPORTED` mistakes and, if there are more, SD111. The rest of the iterable is not read."""
    first = list(islice(without_duplicates(mistakes), MOST_REPORTED + 1))
    if len(first) <= MOST_REPORTED:
        return first
    message = f"there are more than {MOST_REPORTED} mistakes; this is the first that is not reported"
    return [*first[:-1], Diagnostic("SD111", first[-1].span, message, "fix the reported ones to see the others")]


def without_duplicates(mistakes: Iterable[Diagnostic]) -> Iterator[Diagnostic]:
    """Yield each mistake once; for repeated items, only the first of one code at one place in the file."""
    reported: set[object] = set()
    for mistake in mistakes:
        span = mistake.span
        key = (mistake.code, span.file, span.line, span.column) if span.where else mistake
        if key not in reported:
            reported.add(key)
            yield mistake


def reading_order(diagnostic: Diagnostic) -> tuple[str, int, int, str, str]:
    """Return the sort key of a diagnostic: place, then code and message."""
    return diagnostic.span.file, diagnostic.span.line, diagnostic.span.column, diagnostic.code, diagnostic.message


@dataclass(frozen=True, slots=True)
class Page:
    """The text of a file, for making spans. Lines and columns count from 0 here, as in parsers."""

    file: str
    text: str
    lines: tuple[str, ...]

    def span(self, line: int, column: int, end_line: int | None = None, end_column: int = 0) -> Span:
        """Return the span from one place to another, cut at the end of the first line; one character without an end."""
        text = self.lines[line]
        one_line = end_line in (None, line)
        end = max(column + 1, end_column if one_line else len(text.rstrip()))
        excerpt, excerpt_column = _excerpt(text, column)
        return Span(self.file, line + 1, column + 1, end + 1, excerpt, excerpt_column)

    def at(self, line: int, column: int) -> str:
        """Return the character at a place; empty at the end of a line."""
        return self.lines[line][column : column + 1]

    def last_visible(self) -> tuple[int, int]:
        """Return the place of the last character that is not a space; the beginning of a blank text."""
        filled = [line for line, text in enumerate(self.lines) if text.strip()]
        return (filled[-1], len(self.lines[filled[-1]].rstrip()) - 1) if filled else (0, 0)

    def ends_before(self, line: int, column: int) -> bool:
        """Return whether only white space stands at this place and after it."""
        return (line, column) > self.last_visible()


def page_of(text: str, file: str) -> Page:
    """Split a text whose lines end in LF, CRLF or CR into a page."""
    return Page(file, text, tuple(re.split("\r\n|\r|\n", text)))


def _excerpt(line: str, column: int) -> tuple[str, int]:
    """Return the line, or the part of a long line around `column`, and the column (from 1) where the part begins."""
    if len(line) <= EXCERPT_WIDTH:
        return line, 1
    start = max(0, min(column - EXCERPT_WIDTH // 2, len(line) - EXCERPT_WIDTH))
    part = line[start : start + EXCERPT_WIDTH]
    left = "…" + part[1:] if start > 0 else part
    return (left[:-1] + "…" if start + EXCERPT_WIDTH < len(line) else left), start + 1


def did_you_mean(word: str, choices: Sequence[str], synonyms: Mapping[str, str] = NO_SYNONYMS) -> str:
    """Return a hint that names the choice of this meaning or the closest one, or else all choices if they are few."""
    if there := _bricks_there(word, choices):
        return there
    if meant := meant_choice(word, choices) or synonyms.get(word.lower(), ""):
        return f"did you mean '{meant}'?"
    return f"choose from: {', '.join(choices)}" if 0 < len(choices) <= 16 else ""  # noqa: PLR2004 -- more do not fit a line


LEVELLED: Final = re.compile(r"(.*\bL)(\d{1,6})\.\d+")  # the name of a brick of a layout
MOST_NAMED: Final = 4  # bricks of a level


def _bricks_there(word: str, choices: Sequence[str]) -> str:
    """Return the bricks of the level that a name of a brick asks for, or of the highest one; empty for other words.

    Such names all look alike, so the closest one is a brick of any level.
    """
    if (asked := LEVELLED.fullmatch(word)) is None:
        return ""
    levels: dict[int, list[str]] = {}
    for choice in choices:
        if (match := LEVELLED.fullmatch(choice)) and match[1] == asked[1]:
            levels.setdefault(int(match[2]), []).append(choice)
    level = min(int(asked[2]), max(levels, default=0))
    if (names := levels.get(level)) is None:
        return ""
    listed = ", ".join(names) if len(names) <= MOST_NAMED else f"{names[0]} to {names[-1]}"
    return f"the highest level is {level} ({listed})" if level < int(asked[2]) else f"level {level} has {listed}"


def meant_choice(word: str, choices: Sequence[str]) -> str:
    """Return the choice that a word may be a slip of; empty if none."""
    by_letters = {choice.lower(): choice for choice in reversed([*_compared(word, choices)])}
    close = get_close_matches(word.lower(), by_letters, n=1, cutoff=0.6)
    return by_letters[close[0]] if close and _is_slip(word.lower(), close[0]) else ""


def unknown_attribute(value: object, name: str, remedies: Mapping[str, str]) -> AttributeError:
    """Return the error for an attribute that a value does not have: the remedy for this name, or the closest name."""
    own = [each for each in dir(type(value)) if not each.startswith("_")]
    remedy = remedies.get(name) or choice_text(name, own)
    return missing_attribute(f"'{type(value).__name__}' object", name, remedy)


def missing_attribute(owner: str, name: str, remedy: str) -> AttributeError:
    """Return the error for an attribute that an object or module does not have."""
    shown = f"; {remedy}" if remedy and not name.startswith("_") else ""
    # With an empty `name`, Python adds no suggestion, which would repeat the remedy.
    return AttributeError(f"{owner} has no attribute '{name}'{shown}", name="", obj=None)


def choice_text(word: str, choices: Sequence[str], synonyms: Mapping[str, str] = NO_SYNONYMS) -> str:
    """Return a hint that names the choice of this meaning or the closest one, or else all choices."""
    return did_you_mean(word, choices, synonyms) or f"choose from: {', '.join(choices)}"


MOST_SLIPS = 0.4  # changed letters of a slip, as a share of the longer word


def _is_slip(word: str, choice: str) -> bool:
    """Return whether a word may be a slip of a choice: few letters differ, or one is the beginning of the other."""
    if word.startswith(choice) or choice.startswith(word):
        return True
    return _distance(word, choice) <= MOST_SLIPS * max(len(word), len(choice))


def _distance(one: str, other: str) -> int:
    """Return the number of letters to insert, remove, replace or swap with the next (Damerau 1964)."""
    before: list[int] = []
    row = list(range(len(other) + 1))
    for at, letter in enumerate(one, start=1):
        above, before, row = before, row, [at]
        for to, wanted in enumerate(other, start=1):
            cost = min(before[to] + 1, row[to - 1] + 1, before[to - 1] + (letter != wanted))
            if at > 1 and to > 1 and letter == other[to - 2] and one[at - 2] == wanted:
                cost = min(cost, above[to - 2] + 1)
            row.append(cost)
    return row[-1]


def _compared(word: str, choices: Sequence[str]) -> Iterable[str]:
    """Return the choices to compare with a word; of very many, those that begin or end like it."""
    if len(choices) <= MOST_COMPARED:
        return choices
    begins, ends = word[:2], word[-2:]
    return islice((choice for choice in choices if choice.startswith(begins) or choice.endswith(ends)), MOST_COMPARED)
