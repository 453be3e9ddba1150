"""Writes the rows of a sweep as JSON lines, CSV or Parquet, and resumes where a file ends."""

import csv
import errno
import fcntl
import json
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO, StringIO
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, BinaryIO, Final, Self

from stackdsl.disk import NOT_REGULAR, read_file, remove_file, replace_file
from stackdsl.studies.sweep_plan import PlannedCase, RowKind, SweepPlan
from stackdsl.user_files import make_user_folder, open_user_file

if TYPE_CHECKING:
    import pyarrow as pa


# Rows as text, one line each.


class RowsError(Exception):
    """A file cannot be resumed: it is of another sweep, in use, damaged, or not writable."""


@dataclass
class Counts:
    """Number of rows by kind, for each case by its number."""

    of: dict[int, Counter[RowKind]] = field(default_factory=dict)

    @property
    def rows(self) -> int:
        """Total number of rows."""
        return sum(counter.total() for counter in self.of.values())

    def add(self, index: int, kind: RowKind, count: int = 1) -> None:
        """Add rows of a kind."""
        self.of.setdefault(index, Counter())[kind] += count

    def merge(self, more: "Counts") -> None:
        """Add other counts."""
        for index, counter in more.of.items():
            self.of.setdefault(index, Counter()).update(counter)


@dataclass(frozen=True, slots=True)
class RowFormat:
    """The text of a row: its head, the number of the sample, and its tail."""

    title_of: Callable[[SweepPlan], bytes]  # line above the rows; empty for none
    head_of: Callable[[PlannedCase], bytes]
    tail_of: Callable[[RowKind], bytes]
    kind_of: Callable[[bytes], RowKind | None]  # of a tail; None if it is invalid
    no_number: bytes  # in place of the number, for a case that is played once

    def number_of(self, entry: PlannedCase, sample: int) -> bytes:
        """Return the text for the number of a sample."""
        return b"%d" % sample if entry.case.is_sampled else self.no_number


def _json_head(entry: PlannedCase) -> bytes:
    values = {"case": entry.name, **entry.columns, "seed": entry.seed}
    return json.dumps(values)[:-1].encode() + b', "sample": '


def _json_tail(kind: RowKind) -> bytes:
    return b", " + json.dumps(kind._asdict()).encode()[1:] + b"\n"


def _json_kind(tail: bytes) -> RowKind | None:
    try:
        values = json.loads(b"{" + tail[2:])
        kind = RowKind(values["verdict"], values["level"], values["how"])
    except (KeyError, TypeError, ValueError):
        return None
    return kind if _json_tail(kind) == tail else None


def _csv_line(cells: Iterable[object]) -> bytes:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow(["" if cell is None else cell for cell in cells])
    return text.getvalue().encode()


def _csv_head(entry: PlannedCase) -> bytes:
    return _csv_line((entry.name, *entry.columns.values(), entry.seed)).rstrip(b"\n") + b","


def _csv_tail(kind: RowKind) -> bytes:
    return b"," + _csv_line(" ".join(cell.split()) if isinstance(cell, str) else cell for cell in kind)


def _csv_kind(tail: bytes) -> RowKind | None:
    try:
        (_, verdict, level, how), *more = csv.reader([tail.decode()])
        kind = RowKind(verdict, int(level) if level else None, how)
    except (ValueError, csv.Error):
        return None
    return kind if not more and _csv_tail(kind) == tail else None


def _csv_title(plan: SweepPlan) -> bytes:
    return _csv_line(("case", *plan.columns, "seed", "sample", *RowKind._fields))


JSON: Final = RowFormat(lambda _: b"", _json_head, _json_tail, _json_kind, b"null")
CSV: Final = RowFormat(_csv_title, _csv_head, _csv_tail, _csv_kind, b"")


def header_line(plan: SweepPlan, after: int = 0) -> bytes:
    """Return the line that identifies a sweep; `after` is the number of earlier rows in other files."""
    return json.dumps({**plan.header, "after": after}).encode() + b"\n"


