"""A load as the text of a scenario of its own, a line a box."""

import re
from collections.abc import Iterator, Sequence

import yaml

from stackdsl.importing.kept_surfaces import written_world
from stackdsl.importing.load import ImportedLoad
from stackdsl.importing.written_load import written_box
from stackdsl.reading.source import Plain

LONGEST_SLUG = 64


def scenario_text(name: str, notes: Sequence[str], load: ImportedLoad, friction: float) -> str:
    """YAML that builds the boxes of a load one after the other; `notes` are comments at its head."""
    return "\n".join(_lines(name, notes, load, friction)) + "\n"


def _lines(name: str, notes: Sequence[str], load: ImportedLoad, friction: float) -> Iterator[str]:
    yield from (f"# {note}" for note in notes)
    yield f"scenario: {name}"
    yield f"friction: {friction!r}"
    if load.surfaces is not None:
        yield f"world: {_flow(written_world(load.surfaces))}"
    yield "build:"
    yield "  - every: 1 s"
    yield "    bricks:"
    yield from (f"      - {_flow(written_box(box))}" for box in load.boxes)
    yield "expect:"
    yield "  - stands: all"


def _flow(value: Plain) -> str:
    return yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True).strip()


def slug(text: str) -> str:
    """A name for a scenario, made of a text."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:LONGEST_SLUG].strip("-") or "load"
