"""Reads tables of boxes from CSV and JSON, with units in their headers."""

import csv
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

from stackdsl.diagnostics import Span, did_you_mean, meant_choice
from stackdsl.importers.load import TOTALS, Exact3, ImportedBox, ImportedLoad, LoadReading, digits
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
    "name": (
        *("id", "label", "box", "item", "carton", "sku", "no", "nr", "number", "key"),
        *("nve", "sscc", "cartonno", "cartonnr", "cartonid", "cartonnumber", "itemno", "itemid", "boxno", "boxid"),
        *("packageid", "parcelid", "caseid", "karton", "kartonnr", "colli", "collinr", "collo", "collonr", "kollinr"),
        *("artikel", "artikelnr", "packstück"),
    ),
    "length": ("l", "len", "dx", "sx", "lx", "sizex", "länge", "laenge"),
    "width": ("w", "depth", "d", "breadth", "b", "dy", "sy", "ly", "sizey", "breite", "tiefe"),
    "height": ("h", "dz", "sz", "lz", "thickness", "sizez", "höhe", "hoehe"),
    "mass": ("weight", "wt", "load", "kg", "masse"),
    "x": ("posx", "px", "cx", "xpos", "left"),
    "y": ("posy", "py", "cy", "ypos", "front"),
    "z": ("posz", "pz", "cz", "zpos", "bottom"),
    "friction": ("mu", "cof"),
    "rotated": ("gedreht", "turned", "verdreht"),
    "yaw": ("rotation", "rot", "angle", "orientation", "theta", "turn", "drehung", "winkel"),
}
LAYERS: Final = ("layer", "level", "tier", "lage", "ebene")  # numbers from the bottom, which are no heights
GROSS: Final = ("gross", "brutto")  # the mass of a carton with its content and packaging
UNIT: Final = re.compile(r"[\[(/].*|[_\s](?:mm|cm|m|in|g|kg|t|lbs?|deg)$", re.IGNORECASE)
_POSITION: Final = re.compile(r"pos(?:ition)?|[ck]oord(?:inate)?|cent(?:er|re)|corner")


NAME_TWICE: Final = "give each a different name; or leave the column out with `ignore`"
PREFIX: Final = "c"  # of names that begin with a digit, such as numbers of cartons
INVALID_NAME: Final = " is not a valid name"


def likely_column(header: str) -> str:
    """Return the column that a header probably means; "" if none."""
    word = re.sub(r"[\W\d_]", "", UNIT.sub("", header.strip()).lower())
    if "weight" in word or "gewicht" in word:  # gross or net, of an article or a unit
        return "mass"
    if word in LAYERS:
        return ""
    if (axis := _POSITION.sub("", word)) in ("x", "y", "z"):
        return axis
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
# | `rotated` | orientation: whether the length is along y, or the sides along x, y and z, such as WLH; optional |
# | `friction` | Coulomb coefficient of the box, without a unit; optional, also in each row |
#
# A header is written as `length [mm]`, `length (mm)`, `length/mm`, `length_mm` or `length mm`.


SIDES: Final = ("length", "width", "height")
PLACE: Final = ("x", "y", "z")
NEEDED: Final = (*SIDES, "mass", *PLACE)
COLUMNS: Final = ("name", *NEEDED, "yaw", "rotated", "friction")
BARE: Final = ("name", "rotated", "friction")  # columns without a unit
TEXTS: Final = ("name", "rotated")  # columns without numbers
# Whether the length of a box is along y, as tables say it.
ROTATED: Final[Mapping[str, bool]] = {
    **dict.fromkeys(("yes", "y", "true", "1", "ja", "j", "wahr", "x", "90", "270", "-90"), True),
    **dict.fromkeys(("no", "n", "false", "0", "nein", "falsch", "", "-", "180"), False),
}
LABEL_SIDES: Final[Mapping[str, str]] = {"L": "length", "W": "width", "B": "width", "H": "height"}
DEGREES: Final = {"deg": Fraction(1)}
DELIMITERS: Final = ",;\t"
LAYERS_TOLD: Final = 6  # in a message
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
    rows: Sequence[_Row] = list(_objects(reading) if text.startswith(("[", "{")) else _lines(reading))
    rows = _mapped(reading, rows, options.map_.headers()) if options.map_ is not None and rows else rows
    rows = _with_decimal_points(reading, rows, options.decimals)
    columns = _columns(reading, rows, options) if rows else {}
    boxes_only = _only_boxes(reading, rows)
    if "name" in columns and _unusable_name(boxes_only, columns["name"].header):
        reading.proposed["ignore"] = [columns["name"].header]
    if rows and options.point is None:
        _ask_for_point(reading, boxes_only, options)
    if not columns:
        reading.end()
    boxes = [_box(reading, row, columns, options.point == "corner") for row in boxes_only]
    _refuse_duplicate_names(reading, boxes_only, columns)
    likely = _likely_headers(rows)
    load = replace(
        reading.load([box for box in boxes if box is not None]), likely_point=_likely_point(boxes_only, likely, options)
    )
    numbered = "name" in columns and any(
        re.match(r"[0-9]", _text_in(row, columns["name"].header)) for row in boxes_only
    )
    return replace(load, prefix=PREFIX) if numbered else load


