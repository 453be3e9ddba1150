"""Reads tables of boxes from CSV and JSON, with units in their headers."""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span, meant_choice
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

# The column that an unknown header may mean. It is suggested to the author, never assumed.


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


INVALID_NAME: Final = " is not a valid name"


def likely_column(header: str) -> str:
    """Return the column that a header probably means; "" if none."""
    word = re.sub(r"[^a-z]", "", UNIT.sub("", header.strip()).lower())
    if "weight" in word:  # gross or net, of an article or a unit
        return "mass"
    synonym = next((column for column, words in LIKE.items() if word in words), "")
    return synonym or meant_choice(word, [column for column in LIKE if len(column) > 1])


# A table of boxes with one row per box: CSV, or JSON as a list of objects. The headers contain the units.
#
# | column | meaning |
# |---|---|
# | `name` | name of the box; optional |
# | `length`, `width`, `height` | sides along x, y and z, before the rotation |
# | `mass` | mass |
# | `x`, `y`, `z` | position of the lower corner or of the centre, according to `point` |
# | `yaw` | rotation about the vertical, from x towards y; optional |
# | `friction` | Coulomb coefficient of the box, without a unit; optional, also in each row |
#
# A header is written as `length [mm]`, `length (mm)`, `length/mm`, `length_mm` or `length mm`.


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
    """The text of one cell and its position."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class _Row:
    """One row: its cells by the written header."""

    cells: Mapping[str, _Cell]
    span: Span


@dataclass(frozen=True, slots=True)
class _Column:
    """A column of the table, with its written header and its unit."""

    name: str
    header: str
    unit: Fraction  # in SI, or in degrees


def read_table(reading: LoadReading, options: Import) -> ImportedLoad:
    """Read the boxes of a table. Raises UnreadableLoadError."""
    text = "\n".join(reading.page.lines).lstrip()
    rows = list(_objects(reading) if text.startswith(("[", "{")) else _lines(reading))
    columns = _columns(reading, rows, options)
    if not columns:
        reading.end()
    if columns and options.point is None:
        message = "the table does not state whether x, y, z are the lower corner or the centre of a box"
        hint = "set `point: corner` or `point: centre`"
        reading.undetermined(rows[0].cells[columns["x"].header].span, message, hint)
    boxes = [_box(reading, row, columns, options.point == "corner") for row in rows]
    _refuse_duplicate_names(reading, rows, columns)
    return reading.load([box for box in boxes if box is not None])


# --- rows -------------------------------------------------------------------------------------------------------------


def _lines(reading: LoadReading) -> Iterator[_Row]:
    """Yield the rows of a CSV table; skip blank lines."""
    filled = [number for number, line in enumerate(reading.page.lines) if line.strip()]
    if not filled:
        return
    delimiter = max(DELIMITERS, key=reading.page.lines[filled[0]].count)
    headers = [cell.text.strip() for cell in _cells(reading, filled[0], delimiter)]
    for header in sorted({header for header in headers if headers.count(header) > 1}):
        reading.wrong(reading.page.span(filled[0], 0), f"two columns have the name '{header}'", "keep one of them")
    reading.end()
    for number in filled[1:]:
        cells = _cells(reading, number, delimiter)
        if len(cells) != len(headers):
            message = f"the row has {len(cells)} cells, but the header has {len(headers)}"
            hint = (
                "write decimals with a point instead of a comma"
                if len(cells) > len(headers)
                else "add the missing cells"
            )
            reading.wrong(reading.page.span(number, 0), message, hint)
            continue
        yield _Row(dict(zip(headers, cells, strict=True)), reading.page.span(number, 0))


def _cells(reading: LoadReading, number: int, delimiter: str) -> list[_Cell]:
    """Return the cells of a line with their positions."""
    line = reading.page.lines[number]
    try:
        texts = next(csv.reader([line], delimiter=delimiter, strict=True, skipinitialspace=True))
    except (csv.Error, StopIteration) as error:
        reading.wrong(reading.page.span(number, 0), f"the line is invalid CSV: {error}", "correct the quotes")
        return []
    starts = [0]
    cell = re.compile(_CELL.format(delimiter))
    while (match := cell.match(line, starts[-1])) and match.end() < len(line):
        starts.append(match.end() + 1)
    column = dict(enumerate(starts))
    return [_Cell(text, reading.page.span(number, column.get(n, 0))) for n, text in enumerate(texts)]


def _objects(reading: LoadReading) -> Iterator[_Row]:
    """Yield the rows of a JSON table."""
    json = json_text(reading)
    for node in json.items(json.root, "the table"):
        row = json.mapping(node, "the row")
        cells = {key.strip(): _Cell(_text(member), json.span(member)) for key, member in row.items()}
        if len(cells) < len(row):
            reading.wrong(json.span(node), "two keys differ only in spaces", "keep one of them")
        invalid = [member for member in row.values() if not isinstance(member.value, str | Numeral)]
        for member in invalid:
            reading.wrong(json.span(member), "the cell is neither a number nor a string", "write a number or a string")
        if invalid:
            continue
        yield _Row(cells, json.span(node))


def _text(node: Node) -> str:
    return node.value.text if isinstance(node.value, Numeral) else node.value if isinstance(node.value, str) else ""


# --- columns ----------------------------------------------------------------------------------------------------------


def _columns(reading: LoadReading, rows: Sequence[_Row], options: Import) -> Mapping[str, _Column]:
    """Return the columns by name; report mistakes and return {} if a column is missing, repeated or without a unit."""
    if not rows:
        return {}
    columns: dict[str, _Column] = {}
    without_unit: list[tuple[str, Span]] = []
    unsupported: dict[str, re.Match[str] | None] = {}
    before = len(reading.mistakes)
    headers = {header: cell.span for row in rows for header, cell in row.cells.items()}
    where = reading.page.span(next((n for n, line in enumerate(reading.page.lines) if line.strip()), 0), 0)
    for header, span in headers.items():
        match = _HEADER.fullmatch(header)
        name = match["name"].lower() if match else ""
        if header in reading.ignored:
            reading.skip(header, span, harmless=False)
        elif match is None or name not in COLUMNS:
            unsupported[header] = match
        elif name in columns:
            reading.wrong(span, f"both '{columns[name].header}' and '{header}' specify the {name}", "keep one of them")
        else:
            written = (match["a"] or match["b"] or match["c"] or "").strip()
            written = written or _default_unit(name, options)
            if not written and name not in BARE:
                without_unit.append((name, _header_span(reading, header, span)))
                continue
            unit = _unit(reading, name, written, _header_span(reading, header, span))
            if unit is not None:
                columns[name] = _Column(name, header, unit)
    known = {*columns, *(name for name, _ in without_unit)}
    _refuse_unsupported(reading, unsupported, headers, [name for name in NEEDED if name not in known])
    if without_unit:
        names, (first, where_first) = [name for name, _ in without_unit], without_unit[0]
        plural, told = len(names) > 1, ", ".join(f"`{name}`" for name in names)
        message = f"the columns {told} have no unit" if plural else f"the column {told} has no unit"
        reading.undetermined(where_first, message, _example(first, names))
    missing = [name for name in NEEDED if name not in columns]
    wrong = len(reading.mistakes) > before
    if missing and not wrong:
        message = f"the table has no column {', '.join(f'`{name}`' for name in missing)}"
        reading.undetermined(where, message, _example(missing[0]))
    return {} if missing or wrong else columns


def _refuse_unsupported(
    reading: LoadReading,
    unsupported: Mapping[str, re.Match[str] | None],
    spans: Mapping[str, Span],
    missing: Sequence[str],
) -> None:
    """Report all headers of no known column together, with the columns that they probably mean."""
    if not unsupported:
        return
    headers = list(unsupported)
    meant = {header: name for header in headers if (name := likely_column(header))}
    if len(headers) == 1:
        (header,) = headers
        advice = f"if it is the {meant[header]}, write '{_rewritten(header, unsupported)}'" if meant else ""
        reading.skip(header, _header_span(reading, header, spans[header]), harmless=False, advice=advice)
        return
    others = [header for header in headers if header not in meant] or headers
    hints = [f"'{_rewritten(header, unsupported)}' for '{header}'" for header in meant]
    told = [f"write {', '.join(hints)}"] if hints else []
    unknown = [f"`{name}`" for name in missing if name not in meant.values()]
    told += [f"the table {'also ' * bool(hints)}needs {', '.join(unknown)}"] if unknown else []
    told.append(f"to ignore columns, write `ignore: [{', '.join(map(repr, others))}]`")
    message = f"the columns {', '.join(map(repr, headers))} are not supported"
    reading.undetermined(_header_span(reading, headers[0], spans[headers[0]]), message, "; ".join(told))


def _rewritten(header: str, unsupported: Mapping[str, re.Match[str] | None]) -> str:
    """Return the header of the column that a header probably means, with its unit."""
    name, match = likely_column(header), unsupported[header]
    written = "" if match is None else (match["a"] or match["b"] or "").strip()
    if not written and (ending := re.search(r"_(mm|cm|m|g|kg|t|deg)$", header)):
        written = ending[1]
    return name if name in BARE else f"{name} [{written}]" if written else f"{name} [its unit]"


def _header_span(reading: LoadReading, header: str, span: Span) -> Span:
    """Return the position of a header: in the first line of CSV, or as given in JSON, where every row has its own."""
    for number, line in enumerate(reading.page.lines):
        if line.strip():
            start = line.find(header)
            return reading.page.span(number, start) if start >= 0 and line.lstrip()[0] not in "[{" else span
    return span


def _default_unit(name: str, options: Import) -> str:
    """Return the unit that the author gives for columns without one; empty for none."""
    if options.units is None or name in BARE or name == "yaw":
        return ""
    return (options.units.mass if name == "mass" else options.units.length) or ""


def _unit(reading: LoadReading, name: str, unit: str, span: Span) -> Fraction | None:
    """Return the unit of a column; report and return None if it is unknown."""
    if name == "friction" and unit:
        hint = "write the header 'friction' without a unit, and numbers such as 0.4"
        reading.undetermined(span, f"a friction coefficient has no unit, but this column has the unit '{unit}'", hint)
        return None
    if name in BARE:
        return Fraction(1)
    units = IN_KILOGRAMS if name == "mass" else DEGREES if name == "yaw" else IN_METRES
    if unit not in units:
        reading.undetermined(span, f"'{unit}' is not a known unit of {name}", f"choose from: {', '.join(units)}")
    return units.get(unit)


def _example(name: str, names: Sequence[str] = ()) -> str:
    """Return how to give the units of columns: in a header such as that of `name`, or for all of `names`."""
    unit = "kg" if name == "mass" else "deg" if name == "yaw" else "mm"
    kinds = {"mass" if each == "mass" else "length" for each in names or [name] if each != "yaw"}
    units = ", ".join(f"{kind}: {usual}" for kind, usual in (("length", "mm"), ("mass", "kg")) if kind in kinds)
    return f"write the header '{name} [{unit}]'" + (f", or set `units: {{{units}}}`" if units else "")


# --- boxes ------------------------------------------------------------------------------------------------------------


def _box(reading: LoadReading, row: _Row, columns: Mapping[str, _Column], of_corner: bool) -> ImportedBox | None:
    units, cells = UnitReader(reading, Fraction(1)), {}
    for name, column in columns.items():
        cell = row.cells.get(column.header)
        if cell is None:
            reading.wrong(row.span, f"the row has no value for '{column.header}'", "add the value")
            return None
        cells[name] = cell

    def unit(name: str) -> Fraction:
        return columns[name].unit

    size = [units.side(cells[n].text, cells[n].span, f"`{n}`", unit(n)) for n in SIDES]
    position = [units.coordinate(cells[n].text, cells[n].span, f"`{n}`", unit(n)) for n in PLACE]
    mass = units.mass(cells["mass"].text, cells["mass"].span, "`mass`", unit("mass"))
    yaw = units.number(cells["yaw"].text, cells["yaw"].span, "`yaw`") if "yaw" in cells else (Fraction(0),)
    if None in size or None in position or mass is None or yaw is None or not _is_valid_friction(reading, cells):
        return None
    length, width, height = (side for side in size if side is not None)
    x, y, z = (part for part in position if part is not None)
    if of_corner and yaw[0] != 0:
        message = "the lower corner of a rotated box is ambiguous"
        reading.undetermined(cells["yaw"].span, message, "write the positions of the centres, and set `point: centre`")
        return None
    if abs(yaw[0]) > 360:  # noqa: PLR2004 -- [deg]
        reading.wrong(cells["yaw"].span, "`yaw` exceeds 360 deg", "write an angle in degrees, from -360 to 360")
        return None
    if of_corner:
        x, y, z = x + length / 2, y + width / 2, z + height / 2
    name = cells["name"].text.strip() if "name" in cells else ""
    if name and not re.fullmatch(NAME, name):
        # The other names of the column are mostly of the same form, so one message is enough.
        if not any(mistake.message.endswith(INVALID_NAME) for mistake in reading.mistakes):
            hint = "begin each name with a letter, then use letters, digits, _ . or -"
            hint += "; or leave the column out with `ignore`"
            reading.wrong(cells["name"].span, f"'{name}'{INVALID_NAME}", hint)
        return None
    turn = (Fraction(0), Fraction(0), yaw[0])
    number = number_of(cells["friction"].text.strip()) if "friction" in cells else None
    friction = number[0] if number is not None else None
    return ImportedBox(name or None, (length, width, height), (x, y, z), mass, row.span, turn, friction=friction)


def _is_valid_friction(reading: LoadReading, cells: Mapping[str, _Cell]) -> bool:
    """Return whether a row has a valid friction or none; report an invalid one."""
    cell = cells.get("friction")
    if cell is None or not cell.text.strip():
        return True
    number = number_of(cell.text.strip())
    if number is None or not 0 <= number[0] <= ROUGHEST:
        message = f"`friction`: '{cell.text.strip()[:LONGEST_TOLD]}' is not a friction coefficient"
        reading.wrong(
            cell.span, message, f"write a number from 0 to {ROUGHEST} without a unit, or leave the cell empty"
        )
        return False
    return True


def _refuse_duplicate_names(reading: LoadReading, rows: Sequence[_Row], columns: Mapping[str, _Column]) -> None:
    seen: set[str] = set()
    for row in rows if "name" in columns else ():
        cell = row.cells.get(columns["name"].header)
        if cell is None or not (name := cell.text.strip()):
            continue
        if name in seen:
            reading.wrong(cell.span, f"two boxes have the name '{name}'", "give each a different name")
        seen.add(name)
