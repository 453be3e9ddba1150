"""Reads records over time: ground accelerations in the AT2 format of PEER, and CSV tables of time and values.

| format | content |
|---|---|
| AT2 | lines of text, among them the unit of acceleration (`UNITS OF G`); a line with the number of values and their time step (`NPTS= 4000, DT= .0050 SEC`); then the values, in lines of any length |
| CSV | a line of headers with a unit in brackets, such as `time [s],acceleration [g]`; then one row for each time. Lines that begin with `#` are comments |

Nothing is filtered, and no value is left out: a file with fewer or more values than it states is refused.
"""  # noqa: E501 -- a table

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate, chain, pairwise
from typing import Final

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from stackdsl.language.bricks import KnownBricks
from stackdsl.language.quantities import InputError, shown
from stackdsl.language.value_types import FILE, JsonSchema

MOST_VALUES: Final = 100_000  # of one column
LONGEST: Final = 86_400.0  # [s]
LARGEST: Final = 1e9  # of any value, in the unit of the file
HEADER_LINES: Final = 20  # of an AT2 file, in which the number of values must stand
LINES_REMEMBERED: Final = 16  # files of one process

Row = tuple[float, float]

# Standard gravity, as for the unit `g` of an acceleration in a scenario.
ACCELERATIONS: Final[Mapping[str, float]] = {
    **dict.fromkeys(("g", "g0"), 9.80665),
    **dict.fromkeys(("m/s2", "m/s/s", "m/s**2", "m/sec2", "m/sec/sec", "m/sec**2"), 1.0),
    **dict.fromkeys(("cm/s2", "cm/s/s", "cm/s**2", "cm/sec2", "cm/sec/sec", "cm/sec**2", "gal"), 0.01),
}
TIMES: Final[Mapping[str, float]] = {**dict.fromkeys(("s", "sec"), 1.0), "ms": 1e-3}
SHARES: Final[Mapping[str, float]] = {"": 1.0, "%": 0.01}

ACCELERATION: Final = "acceleration"
COMPONENTS: Final = ("along", "across", "up")  # columns of a record, relative to its bearing
SHARE: Final = "share"  # column of a load over time
TIME: Final = "time"

_NUMBER: Final = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eEdD][-+]?[0-9]{1,3})?")
# A number of an AT2 file, whose columns of fixed width may leave no space before a minus; or anything else.
_WORD: Final = re.compile(r"[-+]?[0-9.]+(?:[eEdD][-+]?[0-9]+)?|\S+")
_STATED: Final = re.compile(
    r"NPTS\s*=\s*(?P<a>[^\s,]+)[\s,]+DT\s*=\s*(?P<b>[^\s,]+)|^\s*(?P<c>[^\s,]+)[\s,]+(?P<d>[^\s,]+)[\s,]+NPTS\b",
    re.IGNORECASE,
)
_UNIT: Final = re.compile(r"\bUNITS?\b\s*(?:OF\b|:|=)?\s*(?P<unit>[^\s,;]+)", re.IGNORECASE)
_HEADER: Final = re.compile(r"\s*(?P<name>[A-Za-z]+)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\))?\s*")
_DELIMITERS: Final = ",;\t"


@dataclass(frozen=True, slots=True)
class Column:
    """Values of one quantity, in the unit of the file."""

    unit: str  # as written
    values: tuple[float, ...]
    place: str  # `file:line:column` of its unit


@dataclass(frozen=True, slots=True)
class Record:
    """Columns of values over time."""

    file: str
    times: tuple[float, ...]  # [s], not decreasing
    columns: Mapping[str, Column]

    def rows(self, name: str, units: Mapping[str, float], noun: str) -> Sequence[Row]:
        """Return the times [s] and the values of a column in SI. Raises InputError for a unit that is not in `units`.

        `noun` names the quantity in messages.
        """
        column = self.columns[name]
        factor = units.get(re.sub(r"[\s^]", "", column.unit).lower().replace("²", "2"))
        known = ", ".join(unit for unit in dict.fromkeys(units) if unit and unit.count("/") < 2 and "*" not in unit)  # noqa: PLR2004
        if factor is None:
            message = (
                f"{shown(column.unit)} is not a unit of {noun}" if column.unit else f"the unit of {noun} is missing"
            )
            raise _wrong(column.place, message, f"write one of {known}; convert the values if needed")
        return tuple((time, factor * value) for time, value in zip(self.times, column.values, strict=True))


