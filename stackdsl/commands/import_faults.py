"""What `stackdsl check` will say of an imported scenario as it is written, with the places in the file of the load."""

from collections.abc import Sequence
from dataclasses import replace

from stackdsl.checking.gathering import cases_of
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importing.load import ImportedBox
from stackdsl.reading.source import Path, Source, parse


def faults(text: str, file: str, boxes: Sequence[ImportedBox]) -> list[Diagnostic]:
    """The mistakes of the text of a scenario that builds these boxes, such as boxes inside one another.

    `file` is what is told of those that are of no box.
    """
    loaded = parse(text, file)
    _, mistakes = cases_of(replace(loaded, sources=tuple(_placed(source, boxes) for source in loaded.sources)))
    return mistakes


def _placed(source: Source, boxes: Sequence[ImportedBox]) -> Source:
    """A scenario whose bricks stand where the boxes do in their own file."""
    places: dict[Path, Span] = {("build", 0, "bricks", number): box.span for number, box in enumerate(boxes)}
    return replace(source, value_spans={**source.value_spans, **places})
