"""Table of the results of a study, with writers for CSV and JSON."""

import csv
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from typing import Any, Final, TypeAlias

FORMAT: Final = 1  # version of the JSON; increased if a key changes its meaning

Row: TypeAlias = Mapping[str, Any]  # by column


@dataclass(frozen=True, slots=True)
class StudyTable:
    """Results of a study: rows for CSV, and the results with all details for JSON."""

    columns: Sequence[str]  # of CSV; without any, no header is written
    rows: Sequence[Row]  # which may have more than the columns; None is an empty cell
    details: Sequence[Row]  # of JSON, an object a case
    key: str = "cases"  # of the details in JSON

    def written_as(self, form: str) -> str:
        """Return the text of a format, `csv` or `json`."""
        return self.csv() if form == "csv" else self.json()

    def csv(self) -> str:
        """Return a header and a line for each row."""
        out = StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerows([self.columns] if self.columns else [])
        writer.writerows([row[column] for column in self.columns] for row in self.rows)
        return out.getvalue()

    def json(self) -> str:
        """Return one object with the format and the details."""
        return json.dumps({"format": FORMAT, self.key: self.details}, indent=2) + "\n"


def rows_within(cases: Iterable[Row], key: str) -> list[Row]:
    """Return the rows that each case has under a key, each with the other keys of its case."""
    return [{**case, **row} for case in cases for row in case[key]]


@dataclass(frozen=True, slots=True)
class Part:
    """Some rows of the result of a case, which arrives in parts."""

    case: str
    lines: Sequence[str] = ()  # of text
    rows: Sequence[Row] = ()
    whole: Row = field(default_factory=dict)  # statements about the case as a whole, by key


def parts_table(parts: Sequence[Part]) -> StudyTable:
    """Return the rows of all parts, which have the same columns; JSON has those of a case together."""
    cases: dict[str, dict[str, Any]] = {}
    for part in parts:
        case = cases.setdefault(part.case, {"case": part.case, "rows": []})
        case["rows"] += map(dict, part.rows)
        case |= part.whole
    rows = [{"case": part.case, **_in_words(row)} for part in parts for row in part.rows]
    return StudyTable(tuple(rows[0]) if rows else (), rows, list(cases.values()))


def _in_words(row: Row) -> Row:
    return {key: ("yes" if value else "no") if isinstance(value, bool) else value for key, value in row.items()}
