"""Parses YAML into nodes with places, and rejects ambiguous and malformed YAML."""

import re
import shlex
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import islice
from math import isfinite
from typing import Final, TypeAlias

import yaml

from stackdsl.diagnostics import Diagnostic, Page, Span, did_you_mean
from stackdsl.shown_text import COMMANDING, JOINERS, UNSEEN

# Syntax errors: the messages of both parsers, translated into cause, remedy and place.


NO_DIRECTIVES: Final = "YAML directives are not supported"
UNKNOWN_ESCAPE: Final = (
    "the escape sequence is not part of YAML",
    "double the backslash, or put the text in single quotes",
)
# Pattern of the parser's error -> message and hint. In the message, @ is the offending character, # the opening line.
SYNTAX: Final = (
    (
        "mapping values",
        "unexpected ':'; a value cannot contain a second key on this line",
        "quote the text that contains it, or check the indentation",
    ),
    ("any token|parsing a block node", "a value cannot begin with '@'", "quote it"),
    ("quoted scalar.*(end of stream|document)", "the quoted text is not closed", "add the missing quote"),
    ("quoted scalar", *UNKNOWN_ESCAPE),
    ("simple key", "the key has no ':'", "write `key: value`, or check the indentation"),
    (
        "a block mapping:",
        "the line does not continue the mapping that begins in line #",
        "check indentation and quotes",
    ),
    (
        "a block collection:",
        "the line does not continue the list that begins in line #",
        "begin each item with '- ', with the same indentation",
    ),
    ("a flow sequence:", "the list that begins in line # has no ',' or ']' here", "add one of them"),
    ("a flow mapping:", "the mapping that begins in line # has no ',' or '}' here", "add one of them"),
    ("a flow node:", "a value or a closing bracket is missing", "add it, or quote text that contains , [ ] { or }"),
    ("a block scalar", "the text block that begins with '@' is malformed", "quote text that begins with | or >"),
    ("mapping keys", "the '?' has no key", "quote it"),
    ("unexpected ':'", "the ':' in brackets has no key", "quote the text that contains it"),
    ("sequence entries", "a list cannot begin here", "begin it on the next line, or quote the text"),
    ("an alias|an anchor", "the alias or anchor has no name", "quote text that begins with * or &"),
    (
        "expected '?<document start>",
        "unexpected text after the end of a document",
        "begin the next scenario with '---'",
    ),
)
BLAMES_OPENING = re.compile(
    "quoted scalar.*(end of stream|document)|simple key|a block scalar|a directive|an alias|an anchor|a tag:"
)


MERGE_MARKER: Final = re.compile(r"<{7}(?: |$)")  # of an unresolved conflict in git


def syntax_error(page: Page, error: yaml.MarkedYAMLError) -> Diagnostic:
    """Translate a syntax error of the parser."""
    marked = next((number for number, line in enumerate(page.lines) if MERGE_MARKER.match(line)), None)
    if marked is not None:
        message = "the file has an unresolved merge conflict"
        hint = "merge both versions, and delete the lines that begin with <<<<<<<, ======= and >>>>>>>"
        return Diagnostic("SD004", page.span(marked, 0), message, hint)
    description = f"{error.context or ''}: {error.problem or ''}"
    line, column = _blamed(page, error, description)
    span = page.span(line, column)
    if re.search("directive(?!>)|incompatible YAML", description):
        return Diagnostic("SD010", span, NO_DIRECTIVES, "delete the line")
    if re.search("a tag:|tag handle", description):
        return Diagnostic("SD010", span, "YAML tags are not supported", "delete the tag; quote text that begins with !")
    if (special := _typical_slip(page, error, line, column, description)) is not None:
        place, message, hint = special
        return Diagnostic("SD004", page.span(*place), message, hint)
    matches = ((message, hint) for pattern, message, hint in SYNTAX if re.search(pattern, description))
    message, hint = next(matches, (f"invalid YAML: {error.problem}", "check the indentation and the quotes"))
    opening = error.context_mark.line + 1 if error.context_mark else line + 1
    return Diagnostic("SD004", span, message.replace("#", str(opening)).replace("@", page.at(line, column)), hint)


def _blamed(page: Page, error: yaml.MarkedYAMLError, description: str) -> tuple[int, int]:
    """Return the place of a syntax error: the mark of the problem, or the opening if the problem is at the end."""
    problem = (error.problem_mark.line, error.problem_mark.column) if error.problem_mark else (0, 0)
    opening = (error.context_mark.line, error.context_mark.column) if error.context_mark else problem
    is_open = re.search("a flow (mapping|sequence):", description) and problem[0] > opening[0]
    if is_open and BEGINS.match(page.lines[problem[0]]):
        return _end_before(page, problem[0])
    place = opening if BLAMES_OPENING.search(description) or page.ends_before(*problem) else problem
    if page.ends_before(*place):
        return page.last_visible()
    if "quoted scalar" in description:  # libyaml marks the backslash, the pure parser the next character
        return place[0], max(place[1] if place == opening else 0, page.lines[place[0]].rfind("\\", 0, place[1] + 1))
    return place


