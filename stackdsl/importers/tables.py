"""Reads tables of boxes from CSV and JSON, with units in their headers."""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span
from stackdsl.importers.load import ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import (
    IN_KILOGRAMS,
    IN_METRES,
    LONGEST_TOLD,
    ROUGHEST,
    Node,
    Numeral,
    UnitReader,
    json_text,
    number_of,
)
from stackdsl.language.imports import Import
from stackdsl.language.value_types import NAME

# Which column of a table a header may mean that is none: its author is asked, nothing is guessed.


LIKE: Final[Mapping[str, Sequence[str]]] = {
    "name": ("id", "label", "box", "item", "carton", "sku", "no", "nr", "number", "key"),
    "length": ("l", "len", "dx", "sx", "lx", "sizex"),
    "width": ("w", "depth", "d", "breadth", "b", "dy", "sy", "ly", "sizey"),
    "height": ("h", "dz", "sz", "lz", "thickness", "sizez"),
    "mass": ("weight", "wt", "load", "kg"),
    "x": ("posx", "px", "cx", "xpos", "left"),
    "y": ("posy", "py", "cy", "ypos", "front"),
    "z": ("posz", "pz", "cz", "zpos", "bottom", "level"),
    "friction": ("mu", "cof"),
    "yaw": ("rotation", "rot", "angle", "orientation", "theta", "turn"),
}
UNIT: Final = re.compile(r"[\[(/].*|_(?:mm|cm|m|in|g|kg|t|lb|deg)$", re.IGNORECASE)


def likely_column(header: str) -> str:
    """The column that a header seems to be meant as; empty where nothing says so."""
    word = re.sub(r"[^a-z]", "", UNIT.sub("", header.strip()).lower())
    named = next((column for column, words in LIKE.items() if word in words), "")
    close = get_close_matches(word, [column for column in LIKE if len(column) > 1], n=1, cutoff=0.75)
    return named or (close[0] if close else "")


# A table of boxes: CSV, or JSON as a list of objects, a row a box, whose columns say their units.
#
# | column | what it is |
# |---|---|
# | `name` | what the box is called; may be missing |
# | `length`, `width`, `height` | its sides along x, y and z, before it is turned |
# | `mass` | its mass |
# | `x`, `y`, `z` | its place: of the lower corner or of the centre, as `point` says |
# | `yaw` | its turn about the vertical, from x towards y; may be missing |
# | `friction` | its own Coulomb coefficient, without a unit; may be missing, or empty where it has none of its own |
#
# Headers are such as `length [mm]`, `length (mm)`, `length/mm`, `length_mm` or `length mm`.


SIDES: Final = ("length", "width", "height")
PLACE: Final = ("x", "y", "z")
NEEDED: Final = (*SIDES, "mass", *PLACE)
COLUMNS: Final = ("name", *NEEDED, "yaw", "friction")
BARE: Final = ("name", "friction")  # columns without a unit
DEGREES: Final = {"deg": Fraction(1)}
DELIMITERS: Final = ",;\t"
_HEADER: Final = re.compile(r"\s*(?P<name>[A-Za-z]+)\s*(?:\[(?P<a>.*)\]|\((?P<b>.*)\)|(?:[/_]|(?<=\s))(?P<c>.*))?\s*")
_CELL: Final = r'\s*"(?:[^"]|"")*"[^{0}]*|[^{0}]*'