def _mapped(reading: LoadReading, rows: Sequence[_Row], headers: Mapping[str, str]) -> Sequence[_Row]:
    """Return the rows with the headers of the author renamed to their columns; each keeps its unit."""
    written = {header: cell.span for row in rows for header, cell in row.cells.items()}
    renamed: dict[str, str] = {}
    start = next((n for n, line in enumerate(reading.page.lines) if line.strip()), 0)
    for column, header in headers.items():
        found = next((each for each in written if header in (each, UNIT.sub("", each).strip())), None)
        other = next((each for each in written if each != found and _exact_column(each) == column), None)
        if found is None:
            hint = did_you_mean(header, list(written)) or f"the table has the columns {', '.join(map(repr, written))}"
            reading.undetermined(
                reading.page.span(start, 0), f"`map` names the column '{header}', which the table does not have", hint
            )
        elif found in renamed or found in reading.ignored:
            why = f"the {_exact_column(renamed[found])}" if found in renamed else "a column of `ignore`"
            message = f"`map` says that '{header}' is the {column}, but it is also {why}"
            reading.undetermined(_header_span(reading, found, written[found]), message, "remove one of them")
        elif other is not None and other not in reading.ignored:
            message = f"`map` says that '{header}' is the {column}, but the table also has the column '{other}'"
            hint = f"to ignore it, write `ignore: ['{other}']`"
            reading.undetermined(_header_span(reading, found, written[found]), message, hint)
        else:
            unit = _unit_in(found)
            renamed[found] = f"{column} [{unit}]" if unit and column not in BARE else column
            reading.renamed[renamed[found]] = found
    reading.end()
    kept = {
        header: renamed.get(header, header) for header in written if header not in reading.ignored or header in renamed
    }
    reading.used.update(reading.ignored.intersection(written))
    reading.ignored -= written.keys()  # these columns are gone, and a mapped one may have the header of one of them
    return [
        replace(row, cells={kept[header]: cell for header, cell in row.cells.items() if header in kept}) for row in rows
    ]


# --- rows -------------------------------------------------------------------------------------------------------------


def _lines(reading: LoadReading) -> Iterator[_Row]:
    """Yield the rows of a CSV table; skip blank lines."""
    filled = [number for number, line in enumerate(reading.page.lines) if line.strip()]
    if not filled:
        return
    delimiter = max(DELIMITERS, key=reading.page.lines[filled[0]].count)
    headers = [cell.text.strip() for cell in _cells(reading, filled[0], delimiter)]
    if 2 * sum(number_of(header) is not None for header in headers) > len(headers):
        example = delimiter.join(
            ("name", *(f"{side} [mm]" for side in SIDES), "mass [kg]", *(f"{axis} [mm]" for axis in PLACE))
        )
        hint = f"write one above it, with the columns in their order, such as `{example}`"
        reading.wrong(reading.page.span(filled[0], 0), "the table has no line of headers", hint)
        reading.end()
    for header in sorted({header for header in headers if headers.count(header) > 1}):
        reading.wrong(reading.page.span(filled[0], 0), f"two columns have the name '{header}'", "keep one of them")
    reading.end()
    headers, first = _with_unit_row(reading, headers, filled, delimiter)
    for number in filled[first:]:
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