def _wrong(place: str, message: str, hint: str) -> InputError:
    return InputError("SD114", f"{place}: {message}", hint)


@lru_cache(maxsize=LINES_REMEMBERED)
def read_record(text: str, file: str) -> Record:
    """Read the text of a file. Raises InputError with file, line and column."""
    lines = text.removeprefix("\ufeff").splitlines()
    if not any(line.strip() for line in lines):
        raise _wrong(f"{file}:1:1", "the file is empty", "export it again")
    for number, line in enumerate(lines[:HEADER_LINES]):
        if (stated := _STATED.search(line)) is not None:
            record = _at2(lines, number, stated, file)
            _check_end(text, lines, file)
            return record
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    if not any(mark in first for mark in _DELIMITERS):
        message = (
            "the file is neither AT2, since no line states NPTS and DT, nor CSV, since its first line has no columns"
        )
        raise _wrong(f"{file}:1:1", message, "export it again, as AT2 or as CSV with the columns time and acceleration")
    return _csv(text, lines, file)


# --- AT2 --------------------------------------------------------------------------------------------------------------


def _at2(lines: Sequence[str], number: int, stated: re.Match[str], file: str) -> Record:
    """Read a file of PEER; line `number`, from 0, states the number of values and the time step."""
    one = "a" if stated["a"] is not None else "c"
    count_text, step_text = stated[one], stated["b" if one == "a" else "d"]
    place = f"{file}:{number + 1}:{stated.start(one) + 1}"
    if not re.fullmatch(r"[0-9]{1,9}", count_text):
        raise _wrong(place, f"{shown(count_text)} is not a number of values", "export the file again")
    count = int(count_text)
    if not 2 <= count <= MOST_VALUES:  # noqa: PLR2004
        raise _wrong(place, f"the file has {count} values", f"use a record of 2 to {MOST_VALUES} values")
    step_place = f"{file}:{number + 1}:{stated.start('b' if one == 'a' else 'd') + 1}"
    step = _number(step_text, step_place)
    if not 0.0 < step * count <= LONGEST:
        raise _wrong(step_place, f"the time step is {shown(step_text)} s", "write a step greater than zero")
    unit, unit_place = "", f"{file}:{number + 1}:1"
    for index, line in enumerate(lines[:number]):
        if (match := _UNIT.search(line)) is not None:
            unit, unit_place = match["unit"].rstrip("."), f"{file}:{index + 1}:{match.start('unit') + 1}"
    values: list[float] = []
    for index in range(number + 1, len(lines)):
        for word in _WORD.finditer(lines[index]):
            here = f"{file}:{index + 1}:{word.start() + 1}"
            value = _number(word[0], here)
            if len(values) == count:
                message = f"the file has more than the {count} values that line {number + 1} states"
                raise _wrong(here, message, "export it again")
            values.append(value)
    if len(values) < count:
        message = f"the file is cut: it has {len(values)} of the {count} values that line {number + 1} states"
        raise _wrong(f"{file}:{len(lines)}:1", message, "export it again")
    times = tuple(step * index for index in range(count))
    return Record(file, times, {ACCELERATION: Column(unit, tuple(values), unit_place)})


def _number(text: str, place: str) -> float:
    if not _NUMBER.fullmatch(text):
        raise _wrong(
            place, f"{shown(text)} is not a number", "write digits with a decimal point, such as -0.0123 or 1.5E-02"
        )
    value = float(text.upper().replace("D", "E"))
    if abs(value) > LARGEST:
        raise _wrong(place, f"{shown(text)} is out of range", "correct the number")
    return value


