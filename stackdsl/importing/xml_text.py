"""XML in which every element knows where it stands: the standard library's parser, with a place noted for each.

What of it is taken goes on to the format's own parser line by line as it was, so that this, too, can say where.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Final
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from stackdsl.diagnostics import Span
from stackdsl.importing.load import LoadReading, UnreadableLoadError
from stackdsl.language.mistakes import shown

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