UNQUOTED: Final = re.compile(r"""(?<![\w"'$])\$\{[^}"']*\}""")  # an expression outside of quotes
QUOTED_LATE: Final = re.compile(r"""[\[{,:]\s+([^\s\[{,:"']+\s*)"(\$\{[^"]*)\"""")  # quotes that begin within a value
VALUE_BEGINS: Final = re.compile(r"[\[{,]\s*|:\s+")
VALUE_GOES_ON: Final = re.compile(r"""(?:\$\{[^}"']*\}|(?!\s#|:\s)[^]},"'])*""")
NO_SPACE: Final = re.compile(r"\s*(?:- )?([\w-]+):([^\s:/].*)")
EQUALS: Final = re.compile(r"\s*(?:- )?([\w-]+\s*)([=;])\s*([^\s=].*)")
ONLY_KEY: Final = re.compile(r"\s*(?:- )?([A-Za-z][\w-]*)\s*")
TEXT_KEYS: Final = ("because", "description", "reason")  # whose values are free text in the schema
TWO_KEYS: Final = re.compile(r"\s*(?:- )?([\w-]+):\s+([\w-]+:\s.*)")
BULLET: Final = re.compile(r"\s*([*•]) ")
COMPARISON: Final = re.compile(r">=?\s*[^\s#][^#]*")
NO_DASH_SPACE: Final = re.compile(r"-([A-Za-z][\w-]*)$")
NO_COLON: Final = re.compile(r"([\w-]+)(:?)\s*([{\[].*)")
KEY_BEFORE: Final = re.compile(r".*?[^\s,{\[]\s+([\w-]+)\s*$")
WIDE_SPACE: Final = re.compile("[\u00a0\u1680\u2000-\u200a\u202f\u205f\u3000]")  # blank, but no separator in YAML
SEPARATES: Final = re.compile(f"^{WIDE_SPACE.pattern}|[:-]{WIDE_SPACE.pattern}")  # where YAML expects a space
SPACE_REMEDY: Final = "replace it by an ordinary space"
TYPOGRAPHIC: Final = re.compile("[\u201c\u201d\u201e\u2018\u2019]")


def _missing_quotes(text: str) -> tuple[int, str, str] | None:
    """Return column, message and whole value, such as `<= ${most}`, of an expression that is not all quoted."""
    if expression := UNQUOTED.search(text):
        begin = max((each.end() for each in VALUE_BEGINS.finditer(text, 0, expression.start())), default=0)
        rest = VALUE_GOES_ON.match(text, expression.end())
        value = text[begin : rest.end() if rest else expression.end()].rstrip()
        return expression.start(), f"{expression[0]} needs quotes in braces or brackets", value
    if late := QUOTED_LATE.search(text):
        return late.start(1), "the quotes begin within the value", f"{late[1]}{late[2]}"
    return None


Slip: TypeAlias = tuple[tuple[int, int], str, str]  # place, message and hint


def _typical_slip(page: Page, error: yaml.MarkedYAMLError, line: int, column: int, description: str) -> Slip | None:
    """Return a slip that the text shows; None for other syntax errors."""
    text = page.lines[line]
    if wide := WIDE_SPACE.search(text):
        return (line, wide.start()), f"{_name(wide[0])} does not count as a space", SPACE_REMEDY
    if quote := TYPOGRAPHIC.search(text):
        return (line, quote.start()), f"{quote[0]} is not a quote of YAML", 'write "'
    if bullet := BULLET.match(text):
        return (line, bullet.start(1)), f"'{bullet[1]}' does not begin an item of a list", "write '- '"
    if "simple key" in description:
        return _slip_of_key(text, line)
    if "mapping values" in description:
        return _slip_of_second_key(page, line, column)
    if "a block scalar" in description and (comparison := COMPARISON.match(text, column)):
        return (line, column), "a value that begins with '>' needs quotes", f'write "{comparison[0].rstrip()}"'
    if re.search("a flow (mapping|sequence):", description):
        return _slip_in_brackets(page, error, line)
    if re.search("a block (mapping|collection):", description):
        return _slip_of_block(page, error, line, column)
    return None


def _slip_of_second_key(page: Page, line: int, column: int) -> Slip | None:
    """Return the slip of a line with a second key, or of one that the line above would have as its value."""
    text = page.lines[line]
    if keys := TWO_KEYS.match(text):
        inner = keys[2].split("#")[0].strip()
        hint = f"write `{keys[1]}: {{{inner}}}`, or quote the value if it is text"
        if keys[1] in TEXT_KEYS:
            quoted = "'{}'".format(inner.replace("'", "''")) if re.search(r'["\\]', inner) else f'"{inner}"'
            hint = f"write `{keys[1]}: {quoted}`"
        return (line, column), "unexpected ':'; a value cannot contain a second key on this line", hint
    key = FIRST_KEY.match(text)
    above = next((number for number in range(line - 1, -1, -1) if page.lines[number].strip()), None)
    if key is None or above is None or key.end(1) != column:
        return None
    item = ITEM.match(page.lines[above])
    before = FIRST_KEY.match(page.lines[above], item.end() if item else 0)
    return _wrong_indentation(line, key, above, before) if before else None