def _with_unit_row(
    reading: LoadReading, headers: list[str], filled: Sequence[int], delimiter: str
) -> tuple[list[str], int]:
    """Return the headers with the units of a row below them, if all filled cells of it are units, and the first row."""
    cells = [cell.text.strip().strip("[]()") for cell in _cells(reading, filled[1], delimiter)] if filled[1:] else []
    if not any(cells) or len(cells) != len(headers) or not {*cells} <= {"", *IN_METRES, *IN_KILOGRAMS, *DEGREES}:
        return headers, 1
    for header, unit in zip(headers, cells, strict=True):
        if unit and (own := _unit_in(header)) and own != unit:
            message = f"the header '{header}' and the row below it give different units: '{own}' and '{unit}'"
            reading.wrong(reading.page.span(filled[1], 0), message, "delete the row of units")
    return [
        f"{header} [{unit}]" if unit and not _unit_in(header) else header
        for header, unit in zip(headers, cells, strict=True)
    ], 2


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
        invalid = [member for member in row.values() if not isinstance(member.value, str | Numeral | bool)]
        for member in invalid:
            reading.wrong(json.span(member), "the cell is neither a number nor a string", "write a number or a string")
        if invalid:
            continue
        yield _Row(cells, json.span(node))


def _text(node: Node) -> str:
    if isinstance(node.value, bool):
        return str(node.value).lower()
    return node.value.text if isinstance(node.value, Numeral) else node.value if isinstance(node.value, str) else ""


# --- numbers ---------------------------------------------------------------------------------------------------------


_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d*,\d+")
_GROUPED: Final = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+")  # 1,250: with a thousands separator, or a decimal comma


def _with_decimal_points(reading: LoadReading, rows: Sequence[_Row], decimals: str | None) -> Sequence[_Row]:
    """Return the rows with decimal points for decimal commas; report numbers that can be read in two ways.

    A comma such as that of `12,5` or `0,125` cannot separate thousands, and decides for the whole table, unless the
    author gives the sign of decimals.
    """
    numeric = [header for name, header in _likely_headers(rows).items() if name not in TEXTS]
    texts = [text for row in rows for header in numeric if (text := _text_in(row, header))]
    example = next((text for text in texts if _DECIMAL_COMMA.fullmatch(text) and not _GROUPED.fullmatch(text)), "")
    if decimals is None and not example and not any("," in text for text in texts):
        return rows
    read: list[_Row] = []
    for row in rows:
        cells, clear = dict(row.cells), True
        for header in numeric:
            text = _text_in(row, header)
            if decimals is not None:
                cells[header] = replace(cells[header], text=_with_point(text, decimals)) if text else cells[header]
                continue
            wrong = _ambiguity(text, example)
            if wrong is not None:
                reading.wrong(row.cells[header].span, *wrong)
                clear = False
            elif "," in text:
                cells[header] = replace(cells[header], text=text.replace(",", "."))
        if clear:
            read.append(replace(row, cells=cells))
    return read


def _with_point(text: str, decimals: str) -> str:
    """Return a number with a decimal point and no separators of thousands; other texts as they are."""
    sign, thousands = (",", ".") if decimals == "comma" else (".", ",")
    whole, point, rest = text.partition(sign)
    if thousands in whole and re.fullmatch(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(thousands)}\d{{3}})+", whole):
        whole = whole.replace(thousands, "")
    if thousands in whole + rest or sign in rest:
        return text  # reported as no number
    return f"{whole}.{rest}" if point else whole


def _ambiguity(text: str, example: str) -> tuple[str, str] | None:
    """Return message and remedy for a number whose comma or point is unclear beside a decimal comma as in `example`."""
    digits = text.replace(",", "").replace(".", "")
    if example and "." in text:
        message = f"the point in '{text}' is unclear, since the table has decimal commas, such as '{example}'"
        return message, f"write {digits} or {text.replace(',', '').replace('.', ',')}, or set `decimals: comma`"
    if "," not in text or (example and text.count(",") == 1):
        return None
    if _GROUPED.fullmatch(text):
        return (
            f"'{text}' is {digits} with a thousands separator, or {text.replace(',', '.', 1)} with a decimal comma",
            f"write {digits}, or a decimal point; or set `decimals: point` or `decimals: comma`",
        )
    return f"'{text}' has a thousands separator", f"write {text.replace(',', '')}, or set `decimals: point`"


def _text_in(row: _Row, header: str) -> str:
    """Return the text of a cell; empty if the row has none."""
    return row.cells[header].text.strip() if header in row.cells else ""


