"""Reads a load in any supported format, and writes a load as a scenario."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath
from typing import Final

import yaml

from stackdsl.diagnostics import Diagnostic, Span, page_of
from stackdsl.importers.built_deck import BuiltDeck
from stackdsl.importers.imported_friction import written_world
from stackdsl.importers.ldraw import read_ldraw
from stackdsl.importers.lego import read_brickgpt, read_stablelego
from stackdsl.importers.load import ImportedLoad, LoadReading, UnreadableLoadError, shifted, written_box
from stackdsl.importers.meshes import read_compas, read_obj, read_ply, read_stl
from stackdsl.importers.pallets import read_bed_bpp, read_pallet_sim
from stackdsl.importers.tables import DELIMITERS, read_table
from stackdsl.importers.text_positions import json_text
from stackdsl.language.imports import LOAD_FORMATS, Format, Import
from stackdsl.language.mesh_files import is_binary_mesh, mesh_kind
from stackdsl.language.yaml.parsing import unreadable_characters
from stackdsl.language.yaml.source import BOM, Plain, decoded

# The reader of each format.


BOM_BYTES: Final = BOM.encode()
MAX_IMPORTED: Final = 16 << 20  # [bytes] of one file
# Formats of files that are not read -> the format in which to save them.
TABLES: Final = (".csv", ".tsv", ".txt")  # endings of tables
WESTERN: Final = "windows-1252"  # in which spreadsheets of the West write them
SAVED_AS: Final[Mapping[str, str]] = {
    **dict.fromkeys((".xlsx", ".xls", ".ods", ".numbers"), "CSV"),
    **dict.fromkeys((".off", ".dae", ".gltf", ".glb", ".fbx", ".3ds", ".blend"), "OBJ, STL or PLY"),
    **dict.fromkeys((".step", ".stp", ".iges", ".igs", ".ifc", ".dxf", ".dwg", ".3dm"), "OBJ, STL or PLY"),
    **dict.fromkeys((".sdf", ".world", ".usd", ".usda", ".usdz", ".xacro"), "URDF or MJCF"),
}
_CORNER: Final = re.compile(r"^v\s+[-+.\d]", re.MULTILINE)  # a line of an OBJ file
_ROOT: Final = re.compile(r"\A(?:<\?[^>]*>|<!--(?:(?!-->).)*-->|<!(?!--)[^>]*>|\s)*<(mujoco|robot)\b", re.DOTALL)
# Patterns of the first line of a file, by format.
FIRST_LINES: Final[Mapping[Format, re.Pattern[str]]] = {
    "stl": re.compile(r"solid\b[^\n]*\n\s*(?:facet|endsolid)\b"),
    "ply": re.compile(r"ply[ \t]*\n"),
    "brickgpt": re.compile(r"\d+x\d+ ?\(\d+,"),
    "ldraw": re.compile(r"0[ \t]+[^\d\s,;]|1(?:[ \t]+[-+.\w]+){13}[ \t]+\S+\.(?:dat|ldr|mpd)\b", re.IGNORECASE),
}
_FACE: Final = re.compile(r"^f\s+-?\d", re.MULTILINE)

READERS: Final[Mapping[Format, Callable[[LoadReading, Import], ImportedLoad]]] = {
    "table": read_table,
    "pallet-sim": lambda reading, options: read_pallet_sim(reading, options.load),
    "bed-bpp": lambda reading, options: read_bed_bpp(reading, options.load),
    "compas": read_compas,
    "obj": read_obj,
    "stl": read_stl,
    "ply": read_ply,
    "stablelego": lambda reading, options: read_stablelego(reading, options.library),
    "apex-mr": lambda reading, options: read_stablelego(reading, options.library, lowest=None),
    "brickgpt": lambda reading, _: read_brickgpt(reading),
    "ldraw": lambda reading, _: read_ldraw(reading),
    "mjcf": lambda reading, options: _read_engine_scene("mjcf", reading, options),
    "urdf": lambda reading, options: _read_engine_scene("urdf", reading, options),
}


def _read_engine_scene(format_: Format, reading: LoadReading, options: Import) -> ImportedLoad:
    from stackdsl.importers.robots import read_mjcf, read_urdf  # noqa: PLC0415 -- they import numpy and scipy

    return (read_mjcf if format_ == "mjcf" else read_urdf)(reading, options)


def read_load(data: bytes, file: str, options: Import, read_file: Callable[[str], bytes] | None = None) -> ImportedLoad:
    """Read a load from the bytes of a file of the given path. Raises UnreadableLoadError.

    `read_file` returns the bytes of another file that this file names, by a path relative to it. It raises OSError.
    """
    if len(data) > MAX_IMPORTED:
        message = f"the file is larger than {MAX_IMPORTED >> 20} MiB"
        raise UnreadableLoadError(
            [Diagnostic("SD006", Span(file, 1, 1, 1), message, "save the load in a file of its own")]
        )
    suffix = PurePath(file).suffix.lower()
    if options.format is None and suffix in SAVED_AS:
        hint = f"save it as {SAVED_AS[suffix]}, and import that"
        mistake = Diagnostic("SD115", Span(file, 1, 1, 1), f"files of type {suffix} are not supported", hint)
        raise UnreadableLoadError([mistake])
    data = data.removeprefix(BOM_BYTES)
    is_binary = is_binary_mesh(data, options.format or mesh_kind(file))
    text = "" if is_binary else decoded(data, file, options.encoding or "utf-8")
    if isinstance(text, Diagnostic):
        raise UnreadableLoadError([_with_encoding(text, data, options, suffix)])
    page = page_of(text, file)
    if (unreadable := next(unreadable_characters(page_of(text.replace("\t", " "), file)), None)) is not None:
        raise UnreadableLoadError([unreadable])
    reading = LoadReading(page, frozenset(options.ignore), read_file=read_file, data=data)
    binary: Format = "ply" if data.startswith(b"ply") else "stl"
    format_ = options.format or (binary if is_binary else _format_of(reading))
    if (conflict := options.beside(format_)) is not None:
        reading.undetermined(page.span(0, 0), *conflict)
        reading.end()
    return shifted(READERS[format_](reading, options), options.origin)


def _with_encoding(mistake: Diagnostic, data: bytes, options: Import, suffix: str) -> Diagnostic:
    """Return why a file has no text, with the encoding to write if it can be a table of a spreadsheet."""
    is_table = options.format == "table" or (options.format is None and suffix in TABLES)
    if not is_table or options.encoding is not None or isinstance(decoded(data, "", WESTERN), Diagnostic):
        return mistake
    return replace(mistake, hint=f"{mistake.hint}, or write `encoding: {WESTERN}`")


def _format_of(reading: LoadReading) -> Format:
    """Detect the format of a file. Raises UnreadableLoadError unless exactly one format fits."""
    text = "\n".join(reading.page.lines).lstrip()
    if text.startswith("scenario:"):
        reading.wrong(reading.page.span(0, 0), "the file is a scenario already", "run `stackdsl check` on it")
        raise UnreadableLoadError(reading.mistakes)
    if text.startswith("["):
        return "table"
    if text.startswith("{"):
        signs: tuple[tuple[Format, tuple[str, ...]], ...] = (
            ("pallet-sim", ('"pallets"', '"articles"')),
            ("bed-bpp", ('"flb_coordinates"',)),
            ("compas", ('"dtype"', '"graph"', '"block"')),
            ("compas", ('"dtype"', '"graph"', '"elements"')),
            ("apex-mr" if '"press_x"' in text else "stablelego", ('"brick_id"', '"ori"')),
        )
        matches = list(dict.fromkeys(format_ for format_, words in signs if all(word in text for word in words)))
    else:
        matches = [format_ for format_, first in FIRST_LINES.items() if first.match(text)]
    if len(matches) == 1:
        return matches[0]
    if text.startswith("{"):
        json_text(reading)  # raises UnreadableLoadError at a syntax error, such as the end of a truncated file
    elif (root := _ROOT.search(text)) is not None:
        return "mjcf" if root[1] == "mujoco" else "urdf"
    elif _CORNER.search(text) and _FACE.search(text):
        return "obj"
    elif not text.startswith("<") and any(mark in text.partition("\n")[0] for mark in DELIMITERS):
        return "table"
    if not text.strip():
        reading.wrong(reading.page.span(0, 0), "the file is empty", "export it again")
        raise UnreadableLoadError(reading.mistakes)
    reading.undetermined(
        reading.page.span(0, 0),
        "the format of the file cannot be recognised",
        f"set `format`: {', '.join(LOAD_FORMATS)}",
    )
    raise UnreadableLoadError(reading.mistakes)


# A load as the text of a scenario, one line per box.


LONGEST_SLUG = 64  # [characters]


def scenario_text(  # noqa: PLR0913, PLR0917 -- a load, and all that is written beside it
    name: str,
    notes: Sequence[str],
    load: ImportedLoad,
    deck: BuiltDeck | None,
    friction: float,
    on_share: Callable[[float], None] = lambda _: None,
) -> str:
    """Return the YAML of a scenario that builds the boxes of a load one by one, on a pallet if it has one.

    `notes` become comments at its head. `on_share` is called with the share of the boxes that are written.
    """
    return "\n".join(_lines(name, notes, load, deck, friction, on_share)) + "\n"


def _lines(  # noqa: PLR0913, PLR0917 -- as `scenario_text`
    name: str,
    notes: Sequence[str],
    load: ImportedLoad,
    deck: BuiltDeck | None,
    friction: float,
    on_share: Callable[[float], None],
) -> Iterator[str]:
    yield from (f"# {note}" for note in notes)
    yield f"scenario: {name}"
    yield f"friction: {friction!r}"
    if load.on_base_plate:
        yield "world: {ground: {studs: lego}}"
    if load.surfaces is not None:
        yield f"world: {_flow(written_world(load.surfaces))}"
    yield "build:"
    # Bricks with studs may hang from later ones, so they are placed together.
    yield "  - bricks:" if load.on_base_plate else "  - every: 1 s\n    bricks:"
    if deck is not None:
        yield f"      - {_flow(deck.written)}"
    for number, box in enumerate(load.boxes, 1):
        yield f"      - {_flow(written_box(box))}"
        on_share(number / len(load.boxes))
    yield "expect:"
    yield "  - stands: all"


def _flow(value: Plain) -> str:
    return yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True).strip()


def slug(text: str) -> str:
    """Return a scenario name made from a text."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:LONGEST_SLUG].strip("-") or "load"