def _wrong_indentation(line: int, key: re.Match[str], above: int, sibling: re.Match[str], more: str = "") -> Slip:
    """Return the slip of a key that is not indented like the key of a line above it."""
    message = f"`{key[1]}` is indented by {_spaces(key.start(1))}, and so belongs to no mapping"
    hint = f"indent it by {_spaces(sibling.start(1))}, like `{sibling[1]}` in line {above + 1}{more}"
    return (line, key.start(1)), message, hint


def _spaces(count: int) -> str:
    return "1 space" if count == 1 else f"{count} spaces"


def _slip_of_key(text: str, line: int) -> Slip | None:
    """Return the slip of a line that has no colon where a key ends."""
    if key := NO_SPACE.match(text):
        return (line, key.end(1)), "a space is missing after ':'", f"write `{key[1]}: {key[2].strip()}`"
    if key := EQUALS.match(text):
        return (line, key.start(2)), f"'{key[2]}' in place of ':'", f"write `{key[1].strip()}: {key[3].strip()}`"
    if set(text.strip()) == {"-"}:
        return (line, 0), "a line between two scenarios has exactly three dashes", "write ---"
    if key := ONLY_KEY.fullmatch(text):
        return (line, key.start(1)), "the key has no ':'", f"write `{key[1]}:`, or check the indentation"
    return None


def _slip_in_brackets(page: Page, error: yaml.MarkedYAMLError, line: int) -> Slip | None:
    """Return the slip in a list or mapping in brackets."""
    text = page.lines[line]
    if quotes := _missing_quotes(text):
        start, message, written = quotes
        return (line, start), message, f'write "{written}"'
    problem = (error.problem_mark.line, error.problem_mark.column) if error.problem_mark else (line, 0)
    if unclosed := _unclosed(page, error, problem):
        return unclosed
    has_colon = problem[0] == line and page.at(*problem) == ":"
    if has_colon and (key := KEY_BEFORE.match(text[: problem[1]])):
        return (line, key.start(1)), f"a ',' is missing before `{key[1]}`", "add it"
    return None


def _unclosed(page: Page, error: yaml.MarkedYAMLError, problem: tuple[int, int]) -> Slip | None:
    """Return the slip of a bracket that is not closed before another one, the next key or item, or the end."""
    opening = (error.context_mark.line, error.context_mark.column) if error.context_mark else problem
    closing = CLOSED_BY.get(page.at(*opening), "")
    if not closing:
        return None
    message = f"the '{page.at(*opening)}' of {opening[0] + 1}:{opening[1] + 1} is not closed"
    found = page.at(*problem)
    if found and found in CLOSED_BY.values() and found != closing:
        return problem, message, f"write '{closing}' in place of '{found}'"
    is_at_end = page.ends_before(*problem)
    if not is_at_end and (problem[0] == opening[0] or not BEGINS.match(page.lines[problem[0]])):
        return None
    end = page.last_visible() if is_at_end else _end_before(page, problem[0])
    line = "" if is_at_end else page.lines[problem[0]]
    if line.count(closing) > line.count(page.at(*opening)):
        return (
            end,
            f"a ',' is missing before `{line.split(':')[0].strip(' -')}`",
            f"write ',' at the end of line {end[0] + 1}",
        )
    return end, message, f"write '{closing}' at the end of line {end[0] + 1}"


CLOSED_BY: Final = {"{": "}", "[": "]"}


def _slip_of_block(page: Page, error: yaml.MarkedYAMLError, line: int, column: int) -> Slip | None:
    """Return the slip of a line that does not continue the list or mapping above it."""
    if page.at(line, column) in set("}]"):
        return (line, column), f"one '{page.at(line, column)}' too many", "remove it"
    dash, opening = ITEM.match(page.lines[line]), error.context_mark
    key = FIRST_KEY.match(page.lines[line], dash.end() if dash else 0)
    if dash and key and opening and "mapping" in str(error.context):
        hint = f"remove the '- ' if `{key[1]}` belongs to that item, or indent the line like the items above"
        return (line, column), f"an item begins inside the item of line {opening.line + 1}", hint
    if key is None or key.start(1) != column or opening is None:
        return None
    of_list = "collection" in str(error.context)
    items = (number for number in range(line - 1, opening.line - 1, -1) if ITEM.match(page.lines[number]))
    above = next(items, opening.line) if of_list else opening.line
    item = ITEM.match(page.lines[above])
    first = FIRST_KEY.match(page.lines[above], item.end() if item else opening.column)
    more = ", or begin an item with '- '" if of_list else ""
    return _wrong_indentation(line, key, above, first, more) if first else None


