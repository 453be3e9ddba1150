"""Columns of a table: a heading, and the format of the cell of a row."""

from collections.abc import Sequence
from dataclasses import dataclass
from string import Formatter

from benchmarks.figures.data import Row
from benchmarks.figures.forms import NOTHING, written


class _Forms(Formatter):
    """Formats values in the forms of figures."""

    def format_field(self, value: object, format_spec: str) -> str:
        assert value is None or isinstance(value, float | int | str)
        return written(value, format_spec)


@dataclass(frozen=True, slots=True)
class Column:
    """One column: `cell_form` names values in braces, each with its form; `{row}` is the name of the row."""

    heading: str
    cell_form: str

    def cell(self, name: str, row: Row) -> str:
        """Return the text of a cell; `-` if none of its values was measured."""
        named = [field for _, field, _, _ in Formatter().parse(self.cell_form) if field and field != "row"]
        if named and all(row.get(field) is None for field in named):
            return NOTHING
        return _Forms().vformat(self.cell_form, (), {**row, "row": name})


@dataclass(frozen=True, slots=True)
class Table:
    """Table of a text: its file and table of data, and its columns."""

    data: str  # file
    of: str  # table in it
    columns: Sequence[Column]
    rows: Sequence[str] = ()  # in this order; all if empty
