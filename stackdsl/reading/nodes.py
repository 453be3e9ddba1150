"""Parser events as nodes: the values of one document and the place of each, its aliases not yet spread out.

Read from events, not by `yaml.load`, so that hostile nesting stops at once and positions survive.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from typing import Final, TypeAlias

import yaml

from stackdsl.diagnostics import Diagnostic, Page, Span, did_you_mean
from stackdsl.reading.characters import commanding_character
from stackdsl.reading.plain_scalars import QUOTE_WIDTH, Scalar, Trap, key_trap, plain_value, shown
from stackdsl.reading.yaml_syntax import UNKNOWN_ESCAPE

MAX_DEPTH: Final = 64  # collections in each other; keeps the recursion below far from Python's limit of 1000 frames
COMMA: Final = "write a decimal point in place of the comma"
MAX_VALUES: Final = 100_000  # written in one file; bounds the memory that spans take to some 100 MB
MAX_MISTAKES: Final = 1000  # reported of one file; who mends these sees the next
ANCHORS_COMPARED: Final = 20  # with a misspelt alias; comparing all would take a hostile file minutes

BEGIN: Final = "begin with `scenario: its-name`"
NO_MAPPING: Final = "a scenario is a mapping of keys to values, but this document is "


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
    """What follows cannot be read, or is not worth it."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic)
        self.diagnostic = diagnostic


@dataclass(slots=True)
class Reading:
    """How far a file is read: the events to come, and what was seen."""

    page: Page
    events: Iterator[yaml.Event]
    diagnostics: list[Diagnostic] = field(default_factory=list)
    anchors: dict[str, Node | None] = field(default_factory=dict)  # None: its value is not complete yet
    values: int = 0
    aliased: int = 0

    def report(self, code: str, span: Span, message: str, hint: str = "") -> None:
        """Note a mistake after which reading goes on, unless there are too many."""
        found = Diagnostic(code, span, message, hint)
        if len(self.diagnostics) >= MAX_MISTAKES - 1:
            raise StopReadingError(found)
        self.diagnostics.append(found)


def document(reading: Reading, start: yaml.DocumentStartEvent) -> Map | None:
    """The mapping that the document is, or None if it has a mistake."""
    before = len(reading.diagnostics)
    reading.anchors.clear()
    if reading.page.at(*_start(start)) == "%":
        reading.report("SD010", reading.page.span(*_start(start)), "a directive", "delete the line")
    root = next(reading.events)
    if isinstance(root, yaml.ScalarEvent) and not root.value and not root.style:
        span = reading.page.span(*_start(start))
        reading.report("SD005", span, "the document is empty", "write a scenario here, or delete the '---'")
        return None
    if isinstance(root, yaml.ScalarEvent):
        hint = "put a space after the colon" if ":" in root.value else BEGIN
        reading.report("SD004", _span(reading.page, root), NO_MAPPING + "a single value", hint)
        return None
    node = _node(reading, root, 0, None)
    if isinstance(node, List):
        reading.report("SD004", node.span, NO_MAPPING + "a list", BEGIN)
    clean = len(reading.diagnostics) == before
    return node if clean and isinstance(node, Map) else None


# --- places -----------------------------------------------------------------------------------------------------------


def _span(page: Page, start: yaml.Event, end: yaml.Event | None = None) -> Span:
    """From the start of one event to the end of it, or of another."""
    return page.span(*_start(start), *_end(end or start))


def _start(event: yaml.Event) -> tuple[int, int]:
    assert event.start_mark is not None  # only the stubs doubt it
    return event.start_mark.line, event.start_mark.column


def _end(event: yaml.Event) -> tuple[int, int]:
    assert event.end_mark is not None  # as above
    return event.end_mark.line, event.end_mark.column


# --- values -----------------------------------------------------------------------------------------------------------


def _node(reading: Reading, event: yaml.Event, depth: int, owner: Span | None) -> Node:
    """The value that begins with `event`, `depth` collections deep, under the key at `owner`."""
    reading.values += 1
    span = _span(reading.page, event)
    if reading.values > MAX_VALUES:
        message = f"the file holds more than {MAX_VALUES} values"
        raise StopReadingError(Diagnostic("SD006", span, message, "split it, or use a layout"))
    if isinstance(event, yaml.AliasEvent):
        return _alias(reading, event.anchor or "", span)
    assert isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent)  # nothing else begins a value
    _report_tag(reading, event, span)
    if event.anchor and event.anchor in reading.anchors:
        reading.report("SD010", span, f"the anchor '{shown(event.anchor)}' is given twice", "give each its own name")
    if event.anchor:
        reading.anchors[event.anchor] = None
    node = _leaf(reading, event, owner) if isinstance(event, yaml.ScalarEvent) else _nest(reading, event, depth, owner)
    if event.anchor:
        reading.anchors[event.anchor] = node
    return node


def _alias(reading: Reading, name: str, span: Span) -> Node:
    if name not in reading.anchors:
        quoted = shown(name)
        near = [known for known in islice(reading.anchors, ANCHORS_COMPARED) if len(known) <= QUOTE_WIDTH]
        hint = did_you_mean(quoted, near) or f"define it before, with &{quoted}; quote text that begins with *"
        reading.report("SD004", span, f"there is no anchor '{quoted}' before this alias", hint)
        return Leaf(span, None)
    target = reading.anchors[name]
    if target is None:
        message = f"the alias '{shown(name)}' stands inside the value that it repeats"
        reading.report("SD008", span, message, "write the value out")
        return Leaf(span, None)
    return Alias(span, target)


