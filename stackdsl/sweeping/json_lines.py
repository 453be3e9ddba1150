"""Rows in a file of JSON lines, in order, that is gone on with where it ends."""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Final, Self

from stackdsl.asked_files import make_asked, open_asked
from stackdsl.disk import NOT_REGULAR
from stackdsl.sweeping.file_lock import lock, unlock
from stackdsl.sweeping.pieces import Kind
from stackdsl.sweeping.row_text import Counts, RowsError, head_of, header_line, kind_of, number_of, refuse_other
from stackdsl.sweeping.sweep_plan import Plan

LONGEST: Final = 1 << 20  # [bytes] of a line; what has none within so many is no file of ours


class JsonLines:
    """A file of rows under way. What it holds on opening is counted, and a last line that was cut short is removed."""

    def __init__(self, path: Path, plan: Plan, *, locked: bool = True) -> None:
        """Raises RowsError."""
        self.path, self.plan = path, plan
        self._due = b""  # the first line, which comes with the first rows: until then the file is of no sweep
        self.counts = Counts()  # of what is there on opening; whoever writes adds to it
        descriptor = _opened(path) if locked else _opened(path, path.parent)
        self._stream: BinaryIO = os.fdopen(descriptor, "r+b")
        try:
            if locked:
                lock(descriptor, path)
            self.after = self._read()  # rows that are kept elsewhere, and come before
            self.rows = self.after + self.counts.rows
        except BaseException:
            unlock(descriptor)
            self._stream.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def write(self, lines: list[bytes]) -> None:
        """Add rows, so that they are there even if this process is killed. Raises RowsError."""
        try:
            self._stream.write(self._due + b"".join(lines))
            self._due = b""
            self._stream.flush()
        except OSError as error:
            raise RowsError(f"{self.path} cannot be written on: {error.strerror}; what is there is kept") from error
        self.rows += len(lines)

    def close(self) -> None:
        """Write all of it to the disk."""
        if self._stream.closed:
            return
        with suppress(OSError):  # what could not be written was told, and is tried once more by closing
            os.fsync(self._stream.fileno())
        unlock(self._stream.fileno())
        with suppress(OSError):
            self._stream.close()

    # --- what is there ------------------------------------------------------------------------------------------------

    def _read(self) -> int:
        """Count the rows, and get ready to write behind them; how many come before this file."""
        try:
            line = self._stream.readline(LONGEST)
            after = end = 0
            if line.endswith(b"\n"):
                after = refuse_other(line, self.plan, self.path)
                end = self._counted(len(line), after)
            else:
                self._due = header_line(self.plan)
                if not self._due.startswith(line):
                    refuse_other(line, self.plan, self.path)
            self._stream.seek(end)
            self._stream.truncate()
        except OSError as error:
            raise RowsError(f"{self.path} cannot be read, or written on: {error.strerror}") from error
        return after

    def _counted(self, end: int, after: int) -> int:
        """Count the rows behind the first line; where the last one of them ends [bytes]."""
        heads = [head_of(entry) for entry in self.plan.entries]
        kinds = dict[bytes, Kind | None]()
        order = self.plan.order(after)
        for place, line in enumerate(self._lines(), start=2):
            if not line.endswith(b"\n"):
                break  # cut short by whatever ended the sweep before
            sample, index = next(order, (-1, 0))
            if sample < 0:
                raise RowsError(f"{self.path} has more rows than the {self.plan.total} that are asked for: {_MORE}")
            start = heads[index] + number_of(self.plan.entries[index], sample)
            tail = line[len(start) :]
            if tail not in kinds:
                kinds[tail] = kind_of(tail)
            kind = kinds[tail]
            if kind is None or not line.startswith(start):
                raise RowsError(self._wrong(place, index, sample))
            self.counts.add(index, kind)
            end += len(line)
        return end

    def _lines(self) -> Iterator[bytes]:
        while line := self._stream.readline(LONGEST):
            yield line

    def _wrong(self, place: int, index: int, sample: int) -> str:
        name = self.plan.entries[index].name
        lacks = f"{self.path}:{place}: there should be the row of sample {sample} of {name}"
        why = "the file was changed, or its cases had other numbers of samples"
        return f"{lacks}: {why}; write to another file, or remove this one"


_MORE: Final = "ask for as many samples as it has, or more; or write to another file"


def _opened(path: Path, *folders: Path) -> int:
    """The descriptor of a file that is left as it is, as it may be of another sweep. Raises RowsError."""
    try:
        make_asked(path.parent)
        return open_asked(path, os.O_RDWR | os.O_CREAT, *folders)
    except OSError as error:
        if error.strerror == NOT_REGULAR:
            raise RowsError(f"{path} is no regular file, so no sweep could go on with it") from error
        raise RowsError(f"{path} cannot be written: {error.strerror}") from error