def _only_boxes(reading: LoadReading, rows: Sequence[_Row]) -> Sequence[_Row]:
    """Return the rows with a box; report each row that has neither a size nor a position, unless totals are ignored."""
    likely = _likely_headers(rows)
    headers = [likely[name] for name in (*SIDES, *PLACE) if name in likely]
    boxes: list[_Row] = []
    for row in rows:
        if not headers or any(_text_in(row, header) for header in headers):
            boxes.append(row)
            continue
        if TOTALS in reading.ignored:
            reading.used.add(TOTALS)
            continue
        word = next((cell.text.strip() for cell in row.cells.values() if re.search(r"[^\W\d]", cell.text)), "")
        total = f", as in a row of totals ('{word[:LONGEST_TOLD]}')" if word else ""
        message = f"the row has no size and no position{total}"
        reading.wrong(row.span, message, f"delete the row, add the numbers, or write `ignore: ['{TOTALS}']`")
    return boxes


# --- columns ----------------------------------------------------------------------------------------------------------


def _columns(reading: LoadReading, rows: Sequence[_Row], options: Import) -> Mapping[str, _Column]:
    """Return the columns by name; report mistakes and return {} if a column is missing, repeated or without a unit."""
    columns: dict[str, _Column] = {}
    without_unit: list[tuple[str, Span]] = []
    unsupported: dict[str, None] = {}
    before = len(reading.mistakes)
    headers = {header: cell.span for row in rows for header, cell in row.cells.items()}
    weight = _weight_column(headers, reading.ignored)
    where = reading.page.span(next((n for n, line in enumerate(reading.page.lines) if line.strip()), 0), 0)
    for header, span in headers.items():
        match = _HEADER.fullmatch(header)
        name = "mass" if header == weight else match["name"].lower() if match else ""
        if header in reading.ignored:
            reading.skip(header, span, harmless=False)
        elif (match is None and not name) or name not in COLUMNS:
            unsupported[header] = None
        elif name in columns:
            reading.wrong(span, f"both '{columns[name].header}' and '{header}' specify the {name}", "keep one of them")
        else:
            written = _unit_in(header) if header == weight else _written_unit(match)
            written = written or _default_unit(name, options)
            if not written and name not in BARE:
                without_unit.append((name, _header_span(reading, header, span)))
                continue
            unit = _unit(reading, name, written, _header_span(reading, header, span))
            if unit is not None:
                columns[name] = _Column(name, header, unit)
    known = {*columns, *(name for name, _ in without_unit)}
    _refuse_unsupported(reading, rows, unsupported, headers, [name for name in NEEDED if name not in known])
    without_unit += [
        (name, _header_span(reading, header, headers[header]))
        for name, header in _likely_headers(rows).items()
        if header in unsupported and name not in BARE and not (_unit_in(header) or _default_unit(name, options))
    ]
    _ask_for_units(reading, rows, without_unit)
    missing = [name for name in NEEDED if name not in columns]
    wrong = len(reading.mistakes) > before
    if missing and not wrong:
        message = f"the table has no column {', '.join(f'`{name}`' for name in missing)}"
        reading.undetermined(where, message, _example(missing[0], {}))
    return {} if missing or wrong else columns


def _weight_column(headers: Collection[str], ignored: Collection[str]) -> str:
    """Return the header of the only column of weights, such as `Weight` or `Gewicht [kg]`; it gives the masses.

    Empty if the table has a column of masses, several of weights, or one whose unit is no unit of mass.
    """
    weights = [header for header in headers if likely_column(header) == "mass" and header not in ignored]
    if len(weights) != 1 or _exact_column(weights[0]) or any(_exact_column(header) == "mass" for header in headers):
        return ""
    unit = _unit_in(weights[0])
    return weights[0] if not unit or unit in IN_KILOGRAMS else ""


def _written_unit(match: re.Match[str] | None) -> str:
    """Return the unit of a header; empty for none."""
    return (match["a"] or match["b"] or match["c"] or "").strip() if match is not None else ""


def _ask_for_units(reading: LoadReading, rows: Sequence[_Row], without_unit: Sequence[tuple[str, Span]]) -> None:
    """Ask for the units of all columns that have none, with likely units."""
    if not without_unit:
        return
    names, (first, where_first) = [name for name, _ in without_unit], without_unit[0]
    headers = {name: header for name, header in _likely_headers(rows).items() if name in names}
    plural, told = len(names) > 1, ", ".join(f"'{headers.get(name, name)}'" for name in names)
    message = f"the columns {told} have no unit" if plural else f"the column {told} has no unit"
    units, reason = _likely_units(rows, names)
    reading.proposed |= units
    reading.undetermined(where_first, message, _example(first, units, headers.get(first, first)) + reason)