def _report_tag(reading: Reading, event: yaml.ScalarEvent | yaml.CollectionStartEvent, span: Span) -> None:
    if event.tag is not None:
        tag = event.tag.replace("tag:yaml.org,2002:", "!!")
        reading.report("SD010", span, f"the tag '{shown(tag)}'", "delete it; quote text that begins with !")


def _leaf(reading: Reading, event: yaml.ScalarEvent, owner: Span | None) -> Leaf:
    span = _span(reading.page, event)
    if re.search("[\ud800-\udfff]", event.value):  # only the pure parser lets such escapes pass
        raise StopReadingError(Diagnostic("SD004", span, *UNKNOWN_ESCAPE))
    if event.style:
        _report_commands(reading, event.value, span)
        _report_swallowed_comparison(reading, event, span)
        return Leaf(span, event.value)
    value = plain_value(event.value)
    if not isinstance(value, Trap):
        return Leaf(span, value)
    if event.value:
        reading.report("SD009", span, f"'{shown(event.value)}' {value.meaning}", value.remedy)
    else:
        _report_missing(reading, event, owner)
    return Leaf(span, None)


def _report_commands(reading: Reading, value: str, span: Span) -> None:
    """An escape may bring in what nobody may write as it is: names and descriptions are shown in terminals."""
    if name := commanding_character(value):
        reading.report("SD004", span, f"an escape stands for {name}, which terminals obey", "leave it out")


def _report_missing(reading: Reading, event: yaml.ScalarEvent, owner: Span | None) -> None:
    """Point at the key without a value, or at the dash of an empty item."""
    line, column = _start(event)
    span = owner or reading.page.span(line, max(0, column - 1))
    reading.report("SD009", span, "a value is missing", _remedy_of_missing(span))


def _remedy_of_missing(span: Span) -> str:
    """What to write instead, from what stands before the place, at it and after it."""
    start = span.column - span.excerpt_column
    end = start + span.end_column - span.column
    key = span.excerpt[start:end]
    if ":" in key:
        return "put a space after the colon"
    if key[:1].isdigit() and _ends_in_comma(span):
        return COMMA
    if span.excerpt[end:].strip() == ":":
        return "write the value, indent the lines below that belong to it, or delete the line"
    return "write the value, or delete the line"


def _ends_in_comma(span: Span) -> bool:
    """Whether what stands right before a place is a digit and a comma, as of a number in a flow mapping."""
    return re.search(r"\d,$", span.excerpt[: span.column - span.excerpt_column]) is not None


def _report_swallowed_comparison(reading: Reading, event: yaml.ScalarEvent, span: Span) -> None:
    """`>5` opens a text block indented by five: it would swallow a comparison and what follows."""
    line, column = _start(event)
    if re.match(r"([&!]\S*\s+)*[|>][-+]?\d", reading.page.lines[line][column:]):
        reading.report("SD009", span, "this begins a text block with a set indentation", 'quote a comparison: ">5"')


# --- collections ------------------------------------------------------------------------------------------------------


def _nest(reading: Reading, start: yaml.CollectionStartEvent, depth: int, owner: Span | None) -> List | Map:
    if depth >= MAX_DEPTH:
        raise StopReadingError(too_deep(reading.page.span(*_start(start))))
    build = _map if isinstance(start, yaml.MappingStartEvent) else _list
    return build(reading, start, depth, owner)


def too_deep(span: Span) -> Diagnostic:
    return Diagnostic("SD007", span, f"more than {MAX_DEPTH} lists and mappings inside each other", "flatten them")


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
        if key in entries:
            first = entries[key][0]
            message = f"duplicate key '{shown(key)}', first defined at {first.line}:{first.column}"
            reading.report("SD003", span, message, "delete or rename one of them")
        elif key is not None:
            entries[key] = (span, value)
    owner = owner or next((span for span, _ in entries.values()), None)
    flat = tuple((key, span, value) for key, (span, value) in entries.items())
    return Map(_nest_span(reading.page, start, event, owner), flat)


def _nest_span(page: Page, start: yaml.CollectionStartEvent, end: yaml.Event, owner: Span | None) -> Span:
    """The brackets, or for a collection without them the key that owns it, or else its beginning."""
    if start.flow_style and page.at(*_start(start)) in set("[{&!"):
        return _span(page, start, end)
    return owner or page.span(*_start(start))


def _key(reading: Reading, event: yaml.Event, depth: int) -> tuple[str | None, Span]:
    """The key that begins with `event`, None if it is no text; and its place."""
    span = _span(reading.page, event)
    if not isinstance(event, yaml.ScalarEvent) or _start(event)[0] != _end(event)[0]:
        reading.report("SD010", span, "a key that is not text on one line", "write a plain word as the key")
        if isinstance(event, yaml.CollectionStartEvent):
            _node(reading, event, depth + 1, None)
        return None, span
    _report_tag(reading, event, span)
    if event.anchor is not None:
        reading.report("SD010", span, "an anchor on a key", f"move &{shown(event.anchor)} behind the colon")
    if event.style:
        _report_commands(reading, event.value, span)
        return event.value, span
    if event.value == "<<":
        reading.report("SD010", span, "a merge key", "repeat the keys here")
    elif trap := key_trap(event.value):
        remedy = COMMA if _ends_in_comma(span) and event.value[:1].isdigit() else trap.remedy
        reading.report("SD009", span, f"the key '{shown(event.value)}' {trap.meaning}", remedy)
    return event.value, span