BEGINS: Final = re.compile(r"\s*(?:- |[\w-]+\s*:(?:\s|$))")  # a line that begins a key or an item
ITEM: Final = re.compile(r"\s*- +")
FIRST_KEY: Final = re.compile(r"\s*([\w-]+)\s*:(?:\s|$)")  # a line, or the rest of one, that begins a key


def _end_before(page: Page, line: int) -> tuple[int, int]:
    """Return the end of the last text before a line: a comma or a bracket is missing there."""
    before = next((number for number in range(line - 1, -1, -1) if page.lines[number].strip()), line)
    return before, max(len(page.lines[before].rstrip()) - 1, 0)


# Plain scalars, of which only unambiguous ones are accepted.
#
# Numbers in the form of JSON, `true` and `false` are values. All others are text, or an error if some YAML version or
# reader takes them for a value (`no`, `012`, `1:30`, an empty value).


Scalar: TypeAlias = bool | int | float | str | None

MAX_EXACT: Final = 2**53  # integers up to this are exact as doubles, and so for every JSON reader
QUOTE_WIDTH: Final = 40  # [characters] of the author's text in a message

KEYS: Final = ("y", "n", "Y", "N", "on")  # accepted as keys, since no scenario has a boolean for a key

INTEGER = re.compile(r"-?(0|[1-9]\d*)", re.ASCII)
FLOAT = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?", re.ASCII)
# A fraction must begin with a dot, so that the pattern matches in only one way: two ways take quadratic time.
LOOSE_NUMBER = re.compile(r"[-+]?(\d[\d_]*(\.[\d_]*)?|\.\d[\d_]*)([eE][-+]?\d+)?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Trap:
    """The ambiguity of a plain scalar, and its remedy."""

    meaning: str
    remedy: str


TRUE = Trap("is read as true by some YAML parsers, and as text by others", "write true, or quote it if it is text")
FALSE = Trap("is read as false by some YAML parsers, and as text by others", "write false, or quote it if it is text")
NULL = Trap("is read as a missing value", "write the value, or remove the key")
NOT_FINITE = Trap("is not a finite number", "write a finite number, or quote it if it is text")
OUT_OF_RANGE = Trap("exceeds the range or precision of numbers", "write fewer digits, or quote it if it is text")
MERGE = Trap("has a special meaning in YAML 1.1", "quote it")
TRAP_WORDS: Final = {
    **dict.fromkeys(("true", "yes", "on", "y"), TRUE),
    **dict.fromkeys(("false", "no", "off", "n"), FALSE),
    **dict.fromkeys(("null", "~", ""), NULL),
    **dict.fromkeys((sign + word for sign in ("", "+", "-") for word in (".inf", "inf", "infinity")), NOT_FINITE),
    **dict.fromkeys((".nan", "nan"), NOT_FINITE),
    **dict.fromkeys(("<<", "="), MERGE),
}
TRAP_SHAPES: Final = (
    (
        re.compile(r"[-+]?0([oO][0-7_]+|[xX][\da-fA-F_]+|[bB][01_]+)", re.ASCII),
        Trap(
            "is read as a number in another base by some YAML parsers", "write it in decimal, or quote it if it is text"
        ),
    ),
    (
        re.compile(r"[-+]?[\d_]+(:\d+)+(\.[\d_]*)?", re.ASCII),
        Trap("is a base-60 number in YAML 1.1", "write a time with its unit, such as 90 s, or quote it if it is text"),
    ),
    (
        re.compile(r"\d{4}-\d\d?-\d\d?(([Tt]|[ \t]+)\d\d?:\d\d(:\d\d)?.*)?", re.ASCII),
        Trap("is read as a date by some YAML parsers", "quote it"),
    ),
)


def plain_value(text: str) -> Scalar | Trap:
    """Return the value of a plain scalar: a number, a boolean, a text, or the trap if it is ambiguous."""
    if text in ("true", "false"):
        return text == "true"
    if FLOAT.fullmatch(text):
        return _number(text)
    if LOOSE_NUMBER.fullmatch(text):
        remedy = f"write {shown(_strict_number(text))}, or quote it if it is text"
        return Trap("is not read as a number by every YAML parser", remedy)
    shaped = (trap for shape, trap in TRAP_SHAPES if shape.fullmatch(text))
    return TRAP_WORDS.get(text.lower()) or next(shaped, text)


def _number(text: str) -> int | float | Trap:
    """Convert the text of a number; return a trap if it loses digits or is out of the range of doubles."""
    if INTEGER.fullmatch(text):
        # Check the length first, since Python does not convert very long integers.
        exact = len(text) <= len(str(-MAX_EXACT)) and abs(int(text)) <= MAX_EXACT
        return int(text) if exact else OUT_OF_RANGE
    value = float(text)
    vanished = value == 0 and re.search("[1-9]", re.split("[eE]", text)[0])
    return OUT_OF_RANGE if vanished or not isfinite(value) else value


def _strict_number(text: str) -> str:
    """Convert a number to the form of JSON: `+012` to 12, `.5` to 0.5, `1_000.` to 1000.0."""
    sign = "-" if text.startswith("-") else ""
    digits = text.lstrip("+-").replace("_", "").lstrip("0")
    whole = digits if digits[:1].isdigit() else f"0{digits}"
    return sign + re.sub(r"\.(?!\d)", ".0", whole)


def key_trap(key: str) -> Trap | None:
    """Return the trap of an ambiguous plain key. `y` and `n` are common variables, and `on` is a key of bricks."""
    value = key if key in KEYS else plain_value(key)
    if isinstance(value, str):
        return None
    meaning = value.meaning if isinstance(value, Trap) else "is not text"
    return Trap(meaning, f'quote it: "{shown(key)}"')


def shown(text: str) -> str:
    """Cut a text to `QUOTE_WIDTH` for a message."""
    return text if len(text) <= QUOTE_WIDTH else text[: QUOTE_WIDTH - 1] + "…"


# Allowed characters: those that every YAML version and both parsers read alike.


UNSEEN_PATTERN = re.compile(f"[{UNSEEN}{JOINERS}]")


def commanding_character(text: str) -> str:
    """Return the name of the first control character of a value; empty if there is none."""
    match = COMMANDING.search(text)
    return _name(match.group()) if match else ""


def unreadable_characters(page: Page) -> Iterator[Diagnostic]:
    """Yield a diagnostic for the first forbidden character of each line."""
    for line, text in enumerate(page.lines):
        if text.isascii() and text.isprintable():  # avoids compiling the pattern for most files
            continue
        if match := _unreadable_pattern().search(text):
            yield _unreadable(match.group(), page.span(line, match.start()), _indentation(page, line))


@cache
def _unreadable_pattern() -> re.Pattern[str]:
    # Control characters and surrogates, which YAML forbids, and characters that YAML versions or the two parsers read
    # differently: tabs, NEL, LS and PS (line breaks in YAML 1.1, text in 1.2), a byte order mark inside the text.
    unlike = "[^\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"
    return re.compile(f"{unlike}|[{UNSEEN}]|(?<![^\x00-\x7f])[{JOINERS}]")


def _indentation(page: Page, line: int) -> str:
    """Return the remedy for a line that begins with a tab, by the line above it; empty for any other line."""
    if not page.lines[line].strip() or "\t" not in page.lines[line][: -len(page.lines[line].lstrip())]:
        return ""
    above = next((number for number in range(line - 1, -1, -1) if page.lines[number].strip()), None)
    if above is None:
        return "remove it"
    text = page.lines[above]
    indentation = len(text) - len(text.lstrip())
    if "\t" in text[:indentation]:
        return "write two spaces in place of each tab"
    item = ITEM.match(text)
    if text.split(" #")[0].rstrip().endswith(":"):
        deeper = (item.end() if item else indentation) + 2
        return f"indent the line with {_spaces(deeper)}, as it belongs to line {above + 1}"
    if item and ITEM.match(page.lines[line].expandtabs()):
        return f"indent the line with {_spaces(indentation)}, like the item in line {above + 1}"
    key = FIRST_KEY.match(text, item.end() if item else 0)
    where = f", like `{key[1]}` in line {above + 1}" if key else ""
    return f"indent the line with {_spaces(key.start(1) if key else indentation)}{where}"


def _unreadable(character: str, span: Span, indentation: str) -> Diagnostic:
    if character == "\t" and indentation:
        return Diagnostic("SD004", span, "tabs are not allowed", indentation)
    if character == "\t":
        return Diagnostic("SD004", span, "tabs are not allowed", "use spaces; in a double-quoted text, write \\t")
    if UNSEEN_PATTERN.fullmatch(character):
        message = f"the character {_name(character)} is invisible, or changes the appearance of the line"
        return Diagnostic("SD004", span, message, "delete it")
    return Diagnostic("SD004", span, f"the character {_name(character)} is not allowed in a scenario", "delete it")


def _name(character: str) -> str:
    return f"U+{ord(character):04X} {unicodedata.name(character, '')}".rstrip()


# Parser events as nodes: the values of one document and their places, with aliases not yet expanded.
#
# Nodes are read from events, not by `yaml.load`, to keep places and to stop at once in a deeply nested file.


MAX_DEPTH: Final = 64  # collections in each other; keeps the recursion below far from Python's limit of 1000 frames
COMMA: Final = "replace the decimal comma by a point, or put a list in brackets"
COMMA_ENDS: Final = "the ',' before this text begins another entry"
MAX_VALUES: Final = 100_000  # written in one file; bounds the memory for spans to some 100 MB
MAX_MISTAKES: Final = 1000  # reported for one file
ANCHORS_COMPARED: Final = 20  # anchors compared with a misspelt alias; all of a hostile file would take minutes

IMPORTED: Final = (".csv", ".obj", ".stl", ".ply", ".urdf", ".xml", ".tsv", ".txt")  # files of other programs
TABLE: Final = re.compile(r"[^,;]*(?:,[^,;]*){3}|[^,;]*(?:;[^,;]*){3}")  # the first four cells of a row
BEGIN: Final = "begin with `scenario: NAME`"
NO_MAPPING: Final = "a scenario must be a mapping of keys to values, but this document is "


@dataclass(frozen=True, slots=True)
class Leaf:
    span: Span
    value: Scalar


@dataclass(frozen=True, slots=True)
class List:
    span: Span
    items: tuple["Node", ...]


@dataclass(frozen=True, slots=True)
class Map:
    span: Span
    entries: tuple[tuple[str, Span, "Node"], ...]


@dataclass(frozen=True, slots=True)
class Alias:
    span: Span
    target: "Node"


Node: TypeAlias = Leaf | List | Map | Alias


class StopReadingError(Exception):
    """Stops reading, after an error or at a limit."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic)
        self.diagnostic = diagnostic


@dataclass(slots=True)
class Reading:
    """State of reading a file: remaining events, anchors, counts, and diagnostics."""

    page: Page
    events: Iterator[yaml.Event]
    diagnostics: list[Diagnostic] = field(default_factory=list)
    ambiguous: list[Diagnostic] = field(default_factory=list)  # words that some YAML parsers read as booleans
    anchors: dict[str, Node | None] = field(default_factory=dict)  # None: its value is not complete yet
    values: int = 0
    aliased: int = 0  # values repeated by aliases

    def report(self, code: str, span: Span, message: str, hint: str = "", *, is_ambiguous: bool = False) -> None:
        """Add a diagnostic; one of an ambiguous word leaves the document valid. Raises StopReadingError at a limit."""
        diagnostic = Diagnostic(code, span, message, hint)
        if len(self.diagnostics) + len(self.ambiguous) >= MAX_MISTAKES - 1:
            raise StopReadingError(diagnostic)
        (self.ambiguous if is_ambiguous else self.diagnostics).append(diagnostic)


def document(reading: Reading, start: yaml.DocumentStartEvent) -> Map | None:
    """Read the mapping of a document; return None if it has a mistake."""
    before = len(reading.diagnostics)
    reading.anchors.clear()
    if reading.page.at(*_start(start)) == "%":
        reading.report("SD010", reading.page.span(*_start(start)), NO_DIRECTIVES, "delete the line")
    root = next(reading.events)
    if isinstance(root, yaml.ScalarEvent) and not root.value and not root.style:
        span = reading.page.span(*_start(start))
        reading.report("SD005", span, "the document is empty", "write a scenario here, or delete the '---'")
        return None
    if isinstance(root, yaml.ScalarEvent) and not root.style and SEPARATES.search(root.value):
        raise StopReadingError(_wide_space(reading, root))
    if isinstance(root, yaml.ScalarEvent):
        hint = "put a space after the colon" if ":" in root.value else BEGIN
        is_table = TABLE.match(root.value) is not None
        if is_table or reading.page.file.lower().endswith(IMPORTED):
            hint = f"convert it first, with `stackdsl import {shlex.quote(reading.page.file)}`"
        kind = "a table" if is_table else "a single value"
        reading.report("SD004", _span(reading.page, root), NO_MAPPING + kind, hint)
        return None
    node = _node(reading, root, 0, None)
    if isinstance(node, List):
        reading.report("SD004", node.span, NO_MAPPING + "a list", BEGIN)
    clean = len(reading.diagnostics) == before
    return node if clean and isinstance(node, Map) else None


# --- places -----------------------------------------------------------------------------------------------------------


def _span(page: Page, start: yaml.Event, end: yaml.Event | None = None) -> Span:
    """Return the span from the start of an event to its end, or to the end of another."""
    return page.span(*_start(start), *_end(end or start))


def _start(event: yaml.Event) -> tuple[int, int]:
    assert event.start_mark is not None  # optional in the stubs only
    return event.start_mark.line, event.start_mark.column


def _end(event: yaml.Event) -> tuple[int, int]:
    assert event.end_mark is not None  # as above
    return event.end_mark.line, event.end_mark.column


# --- values -----------------------------------------------------------------------------------------------------------


def _node(reading: Reading, event: yaml.Event, depth: int, owner: Span | None) -> Node:
    """Read the value that begins with `event`, `depth` collections deep, under the key at `owner`."""
    reading.values += 1
    span = _span(reading.page, event)
    if reading.values > MAX_VALUES:
        message = f"the file contains more than {MAX_VALUES} values"
        raise StopReadingError(Diagnostic("SD006", span, message, "split the file, or use a layout"))
    if isinstance(event, yaml.AliasEvent):
        return _alias(reading, event.anchor or "", span)
    assert isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent)  # no other event begins a value
    _report_tag(reading, event, span)
    if isinstance(event, yaml.MappingStartEvent) and (template := TEMPLATE.match(span.excerpt, _offset(span))):
        hint = f'write "${{{template[1]}}}"'
        raise StopReadingError(Diagnostic("SD004", span, f"{template[0]} is not an expression of scenarios", hint))
    if event.anchor and event.anchor in reading.anchors:
        reading.report("SD010", span, f"the anchor '{shown(event.anchor)}' is defined twice", "use different names")
    if event.anchor:
        reading.anchors[event.anchor] = None
    node = _leaf(reading, event, owner) if isinstance(event, yaml.ScalarEvent) else _nest(reading, event, depth, owner)
    if event.anchor:
        reading.anchors[event.anchor] = node
    return node


TEMPLATE: Final = re.compile(r"\{\{\s*([^{}]*[^{}\s])\s*\}\}")  # an expression of Jinja


def _offset(span: Span) -> int:
    """Return where a span begins in its excerpt."""
    return span.column - span.excerpt_column


def _alias(reading: Reading, name: str, span: Span) -> Node:
    if name not in reading.anchors:
        quoted = shown(name)
        near = [anchor for anchor in islice(reading.anchors, ANCHORS_COMPARED) if len(anchor) <= QUOTE_WIDTH]
        hint = did_you_mean(quoted, near) or f"define it above, as &{quoted}; quote text that begins with *"
        reading.report("SD004", span, f"the alias '{quoted}' has no anchor above it", hint)
        return Leaf(span, None)
    target = reading.anchors[name]
    if target is None:
        message = f"the alias '{shown(name)}' is inside the value that it refers to"
        reading.report("SD008", span, message, "replace the alias by a value")
        return Leaf(span, None)
    return Alias(span, target)


def _report_tag(reading: Reading, event: yaml.ScalarEvent | yaml.CollectionStartEvent, span: Span) -> None:
    if event.tag is not None:
        tag = event.tag.replace("tag:yaml.org,2002:", "!!")
        reading.report(
            "SD010", span, f"the YAML tag '{shown(tag)}' is not supported", "delete it; quote text that begins with !"
        )


def _leaf(reading: Reading, event: yaml.ScalarEvent, owner: Span | None) -> Leaf:
    span = _span(reading.page, event)
    if re.search("[\ud800-\udfff]", event.value):  # the pure parser accepts such escapes
        raise StopReadingError(Diagnostic("SD004", span, *UNKNOWN_ESCAPE))
    if event.style:
        _report_commands(reading, event.value, span)
        _report_swallowed_comparison(reading, event, span)
        return Leaf(span, event.value)
    if SEPARATES.search(event.value):
        raise StopReadingError(_wide_space(reading, event))
    value = plain_value(event.value)
    if not isinstance(value, Trap):
        return Leaf(span, value)
    is_word = value in (TRUE, FALSE)
    if event.value:
        message = f"'{shown(event.value)}' {value.meaning}"
        reading.report("SD009", span, message, value.remedy, is_ambiguous=is_word)
    else:
        _report_missing(reading, event, owner)
    return Leaf(span, event.value if is_word else None)


def _report_commands(reading: Reading, value: str, span: Span) -> None:
    """Reject control characters in escapes, since names and descriptions are shown in terminals."""
    if name := commanding_character(value):
        reading.report("SD004", span, f"an escape sequence encodes the control character {name}", "remove it")


def _wide_space(reading: Reading, event: yaml.ScalarEvent) -> Diagnostic:
    """Return the diagnostic for the first blank of a text that is no space for YAML, such as a no-break space."""
    (line, column), wide = _start(event), WIDE_SPACE.search(event.value)
    assert wide is not None  # the caller has found it
    message = f"{_name(wide[0])} does not count as a space"
    return Diagnostic("SD004", reading.page.span(line, column + wide.start()), message, SPACE_REMEDY)


def _report_missing(reading: Reading, event: yaml.ScalarEvent, owner: Span | None) -> None:
    """Point at the key without a value, or at the dash of an empty item."""
    line, column = _start(event)
    span = owner or reading.page.span(line, max(0, column - 1))
    remedy = _remedy_of_missing(span)
    reading.report("SD009", span, COMMA_ENDS if remedy == COMMA else "a value is missing", remedy)


def _remedy_of_missing(span: Span) -> str:
    """Return the remedy for a missing value, from the text around the place."""
    key, end = span.text, span.end_column - span.excerpt_column
    if ":" in key:
        return "put a space after the colon"
    if "=" in key:
        return "write ':' in place of '='"
    if key[:1].isdigit() and _ends_in_comma(span):
        return COMMA
    if words := re.fullmatch(r"([\w-]+)\s+([\w.+-].*)", key):
        return f"write `{words[1]}: {words[2]}`"
    if span.excerpt[end:].strip() == ":":
        return "write the value, indent the lines below if they belong to it, or delete the line"
    return "write the value, or delete the line"


def _ends_in_comma(span: Span) -> bool:
    """Return whether a digit and a comma precede a place, as in a flow mapping with a decimal comma."""
    return re.search(r"\d,$", span.excerpt[: span.column - span.excerpt_column]) is not None


def _report_swallowed_comparison(reading: Reading, event: yaml.ScalarEvent, span: Span) -> None:
    """Report `>5`, which opens a text block indented by five, and would swallow a comparison and the next lines."""
    line, column = _start(event)
    text = reading.page.lines[line][column:]
    if re.match(r"([&!]\S*\s+)*[|>][-+]?\d", text):
        comparison = COMPARISON.search(text)
        hint = f'write "{comparison[0].rstrip()}"' if comparison else "quote text that begins with |"
        reading.report("SD009", span, "this value begins a text block with a fixed indentation", hint)


# --- collections ------------------------------------------------------------------------------------------------------


def _nest(reading: Reading, start: yaml.CollectionStartEvent, depth: int, owner: Span | None) -> List | Map:
    if depth >= MAX_DEPTH:
        raise StopReadingError(too_deep(reading.page.span(*_start(start))))
    build = _map if isinstance(start, yaml.MappingStartEvent) else _list
    return build(reading, start, depth, owner)


def too_deep(span: Span) -> Diagnostic:
    return Diagnostic("SD007", span, f"more than {MAX_DEPTH} nested lists and mappings", "reduce the nesting")


def _list(reading: Reading, start: yaml.CollectionStartEvent, depth: int, owner: Span | None) -> List:
    items: list[Node] = []
    while not isinstance(event := next(reading.events), yaml.SequenceEndEvent):
        items.append(_node(reading, event, depth + 1, None))
    return List(_nest_span(reading.page, start, event, owner), tuple(items))


def _map(reading: Reading, start: yaml.CollectionStartEvent, depth: int, owner: Span | None) -> Map:
    entries: dict[str, tuple[Span, Node]] = {}
    while not isinstance(event := next(reading.events), yaml.MappingEndEvent):
        key, span = _key(reading, event, depth)
        value = _node(reading, next(reading.events), depth + 1, span)
        if key in entries and depth == 0 and key == "scenario":
            message = "a second scenario begins here, in the document of the first"
            raise StopReadingError(Diagnostic("SD003", span, message, "write a line with only --- above it"))
        if key in entries:
            first = entries[key][0]
            message = f"duplicate key '{shown(key)}', first defined at {first.line}:{first.column}"
            reading.report("SD003", span, message, _in_one(key, entries[key][1], value))
        elif key is not None:
            entries[key] = (span, value)
    owner = owner or next((span for span, _ in entries.values()), None)
    flat = tuple((key, span, value) for key, (span, value) in entries.items())
    return Map(_nest_span(reading.page, start, event, owner), flat)


def _in_one(key: str, first: Node, second: Node) -> str:
    """Return the remedy for a key that is written twice."""
    if isinstance(first, List) and isinstance(second, List):
        return f"put the items of both into one `{shown(key)}`"
    if isinstance(first, Map) and isinstance(second, Map):
        return f"put the keys of both into one `{shown(key)}`"
    return "delete one of them"


def _nest_span(page: Page, start: yaml.CollectionStartEvent, end: yaml.Event, owner: Span | None) -> Span:
    """Return the span of the brackets; for a collection without brackets, that of its key, or of its beginning."""
    if start.flow_style and page.at(*_start(start)) in set("[{&!"):
        return _span(page, start, end)
    return owner or page.span(*_start(start))


def _slip_in_key(span: Span, written: str) -> tuple[str, str] | None:
    """Return message and hint of a key that begins with a dash, or goes on with the value."""
    if item := NO_DASH_SPACE.match(written):
        return "a space is missing after '-'", f"write `- {item[1]}: `, followed by the value"
    if (key := NO_COLON.match(written)) is None:
        return None
    rest = span.excerpt[_offset(span) + key.start(3) :].strip()
    message = f"a space is missing after '{key[1]}:'" if key[2] else f"a ':' is missing after '{key[1]}'"
    return message, f"write `{key[1]}: {rest}`"


def _key(reading: Reading, event: yaml.Event, depth: int) -> tuple[str | None, Span]:
    """Read the key that begins with `event`, None if it is not text, and its place."""
    span = _span(reading.page, event)
    if not isinstance(event, yaml.ScalarEvent) or _start(event)[0] != _end(event)[0]:
        reading.report("SD010", span, "a key must be text on one line", "write a plain word as the key")
        if isinstance(event, yaml.CollectionStartEvent):
            _node(reading, event, depth + 1, None)
        return None, span
    _report_tag(reading, event, span)
    if not event.style and WIDE_SPACE.search(event.value):
        raise StopReadingError(_wide_space(reading, event))
    if not event.style and (slip := _slip_in_key(span, event.value)):
        raise StopReadingError(Diagnostic("SD004", span, *slip))
    if event.anchor is not None:
        reading.report(
            "SD010", span, "anchors on keys are not supported", f"move &{shown(event.anchor)} behind the colon"
        )
    if event.style:
        _report_commands(reading, event.value, span)
        return event.value, span
    if event.value == "<<":
        reading.report("SD010", span, "merge keys are not supported", "repeat the keys here")
    elif trap := key_trap(event.value):
        if _ends_in_comma(span) and event.value[:1].isdigit():
            raise StopReadingError(Diagnostic("SD009", span, COMMA_ENDS, COMMA))
        reading.report("SD009", span, f"the key '{shown(event.value)}' {trap.meaning}", trap.remedy)
    return event.value, span
