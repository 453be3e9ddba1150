"""JSON, XML and numbers with the position of every value in its file."""

import json
import re
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import accumulate
from json.decoder import JSONArray, JSONObject  # type: ignore[attr-defined]  # what its decoder is made of
from json.scanner import py_make_scanner  # type: ignore[attr-defined]  # likewise
from math import isfinite
from typing import Any, Final, TypeAlias
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from stackdsl.diagnostics import Page, Span
from stackdsl.importers.load import Exact3, LoadReading, UnreadableLoadError
from stackdsl.language.quantities import SIGNED, shown

# JSON in which every value knows where it stands: the standard library's parser, with a place noted beside each.


LONGEST_TOLD: Final = 40  # [characters] of a number
_HALF: Final = re.compile("[\ud800-\udfff]")


@dataclass(frozen=True, slots=True)
class Numeral:
    """A number as it is written."""

    text: str


@dataclass(frozen=True, slots=True)
class Node:
    """A value of JSON, and where it begins in the text."""

    value: "dict[str, Node] | list[Node] | str | Numeral | bool | None"
    start: int


_Scan: TypeAlias = Callable[[str, int], tuple[Any, int]]


class _WrongError(ValueError):
    """JSON that the parser accepts but a load must not have: its position, what is wrong, and the remedy."""

    def __init__(self, start: int, message: str, hint: str) -> None:
        super().__init__(message)
        self.start, self.message, self.hint = start, message, hint


