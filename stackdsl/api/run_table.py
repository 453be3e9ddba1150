"""Tables of runs: lists of rows with access to columns, and conversion to pandas or polars."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl

Row = dict[str, str | int | float | bool | None]


class Table(list[Row]):
    """Rows with the same columns. pandas and polars also accept it as it is: `pandas.DataFrame(table)`."""

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
        import pandas as pd  # noqa: PLC0415 -- an optional package

        return pd.DataFrame(list(self))

    def to_polars(self) -> "pl.DataFrame":
        """Return a polars data frame. Raises ImportError if polars is not installed."""
        import polars as pl  # noqa: PLC0415 -- an optional package

        return pl.DataFrame(list(self))

    def _repr_html_(self) -> str:
        """Return the table as HTML, for notebooks."""
        head = "".join(f"<th>{escape(name)}</th>" for name in self.columns)
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(_shown(value))}</td>" for value in row.values()) + "</tr>" for row in self
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"

    def __str__(self) -> str:
        """Return the table as text, with one line per row."""
        cells = [self.columns, *([_shown(value) for value in row.values()] for row in self)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in cells)


def _shown(value: str | float | bool | None) -> str:
    return "~" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
