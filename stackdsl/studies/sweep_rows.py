"""Writes the rows of a sweep as JSON lines or Parquet, and resumes where a file ends."""

import errno
import fcntl
import json
import os
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, BinaryIO, Final, Self

from stackdsl.asked_files import make_asked, open_asked
from stackdsl.disk import NOT_REGULAR, read_file, remove_file, replace_file
from stackdsl.studies.sweep_plan import PlannedCase, RowKind, SweepPlan

if TYPE_CHECKING:
    import pyarrow as pa


# Rows as text: a line of JSON each, below a line that says of which sweep they are.


class RowsError(Exception):
    """A file that cannot be gone on with: of another sweep, in use, damaged, or one that cannot be written."""


@dataclass
class Counts:
    """How many rows of each kind there are, by the number of the case."""

    of: dict[int, Counter[RowKind]] = field(default_factory=dict)

    @property
    def rows(self) -> int:
        """All of them."""
        return sum(counter.total() for counter in self.of.values())

    def add(self, index: int, kind: RowKind, count: int = 1) -> None:
        """So many more of a kind."""
        self.of.setdefault(index, Counter())[kind] += count

    def merge(self, more: "Counts") -> None:
        """Add all of those."""
        for index, counter in more.of.items():
            self.of.setdefault(index, Counter()).update(counter)


def head_of(entry: PlannedCase) -> bytes:
    """What a row of a case begins with, up to the number of the sample."""
    return f'{{"case": {json.dumps(entry.name)}, "seed": {json.dumps(entry.seed)}, "sample": '.encode()


def tail_of(kind: RowKind) -> bytes:
    """What a row ends with."""
    return b", " + json.dumps(kind._asdict()).encode()[1:] + b"\n"


def number_of(entry: PlannedCase, sample: int) -> bytes:
    """The number of a sample; a case that is played once has none."""
    return b"%d" % sample if entry.case.is_sampled else b"null"


def kind_of(tail: bytes) -> RowKind | None:
    """What such an end says; None where it is none."""
    try:
        said = json.loads(b"{" + tail[2:])
        kind = RowKind(said["verdict"], said["level"], said["how"])
    except (KeyError, TypeError, ValueError):
        return None
    return kind if tail_of(kind) == tail else None


def header_line(plan: SweepPlan, after: int = 0) -> bytes:
    """The first line of a file, of which so many rows are kept elsewhere."""
    return json.dumps({**plan.header, "after": after}).encode() + b"\n"


def refuse_other(line: bytes, plan: SweepPlan, path: object) -> int:
    """How many rows come before those of a file, by its first line. Raises RowsError where it is of another sweep."""
    try:
        said = json.loads(line)
        differing = [key for key in plan.header if said.get(key) != plan.header[key]]
        after = said["after"]
        cases = {told["case"]: told for told in said["cases"]}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RowsError(f"{path} is no file of a sweep: its first line says nothing of one; {_ELSE}") from error
    if differing:
        raise RowsError(f"{path} is of another sweep: {_why(differing, said, cases, plan)}; {_ELSE}")
    return int(after)


_ELSE: Final = "write to another file, or remove this one"


def _why(differing: list[str], said: dict[str, object], cases: dict[str, dict[str, object]], plan: SweepPlan) -> str:
    if "stackdsl" in differing or "rows" in differing:
        return f"stackdsl {said.get('stackdsl')} wrote it, and this is {plan.header['stackdsl']}"
    for entry in plan.entries:
        was = cases.get(entry.name)
        if was is None:
            return f"it has no case '{entry.name}', but {', '.join(cases)}"
        if was.get("seed") != entry.seed:
            return f"'{entry.name}' had seed {was.get('seed')}, and has {entry.seed} now"
        if was.get("scenario") != entry.told["scenario"]:
            return f"'{entry.name}' has been changed since"
    if len(cases) != len(plan.entries):
        gone = [name for name in cases if name not in {entry.name for entry in plan.entries}]
        return f"it also has {', '.join(gone)}"
    if "cases" in differing:
        return "its cases come in another order, or with other values of their parameters"
    return "another program wrote it: the code of stackdsl, Python, numpy, scipy, clarabel or the engine has changed"


# Locks of files that one process writes to, and that no copy of that process keeps.


IN_USE: Final = "another sweep writes to it now: wait for that, or write to another file"
_HELD: Final[set[int]] = set()  # the descriptors of what is locked


def lock(descriptor: int, path: Path) -> None:
    """Let nobody else write to what is open, until `unlock`. Raises RowsError."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise RowsError(f"{path} is in use: {IN_USE}") from error
        return  # a file system without locks: then it is up to whoever calls
    _HELD.add(descriptor)


def unlock(descriptor: int) -> None:
    """No longer keep what is about to be closed from others; nothing happens if it was not locked."""
    _HELD.discard(descriptor)


def _let_go() -> None:
    """A copy of this process would hold what is locked for as long as it lives, even if this one is killed."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in _HELD:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
    _HELD.clear()


os.register_at_fork(after_in_child=_let_go)


# Rows in a file of JSON lines, in order, that is gone on with where it ends.


LONGEST: Final = 1 << 20  # [bytes] of a line; what has none within so many is no file of ours


class JsonLines:
    """A file of rows under way. What it holds on opening is counted, and a last line that was cut short is removed."""

    def __init__(self, path: Path, plan: SweepPlan, *, locked: bool = True) -> None:
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
        kinds = dict[bytes, RowKind | None]()
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


# Rows in a folder of Parquet files, with a file of JSON lines for those that fill no file yet.
#
# A Parquet file is of no use before its last byte is written, so each is written at once, of as many rows as fill one.
# What comes after stands in `_tail.jsonl`, which readers of such folders pass over, and in a last file once a sweep
# ends. Where a kill has left rows in both, the tail has them: it says how many rows come before its own.


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

    def __init__(self, path: Path, plan: SweepPlan, part: int = PART) -> None:
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
            self.counts.add(numbers[case], RowKind(*kind), count)

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


def _kind(row: dict[str, Any]) -> RowKind:
    return RowKind(row["verdict"], row["level"], row["how"])


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
