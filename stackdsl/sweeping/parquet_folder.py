"""Rows in a folder of Parquet files, with a file of JSON lines for those that fill no file yet.

A Parquet file is of no use before its last byte is written, so each is written at once, of as many rows as fill one.
What comes after stands in `_tail.jsonl`, which readers of such folders pass over, and in a last file once a sweep ends.
Where a kill has left rows in both, the tail has them: it says how many rows come before its own.
"""

import os
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Final, Self

from stackdsl.asked_files import make_asked
from stackdsl.disk import read_file, remove_file, replace_file
from stackdsl.sweeping.file_lock import lock, unlock
from stackdsl.sweeping.json_lines import LONGEST, JsonLines
from stackdsl.sweeping.pieces import Kind
from stackdsl.sweeping.row_text import Counts, RowsError, head_of, header_line, number_of, refuse_other, tail_of
from stackdsl.sweeping.sweep_plan import Plan

if TYPE_CHECKING:
    import pyarrow as pa

HINT: Final = "pip install 'stackdsl[parquet]'"
PART: Final = 100_000  # rows of a file
TAIL: Final = "_tail.jsonl"
SMALL: Final[dict[str, Any]] = {
    "compression": "zstd",
    "use_dictionary": ["case", "seed", "verdict", "level", "how"],
    "column_encoding": {"sample": "DELTA_BINARY_PACKED"},  # numbers that follow each other take next to nothing
}
PART_NAME: Final = re.compile(r"part-([0-9]{12})\.parquet")
FRESH: Final = "_fresh"  # what is being written, until it has its name


