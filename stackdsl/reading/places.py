"""The places of values that move: where in a file each comes from, by where it stands in the end."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from stackdsl.diagnostics import Span
from stackdsl.reading.source import Path, Plain, Source


@dataclass(frozen=True, slots=True)
class Places:
    """As those of a source, in the making."""

    value_spans: dict[Path, Span] = field(default_factory=dict)
    key_spans: dict[Path, Span] = field(default_factory=dict)

    def note(self, source: Source, old: Path, new: Path, where: str = "") -> None:
        """What stands at one path comes from another, perhaps from a repetition or a file that is to be told."""
        self.value_spans[new] = _within(source.span_of(old), where)
        if old in source.key_spans:
            self.key_spans[new] = _within(source.key_spans[old], where)

    def note_all(self, source: Source, value: Plain, old: Path, new: Path, where: str = "") -> None:
        """The same for a value and all that it holds."""
        self.note(source, old, new, where)
        members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, member in members:
            self.note_all(source, member, (*old, key), (*new, key), where)

    def keep(self, source: Source, without: Mapping[Path, object]) -> None:
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
