"""JSON, XML and numbers with the position of every value in its file."""

import json
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import accumulate
from json.decoder import JSONArray, JSONObject  # type: ignore[attr-defined]  # parts of its decoder
from json.scanner import py_make_scanner  # type: ignore[attr-defined]  # likewise
from math import isfinite
from typing import Any, Final, TypeAlias
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from stackdsl.diagnostics import Page, Span
from stackdsl.importers.load import Exact3, LoadReading, UnreadableLoadError
from stackdsl.language.quantities import SIGNED, shown

# JSON whose values carry their positions: the parser of the standard library, which records the start of each value.


LONGEST_TOLD: Final = 40  # [characters] of a number in a message
_HALF: Final = re.compile("[\ud800-\udfff]")


@dataclass(frozen=True, slots=True)
class Numeral:
    """A number as written in the file."""

    text: str


@dataclass(frozen=True, slots=True)
class Node:
    """A JSON value and the index of its first character."""

    value: "dict[str, Node] | list[Node] | str | Numeral | bool | None"
    start: int


_Scan: TypeAlias = Callable[[str, int], tuple[Any, int]]


class _WrongError(ValueError):
    """JSON that the parser accepts but a load must not have; carries the position, the message and the remedy."""

    def __init__(self, start: int, message: str, hint: str) -> None:
        super().__init__(message)
        self.start, self.message, self.hint = start, message, hint


class _Decoder(json.JSONDecoder):
    """The decoder of the standard library, with a Node for each value."""

    def __init__(self) -> None:
        super().__init__(
            object_pairs_hook=_unique_keys, parse_float=Numeral, parse_int=Numeral, parse_constant=_no_number
        )
        self.parse_object = lambda at, strict, _scan, hook, pairs, memo=None: JSONObject(
            at, strict, self._located, hook, pairs, memo
        )
        self.parse_array = lambda at, _scan: JSONArray(at, self._located)
        self._plain: _Scan = py_make_scanner(self)
        self.scan_once = self._located

    def _located(self, text: str, start: int) -> tuple[Node, int]:
        value, end = self._plain(text, start)
        if isinstance(value, str):
            _refuse_halves(value, start)
        return Node(value, start), end


def _unique_keys(pairs: "list[tuple[str, Node]]") -> "dict[str, Node]":
    members: dict[str, Node] = {}
    for key, node in pairs:
        _refuse_halves(key, node.start)
        if key in members:
            raise _WrongError(node.start, f"the object contains the key '{key}' twice", "keep one of them")
        members[key] = node
    return members


def _refuse_halves(text: str, start: int) -> None:
    """Raise an error for a lone surrogate, which a JSON escape can write but UTF-8 cannot encode."""
    if (half := _HALF.search(text)) is not None:
        escape = f"\\u{ord(half.group()):04x}"
        message = f"{escape} is half of a surrogate pair, and the other half is missing"
        raise _WrongError(start, message, "write the complete pair, or remove it")


def _no_number(word: str) -> None:
    raise ValueError(word)


@dataclass(frozen=True, slots=True)
class JsonText:
    """The JSON of a file, with the position of each value."""

    reading: LoadReading
    root: Node
    starts: tuple[int, ...]  # index of the first character of each line

    def span(self, node: Node) -> Span:
        """Return the position of a value."""
        return _span(self.reading.page, self.starts, node.start)

    def mapping(self, node: Node, label: str) -> "dict[str, Node]":
        """Return the members of an object; report any other value and return {}."""
        if isinstance(node.value, dict):
            return node.value
        self.reading.wrong(
            self.span(node), f"{label} is {_described(node)} instead of an object", "write an object in braces, {...}"
        )
        return {}

    def items(self, node: Node, label: str) -> "list[Node]":
        """Return the items of a list; report any other value and return []."""
        if isinstance(node.value, list):
            return node.value
        message = f"{label} is {_described(node)} instead of a list"
        self.reading.wrong(self.span(node), message, "write a list in brackets, [...]")
        return []

    def member(self, owner: Node, members: "dict[str, Node]", key: str, label: str) -> Node | None:
        """Return a required member; report and return None if it is missing."""
        if key in members:
            return members[key]
        if isinstance(owner.value, dict):
            self.reading.wrong(self.span(owner), f"{label} has no '{key}'", "add this key, or correct its spelling")
        return None

    def word(self, node: Node, label: str) -> str | None:
        """Return a string; report any other value and return None."""
        if isinstance(node.value, str):
            return node.value
        self.reading.wrong(
            self.span(node), f"{label} is {_described(node)} instead of a string", "write the string in quotes"
        )
        return None

    def skip_others(self, members: "dict[str, Node]", supported: set[str], harmless: set[str]) -> None:
        """Skip the members that are not supported."""
        for key, node in members.items():
            if key not in supported:
                self.reading.skip(key, self.span(node), key in harmless)