def _likely_headers(rows: Sequence[_Row]) -> Mapping[str, str]:
    """Return the header of each column: the exact name if the table has it, otherwise a header that may mean it."""
    headers = list(dict.fromkeys(header for row in rows for header in row.cells))
    exact = {name: header for header in headers if (name := _exact_column(header))}
    meant: dict[str, str] = {}

    def order(header: str) -> tuple[bool, bool]:
        unusable = likely_column(header) == "name" and _unusable_name(rows, header)
        return unusable, not header.lower().startswith(GROSS)

    for header in sorted(headers, key=order):
        if (name := likely_column(header)) and not _exact_column(header):
            meant.setdefault(name, header)
    return {**meant, **exact}


def _exact_column(header: str) -> str:
    """Return the column that a header names; empty for an unknown header."""
    match = _HEADER.fullmatch(header)
    return name if match and (name := match["name"].lower()) in COLUMNS else ""


def _unit_in(header: str) -> str:
    """Return the unit in a header; empty for none."""
    match = re.search(r"\[(.*)\]|\((.*)\)|[/_\s](mm|cm|m|in|g|kg|t|lbs?|deg)$", header.strip())
    return next(filter(None, match.groups()), "").strip() if match else ""


def _ask_for_point(reading: LoadReading, rows: Sequence[_Row], options: Import) -> None:
    """Ask for the reference point of the positions, with a guess from the lowest boxes."""
    likely = _likely_headers(rows)
    if "z" not in likely:
        return
    guess = _likely_point(rows, likely, options)
    message = "the table does not state whether x, y, z are the lower corner or the centre of a box"
    reason = {"corner": "is 0", "centre": "is half their height"}.get(guess, "")
    other = "centre" if guess == "corner" else "corner"
    hint = f"z of the lowest boxes {reason}, so write `point: {guess}`, or `point: {other}` if that is not so"
    span = _header_span(reading, likely["z"], rows[0].cells[likely["z"]].span) if rows else reading.page.span(0, 0)
    reading.undetermined(span, message, hint if guess else "set `point: corner` or `point: centre`")
    reading.proposed["point"] = guess or "corner"


def _likely_point(rows: Sequence[_Row], likely: Mapping[str, str], options: Import) -> str:
    """Return `corner` or `centre`, if the lowest boxes show which point their z refers to; empty otherwise."""
    if not {"z", "height"} <= likely.keys():
        return ""
    units = [IN_METRES.get(_unit_in(likely[name]) or _default_unit(name, options)) for name in ("z", "height")]
    numbers = [[number_of(_text_in(row, likely[name])) for name in ("z", "height")] for row in rows]
    known = [(z[0], height[0]) for z, height in numbers if z is not None and height is not None]
    if not known or (units[0] is None) != (units[1] is None):
        return ""
    scale = units[0] / units[1] if units[0] is not None and units[1] is not None else Fraction(1)
    least = min(known)[0]
    lowest = [(z * scale, height) for z, height in known if z == least]
    if lowest[0][0] == 0:
        return "corner"
    return "centre" if all(2 * z == height for z, height in lowest) else ""


def _layer_heights(rows: Sequence[_Row], likely: Mapping[str, str], missing: Sequence[str]) -> str:
    """Return the heights of layers, as advice for a table that has numbers of layers in place of z."""
    headers = [header for header in (rows[0].cells if rows else ()) if _word(header) in LAYERS]
    if "z" not in missing or not headers or "height" not in likely:
        return ""
    (layer, *_), unit = headers, _unit_in(likely["height"])
    heights: dict[Fraction, set[Fraction]] = {}
    for row in rows:
        number, height = number_of(_text_in(row, layer)), number_of(_text_in(row, likely["height"]))
        if number is not None and height is not None:
            heights.setdefault(number[0], set()).add(height[0])
    if not heights or any(len(each) > 1 for each in heights.values()):
        return f"'{layer}' is no height: add the column z, with the height of the lower corner of each box"
    bottom, told = Fraction(0), list[str]()
    for layer_number, (layer_height,) in sorted(heights.items()):
        told.append(f"{digits(bottom)} for {layer} {digits(layer_number)}")
        bottom += layer_height
    shown = ", ".join(told[:LAYERS_TOLD]) + (", ..." if len(told) > LAYERS_TOLD else "")
    return f"'{layer}' is no height: add the column 'z{f' [{unit}]' if unit else ''}' with {shown} (lower corners)"


