"""A table of results: a list of rows, with columns by name, and a data frame of pandas or polars if installed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl

Row = dict[str, str | int | float | bool | None]


class Table(list[Row]):
    """Rows with the same columns. pandas and polars accept it directly: `pandas.DataFrame(table)`."""

    @property
    def columns(self) -> Sequence[str]:
        """Return the names of the columns, from the left."""
        return list(self[0]) if self else []

    def column(self, name: str) -> npt.NDArray[Any]:
        """Return a column as an array, nan for a missing number. Raises LookupError for an unknown column."""
        if name not in self.columns:
            raise LookupError(f"there is no column '{name}'; there are {', '.join(self.columns) or 'no rows'}")
        values = [row[name] for row in self]
        numbers = any(isinstance(value, float) for value in values) or None in values
        return np.array([np.nan if value is None and numbers else value for value in values])

    def to_pandas(self) -> "pd.DataFrame":
        """Return a data frame of pandas. Raises ImportError if it is not installed."""
        import pandas as pd  # noqa: PLC0415 -- nothing else needs it

        return pd.DataFrame(list(self))

    def to_polars(self) -> "pl.DataFrame":
        """Return a data frame of polars. Raises ImportError if it is not installed."""
        import polars as pl  # noqa: PLC0415 -- nothing else needs it

        return pl.DataFrame(list(self))

    def __str__(self) -> str:
        """Return the table as text, one line per row."""
        cells = [self.columns, *([_shown(value) for value in row.values()] for row in self)]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in cells)


def _shown(value: str | float | bool | None) -> str:
    return "~" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
