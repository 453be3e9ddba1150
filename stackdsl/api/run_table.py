"""Tables of runs: lists of rows with access to columns, and conversion to CSV, pandas or polars."""

import csv
from collections.abc import Sequence
from html import escape
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from stability.notebook import Printer

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl

Row = dict[str, str | int | float | bool | None]


MOST: Final = 60  # rows that a notebook shows of a table


class Table(list[Row]):
    """Rows with the same columns; each row is a dict. `pandas.DataFrame` and `polars.DataFrame` accept a table."""

    @property
    def columns(self) -> Sequence[str]:
        """The names of the columns, from left to right."""
        return list(self[0]) if self else []

    def column(self, name: str) -> npt.NDArray[Any]:
        """Return one column as an array, with nan for missing numbers. Raises LookupError for an unknown column."""
        if name not in self.columns:
            raise LookupError(f"unknown column '{name}'; the columns are {', '.join(self.columns) or 'none (no rows)'}")
        values = [row[name] for row in self]
        numbers = any(isinstance(value, float) for value in values) or None in values
        return np.array([np.nan if value is None and numbers else value for value in values])

    def to_pandas(self) -> "pd.DataFrame":
        """Return a pandas data frame. Raises ImportError if pandas is not installed."""
        frame: pd.DataFrame = _optional("pandas").DataFrame(list(self))
        return frame

    def to_polars(self) -> "pl.DataFrame":
        """Return a polars data frame. Raises ImportError if polars is not installed."""
        frame: pl.DataFrame = _optional("polars").DataFrame(list(self))
        return frame

    def to_csv(self, path: Path | str) -> None:
        """Write a CSV file with the names of the columns in its first line; a missing value is an empty cell."""
        with Path(path).open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, self.columns)
            writer.writeheader()
            writer.writerows(self)

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        """Return the table as text and as HTML, for notebooks; of a long one its first and last rows."""
        few = self if len(self) <= MOST else Table([*self[: MOST // 2], *self[-MOST // 2 :]])
        sides = self._sides
        cells = [[*map(_shown, row.values())] for row in few]
        lines = [_row("th", sides, self.columns), *(_row("td", sides, row) for row in cells)]
        left_out = [] if few is self else [f"{len(self) - MOST} of {len(self)} rows are left out in the middle"]
        if left_out:
            lines.insert(1 + MOST // 2, f'<tr><td colspan="{len(sides)}">\u2026</td></tr>')
        html = "<table>" + "".join(lines) + "</table>" + "".join(map("<p>{}</p>".format, left_out))
        return {"text/plain": "\n".join([str(few), *left_out]), "text/html": html}

    def _repr_pretty_(self, printer: Printer, cycle: bool) -> None:
        """Print the table as text, for which IPython asks a list in this way."""
        printer.text(self._repr_mimebundle_()["text/plain"])

    def __str__(self) -> str:
        """Return the table as text, with one line per row."""
        cells = [self.columns, *([_shown(value) for value in row.values()] for row in self)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        sides = self._sides
        lines = (
            [
                cell.ljust(width) if side == "left" else cell.rjust(width)
                for cell, width, side in zip(row, widths, sides, strict=True)
            ]
            for row in cells
        )
        return "\n".join("  ".join(line).rstrip() for line in lines)

    @property
    def _sides(self) -> Sequence[str]:
        """The side to which each column is aligned; numbers stand below each other."""
        return ["left" if isinstance(value, str) else "right" for value in (self[0].values() if self else ())]


def _optional(package: str) -> ModuleType:
    """Import an optional package. Raises ImportError, which says how to install it."""
    try:
        return import_module(package)
    except ImportError as error:
        raise ImportError(
            f"{package} is not installed; run `pip install {package}`, or write `table.to_csv(path)`", name=package
        ) from error


def _row(tag: str, sides: Sequence[str], texts: Sequence[str]) -> str:
    cells = (
        f'<{tag} style="text-align: {side}">{escape(text)}</{tag}>' for side, text in zip(sides, texts, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


def _shown(value: str | float | bool | None) -> str:
    return "~" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