def _word(header: str) -> str:
    return re.sub(r"[\W\d_]", "", header.lower())


def _refuse_unsupported(
    reading: LoadReading,
    rows: Sequence[_Row],
    unsupported: Collection[str],
    spans: Mapping[str, Span],
    missing: Sequence[str],
) -> None:
    """Report all headers of no known column together, with the columns that they probably mean."""
    if not unsupported:
        return
    headers = list(unsupported)
    likely = _likely_headers(rows)
    meant = {header: name for name, header in likely.items() if header in unsupported}
    layers = _layer_heights(rows, likely, [name for name in missing if name not in meant.values()])
    names = likely.get("name", "")
    if names in meant and _unusable_name(rows, names):
        del meant[names]  # a number of an article is often no name, or that of several boxes
    reading.proposed["ignore"] = [header for header in headers if header not in meant]
    if len(headers) == 1:
        (header,) = headers
        reading.proposed["map"] = {column: each for each, column in meant.items()}
        advice = (
            f"if it is the {meant[header]}, write `map: {{{meant[header]}: {_shown(header)}}}`" if meant else layers
        )
        reading.skip(header, _header_span(reading, header, spans[header]), harmless=False, advice=advice)
        return
    others = reading.proposed["ignore"]
    if meant:
        reading.proposed["map"] = {column: header for header, column in meant.items()}
    mapped = ", ".join(f"{column}: {_shown(header)}" for header, column in meant.items())
    told = [f"write `map: {{{mapped}}}`"] if meant else []
    unknown = [f"`{name}`" for name in missing if name not in meant.values()]
    told += [f"the table {'also ' * bool(meant)}needs {', '.join(unknown)}"] if unknown else []
    told += [layers] if layers else []
    told += [f"to ignore {'the others' if meant else 'columns'}, write `ignore: {others}`"] if others else []
    message = f"the columns {', '.join(map(repr, headers))} are not supported"
    reading.undetermined(_header_span(reading, headers[0], spans[headers[0]]), message, "; ".join(told))


def _unusable_name(rows: Sequence[_Row], header: str) -> bool:
    """Return whether a column has two equal names, or texts that are no names."""
    names = [_prefixed(name) for row in rows if (name := _text_in(row, header))]
    return len({*names}) < len(names) or not all(re.fullmatch(NAME, name) for name in names)


def _prefixed(name: str) -> str:
    """Return the name of a box: a text that begins with a digit gets a prefix."""
    return PREFIX + name if re.match(r"[0-9]", name) else name


def _shown(header: str) -> str:
    """Return a header as a value of YAML in braces."""
    return header if re.fullmatch(r"[^\W\d][\w .]*", header) else f"'{header}'"


def _header_span(reading: LoadReading, header: str, span: Span) -> Span:
    """Return the position of a header: in the first line of CSV, or as given in JSON, where every row has its own."""
    for number, line in enumerate(reading.page.lines):
        if line.strip():
            start = line.find(reading.renamed.get(header, header))
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


def _example(name: str, units: Mapping[str, str], header: str = "") -> str:
    """Return how to give units: in a header such as that of `name`, or these for all columns without one."""
    unit = units.get("mass", "kg") if name == "mass" else "deg" if name == "yaw" else units.get("length", "mm")
    shown = ", ".join(f"{kind}: {usual}" for kind, usual in units.items())
    return f"write the header '{header or name} [{unit}]'" + (f", or set `units: {{{shown}}}`" if units else "")


# The longest side of all boxes of a load is mostly between these limits.
_LONGEST: Final = (Fraction(1, 10), Fraction(3))  # [m]