@dataclass(frozen=True, slots=True)
class _Cell:
    """What stands in a row under a header, and where."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class _Row:
    """One row: its cells by the header above them, as that is written."""

    cells: Mapping[str, _Cell]
    span: Span


@dataclass(frozen=True, slots=True)
class _Column:
    """Which column it is, and of which unit."""

    name: str
    header: str
    unit: Fraction  # in SI, or in degrees


def read_table(reading: LoadReading, asked: Import) -> ImportedLoad:
    """The boxes of a table. Raises UnreadableLoadError."""
    text = "\n".join(reading.page.lines).lstrip()
    rows = list(_objects(reading) if text.startswith(("[", "{")) else _lines(reading))
    columns = _columns(reading, rows, asked)
    if not columns:
        reading.end()
    if columns and asked.point is None:
        message = "x, y, z may be of the lower corner or of the centre of a box"
        reading.open(rows[0].cells[columns["x"].header].span, message, "say which: point: corner, or point: centre")
    made = [_box(reading, row, columns, asked.point == "corner") for row in rows]
    _names_apart(reading, rows, columns)
    return reading.load([box for box in made if box is not None])


# --- rows -------------------------------------------------------------------------------------------------------------


def _lines(reading: LoadReading) -> Iterator[_Row]:
    """The rows of CSV; lines that are blank are passed over."""
    filled = [number for number, line in enumerate(reading.page.lines) if line.strip()]
    if not filled:
        return
    delimiter = max(DELIMITERS, key=reading.page.lines[filled[0]].count)
    headers = [cell.text.strip() for cell in _cells(reading, filled[0], delimiter)]
    for header in sorted({header for header in headers if headers.count(header) > 1}):
        reading.wrong(reading.page.span(filled[0], 0), f"two columns are called '{header}'", "keep one of them")
    reading.end()
    for number in filled[1:]:
        cells = _cells(reading, number, delimiter)
        if len(cells) != len(headers):
            message = f"the row has {len(cells)} cells, and the header {len(headers)}"
            hint = "a decimal comma is written as a point" if len(cells) > len(headers) else "complete it"
            reading.wrong(reading.page.span(number, 0), message, hint)
            continue
        yield _Row(dict(zip(headers, cells, strict=True)), reading.page.span(number, 0))


def _cells(reading: LoadReading, number: int, delimiter: str) -> list[_Cell]:
    """The cells of a line, each in its place."""
    line = reading.page.lines[number]
    try:
        texts = next(csv.reader([line], delimiter=delimiter, strict=True, skipinitialspace=True))
    except (csv.Error, StopIteration) as error:
        reading.wrong(reading.page.span(number, 0), f"this is no line of CSV: {error}", "mend the quotes of the line")
        return []
    starts = [0]
    cell = re.compile(_CELL.format(delimiter))
    while (found := cell.match(line, starts[-1])) and found.end() < len(line):
        starts.append(found.end() + 1)
    column = dict(enumerate(starts))
    return [_Cell(text, reading.page.span(number, column.get(n, 0))) for n, text in enumerate(texts)]


def _objects(reading: LoadReading) -> Iterator[_Row]:
    """The rows of JSON."""
    json = json_text(reading)
    for node in json.items(json.root, "the table"):
        row = json.mapping(node, "the row")
        cells = {key.strip(): _Cell(_text(member), json.span(member)) for key, member in row.items()}
        if len(cells) < len(row):
            reading.wrong(json.span(node), "two keys differ by spaces only", "keep one of them")
        strange = [member for member in row.values() if not isinstance(member.value, str | Numeral)]
        for member in strange:
            reading.wrong(json.span(member), "the cell is neither a number nor a text", "write a number or a text")
        if strange:
            continue
        yield _Row(cells, json.span(node))


def _text(node: Node) -> str:
    return node.value.text if isinstance(node.value, Numeral) else node.value if isinstance(node.value, str) else ""


# --- columns ----------------------------------------------------------------------------------------------------------


def _columns(reading: LoadReading, rows: Sequence[_Row], asked: Import) -> Mapping[str, _Column]:
    """What each column is, by name; told, and nothing, if anything is missing or left open."""
    if not rows:
        return {}
    found: dict[str, _Column] = {}
    before = len(reading.mistakes)
    headers = {header: cell.span for row in rows for header, cell in row.cells.items()}
    where = reading.page.span(next((n for n, line in enumerate(reading.page.lines) if line.strip()), 0), 0)
    for header, span in headers.items():
        match = _HEADER.fullmatch(header)
        name = match["name"].lower() if match else ""
        if match is None or name not in COLUMNS or header in reading.ignored:
            reading.leave(header, _header_span(reading, header, span), known=False, meant=_meant(header, match))
        elif name in found:
            reading.wrong(span, f"'{found[name].header}' and '{header}' are both the {name}", "keep one of them")
        else:
            written = (match["a"] or match["b"] or match["c"] or "").strip()
            unit = _unit(reading, name, written, asked, _header_span(reading, header, span))
            if unit is not None:
                found[name] = _Column(name, header, unit)
    missing = [name for name in NEEDED if name not in found]
    wrong = len(reading.mistakes) > before
    if missing and not wrong:
        reading.open(where, f"there is no column {', '.join(f'`{name}`' for name in missing)}", _example(missing[0]))
    return {} if missing or wrong else found


def _meant(header: str, match: re.Match[str] | None) -> str:
    """How to call a column that seems to be one of ours; which one it is, only its author knows."""
    if not (name := likely_column(header)):
        return ""
    unit = "" if match is None else (match["a"] or match["b"] or "").strip()
    called = name if name in BARE else f"{name} [{unit}]" if unit else f"{name} [its unit]"
    return f"if it is the {name}, call it '{called}'"


def _header_span(reading: LoadReading, header: str, span: Span) -> Span:
    """Where a header stands in CSV; in JSON every row has its own."""
    for number, line in enumerate(reading.page.lines):
        if line.strip():
            start = line.find(header)
            return reading.page.span(number, start) if start >= 0 and line.lstrip()[0] not in "[{" else span
    return span


def _unit(reading: LoadReading, name: str, written: str, asked: Import, span: Span) -> Fraction | None:
    """One of the unit of a column; told and None if that is not known."""
    if name == "friction" and written:
        reading.open(span, f"a friction has no unit, such as '{written}'", "call it 'friction', of numbers such as 0.4")
        return None
    if name in BARE:
        return Fraction(1)
    known = IN_KILOGRAMS if name == "mass" else DEGREES if name == "yaw" else IN_METRES
    said = asked.units and (asked.units.mass if name == "mass" else None if name == "yaw" else asked.units.length)
    unit = written or said or ""
    if unit in known:
        return known[unit]
    if unit:
        reading.open(span, f"'{unit}' is no unit of {name} that is known", f"choose from: {', '.join(known)}")
    else:
        reading.open(span, f"the column `{name}` says no unit", _example(name))
    return None


def _example(name: str) -> str:
    unit = "kg" if name == "mass" else "deg" if name == "yaw" else "mm"
    key = "mass" if name == "mass" else "length"
    given = "" if name == "yaw" else f", or say `units: {{{key}: {unit}}}`"
    return f"call it '{name} [{unit}]'{given}"


# --- boxes ------------------------------------------------------------------------------------------------------------


def _box(reading: LoadReading, row: _Row, columns: Mapping[str, _Column], of_corner: bool) -> ImportedBox | None:
    measures, cells = UnitReader(reading, Fraction(1)), {}
    for name, column in columns.items():
        cell = row.cells.get(column.header)
        if cell is None:
            reading.wrong(row.span, f"the row has no '{column.header}'", "complete it")
            return None
        cells[name] = cell

    def unit(name: str) -> Fraction:
        return columns[name].unit

    size = [measures.side(cells[n].text, cells[n].span, f"`{n}`", unit(n)) for n in SIDES]
    place = [measures.place(cells[n].text, cells[n].span, f"`{n}`", unit(n)) for n in PLACE]
    mass = measures.mass(cells["mass"].text, cells["mass"].span, "`mass`", unit("mass"))
    yaw = measures.number(cells["yaw"].text, cells["yaw"].span, "`yaw`") if "yaw" in cells else (Fraction(0),)
    if None in size or None in place or mass is None or yaw is None or not _is_friction(reading, cells):
        return None
    length, width, height = (side for side in size if side is not None)
    x, y, z = (part for part in place if part is not None)
    if of_corner and yaw[0] != 0:
        message = "the lower corner of a box that is turned may be any of four"
        reading.open(cells["yaw"].span, message, "give the place of its centre, and say `point: centre`")
        return None
    if abs(yaw[0]) > 360:  # noqa: PLR2004 -- [deg]
        reading.wrong(cells["yaw"].span, "`yaw` is more than a whole turn", "write degrees")
        return None
    if of_corner:
        x, y, z = x + length / 2, y + width / 2, z + height / 2
    name = cells["name"].text.strip() if "name" in cells else ""
    if name and not re.fullmatch(NAME, name):
        reading.wrong(cells["name"].span, f"'{name}' is no name", "begin with a letter, then letters, digits, _ . or -")
        return None
    turn = (Fraction(0), Fraction(0), yaw[0])
    rubs = number_of(cells["friction"].text.strip()) if "friction" in cells else None
    own = rubs[0] if rubs is not None else None
    return ImportedBox(name or None, (length, width, height), (x, y, z), mass, row.span, turn, friction=own)


def _is_friction(reading: LoadReading, cells: Mapping[str, _Cell]) -> bool:
    """Whether a row says a friction that a box may have, or none."""
    cell = cells.get("friction")
    if cell is None or not cell.text.strip():
        return True
    found = number_of(cell.text.strip())
    if found is None or not 0 <= found[0] <= ROUGHEST:
        message = f"`friction`: '{cell.text.strip()[:LONGEST_TOLD]}' is no coefficient"
        reading.wrong(cell.span, message, f"write a number from 0 to {ROUGHEST}, without a unit, or nothing")
        return False
    return True


def _names_apart(reading: LoadReading, rows: Sequence[_Row], columns: Mapping[str, _Column]) -> None:
    seen: set[str] = set()
    for row in rows if "name" in columns else ():
        cell = row.cells.get(columns["name"].header)
        if cell is None or not (name := cell.text.strip()):
            continue
        if name in seen:
            reading.wrong(cell.span, f"two boxes are called '{name}'", "call them apart")
        seen.add(name)