def refuse_other(line: bytes, plan: SweepPlan, path: object) -> int:
    """Return the number of earlier rows in other files, by the first line. Raises RowsError for another sweep."""
    try:
        header = json.loads(line)
        differing = [key for key in plan.header if header.get(key) != plan.header[key]]
        after = header["after"]
        cases = {entry["case"]: entry for entry in header["cases"]}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RowsError(f"{path} is not the file of a sweep: its first line is not a header; {_ELSE}") from error
    if differing:
        raise RowsError(f"{path} belongs to another sweep: {_difference(differing, header, cases, plan)}; {_ELSE}")
    return int(after)


_ELSE: Final = "write to another file, or remove this one"


def _difference(
    differing: list[str], header: dict[str, object], cases: dict[str, dict[str, object]], plan: SweepPlan
) -> str:
    if "stackdsl" in differing or "rows" in differing:
        return f"it was written by stackdsl {header.get('stackdsl')}, and this is {plan.header['stackdsl']}"
    for entry in plan.entries:
        was = cases.get(entry.name)
        if was is None:
            return f"it has no case '{entry.name}', but {', '.join(cases)}"
        if was.get("seed") != entry.seed:
            return f"'{entry.name}' had the seed {was.get('seed')}, and has {entry.seed} now"
        if was.get("scenario") != entry.header["scenario"]:
            return f"'{entry.name}' has changed since"
    if len(cases) != len(plan.entries):
        removed = [name for name in cases if name not in {entry.name for entry in plan.entries}]
        return f"it also has {', '.join(removed)}"
    if "cases" in differing:
        return "its cases have another order, or other values of their parameters"
    return "it was written by a different program: stackdsl, Python, numpy, scipy, clarabel or the engine has changed"


# Locks of files, held by one process and not inherited by its forks.


IN_USE: Final = "another sweep is writing to it; wait for its end, or write to another file"
_HELD: Final[set[int]] = set()  # descriptors of locked files


def lock(descriptor: int, path: Path) -> None:
    """Lock an open file against other sweeps until `unlock`. Raises RowsError if it is in use."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise RowsError(f"{path} is in use: {IN_USE}") from error
        return  # a file system without locks: the user must not start two sweeps
    _HELD.add(descriptor)


def unlock(descriptor: int) -> None:
    """Forget the lock of a file that will be closed; no effect if it was not locked."""
    _HELD.discard(descriptor)


def _let_go() -> None:
    """Release all locks in a fork, which would otherwise keep them even after a kill of this process."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in _HELD:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
    _HELD.clear()


os.register_at_fork(after_in_child=_let_go)


# Rows in a text file, in order; a sweep resumes at the end of the file.
#
# A small file beside it, whose name has `.sweep` appended, says of which sweep the rows are: every line of the file
# itself is data for any program. The tail of a Parquet folder, which only sweeps read, has that line above its rows.


LONGEST: Final = 1 << 20  # [bytes] of a line; a file with a longer one is not of a sweep
BESIDE: Final = ".sweep"