def json_text(reading: LoadReading) -> JsonText:
    """Parse the JSON of a file. Raises UnreadableLoadError."""
    text = "\n".join(reading.page.lines)
    starts = tuple(accumulate((len(line) + 1 for line in reading.page.lines), initial=0))
    try:
        return JsonText(reading, _Decoder().decode(text), starts)
    except json.JSONDecodeError as error:
        start, message, hint = error.pos, f"invalid JSON: {error.msg}", "correct the file, or export it again as JSON"
        if not text[error.pos :].strip():
            message, hint = "the JSON ends too early", "complete it, or export it again"
        rest = text[: error.pos].rstrip()[-1:] + text[error.pos :][:1]  # from Python 3.13 on, the mark is at the comma
        if rest in (",}", ",]") or (rest[1:] == "," and text[error.pos + 1 :].lstrip()[:1] in ("}", "]")):
            hint = "remove the comma before the closing bracket"
    except _WrongError as error:
        start, message, hint = error.start, error.message, error.hint
    except RecursionError:
        start, message, hint = 0, "the JSON is nested too deeply", "save the load in a file of its own"
    except ValueError as error:  # of `_no_number`
        start, message, hint = max(text.find(str(error)), 0), f"{error} is not valid in JSON", "write a finite number"
    reading.wrong(_span(reading.page, starts, min(start, max(len(text) - 1, 0))), message, hint)
    raise UnreadableLoadError(reading.mistakes)


def _span(page: Page, starts: tuple[int, ...], start: int) -> Span:
    line = min(bisect_right(starts, start) - 1, len(page.lines) - 1)
    return page.span(line, min(start - starts[line], max(len(page.lines[line]) - 1, 0)))


def _described(node: Node) -> str:
    match node.value:
        case dict():
            return "an object"
        case list():
            return "a list"
        case str():
            return "a string"
        case Numeral(text):
            return text[:LONGEST_TOLD]
        case value:
            return json.dumps(value)


# XML whose elements carry their positions: the parser of the standard library, which records the start of each element.
#
# The supported elements are then written for the format's own parser, each on its original line, so that the line
# numbers in its errors stay valid.


DEEPEST: Final = 200  # nested elements
WORDS: Final = frozenset({"name", "class", "childclass", "mesh", "file", "filename", "link", "type", "content_type"})


@dataclass(slots=True)
class Element:
    """An XML element and its position."""

    tag: str
    attributes: dict[str, str]
    span: Span
    line: int  # from 1
    children: "list[Element]" = field(default_factory=list)

    def all(self, tag: str) -> "Iterator[Element]":
        """Yield all elements of a tag in this element, itself included, in file order."""
        if self.tag == tag:
            yield self
        for child in self.children:
            yield from child.all(tag)

    def first(self, tag: str) -> "Element | None":
        """Return the first child of a tag."""
        return next((child for child in self.children if child.tag == tag), None)


def xml_text(reading: LoadReading) -> Element:
    """Parse the XML of a file and return its root. Raises UnreadableLoadError."""
    parser, roots = expat.ParserCreate(), list[Element]()
    open_: list[Element] = []

    def here() -> Span:
        line = min(parser.CurrentLineNumber, len(reading.page.lines)) - 1
        return reading.page.span(line, min(parser.CurrentColumnNumber, max(len(reading.page.lines[line]) - 1, 0)))

    def fail(span: Span, message: str, hint: str) -> UnreadableLoadError:
        reading.wrong(span, message, hint)
        return UnreadableLoadError(reading.mistakes)

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, here(), parser.CurrentLineNumber)
        if len(open_) > DEEPEST:
            raise fail(element.span, "elements are nested too deeply", "save the load in a file of its own")
        (open_[-1].children if open_ else roots).append(element)
        open_.append(element)

    def refuse_doctype(*_: object) -> None:
        raise fail(here(), "the file has a document type declaration", "delete it")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_.pop()
    parser.StartDoctypeDeclHandler = refuse_doctype
    try:
        parser.Parse("\n".join(reading.page.lines), True)
    except expat.ExpatError as error:
        line = min(error.lineno, len(reading.page.lines)) - 1
        span = reading.page.span(line, min(error.offset, max(len(reading.page.lines[line]) - 1, 0)))
        raise fail(
            span, f"invalid XML: {expat.errors.messages[error.code]}", "correct the file, or export it again"
        ) from error
    return roots[0]