# --- CSV --------------------------------------------------------------------------------------------------------------


def _csv(text: str, lines: Sequence[str], file: str) -> Record:
    filled = [(n, line) for n, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    first, header = filled[0]
    delimiter = max(_DELIMITERS, key=header.count)
    names, units = [], []
    for column, cell in _cells(header, delimiter):
        match, place = _HEADER.fullmatch(cell), f"{file}:{first}:{column}"
        name = match["name"].lower() if match else ""
        if match is None or name not in {TIME, ACCELERATION, SHARE, *COMPONENTS}:
            known = "`time [s]`, `acceleration [g]` or `along`, `across` and `up`, or `share` for a load"
            raise _wrong(
                place, f"unknown column {shown(cell.strip())}", f"name the columns {known}; delete other columns"
            )
        if name in names:
            raise _wrong(place, f"two columns have the name '{name}'", "keep one of them")
        names.append(name)
        units.append((((match["a"] or match["b"]) or "").strip(), place))
    _check_columns(names, f"{file}:{first}:1")
    if len(filled) - 1 > MOST_VALUES:
        raise _wrong(
            f"{file}:{filled[MOST_VALUES][0]}:1", f"the file has more than {MOST_VALUES} rows", "use a shorter record"
        )
    rows_text = filled[1:]
    if delimiter != "," and _has_decimal_commas([line for _, line in rows_text], delimiter):
        rows_text = [(number, line.replace(",", ".")) for number, line in rows_text]
    rows = [_row(line, number, names, delimiter, file) for number, line in rows_text]
    if len(rows) < 2:  # noqa: PLR2004
        raise _wrong(f"{file}:{filled[-1][0]}:1", "the file has fewer than two rows of values", "export it again")
    _check_end(text, lines, file)
    by_name = dict(zip(names, zip(*rows, strict=True), strict=True))
    columns = {
        name: Column(unit, by_name[name], place)
        for name, (unit, place) in zip(names, units, strict=True)
        if name != TIME
    }
    unit, place = units[names.index(TIME)]
    seconds = Record(file, by_name[TIME], {TIME: Column(unit, by_name[TIME], place)}).rows(TIME, TIMES, "time")
    times = tuple(time for _, time in seconds)
    _check_times(times, [number for number, _ in filled[1:]], file)
    return Record(file, times, columns)


def _has_decimal_commas(lines: Sequence[str], delimiter: str) -> bool:
    """Return whether commas are those of decimals: no number has a point, and some comma cannot separate thousands."""
    cells = [cell.strip() for line in lines for cell in line.split(delimiter)]
    return not any("." in cell for cell in cells) and any(
        "," in cell and not re.fullmatch(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", cell) for cell in cells
    )


def _check_end(text: str, lines: Sequence[str], file: str) -> None:
    """Raise InputError for a file that ends within a line, as its last number may be cut."""
    if not text.endswith(("\n", "\r")):
        message = "the last line has no line end, so the file may be cut"
        hint = "end the file with an empty line, or export it again"
        raise _wrong(f"{file}:{len(lines)}:{len(lines[-1]) + 1}", message, hint)


def _check_columns(names: Sequence[str], place: str) -> None:
    """Raise InputError without a column of time and one of values, and for values that exclude each other."""
    if TIME not in names:
        raise _wrong(
            place, "the column `time` is missing", "begin with a line of headers, such as `time [s],acceleration [g]`"
        )
    others = [name for name in names if name != TIME]
    if not others:
        raise _wrong(place, "the file has no column of values", "add a column, such as `acceleration [g]`")
    if len(others) > 1 and not set(others) <= set(COMPONENTS):
        hint = "name components `along`, `across` and `up`; keep other columns in files of their own"
        raise _wrong(place, f"the columns {' and '.join(others)} exclude each other", hint)


def _cells(line: str, delimiter: str) -> Iterator[tuple[int, str]]:
    """Yield the cells of a line with their columns, from 1."""
    cells = line.split(delimiter)
    starts = accumulate((len(cell) + 1 for cell in cells), initial=1)
    return zip(starts, cells, strict=False)


def _row(line: str, number: int, names: Sequence[str], delimiter: str, file: str) -> tuple[float, ...]:
    cells = list(_cells(line, delimiter))
    if len(cells) != len(names):
        hint = "write decimals with a point; if it is the last row, the file may be cut: export it again"
        raise _wrong(f"{file}:{number}:1", f"the row has {len(cells)} cells, but the header has {len(names)}", hint)
    return tuple(_number(cell.strip(), f"{file}:{number}:{column}") for column, cell in cells)


def _check_times(times: Sequence[float], lines: Sequence[int], file: str) -> None:
    """Raise InputError for times that are negative, decrease, are all the same, or too long."""
    for number, (before, after) in zip(lines[1:], pairwise(times), strict=True):
        if after < before:
            hint = "sort the rows by time; two rows with the same time define a step change"
            raise _wrong(f"{file}:{number}:1", f"the time is {after:g} s, after {before:g} s in the row above", hint)
    if times[0] < 0.0 or times[-1] > LONGEST:
        place = f"{file}:{lines[0 if times[0] < 0.0 else -1]}:1"
        raise _wrong(place, "the time is out of range", f"write times from 0 to {LONGEST:g} s")
    if times[-1] == times[0]:
        raise _wrong(f"{file}:{lines[-1]}:1", "all rows have the same time", "add a row with a later time")


# --- in a scenario ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class RecordFile:
    """Type of a key that names a file of a record; its value is the record."""

    example: str

    def __get_pydantic_core_schema__(self, _source: object, _handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.with_info_plain_validator_function(_named_record)

    def __get_pydantic_json_schema__(self, _core: CoreSchema, _handler: GetJsonSchemaHandler) -> JsonSchema:
        return {**FILE, "examples": [self.example]}


def _named_record(written: object, info: ValidationInfo) -> Record:
    """Read the file with the content that it had when the scenario was read. Raises InputError."""
    files = info.context.files if isinstance(info.context, KnownBricks) else {}
    if not isinstance(written, str) or not written.strip():
        raise InputError("SD103", "expected the path of a file", "write, for example, record.at2")
    if written not in files:
        message = f"the path {shown(written)} of the record contains an expression"
        raise InputError("SD113", message, "write a fixed path, without ${...}")
    return read_record(files[written], written)


def joined_courses(
    along: Record, others: Mapping[str, Record], scale: float
) -> tuple[float, Mapping[str, tuple[Row, ...]]]:
    """Return the first time of any component [s], and its rows for each component [m/s2], from that time on.

    `along` has one column of accelerations, or columns for several components; each of `others` has one column.
    Raises InputError for a component that is given twice, and for other columns.
    """
    read: dict[str, Sequence[Row]] = {}
    for name, record in chain([("along", along)], others.items()):
        for column in record.columns:
            component = name if column == ACCELERATION else column if name == "along" else ""
            if component not in COMPONENTS:
                hint = f"the file of `{name}` needs the columns `time` and `acceleration`"
                raise InputError("SD114", f"{record.file} has a column '{column}'", hint)
            if component in read:
                message = f"both {along.file} and {record.file} have the component `{component}`"
                raise InputError("SD108", message, "keep one of them")
            read[component] = record.rows(column, ACCELERATIONS, "acceleration")
    begins = min(rows[0][0] for rows in read.values())
    return begins, {name: _from(begins, rows, scale) for name, rows in read.items()}


def _from(begins: float, rows: Sequence[Row], scale: float) -> tuple[Row, ...]:
    """Return rows in the time since `begins`, scaled; the first is at 0."""
    shifted = [(time - begins, scale * value) for time, value in rows]
    still = [(0.0, 0.0), (shifted[0][0], 0.0)] if shifted[0][0] > 0.0 else []
    return (*still, *shifted)