class TextRows:
    """A file of rows. On opening, existing rows are counted, and an incomplete last line is removed."""

    def __init__(self, path: Path, plan: SweepPlan, form: RowFormat = JSON, *, is_tail: bool = False) -> None:
        """Open the file, for exclusive use unless it is the tail of a folder in use. Raises RowsError."""
        self.path, self.plan, self.form, self._is_tail = path, plan, form, is_tail
        self._beside = path.with_name(path.name + BESIDE)
        self._due = b""  # first line, written together with the first rows
        self._is_new = False  # whether nothing is written yet
        self.counts = Counts()  # of existing rows on opening; the caller adds those that it writes
        descriptor = _opened(path, path.parent) if is_tail else _opened(path)
        self._stream: BinaryIO = os.fdopen(descriptor, "r+b")
        try:
            if not is_tail:
                lock(descriptor, path)
            self.after = self._read()  # earlier rows in other files
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
        """Append rows, so that they persist even if this process is killed. Raises RowsError."""
        try:
            if self._is_new and not self._is_tail:
                replace_file(self._beside, header_line(self.plan), self.path.parent)
            self._stream.write(self._due + b"".join(lines))
            self._due, self._is_new = b"", False
            self._stream.flush()
        except OSError as error:
            raise RowsError(f"{self.path} cannot be extended: {error.strerror}; its rows are kept") from error
        self.rows += len(lines)

    def close(self) -> None:
        """Flush the file to the disk and close it."""
        if self._stream.closed:
            return
        with suppress(OSError):  # `write` has reported the error already
            os.fsync(self._stream.fileno())
        unlock(self._stream.fileno())
        with suppress(OSError):
            self._stream.close()

    # --- existing rows ------------------------------------------------------------------------------------------------

    def _read(self) -> int:
        """Count the rows, and position the file behind them; return the number of earlier rows in other files."""
        try:
            line = self._stream.readline(LONGEST)
            self._is_new = not line
            after, title = self._identified(line)
            if title and not line.endswith(b"\n"):
                self._due, end = title, 0  # incomplete, as the sweep before was killed
            else:
                end = self._counted(len(title), after)
            self._stream.seek(end)
            self._stream.truncate()
        except OSError as error:
            raise RowsError(f"{self.path} cannot be read or extended: {error.strerror or error}") from error
        return after

    def _identified(self, line: bytes) -> tuple[int, bytes]:
        """Return the number of earlier rows in other files, and the line above the rows. Raises RowsError."""
        if self._is_tail:
            title = header_line(self.plan)
            if line.endswith(b"\n"):
                return refuse_other(line, self.plan, self.path), line
            if not title.startswith(line):
                refuse_other(line, self.plan, self.path)
            return 0, title
        if not line:
            return 0, self.form.title_of(self.plan)
        missing = f"{self.path} is not the file of a sweep: "
        try:
            identity = read_file(self._beside, LONGEST, self.path.parent)
        except FileNotFoundError:
            raise RowsError(
                f"{missing}{self._beside.name}, which a sweep writes beside it, is missing; {_ELSE}"
            ) from None
        refuse_other(identity, self.plan, self._beside)
        title = self.form.title_of(self.plan)
        if not title.startswith(line if title else b""):
            raise RowsError(f"{missing}its first line does not have the names of the columns; {_ELSE}")
        return 0, title

    def _counted(self, end: int, after: int) -> int:
        """Count the rows, which begin at `end` [bytes]; return the end of the last one [bytes]."""
        self._stream.seek(end)
        heads = [self.form.head_of(entry) for entry in self.plan.entries]
        kinds = dict[bytes, RowKind | None]()
        order = self.plan.order(after)
        for place, line in enumerate(self._lines(), start=2 if end else 1):
            if not line.endswith(b"\n"):
                break  # incomplete, as the sweep before was killed
            sample, index = next(order, (-1, 0))
            if sample < 0:
                raise RowsError(f"{self.path} has more rows than the {self.plan.total} of this sweep; {_MORE}")
            start = heads[index] + self.form.number_of(self.plan.entries[index], sample)
            tail = line[len(start) :]
            if tail not in kinds:
                kinds[tail] = self.form.kind_of(tail)
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
        error = f"{self.path}:{place}: expected the row of sample {sample} of {name}"
        cause = "the file was changed, or its cases had different numbers of samples"
        return f"{error}: {cause}; write to another file, or remove this one"


_MORE: Final = "use at least as many samples as it has, or write to another file"


