"""Which reader takes which format, and the bytes of a file as a load."""

import re
from collections.abc import Callable, Mapping
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span, page_of
from stackdsl.importing.bed_bpp import read_bed_bpp
from stackdsl.importing.box_table import read_table
from stackdsl.importing.compas_assembly import read_compas
from stackdsl.importing.load import ImportedLoad, LoadReading, UnreadableLoadError
from stackdsl.importing.obj_bricks import read_obj
from stackdsl.importing.origin import shifted
from stackdsl.importing.pallet_sim import read_pallet_sim
from stackdsl.language.imports import FORMATS, Format, Import
from stackdsl.reading.characters import unreadable_characters

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
    from stackdsl.importing.mjcf import read_mjcf  # noqa: PLC0415 -- as said
    from stackdsl.importing.urdf import read_urdf  # noqa: PLC0415

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