def _likely_units(rows: Sequence[_Row], names: Sequence[str]) -> tuple[dict[str, str], str]:
    """Return units for the columns of these names, and the size that the largest box has then."""
    likely = _likely_headers(rows)
    units = {"mass": "kg"} if "mass" in names else {}
    if {*names} <= {"mass", "yaw"}:
        return units, ""
    given = next((unit for name in (*SIDES, *PLACE) if (unit := _unit_in(likely.get(name, ""))) in IN_METRES), "")
    if given:
        return {"length": given, **units}, ""
    sides = [number_of(_text_in(row, likely[name])) for row in rows for name in SIDES if name in likely]
    longest = max((side[0] for side in sides if side is not None), default=Fraction(0))
    fitting = [unit for unit in ("mm", "cm", "m") if _LONGEST[0] <= longest * IN_METRES[unit] <= _LONGEST[1]]
    unit = fitting[0] if fitting else "mm"
    reason = f"; in {unit}, the longest side is {float(longest * IN_METRES[unit]):.4g} m" if fitting else ""
    return {"length": unit, **units}, reason


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
    laid = _laid(reading, cells, {name: side for name, side in zip(SIDES, size, strict=True) if side is not None})
    if laid is None:
        return None
    length, width, height = laid
    x, y, z = (part for part in position if part is not None)
    if of_corner and yaw[0] != 0:
        message = "the lower corner of a rotated box is ambiguous"
        hint = (
            "write the positions of the centres, and set `point: centre`; or write a column `rotated` for boxes whose "
        )
        hint += "length is along y, and whose corner is that of the box as it lies"
        reading.undetermined(cells["yaw"].span, message, hint)
        return None
    if abs(yaw[0]) > 360:  # noqa: PLR2004 -- [deg]
        reading.wrong(cells["yaw"].span, "`yaw` exceeds 360 deg", "write an angle in degrees, from -360 to 360")
        return None
    if of_corner:
        x, y, z = x + length / 2, y + width / 2, z + height / 2
    name = _prefixed(cells["name"].text.strip()) if "name" in cells else ""
    if name and not _is_valid_name(reading, name, cells["name"].span):
        return None
    turn = (Fraction(0), Fraction(0), yaw[0])
    number = number_of(cells["friction"].text.strip()) if "friction" in cells else None
    friction = number[0] if number is not None else None
    return ImportedBox(name or None, (length, width, height), (x, y, z), mass, row.span, turn, friction=friction)


def _is_valid_name(reading: LoadReading, name: str, span: Span) -> bool:
    """Return whether a text is a name; report the first that is none, as the others are mostly of the same form."""
    if re.fullmatch(NAME, name):
        return True
    if not any(mistake.message.endswith(INVALID_NAME) for mistake in reading.mistakes):
        hint = "begin each name with a letter, then use letters, digits, _ . or -"
        reading.wrong(span, f"'{name}'{INVALID_NAME}", f"{hint}; or leave the column out with `ignore`")
    return False


def _is_valid_yaw(reading: LoadReading, cell: _Cell, yaw: Fraction, of_corner: bool) -> bool:
    """Return whether a box has a clear place with a turn [deg]; report one that has none."""
    if of_corner and yaw != 0:
        message = "the lower corner of a rotated box is ambiguous"
        hint = (
            "write the positions of the centres, and set `point: centre`; or write a column `rotated` for boxes whose "
        )
        hint += "length is along y, and whose corner is that of the box as it lies"
        reading.undetermined(cell.span, message, hint)
        return False
    if abs(yaw) > 360:  # noqa: PLR2004 -- [deg]
        reading.wrong(cell.span, "`yaw` exceeds 360 deg", "write an angle in degrees, from -360 to 360")
        return False
    return True


def _laid(reading: LoadReading, cells: Mapping[str, _Cell], sides: Mapping[str, Fraction]) -> Exact3 | None:
    """Return the sides of a box along x, y and z as it lies; report an unknown orientation and return None."""
    cell = cells.get("rotated")
    text = cell.text.strip() if cell is not None else ""
    order: Sequence[str] = SIDES
    if text.lower() in ROTATED:
        order = ("width", "length", "height") if ROTATED[text.lower()] else SIDES
    else:
        assert cell is not None
        order = [LABEL_SIDES.get(letter, "") for letter in text.upper()]
        if sorted(order) != sorted(SIDES):
            message = f"`rotated`: '{text[:LONGEST_TOLD]}' is not an orientation"
            hint = "write yes if the length is along y, no if it is along x, or the sides along x, y and z, such as WLH"
            reading.wrong(cell.span, message, hint)
            return None
    x, y, z = (sides[name] for name in order)
    return x, y, z


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
        if cell is None or not (name := _prefixed(cell.text.strip())):
            continue
        if name in seen:
            reading.wrong(cell.span, f"two boxes have the name '{name}'", NAME_TWICE)
        seen.add(name)