def _opened(path: Path, *folders: Path) -> int:
    """Open a file without changing it, as it may be of another sweep; return its descriptor. Raises RowsError."""
    try:
        make_user_folder(path.parent)
        return open_user_file(path, os.O_RDWR | os.O_CREAT, *folders)
    except OSError as error:
        if error.strerror == NOT_REGULAR:
            raise RowsError(
                f"{path} is not a regular file, so a sweep cannot continue it; write to another file"
            ) from error
        raise RowsError(f"{path} cannot be written: {error.strerror}") from error


# Rows in a folder of Parquet files, with a file of JSON lines for rows that do not fill a Parquet file yet.
#
# A Parquet file is unreadable before its last byte is written, so each is written at once when its rows are complete.
# The remaining rows are in `_tail.jsonl`, which readers of such folders ignore, and go to a last file when the sweep
# ends. If a kill leaves rows in both, those of the tail count: it states the number of rows before its own.


HINT: Final = "pip install 'stackdsl[parquet]'"
PART: Final = 100_000  # rows of a Parquet file
TAIL: Final = "_tail.jsonl"
SMALL: Final[dict[str, Any]] = {
    "compression": "zstd",
    "use_dictionary": ["case", "system", "seed", "verdict", "level", "how"],
    "column_encoding": {"sample": "DELTA_BINARY_PACKED"},  # consecutive numbers take almost no space
}
PART_NAME: Final = re.compile(r"part-([0-9]{12})\.parquet")
FRESH: Final = "_fresh"  # name of a file while it is written