def supported_subset(
    reading: LoadReading, element: Element, is_supported: Callable[[Element, Element], bool], harmless: frozenset[str]
) -> Element:
    """Return an element with its supported descendants only; skip all others."""
    children = []
    for child in element.children:
        if is_supported(element, child):
            children.append(supported_subset(reading, child, is_supported, harmless))
        else:
            reading.skip(child.tag, child.span, harmless=child.tag in harmless)
    return Element(element.tag, element.attributes, element.span, element.line, children)


def refuse_invalid_numbers(reading: LoadReading, element: Element) -> None:
    """Report numbers that are not finite, and numbers valid in Python only, such as `1_0` or non-ASCII digits."""
    for key, value in element.attributes.items():
        invalid = next(filter(_is_invalid_number, value.split()), None) if key not in WORDS else None
        if invalid is not None:
            message = f"`{key}` of <{element.tag}> contains {shown(invalid)}, which is not a finite number"
            reading.wrong(element.span, message, "write it with the digits 0 to 9, such as 0.25 or 1e-3")
    for child in element.children:
        refuse_invalid_numbers(reading, child)


def _is_invalid_number(word: str) -> bool:
    try:
        number = float(word)
    except ValueError:
        return False
    return not isfinite(number) or not word.isascii() or "_" in word


def xml_of(element: Element, attributes_of: Callable[[Element], Mapping[str, str]] = lambda e: e.attributes) -> str:
    """Write an element as XML, with every element on its original line."""
    lines = [""]

    def put(element: Element) -> None:
        lines.extend("" for _ in range(len(lines), element.line))
        attributes = "".join(f" {key}={quoteattr(value)}" for key, value in attributes_of(element).items())
        lines[-1] += f"<{element.tag}{attributes}>"
        for child in element.children:
            put(child)
        lines[-1] += f"</{element.tag}>"

    put(element)
    return "\n".join(lines)


# Exact numbers of a file, with the unit of their last digit.


IN_METRES: Final = {"mm": Fraction(1, 1000), "cm": Fraction(1, 100), "m": Fraction(1), "in": Fraction(254, 10_000)}
IN_KILOGRAMS: Final = {
    "g": Fraction(1, 1000),
    "kg": Fraction(1),
    "t": Fraction(1000),
    **dict.fromkeys(("lb", "lbs"), Fraction("0.45359237")),
}
MOST_POWER: Final = 30  # of ten; larger than that of any size, position or mass


def number_of(text: str) -> tuple[Fraction, Fraction] | None:
    """Return a number and the unit of its last digit; None if the text is no number, or an absurdly large one."""
    if not re.fullmatch(SIGNED, text):
        return None
    mantissa, _, power = text.lower().partition("e")
    shift = int(power or 0)
    if abs(shift) > MOST_POWER:
        return None
    places = len(mantissa.partition(".")[2].rstrip("0"))
    return Fraction(mantissa) * Fraction(10) ** shift, Fraction(10) ** (shift - places)


# Lengths and masses of a file, with their limits.


FURTHEST: Final = Fraction(10_000)  # [m]
SHORTEST: Final = Fraction(1, 1_000_000)  # [m]
DENSEST: Final = Fraction(1_000_000)  # [kg/m3]
HEAVIEST: Final = Fraction(1_000_000_000)  # [kg]
ROUGHEST: Final = 10  # Coulomb coefficient


