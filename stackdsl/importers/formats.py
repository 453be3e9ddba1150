"""Reads loads by format, and writes a load as a scenario."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import yaml

from stackdsl.diagnostics import Diagnostic, Span, page_of
from stackdsl.importers.imported_friction import written_world
from stackdsl.importers.load import ImportedLoad, LoadReading, UnreadableLoadError, shifted, written_box
from stackdsl.importers.meshes import read_compas, read_obj
from stackdsl.importers.pallets import read_bed_bpp, read_pallet_sim
from stackdsl.importers.tables import read_table
from stackdsl.language.imports import FORMATS, Format, Import
from stackdsl.language.yaml.parsing import unreadable_characters
from stackdsl.language.yaml.source import Plain

# Which reader takes which format, and the bytes of a file as a load.


MAX_IMPORTED: Final = 16 << 20  # [bytes] of one file
_CORNER: Final = re.compile(r"^v\s+[-+.\d]", re.MULTILINE)  # lines of an OBJ file
_ROOT: Final = re.compile(r"\A(?:<\?[^>]*>|<!--(?:(?!-->).)*-->|<!(?!--)[^>]*>|\s)*<(mujoco|robot)\b", re.DOTALL)
_FACE: Final = re.compile(r"^f\s+-?\d", re.MULTILINE)

READERS: Final[Mapping[Format, Callable[[LoadReading, Import], ImportedLoad]]] = {
    "table": read_table,
    "pallet-sim": lambda reading, asked: read_pallet_sim(reading, asked.load),
    "bed-bpp": lambda reading, asked: read_bed_bpp(reading, asked.load),
    "compas": read_compas,
    "obj": read_obj,
    "mjcf": lambda reading, asked: _of_engines("mjcf", reading, asked),
    "urdf": lambda reading, asked: _of_engines("urdf", reading, asked),
}


def _of_engines(format_: Format, reading: LoadReading, asked: Import) -> ImportedLoad:
    """Scenes for engines, whose readers bring numpy and scipy."""
    from stackdsl.importers.robots import read_mjcf, read_urdf  # noqa: PLC0415 -- they bring numpy

    return (read_mjcf if format_ == "mjcf" else read_urdf)(reading, asked)


def read_load(data: bytes, file: str, asked: Import, beside: Callable[[str], bytes] | None = None) -> ImportedLoad:
    """The load in the bytes of a file, which is called so. Raises UnreadableLoadError.

    `beside` gives what a file holds that this one names, as seen from it; it raises OSError.
    """
    if len(data) > MAX_IMPORTED:
        message = f"the file is larger than {MAX_IMPORTED >> 20} MiB"
        raise UnreadableLoadError([Diagnostic("SD006", Span(file, 1, 1, 1), message, "save the load by itself")])
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = page_of(data[: error.start].decode("utf-8", "replace"), file).lines
        page = page_of(data.decode("utf-8", "replace"), file)
        span, message = page.span(len(before) - 1, len(before[-1])), f"the byte 0x{data[error.start]:02x} is not UTF-8"
        raise UnreadableLoadError([Diagnostic("SD002", span, message, "save the file as UTF-8")]) from error
    page = page_of(text, file)
    if (odd := next(unreadable_characters(page_of(text.replace("\t", " "), file)), None)) is not None:
        raise UnreadableLoadError([odd])
    reading = LoadReading(page, frozenset(asked.ignore), beside=beside)
    format_ = asked.format or _format_of(reading)
    if (wrong := asked.beside(format_)) is not None:
        reading.open(page.span(0, 0), *wrong)
        reading.end()
    return shifted(READERS[format_](reading, asked), asked.origin)


def _format_of(reading: LoadReading) -> Format:
    """The only format that a file may be of. Raises UnreadableLoadError if there is none."""
    text = "\n".join(reading.page.lines).lstrip()
    if text.startswith("["):
        return "table"
    if text.startswith("{"):
        signs: tuple[tuple[Format, tuple[str, ...]], ...] = (
            ("pallet-sim", ('"pallets"', '"articles"')),
            ("bed-bpp", ('"flb_coordinates"',)),
            ("compas", ('"dtype"', '"graph"', '"block"')),
        )
        found = [format_ for format_, words in signs if all(word in text for word in words)]
        if len(found) == 1:
            return found[0]
    elif (root := _ROOT.search(text)) is not None:
        return "mjcf" if root[1] == "mujoco" else "urdf"
    elif _CORNER.search(text) and _FACE.search(text):
        return "obj"
    elif text and not text.startswith("<"):
        return "table"
    reading.open(reading.page.span(0, 0), "what this is cannot be told", f"say `format`: {', '.join(FORMATS)}")
    raise UnreadableLoadError(reading.mistakes)


# A load as the text of a scenario of its own, a line a box.


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
