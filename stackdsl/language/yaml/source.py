"""YAML text -> plain values, with the position of every key and value."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import islice
from pathlib import Path as FilePath
from typing import Final, TypeAlias

import yaml

from stability.process_settings import uncollected
from stackdsl.asked_files import read_asked
from stackdsl.diagnostics import Diagnostic, Page, Span, Warned, page_of
from stackdsl.disk import read_file
from stackdsl.language.yaml.parsing import (
    BEGIN,
    MAX_DEPTH,
    MAX_EXACT,
    MAX_MISTAKES,
    MAX_VALUES,
    UNKNOWN_ESCAPE,
    Alias,
    Leaf,
    Map,
    Node,
    Reading,
    Scalar,
    StopReadingError,
    document,
    syntax_error,
    too_deep,
    unreadable_characters,
)
from stackdsl.shown_text import visible

# YAML text as plain values, with the place of every key and value, from a reader that accepts only what is meant.
#
# What libyaml and the pure-Python parser both accept has the same values and places; the latter, for want of the
# former, refuses a little more, such as `[why?]`.


__all__ = [
    "MAX_ALIASED",
    "MAX_BYTES",
    "MAX_DEPTH",
    "MAX_EXACT",
    "MAX_MISTAKES",
    "MAX_SCENARIOS",
    "MAX_VALUES",
    "KeyPath",
    "Loaded",
    "Plain",
    "Source",
    "load",
    "parse",
    "parsed",
]

KeyPath: TypeAlias = tuple[str | int, ...]
Plain: TypeAlias = Scalar | list["Plain"] | dict[str, "Plain"]

MAX_BYTES: Final = 1 << 20  # scenarios are written by hand, some kB each; and parsing stays within seconds
MAX_SCENARIOS: Final = 2000  # of one file; a second
MAX_ALIASED: Final = 20_000  # values that the aliases of one file may repeat

BOM: Final = "\ufeff"
YAML_LOADER: type[yaml.SafeLoader] | type[yaml.CSafeLoader] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True)
class Source:
    """One YAML document: values, and beside them the place of each."""

    file: str
    values: dict[str, Plain]
    value_spans: Mapping[KeyPath, Span]
    key_spans: Mapping[KeyPath, Span]  # the key under which a path stands; list items have none
    inherited: frozenset[KeyPath] = frozenset()  # what another scenario says, of which this one may leave some unused
    parts: tuple[str, ...] = ()  # the other files that it is made of
    warnings: tuple[Warned, ...] = ()  # what is odd in those, and keeps nothing from being played
    files: Mapping[str, str] = field(default_factory=dict)  # the texts of those that bricks are made of, by path

    def span_of(self, path: KeyPath) -> Span:
        """Place of the value at `path`, or else of the closest ancestor that exists."""
        while path not in self.value_spans:
            path = path[:-1]
        return self.value_spans[path]

    def key_span_of(self, path: KeyPath) -> Span:
        """Place of the key at `path`, or else what `span_of` says."""
        return self.key_spans.get(path) or self.span_of(path)


@dataclass(frozen=True, slots=True)
class Loaded:
    """What a file holds: the documents without a mistake, and the mistakes of the others in the order of the text."""

    sources: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]
    digest: str = ""  # SHA-256 of the bytes that were read; empty where nothing could be


def load(path: FilePath, within: str = "") -> Loaded:
    """Read and parse a file; whatever goes wrong is a diagnostic, never an exception.

    One that another file names is `within` a folder, the root of their project; else somebody asks for it by name.
    """
    file = visible(path.as_posix())
    if file != path.as_posix():  # what is told under this name, and what it takes from others, could be of another file
        hidden = "its name has characters that cannot be shown"
        return _refused(Diagnostic("SD001", Span(file, 1, 1, 1), f"cannot read the file: {hidden}", "rename it"))
    try:
        data = read_file(path, MAX_BYTES + 1, within) if within else read_asked(path, MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
        missing = isinstance(error, FileNotFoundError)
        hint = "check its name, or begin one by `stackdsl new`" if missing else "name a file that can be read"
        return _refused(Diagnostic("SD001", Span(file, 1, 1, 1), f"cannot read the file: {reason}", hint))
    return parsed(data, file)


@uncollected()
def parsed(data: bytes, file: str) -> Loaded:
    """What the bytes of a file hold, which is called so."""
    if len(data) > MAX_BYTES:
        return _refused(_too_large(file))
    try:
        return replace(parse(data.decode("utf-8"), file), digest=sha256(data).hexdigest())
    except UnicodeDecodeError as error:
        return _refused(_not_utf8(data, error.start, file))


def parse(text: str, file: str) -> Loaded:
    """Parse the documents of one file; each is one scenario."""
    if len(text) > MAX_BYTES:
        return _refused(_too_large(file))
    # Ended by a newline, a text means the same to both parsers, and marks stay within its lines.
    ended = text if text.endswith("\n") else text + "\n"
    page = page_of(ended.removeprefix(BOM), file)
    unreadable = tuple(islice(unreadable_characters(page), MAX_MISTAKES))
    return Loaded((), unreadable) if unreadable else _read(page)


def _refused(diagnostic: Diagnostic) -> Loaded:
    return Loaded((), (diagnostic,))


def _too_large(file: str) -> Diagnostic:
    message = f"the file is larger than {MAX_BYTES >> 20} MiB"
    return Diagnostic("SD006", Span(file, 1, 1, 1), message, "split it into several files")


def _not_utf8(data: bytes, position: int, file: str) -> Diagnostic:
    before = page_of(data[:position].decode("utf-8").removeprefix(BOM), file).lines
    page = page_of(data.decode("utf-8", "replace").removeprefix(BOM), file)
    span = page.span(len(before) - 1, len(before[-1]))
    return Diagnostic("SD002", span, f"the byte 0x{data[position]:02x} is not UTF-8", "save the file as UTF-8")


def _read(page: Page) -> Loaded:
    reading = Reading(page, yaml.parse(page.text, Loader=YAML_LOADER))
    sources: list[Source] = []
    try:
        for event in reading.events:
            if isinstance(event, yaml.DocumentStartEvent):
                root = document(reading, event)
                sources += [_source(reading, root)] if root else []
                if len(sources) > MAX_SCENARIOS:
                    span = sources[-1].value_spans[()]
                    message = f"the file holds more than {MAX_SCENARIOS} scenarios"
                    raise StopReadingError(Diagnostic("SD006", span, message, "split it into several files"))
        if not sources and not reading.diagnostics:
            reading.report("SD005", page.span(0, 0), "the file holds no scenario", BEGIN)
    except StopReadingError as stop:
        reading.diagnostics.append(stop.diagnostic)
    except yaml.MarkedYAMLError as error:
        reading.diagnostics.append(syntax_error(page, error))
    except (ValueError, OverflowError):  # the pure parser on the escape of a character beyond Unicode
        reading.diagnostics.append(Diagnostic("SD004", page.span(*page.last_visible()), *UNKNOWN_ESCAPE))
    order = sorted(reading.diagnostics, key=lambda found: (found.span.line, found.span.column, found.code))
    return Loaded(tuple(sources), tuple(order))


# --- nodes to values --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Spread:
    """Where the values of one document end up while its aliases are spread out."""

    reading: Reading
    value_spans: dict[KeyPath, Span] = field(default_factory=dict)
    key_spans: dict[KeyPath, Span] = field(default_factory=dict)


def _source(reading: Reading, root: Map) -> Source:
    spread = _Spread(reading)
    spread.value_spans[()] = root.span
    values = _mapping(spread, root, (), None)
    return Source(reading.page.file, values, spread.value_spans, spread.key_spans)


def _value(spread: _Spread, node: Node, path: KeyPath, alias: Span | None) -> Plain:
    """The value of `node` at `path`; `alias` is the outermost alias that repeats it."""
    spread.value_spans[path] = node.span
    if isinstance(node, Alias):
        alias, node = alias or node.span, node.target
    if alias is not None:
        _count_aliased(spread.reading, alias)
    if isinstance(node, Leaf):
        return node.value
    assert not isinstance(node, Alias)  # YAML has no anchors on aliases
    if len(path) >= MAX_DEPTH:  # each definition may be shallow, and yet build on the one before
        raise StopReadingError(too_deep(alias or node.span))
    if isinstance(node, Map):
        return _mapping(spread, node, path, alias)
    return [_value(spread, item, (*path, index), alias) for index, item in enumerate(node.items)]


def _mapping(spread: _Spread, node: Map, path: KeyPath, alias: Span | None) -> dict[str, Plain]:
    spread.key_spans.update({(*path, key): span for key, span, _ in node.entries})
    return {key: _value(spread, value, (*path, key), alias) for key, _, value in node.entries}


def _count_aliased(reading: Reading, alias: Span) -> None:
    reading.aliased += 1
    if reading.aliased > MAX_ALIASED:
        message = f"aliases repeat more than {MAX_ALIASED} values"
        raise StopReadingError(Diagnostic("SD008", alias, message, "write the values out, or use a layout"))


# The places of values that move: where in a file each comes from, by where it stands in the end.


@dataclass(frozen=True, slots=True)
class PlaceBuilder:
    """As those of a source, in the making."""

    value_spans: dict[KeyPath, Span] = field(default_factory=dict)
    key_spans: dict[KeyPath, Span] = field(default_factory=dict)

    def note(self, source: Source, old: KeyPath, new: KeyPath, where: str = "") -> None:
        """What stands at one path comes from another, perhaps from a repetition or a file that is to be told."""
        self.value_spans[new] = _within(source.span_of(old), where)
        if old in source.key_spans:
            self.key_spans[new] = _within(source.key_spans[old], where)

    def note_all(self, source: Source, value: Plain, old: KeyPath, new: KeyPath, where: str = "") -> None:
        """The same for a value and all that it holds."""
        self.note(source, old, new, where)
        members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, member in members:
            self.note_all(source, member, (*old, key), (*new, key), where)

    def keep(self, source: Source, without: Mapping[KeyPath, object]) -> None:
        """All places of a source, but for what stands at some paths and below them; each path has one or two keys."""
        for own, spans in ((self.value_spans, source.value_spans), (self.key_spans, source.key_spans)):
            own.update(
                {path: span for path, span in spans.items() if path[:1] not in without and path[:2] not in without}
            )


def _within(span: Span, where: str) -> Span:
    if not where:
        return span
    told = f"{where}, {span.where}" if span.where else where
    # Spelled out: `replace` takes five times as long, and what is repeated has a hundred thousand places.
    return Span(span.file, span.line, span.column, span.end_column, span.excerpt, span.excerpt_column, told, span.key)