@dataclass(frozen=True, slots=True)
class UnitReader:
    """Reads lengths and masses in the units of a file; reports invalid ones and returns None for them."""

    reading: LoadReading
    metre: Fraction  # unit of length [m]
    kilogram: Fraction = Fraction(1)  # unit of mass [kg]

    def number(self, text: str, span: Span, label: str) -> tuple[Fraction, Fraction] | None:
        """Return a number and the unit of its last digit."""
        number = number_of(text.strip())
        if number is None:
            shown = text if len(text) <= LONGEST_TOLD else f"{text[:LONGEST_TOLD]}..."
            why = "the number is missing" if not text.strip() else f"'{shown}' is not a number"
            hint = "write digits, with a decimal point, and no unit"
            self.reading.wrong(span, f"{label}: {why}", hint)
        return number

    def coordinate(self, text: str, span: Span, label: str, metre: Fraction | None = None) -> Fraction | None:
        """Return a coordinate [m]."""
        number = self.number(text, span, label)
        if number is None:
            return None
        unit = self.metre if metre is None else metre
        value = number[0] * unit
        if abs(value) > FURTHEST:
            self.reading.wrong(span, f"{label} of {text.strip()} exceeds 10 km", "correct the number or its unit")
            return None
        self.reading.note_precision(number[1] * unit)
        return value

    def side(self, text: str, span: Span, label: str, metre: Fraction | None = None) -> Fraction | None:
        """Return the length of a side [m], which is positive."""
        value = self.coordinate(text, span, label, metre)
        if value is not None and value < SHORTEST:
            self.reading.wrong(span, f"{label} of {text.strip()} is not a valid length", "write a positive number")
            return None
        return value

    def mass(self, text: str, span: Span, label: str, kilogram: Fraction | None = None) -> Fraction | None:
        """Return a mass [kg], which is positive."""
        number = self.number(text, span, label)
        if number is None:
            return None
        value = number[0] * (self.kilogram if kilogram is None else kilogram)
        if not 0 < value <= HEAVIEST:
            self.reading.wrong(span, f"{label} of {text.strip()} is not a valid mass", "write a positive number")
            return None
        return value

    # --- of JSON ------------------------------------------------------------------------------------------------------

    def coordinates(
        self, json: JsonText, nodes: Sequence[Node | None], label: str, side: bool = False
    ) -> Exact3 | None:
        """Return three coordinates, or three sides [m]; None if any is missing or invalid."""
        x, y, z = [self._length(json, node, f"{label} {axis}", side) for node, axis in zip(nodes, "xyz", strict=True)]
        return None if x is None or y is None or z is None else (x, y, z)

    def deck(self, json: JsonText, nodes: Sequence[Node | None], label: str) -> tuple[Fraction, Fraction] | None:
        """Return length and width of a deck [m]; their last digits do not count for the precision of the load."""
        sides: list[Fraction] = []
        for node in nodes:
            text = self._text(json, node, label)
            number = self.number(text, json.span(node), label) if node is not None and text is not None else None
            if node is None or number is None:
                return None
            if not SHORTEST <= number[0] * self.metre <= FURTHEST:
                self.reading.wrong(
                    json.span(node), f"{label} of {text} is not a valid length", "write a positive number"
                )
                return None
            sides.append(number[0] * self.metre)
        return (sides[0], sides[1])

    def mass_of(self, json: JsonText, node: Node | None, label: str) -> Fraction | None:
        """Return the mass of a JSON value [kg]."""
        text = self._text(json, node, label)
        return None if node is None or text is None else self.mass(text, json.span(node), label)

    def density_of(self, json: JsonText, node: Node, label: str) -> Fraction | None:
        """Return a density [kg/m3], which is positive and at most that of matter."""
        text = self._text(json, node, label)
        number = self.number(text, json.span(node), label) if text is not None else None
        if number is not None and not 0 < number[0] <= DENSEST:
            self.reading.wrong(json.span(node), f"{label} of {text} is not a valid density", "write a positive number")
            return None
        return number[0] if number is not None else None

    def _length(self, json: JsonText, node: Node | None, label: str, side: bool) -> Fraction | None:
        text = self._text(json, node, label)
        if node is None or text is None:
            return None
        return (self.side if side else self.coordinate)(text, json.span(node), label)

    def _text(self, json: JsonText, node: Node | None, label: str) -> str | None:
        if node is None:
            return None
        if isinstance(node.value, Numeral):
            return node.value.text
        self.reading.wrong(json.span(node), f"{label} must be a number", "write the number without quotes")
        return None


def select_load(
    json: JsonText, loads: Mapping[str, Node], wanted: str | None, noun: str, start: Node
) -> tuple[str, Node] | None:
    """Return the name and the node of the wanted load of a file; report and return None if it is missing or unclear.

    A file with one load needs no name for it.
    """
    if wanted is not None and wanted in loads:
        return wanted, loads[wanted]
    if wanted is None and len(loads) == 1:
        return next(iter(loads.items()))
    listed = ", ".join(f"'{name}'" for name in list(loads)[:16]) + (", ..." if len(loads) > 16 else "")  # noqa: PLR2004
    if not loads:
        json.reading.wrong(json.span(start), f"the file contains no {noun}", "choose another file")
    elif wanted is None:
        message = f"the file contains {len(loads)} {noun}s: {listed}"
        json.reading.undetermined(json.span(start), message, f"choose one, for example load: '{next(iter(loads))}'")
    else:
        message = f"the file contains no {noun} '{wanted}'"
        json.reading.undetermined(json.span(start), message, f"choose from: {listed}")
    return None
