"""Reads YAML text into plain values, with the place of every key and value."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from pathlib import Path as FilePath
from typing import Final, TypeAlias

import yaml

from stability.process_settings import uncollected
from stackdsl.diagnostics import Diagnostic, Page, ScenarioWarning, Span, meant_choice, page_of
from stackdsl.disk import Content, read_file, with_digest
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
from stackdsl.user_files import read_user_file

# YAML text as plain values, with the place of every key and value. The reader rejects ambiguous YAML.
#
# The pure-Python parser is used where libyaml is missing. A text that both accept gives the same values and places; the
# former rejects a little more, such as `[why?]`.


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
Area: TypeAlias = tuple[tuple[float, float], tuple[float, float]]  # its lowest and highest corner in plan [m]
Plain: TypeAlias = Scalar | list["Plain"] | dict[str, "Plain"]

MAX_BYTES: Final = 1 << 20  # far more than in files written by hand; parsing takes seconds at most
MAX_SCENARIOS: Final = 2000  # of one file; a second
MOST_BESIDE: Final = 1000  # files of a folder that are searched for a similar name
MAX_ALIASED: Final = 20_000  # values that the aliases of one file may repeat

BOM: Final = "\ufeff"
YAML_LOADER: type[yaml.SafeLoader] | type[yaml.CSafeLoader] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True)
class Source:
    """One YAML document: its values, and the place of each."""

    file: str
    values: dict[str, Plain]
    value_spans: Mapping[KeyPath, Span]
    key_spans: Mapping[KeyPath, Span]  # places of keys; list items have none
    inherited: frozenset[KeyPath] = frozenset()  # variables from another scenario, which may stay unused
    parts: tuple[str, ...] = ()  # the other files that it uses
    warnings: tuple[ScenarioWarning, ...] = ()  # about these files; they do not stop a run
    files: Mapping[str, str] = field(default_factory=dict)  # texts of mesh files by path
    # of imported loads, by the path of the step; with their permitted overhang
    decks: Mapping[KeyPath, Area] = field(default_factory=dict)
    ambiguous: tuple[Diagnostic, ...] = ()  # words that some YAML parsers read as booleans, here read as text

    def span_of(self, path: KeyPath) -> Span:
        """Return the place of the value at `path`, or else of the closest ancestor that exists."""
        while path not in self.value_spans:
            path = path[:-1]
        return self.value_spans[path]

    def key_span_of(self, path: KeyPath) -> Span:
        """Return the place of the key at `path`, or else the result of `span_of`."""
        return self.key_spans.get(path) or self.span_of(path)


@dataclass(frozen=True, slots=True)
class Loaded:
    """The content of a file: documents without mistakes, and the mistakes of the others in the order of the text.

    The diagnostics include those of ambiguous words, whose documents are kept to know which values they should be.
    """

    sources: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]
    digest: str = ""  # SHA-256 of the bytes; empty if the file cannot be read


def load(path: FilePath, within: str = "", content: Content | None = None) -> Loaded:
    """Read and parse a file. All errors are diagnostics, never exceptions.

    `within` is the root of the project for a file that another file refers to; it is empty for a file that the user
    names. `content` is that of the file if it was read before.
    """
    file = visible(path.as_posix())
    if file != path.as_posix():  # the escaped name in messages and references could be that of another file
        hidden = "its name has characters that cannot be displayed"
        return _refused(Diagnostic("SD001", Span(file, 1, 1, 1), f"cannot read the file: {hidden}", "rename it"))
    try:
        if content is None:
            read = partial(read_file, within=within) if within else read_user_file
            content = with_digest(read(path, MAX_BYTES + 1))
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or str(error)
        missing = isinstance(error, FileNotFoundError)
        hint = _instead_of_missing(path) if missing else "check the path and the permissions of the file"
        return _refused(Diagnostic("SD001", Span(file, 1, 1, 1), f"cannot read the file: {reason}", hint))
    return parsed(content, file)


def similar_file(path: str, beside: str = "") -> str:
    """Return the remedy for a missing file: another file of a similar name in its folder; empty if there is none.

    `beside` is the file that names it, which is not proposed.
    """
    folder, name = os.path.split(path)
    try:
        with os.scandir(folder or ".") as entries:
            files = [entry.name for entry in islice(entries, MOST_BESIDE) if entry.is_file()]
    except (OSError, ValueError):  # as above
        return ""
    others = sorted({*files} - {os.path.basename(beside)})
    meant = meant_choice(name, others) or next((each for each in others if os.path.splitext(each)[0] == name), "")
    return f"did you mean '{visible(os.path.join(folder, meant))}'?" if meant else ""


def _instead_of_missing(path: FilePath) -> str:
    """Return the remedy for a missing file."""
    if set("*?[") & set(path.name):
        return "no file matches this pattern; name a file, or a directory for all files in it"
    if not os.path.isdir(path.parent):
        return f"there is no directory '{visible(path.parent.as_posix())}'; check the path"
    return similar_file(str(path)) or "check the path, or create a scenario with `stackdsl new NAME`"


@uncollected()
def parsed(content: Content, file: str) -> Loaded:
    """Parse the content of a file; `file` is its name for diagnostics."""
    if len(content.data) > MAX_BYTES:
        return _refused(_too_large(file))
    text = decoded(content.data, file)
    return _refused(text) if isinstance(text, Diagnostic) else replace(parse(text, file), digest=content.digest)


def parse(text: str, file: str) -> Loaded:
    """Parse the documents of one file; each is one scenario."""
    if len(text) > MAX_BYTES:
        return _refused(_too_large(file))
    # With a final newline both parsers agree, and the marks of their errors are within the lines of the text.
    ended = text if text.endswith("\n") else text + "\n"
    page = page_of(ended.removeprefix(BOM), file)
    unreadable = tuple(islice(unreadable_characters(page), MAX_MISTAKES))
    return Loaded((), unreadable) if unreadable else _read(page)


def _refused(diagnostic: Diagnostic) -> Loaded:
    return Loaded((), (diagnostic,))


def _too_large(file: str) -> Diagnostic:
    message = f"the file is larger than {MAX_BYTES >> 20} MiB"
    return Diagnostic("SD006", Span(file, 1, 1, 1), message, "split it into several files")


UTF_16: Final = (b"\xff\xfe", b"\xfe\xff")  # how text of that encoding begins
ARCHIVE: Final = b"PK\x03\x04"  # how an archive begins, and so a workbook
SAVE_AS_UTF_8: Final = "save the file as UTF-8"


def decoded(data: bytes, file: str, encoding: str = "utf-8") -> str | Diagnostic:
    """Return the text of a file, or the reason why it has none."""
    start = Span(file, 1, 1, 1)
    if data.startswith(UTF_16):
        return Diagnostic("SD002", start, "the text of the file is UTF-16", SAVE_AS_UTF_8)
    if data.startswith(ARCHIVE) or b"\0" in data:
        hint = "choose the right file; save a workbook or an archive as text first, such as CSV"
        return Diagnostic("SD002", start, "the file is not a text file", hint)
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        page = page_of(data.decode(encoding, "replace").removeprefix(BOM), file)
        before = page_of(data[: error.start].decode(encoding, "replace").removeprefix(BOM), file).lines
        span = page.span(len(before) - 1, len(before[-1]))
        name = "UTF-8" if encoding == "utf-8" else encoding
        return Diagnostic("SD002", span, f"the byte 0x{data[error.start]:02x} is not {name}", SAVE_AS_UTF_8)


def _read(page: Page) -> Loaded:
    reading = Reading(page, yaml.parse(page.text, Loader=YAML_LOADER))
    sources: list[Source] = []
    before = 0
    try:
        for event in reading.events:
            if isinstance(event, yaml.DocumentStartEvent):
                before = len(reading.ambiguous)
                root = document(reading, event)
                ambiguous = tuple(reading.ambiguous[before:])
                sources += [replace(_source(reading, root), ambiguous=ambiguous)] if root else []
                if len(sources) > MAX_SCENARIOS:
                    span = sources[-1].value_spans[()]
                    message = f"the file contains more than {MAX_SCENARIOS} scenarios"
                    raise StopReadingError(Diagnostic("SD006", span, message, "split it into several files"))
        if not sources and not reading.diagnostics:
            reading.report("SD005", page.span(0, 0), "the file contains no scenario", BEGIN)
    except StopReadingError as stop:
        reading.diagnostics.append(stop.diagnostic)
    except yaml.MarkedYAMLError as error:
        del reading.ambiguous[before:]  # they may be keys, in a document without this error
        reading.diagnostics.append(syntax_error(page, error))
    except (ValueError, OverflowError):  # the pure parser raises these for an escape beyond Unicode
        reading.diagnostics.append(Diagnostic("SD004", page.span(*page.last_visible()), *UNKNOWN_ESCAPE))
    mistakes = reading.diagnostics + reading.ambiguous
    ordered = sorted(mistakes, key=lambda mistake: (mistake.span.line, mistake.span.column, mistake.code))
    return Loaded(tuple(sources), tuple(ordered))


# --- nodes to values --------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Expansion:
    """Places of the values of one document, with its aliases expanded."""

    reading: Reading
    value_spans: dict[KeyPath, Span] = field(default_factory=dict)
    key_spans: dict[KeyPath, Span] = field(default_factory=dict)


def _source(reading: Reading, root: Map) -> Source:
    expansion = _Expansion(reading)
    expansion.value_spans[()] = root.span
    values = _mapping(expansion, root, (), None)
    return Source(reading.page.file, values, expansion.value_spans, expansion.key_spans)


def _value(expansion: _Expansion, node: Node, path: KeyPath, alias: Span | None) -> Plain:
    """Return the value of `node` at `path`; `alias` is the place of the outermost alias that repeats it."""
    expansion.value_spans[path] = node.span
    if isinstance(node, Alias):
        alias, node = alias or node.span, node.target
    if alias is not None:
        _count_aliased(expansion.reading, alias)
    if isinstance(node, Leaf):
        return node.value
    assert not isinstance(node, Alias)  # YAML has no anchors on aliases
    if len(path) >= MAX_DEPTH:  # shallow definitions become deep if each repeats the one before
        raise StopReadingError(too_deep(alias or node.span))
    if isinstance(node, Map):
        return _mapping(expansion, node, path, alias)
    return [_value(expansion, item, (*path, index), alias) for index, item in enumerate(node.items)]


def _mapping(expansion: _Expansion, node: Map, path: KeyPath, alias: Span | None) -> dict[str, Plain]:
    expansion.key_spans.update({(*path, key): span for key, span, _ in node.entries})
    return {key: _value(expansion, value, (*path, key), alias) for key, _, value in node.entries}


def _count_aliased(reading: Reading, alias: Span) -> None:
    reading.aliased += 1
    if reading.aliased > MAX_ALIASED:
        message = f"the aliases repeat more than {MAX_ALIASED} values"
        raise StopReadingError(Diagnostic("SD008", alias, message, "replace aliases by values, or use a layout"))


# Places of values that are copied, by their new paths.


@dataclass(frozen=True, slots=True)
class PlaceBuilder:
    """Collects the places of keys and values for a new source."""

    value_spans: dict[KeyPath, Span] = field(default_factory=dict)
    key_spans: dict[KeyPath, Span] = field(default_factory=dict)

    def note(self, source: Source, old: KeyPath, new: KeyPath, where: str = "") -> None:
        """Record that the value at path `new` is the one at path `old` of a source; `where` names the repetition."""
        self.value_spans[new] = _within(source.span_of(old), where)
        if old in source.key_spans:
            self.key_spans[new] = _within(source.key_spans[old], where)

    def note_all(self, source: Source, value: Plain, old: KeyPath, new: KeyPath, where: str = "") -> None:
        """Record a value and all values in it."""
        self.note(source, old, new, where)
        members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, member in members:
            self.note_all(source, member, (*old, key), (*new, key), where)

    def keep(self, source: Source, without: Mapping[KeyPath, object]) -> None:
        """Copy the places of a source, except at and below the paths in `without`, of one or two keys each."""
        for own, spans in ((self.value_spans, source.value_spans), (self.key_spans, source.key_spans)):
            own.update(
                {path: span for path, span in spans.items() if path[:1] not in without and path[:2] not in without}
            )


def _within(span: Span, where: str) -> Span:
    if not where:
        return span
    label = f"{where}, {span.where}" if span.where else where
    # Not by `replace`, which takes five times as long: repeats can have a hundred thousand places.
    return Span(span.file, span.line, span.column, span.end_column, span.excerpt, span.excerpt_column, label, span.key)