class _Decoder(json.JSONDecoder):
    """The decoder of the standard library, whose values are nodes."""

    def __init__(self) -> None:
        super().__init__(
            object_pairs_hook=_each_once, parse_float=Numeral, parse_int=Numeral, parse_constant=_no_number
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


def _each_once(pairs: "list[tuple[str, Node]]") -> "dict[str, Node]":
    found: dict[str, Node] = {}
    for key, node in pairs:
        _refuse_halves(key, node.start)
        if key in found:
            raise _WrongError(node.start, f"'{key}' is written twice in one object", "keep one of them")
        found[key] = node
    return found


def _refuse_halves(text: str, start: int) -> None:
    """Raise an error for a lone surrogate, which a JSON escape can write but UTF-8 cannot encode."""
    if (half := _HALF.search(text)) is not None:
        escape = f"\\u{ord(half.group()):04x}"
        message = f"{escape} is half of a character, whose other half is not beside it"
        raise _WrongError(start, message, "write the whole character, or leave it out")


def _no_number(word: str) -> None:
    raise ValueError(word)


@dataclass(frozen=True, slots=True)
class JsonText:
    """A text of JSON, and where in the file each of its values is."""

    reading: LoadReading
    root: Node
    starts: tuple[int, ...]  # of the lines

    def span(self, node: Node) -> Span:
        """Where a value is."""
        return _span(self.reading.page, self.starts, node.start)

    def mapping(self, node: Node, what: str) -> "dict[str, Node]":
        """The members of an object; told and empty if it is none."""
        if isinstance(node.value, dict):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no object", "write it in braces")
        return {}

    def items(self, node: Node, what: str) -> "list[Node]":
        """The items of an array; told and empty if it is none."""
        if isinstance(node.value, list):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no list", "write it in square brackets")
        return []

    def member(self, owner: Node, members: "dict[str, Node]", key: str, what: str) -> Node | None:
        """A member that must be there; told and None if it is not."""
        if key in members:
            return members[key]
        if isinstance(owner.value, dict):
            self.reading.wrong(self.span(owner), f"{what} has no '{key}'", "complete it, or mend how it is spelt")
        return None

    def word(self, node: Node, what: str) -> str | None:
        """A text; told and None if it is none."""
        if isinstance(node.value, str):
            return node.value
        self.reading.wrong(self.span(node), f"{what} is {_told(node)}, and no text", "put it in quotes")
        return None

    def pass_over(self, owner: "dict[str, Node]", taken: set[str], known: set[str]) -> None:
        """Say of all other members that they are not taken."""
        for key, node in owner.items():
            if key not in taken:
                self.reading.leave(key, self.span(node), key in known)


def json_text(reading: LoadReading) -> JsonText:
    """The JSON of a file. Raises UnreadableLoadError if it is none."""
    text = "\n".join(reading.page.lines)
    starts = tuple(accumulate((len(line) + 1 for line in reading.page.lines), initial=0))
    try:
        return JsonText(reading, _Decoder().decode(text), starts)
    except json.JSONDecodeError as error:
        start, message, hint = error.pos, f"this is no JSON: {error.msg}", "save the file anew as JSON"
    except _WrongError as error:
        start, message, hint = error.start, error.message, error.hint
    except RecursionError:
        start, message, hint = 0, "the JSON is nested too deeply", "save the load by itself"
    except ValueError as error:  # of `_no_number`
        start, message, hint = max(text.find(str(error)), 0), f"{error} is no number of JSON", "write the number"
    reading.wrong(_span(reading.page, starts, min(start, max(len(text) - 1, 0))), message, hint)
    raise UnreadableLoadError(reading.mistakes)


def _span(page: Page, starts: tuple[int, ...], start: int) -> Span:
    line = min(bisect_right(starts, start) - 1, len(page.lines) - 1)
    return page.span(line, min(start - starts[line], max(len(page.lines[line]) - 1, 0)))


def _told(node: Node) -> str:
    match node.value:
        case dict():
            return "an object"
        case list():
            return "a list"
        case str():
            return "a text"
        case Numeral(text):
            return text[:LONGEST_TOLD]
        case value:
            return json.dumps(value)


# XML in which every element knows where it stands: the standard library's parser, with a place noted for each.
#
# What of it is taken goes on to the format's own parser line by line as it was, so that this, too, can say where.


DEEPEST: Final = 200  # elements within elements
WORDS: Final = frozenset({"name", "class", "childclass", "mesh", "file", "filename", "link", "type", "content_type"})


@dataclass(slots=True)
class Element:
    """An element, and where it begins."""

    tag: str
    attributes: dict[str, str]
    span: Span
    line: int  # counted from 1
    children: "list[Element]" = field(default_factory=list)

    def all(self, tag: str) -> "Iterator[Element]":
        """This one and all within it of a tag, in the order of the file."""
        if self.tag == tag:
            yield self
        for child in self.children:
            yield from child.all(tag)

    def first(self, tag: str) -> "Element | None":
        """The first child of a tag."""
        return next((child for child in self.children if child.tag == tag), None)


def xml_text(reading: LoadReading) -> Element:
    """The outermost element of a file. Raises UnreadableLoadError if it is no XML."""
    parser, found = expat.ParserCreate(), list[Element]()
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
            raise fail(element.span, "elements are nested too deeply", "save the load by itself")
        (open_[-1].children if open_ else found).append(element)
        open_.append(element)

    def declared(*_: object) -> None:
        raise fail(here(), "the file declares a document type of its own", "leave it out")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_.pop()
    parser.StartDoctypeDeclHandler = declared
    try:
        parser.Parse("\n".join(reading.page.lines), True)
    except expat.ExpatError as error:
        line = min(error.lineno, len(reading.page.lines)) - 1
        span = reading.page.span(line, min(error.offset, max(len(reading.page.lines[line]) - 1, 0)))
        raise fail(span, f"this is no XML: {expat.errors.messages[error.code]}", "save the file anew") from error
    return found[0]


def taken(
    reading: LoadReading, element: Element, is_taken: Callable[[Element, Element], bool], harmless: frozenset[str]
) -> Element:
    """An element with what is taken of what is within it; all else is named."""
    children = []
    for child in element.children:
        if is_taken(element, child):
            children.append(taken(reading, child, is_taken, harmless))
        else:
            reading.leave(child.tag, child.span, known=child.tag in harmless)
    return Element(element.tag, element.attributes, element.span, element.line, children)


def refuse_odd_numbers(reading: LoadReading, element: Element) -> None:
    """Tell every number that is not finite, or is one to Python only, as `1_0` is, or digits that are not ASCII."""
    for key, value in element.attributes.items():
        odd = next(filter(_is_odd, value.split()), None) if key not in WORDS else None
        if odd is not None:
            message = f"`{key}` of <{element.tag}> has {shown(odd)}, which is no finite number"
            reading.wrong(element.span, message, "write it with the digits 0 to 9, such as 0.25 or 1e-3")
    for child in element.children:
        refuse_odd_numbers(reading, child)


def _is_odd(word: str) -> bool:
    try:
        number = float(word)
    except ValueError:
        return False
    return not isfinite(number) or not word.isascii() or "_" in word


def written(element: Element, of: Callable[[Element], Mapping[str, str]] = lambda e: e.attributes) -> str:
    """An element as XML, with every element on the line on which it was."""
    lines = [""]

    def put(element: Element) -> None:
        lines.extend("" for _ in range(len(lines), element.line))
        attributes = "".join(f" {key}={quoteattr(value)}" for key, value in of(element).items())
        lines[-1] += f"<{element.tag}{attributes}>"
        for child in element.children:
            put(child)
        lines[-1] += f"</{element.tag}>"

    put(element)
    return "\n".join(lines)


# Numbers of a file, exactly as they are written, with the unit of their last digit.


IN_METRES: Final = {"mm": Fraction(1, 1000), "cm": Fraction(1, 100), "m": Fraction(1)}
IN_KILOGRAMS: Final = {"g": Fraction(1, 1000), "kg": Fraction(1), "t": Fraction(1000)}
MOST_POWER: Final = 30  # of ten: beyond, it is no size, place or mass of anything


def number_of(text: str) -> tuple[Fraction, Fraction] | None:
    """A number and the unit of its last digit; None if it is none, or beyond all reason."""
    if not re.fullmatch(SIGNED, text):
        return None
    mantissa, _, power = text.lower().partition("e")
    shift = int(power or 0)
    if abs(shift) > MOST_POWER:
        return None
    places = len(mantissa.partition(".")[2].rstrip("0"))
    return Fraction(mantissa) * Fraction(10) ** shift, Fraction(10) ** (shift - places)


# Lengths and masses of a file: numbers within reason, or what is wrong with them, in its place.


FURTHEST: Final = Fraction(10_000)  # [m]
SHORTEST: Final = Fraction(1, 1_000_000)  # [m]
HEAVIEST: Final = Fraction(1_000_000_000)  # [kg]
ROUGHEST: Final = 10  # Coulomb coefficient


@dataclass(frozen=True, slots=True)
class UnitReader:
    """Reads what is measured in some units."""

    reading: LoadReading
    metre: Fraction  # of a unit of length [m]
    kilogram: Fraction = Fraction(1)  # of a unit of mass [kg]

    def number(self, text: str, span: Span, what: str) -> tuple[Fraction, Fraction] | None:
        """A number, and the unit of its last digit; told and None if it is none."""
        found = number_of(text.strip())
        if found is None:
            shown = text if len(text) <= LONGEST_TOLD else f"{text[:LONGEST_TOLD]}..."
            why = "there is no number" if not text.strip() else f"'{shown}' is no number"
            hint = "write digits, with a point before decimals, and no unit"
            self.reading.wrong(span, f"{what}: {why}", hint)
        return found

    def place(self, text: str, span: Span, what: str, metre: Fraction | None = None) -> Fraction | None:
        """A coordinate [m]."""
        found = self.number(text, span, what)
        if found is None:
            return None
        unit = self.metre if metre is None else metre
        value = found[0] * unit
        if abs(value) > FURTHEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is more than 10 km", "mend the number, or its unit")
            return None
        self.reading.digit(found[1] * unit)
        return value

    def side(self, text: str, span: Span, what: str, metre: Fraction | None = None) -> Fraction | None:
        """Length of a side [m], which is more than nothing."""
        value = self.place(text, span, what, metre)
        if value is not None and value < SHORTEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is no length of a box", "write more than zero")
            return None
        return value

    def mass(self, text: str, span: Span, what: str, kilogram: Fraction | None = None) -> Fraction | None:
        """A mass [kg], which is more than nothing."""
        found = self.number(text, span, what)
        if found is None:
            return None
        value = found[0] * (self.kilogram if kilogram is None else kilogram)
        if not 0 < value <= HEAVIEST:
            self.reading.wrong(span, f"{what} of {text.strip()} is no mass of a box", "write more than zero")
            return None
        return value

    # --- of JSON ------------------------------------------------------------------------------------------------------

    def places(self, json: JsonText, nodes: Sequence[Node | None], what: str, side: bool = False) -> Exact3 | None:
        """Three coordinates, or three sides [m]; None if any is missing or wrong, which is told."""
        found = [self._one(json, node, f"{what} {axis}", side) for node, axis in zip(nodes, "xyz", strict=True)]
        x, y, z = found
        return None if x is None or y is None or z is None else (x, y, z)

    def deck(self, json: JsonText, nodes: Sequence[Node | None], what: str) -> tuple[Fraction, Fraction] | None:
        """Length and width of a deck [m], whose digits say nothing of those of boxes; None if any is wrong."""
        found: list[Fraction] = []
        for node in nodes:
            text = self._text(json, node, what)
            number = self.number(text, json.span(node), what) if node is not None and text is not None else None
            if node is None or number is None:
                return None
            if not SHORTEST <= number[0] * self.metre <= FURTHEST:
                self.reading.wrong(json.span(node), f"{what} of {text} is no side of a deck", "write more than zero")
                return None
            found.append(number[0] * self.metre)
        return (found[0], found[1])

    def weight(self, json: JsonText, node: Node | None, what: str) -> Fraction | None:
        """A mass [kg]."""
        text = self._text(json, node, what)
        return None if node is None or text is None else self.mass(text, json.span(node), what)

    def _one(self, json: JsonText, node: Node | None, what: str, side: bool) -> Fraction | None:
        text = self._text(json, node, what)
        if node is None or text is None:
            return None
        return (self.side if side else self.place)(text, json.span(node), what)

    def _text(self, json: JsonText, node: Node | None, what: str) -> str | None:
        if node is None:
            return None
        if isinstance(node.value, Numeral):
            return node.value.text
        self.reading.wrong(json.span(node), f"{what} is no number", "write it without quotes")
        return None


def chosen(
    json: JsonText, loads: Mapping[str, Node], wanted: str | None, noun: str, start: Node
) -> tuple[str, Node] | None:
    """The load that is meant of those in a file; told and None if that is not said."""
    if wanted is not None and wanted in loads:
        return wanted, loads[wanted]
    if wanted is None and len(loads) == 1:
        return next(iter(loads.items()))
    listed = ", ".join(f"'{name}'" for name in list(loads)[:16]) + (", ..." if len(loads) > 16 else "")  # noqa: PLR2004
    if not loads:
        json.reading.wrong(json.span(start), f"there is no {noun} in it", "name a file with one")
    elif wanted is None:
        message = f"there are {len(loads)} {noun}s in it: {listed}"
        json.reading.open(json.span(start), message, f"say which, such as load: '{next(iter(loads))}'")
    else:
        message = f"there is no {noun} '{wanted}' in it"
        json.reading.open(json.span(start), message, f"choose from: {listed}")
    return None