class ParquetFolder:
    """A folder of rows. On opening, existing rows are counted, and the sweep resumes after the last."""

    form = JSON  # of the rows that it is given

    def __init__(self, path: Path, plan: SweepPlan, part: int = PART) -> None:
        """Open the folder for exclusive use; `part` is the number of rows per file. Raises RowsError."""
        try:
            import pyarrow.parquet  # noqa: F401, PLC0415 -- an optional extra
        except ModuleNotFoundError as error:
            raise RowsError(f"Parquet needs {error.name}, which is not installed; try: {HINT}") from error
        self.path, self.plan, self.part = path, plan, part
        self.counts = Counts()
        try:
            make_user_folder(path)
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
        """Number of rows."""
        return self._tail.rows

    def write(self, lines: list[bytes]) -> None:
        """Append rows. Raises RowsError."""
        while lines:
            room = self.part - (self._tail.rows - self._tail.after)
            here, lines = lines[:room], lines[room:]
            self._tail.write(here)
            if len(here) == room:
                self._seal()

    def close(self) -> None:
        """Write the remaining rows to a last file, and close the folder. Raises RowsError."""
        try:
            if self._tail.rows > self._tail.after:
                self._seal()
        finally:
            self._tail.close()
            unlock(self._folder)
            with suppress(OSError):
                os.close(self._folder)

    # --- existing rows ------------------------------------------------------------------------------------------------

    def _opened(self) -> TextRows:
        import pyarrow as pa  # noqa: PLC0415 -- an optional extra

        try:
            remove_file(self.path / FRESH, self.path)  # left by a run that was killed
            after = self._after()
            for first in self._parts():
                if first >= after:
                    self._file(first).unlink()  # the tail has its rows
            end = self._count_files()
        except (OSError, pa.ArrowException) as error:
            raise RowsError(f"{self.path} cannot be read or extended: {error}") from error
        except (KeyError, TypeError, ValueError) as error:
            raise RowsError(f"{self.path} has no rows of this sweep; write to another folder") from error
        if end != after:
            raise RowsError(f"{self.path} lacks the rows from {end} on; write to another folder, or remove this one")
        tail = TextRows(self.path / TAIL, self.plan, is_tail=True)
        self.counts.merge(tail.counts)
        return tail

    def _count_files(self) -> int:
        """Count the rows of all files, and move those of an incomplete one back to the tail; return their number."""
        end = 0
        for first in self._parts():
            table = self._table(first)
            if first != end:
                break
            end += len(table)
            if len(table) < self.part:  # last file of a finished sweep that is now extended
                self._begin(first, [*self._lines(table)])
                self._file(first).unlink()
            else:
                self._count(table)
        return end

    def _after(self) -> int:
        """Return the number of rows before the tail, by its header. Raises RowsError if it is of another sweep."""
        try:
            line, end, _ = read_file(self.path / TAIL, LONGEST, self.path).partition(b"\n")
        except FileNotFoundError:
            if any(self.path.iterdir()):
                error = f"{self.path} has files but no {TAIL}, so it is not the folder of a sweep"
                raise RowsError(f"{error}; write to another folder") from None
            return 0
        return refuse_other(line + end, self.plan, self.path / TAIL) if end else 0

    def _parts(self) -> list[int]:
        """Return the number of the first row of each file."""
        return sorted(int(match[1]) for file in self.path.iterdir() if (match := PART_NAME.fullmatch(file.name)))

    def _file(self, first: int) -> Path:
        return self.path / f"part-{first:012}.parquet"

    def _table(self, first: int) -> "pa.Table":
        from pyarrow import parquet  # noqa: PLC0415 -- an optional extra

        return parquet.read_table(BytesIO(read_file(self._file(first), within=self.path)))

    def _lines(self, table: "pa.Table") -> Iterator[bytes]:
        entries = {entry.name: entry for entry in self.plan.entries}
        for row in table.to_pylist():
            entry = entries[row["case"]]
            yield JSON.head_of(entry) + JSON.number_of(entry, row["sample"]) + JSON.tail_of(_kind(row))

    def _count(self, table: "pa.Table") -> None:
        numbers = {entry.name: index for index, entry in enumerate(self.plan.entries)}
        columns = (table.column(name).to_pylist() for name in ("case", "verdict", "level", "how"))
        for (case, *kind), count in Counter(zip(*columns, strict=True)).items():
            self.counts.add(numbers[case], RowKind(*kind), count)

    # --- writing ------------------------------------------------------------------------------------------------------

    def _seal(self) -> None:
        """Move the rows of the tail to a new Parquet file. Raises RowsError."""
        import pyarrow as pa  # noqa: PLC0415 -- an optional extra
        from pyarrow import json, parquet  # noqa: PLC0415 -- likewise

        try:
            _, _, rows = read_file(self.path / TAIL, within=self.path).partition(b"\n")
            options = json.ParseOptions(explicit_schema=_schema(self.plan, words=pa.string()))
            table = json.read_json(pa.BufferReader(rows), parse_options=options)
            words = pa.dictionary(pa.int32(), pa.string())
            whole = BytesIO()
            parquet.write_table(table.cast(_schema(self.plan, words)), whole, **SMALL)
            replace_file(self._file(self._tail.after), whole.getvalue(), self.path, fresh=FRESH)
            self._tail.close()
            self._begin(self._tail.rows, [])
        except (OSError, pa.ArrowException) as error:
            raise RowsError(f"{self.path} cannot be extended: {error}; its rows are kept") from error
        self._tail = TextRows(self.path / TAIL, self.plan, is_tail=True)

    def _begin(self, after: int, lines: list[bytes]) -> None:
        """Replace the tail atomically by a new one."""
        replace_file(self.path / TAIL, header_line(self.plan, after) + b"".join(lines), self.path, fresh=FRESH)


def _kind(row: dict[str, Any]) -> RowKind:
    return RowKind(row["verdict"], row["level"], row["how"])


def _schema(plan: SweepPlan, words: "pa.DataType") -> "pa.Schema":
    """Return the columns; variables, seed, sample and level may be null."""
    import pyarrow as pa  # noqa: PLC0415 -- an optional extra

    return pa.schema(
        [
            ("case", words),
            *((name, words if is_word else pa.float64()) for name, is_word in plan.columns.items()),
            ("seed", pa.int64()),
            ("sample", pa.int64()),
            ("verdict", words),
            ("level", pa.int32()),
            ("how", words),
        ]
    )