class ParquetFolder:
    """A folder of rows under way. What it holds on opening is counted, and is gone on with where it ends."""

    def __init__(self, path: Path, plan: Plan, part: int = PART) -> None:
        """Raises RowsError."""
        try:
            import pyarrow.parquet  # noqa: F401, PLC0415 -- an optional extra
        except ModuleNotFoundError as error:
            raise RowsError(f"Parquet needs {error.name}, which is not installed; try: {HINT}") from error
        self.path, self.plan, self.part = path, plan, part
        self.counts = Counts()
        try:
            make_asked(path)
            self._folder = os.open(path, os.O_RDONLY)
        except OSError as error:
            raise RowsError(f"{path} cannot be written: {error.strerror}") from error
        try:
            lock(self._folder, path)
            self._tail = self._opened()
        except BaseException:
            unlock(self._folder)
            os.close(self._folder)
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return self._tail.rows

    def write(self, lines: list[bytes]) -> None:
        """Add rows. Raises RowsError."""
        while lines:
            room = self.part - (self._tail.rows - self._tail.after)
            here, lines = lines[:room], lines[room:]
            self._tail.write(here)
            if len(here) == room:
                self._seal()

    def close(self) -> None:
        """Bring what is left into a last file. Raises RowsError."""
        try:
            if self._tail.rows > self._tail.after:
                self._seal()
        finally:
            self._tail.close()
            unlock(self._folder)
            with suppress(OSError):
                os.close(self._folder)

    # --- what is there ------------------------------------------------------------------------------------------------

    def _opened(self) -> JsonLines:
        import pyarrow as pa  # noqa: PLC0415 -- an optional extra

        try:
            remove_file(self.path / FRESH, self.path)  # which a run that was killed has left
            after = self._after()
            for first in self._parts():
                if first >= after:
                    self._file(first).unlink()  # the tail has its rows
            end = self._taken_over()
        except (OSError, pa.ArrowException) as error:
            raise RowsError(f"{self.path} cannot be read, or written on: {error}") from error
        except (KeyError, TypeError, ValueError) as error:
            raise RowsError(f"{self.path} has rows of no such sweep: write to another folder") from error
        if end != after:
            raise RowsError(f"{self.path} lacks the rows from {end} on: write to another folder, or remove this one")
        tail = JsonLines(self.path / TAIL, self.plan, locked=False)
        self.counts.merge(tail.counts)
        return tail

    def _taken_over(self) -> int:
        """Count the rows of all files, and put those of one that is not full back into the tail; how many there are."""
        end = 0
        for first in self._parts():
            table = self._table(first)
            if first != end:
                break
            end += len(table)
            if len(table) < self.part:  # the last one of a sweep that ended, and now goes on
                self._begin(first, [*self._lines(table)])
                self._file(first).unlink()
            else:
                self._count(table)
        return end

    def _after(self) -> int:
        """How many rows the tail says come before its own. Raises RowsError where it is of another sweep."""
        try:
            line, end, _ = read_file(self.path / TAIL, LONGEST, self.path).partition(b"\n")
        except FileNotFoundError:
            if any(self.path.iterdir()):
                told = f"has files and no {TAIL}, so it is no folder of a sweep"
                raise RowsError(f"{self.path} {told}: write to another folder") from None
            return 0
        return refuse_other(line + end, self.plan, self.path / TAIL) if end else 0

    def _parts(self) -> list[int]:
        """The number of the first row of each file."""
        return sorted(int(found[1]) for file in self.path.iterdir() if (found := PART_NAME.fullmatch(file.name)))

    def _file(self, first: int) -> Path:
        return self.path / f"part-{first:012}.parquet"

    def _table(self, first: int) -> "pa.Table":
        from pyarrow import parquet  # noqa: PLC0415 -- an optional extra

        return parquet.read_table(BytesIO(read_file(self._file(first), within=self.path)))

    def _lines(self, table: "pa.Table") -> Iterator[bytes]:
        entries = {entry.name: entry for entry in self.plan.entries}
        for row in table.to_pylist():
            entry = entries[row["case"]]
            yield head_of(entry) + number_of(entry, row["sample"]) + tail_of(_kind(row))

    def _count(self, table: "pa.Table") -> None:
        numbers = {entry.name: index for index, entry in enumerate(self.plan.entries)}
        columns = (table.column(name).to_pylist() for name in ("case", "verdict", "level", "how"))
        for (case, *kind), count in Counter(zip(*columns, strict=True)).items():
            self.counts.add(numbers[case], Kind(*kind), count)

    # --- what is written ----------------------------------------------------------------------------------------------

    def _seal(self) -> None:
        """Write the rows of the tail as a file of their own, and begin another tail. Raises RowsError."""
        import pyarrow as pa  # noqa: PLC0415 -- an optional extra
        from pyarrow import json, parquet  # noqa: PLC0415 -- likewise

        try:
            _, _, rows = read_file(self.path / TAIL, within=self.path).partition(b"\n")
            options = json.ParseOptions(explicit_schema=_schema(words=pa.string()))
            table = json.read_json(pa.BufferReader(rows), parse_options=options)
            words = pa.dictionary(pa.int32(), pa.string())
            whole = BytesIO()
            parquet.write_table(table.cast(_schema(words)), whole, **SMALL)
            replace_file(self._file(self._tail.after), whole.getvalue(), self.path, fresh=FRESH)
            self._tail.close()
            self._begin(self._tail.rows, [])
        except (OSError, pa.ArrowException) as error:
            raise RowsError(f"{self.path} cannot be written on: {error}; what is there is kept") from error
        self._tail = JsonLines(self.path / TAIL, self.plan, locked=False)

    def _begin(self, after: int, lines: list[bytes]) -> None:
        """Another tail, at one stroke."""
        replace_file(self.path / TAIL, header_line(self.plan, after) + b"".join(lines), self.path, fresh=FRESH)


def _kind(row: dict[str, Any]) -> Kind:
    return Kind(row["verdict"], row["level"], row["how"])


def _schema(words: "pa.DataType") -> "pa.Schema":
    """The columns; seed, sample and level are empty where there are none."""
    import pyarrow as pa  # noqa: PLC0415 -- an optional extra

    return pa.schema(
        [
            ("case", words),
            ("seed", pa.int64()),
            ("sample", pa.int64()),
            ("verdict", words),
            ("level", pa.int32()),
            ("how", words),
        ]
    )
