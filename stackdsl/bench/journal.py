"""The file that runs are written to as they come: one line each, read again to go on where it was left."""

import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from stackdsl.asked_files import make_asked, open_asked
from stackdsl.bench.run_record import MalformedRecordError, Record, line_of, record_of
from stackdsl.disk import read_file, replace_file

NAME = "runs.jsonl"
ASIDE = "runs.of-other-jobs.jsonl"


@dataclass(frozen=True, slots=True)
class Journal:
    """The runs of one bench, in a directory of its own."""

    folder: Path

    @property
    def path(self) -> Path:
        """The file itself."""
        return self.folder / NAME

    @property
    def aside(self) -> Path:
        """Where runs of other jobs are put."""
        return self.folder / ASIDE

    def begin(self) -> None:
        """An empty file; one from before is kept beside it, under its name with `.old`."""
        make_asked(self.folder)
        with suppress(FileNotFoundError):
            self.path.replace(self.path.with_suffix(".jsonl.old"))
        replace_file(self.path, b"", self.folder)

    def add(self, record: Record) -> None:
        """Write one run, and see it on its way to the disk."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
        with os.fdopen(open_asked(self.path, flags, self.folder), "ab") as file:
            file.write(f"{line_of(record)}\n".encode())
            file.flush()
            os.fsync(file.fileno())

    def held(self) -> list[Record]:
        """All runs that the file holds by now, and those that were put aside."""
        return [*_read(self.aside), *_read(self.path)]

    def go_on(self, wanted: Collection[str]) -> list[Record]:
        """What was done before of what is wanted now, by id; the file keeps these runs and no other.

        Those that nobody wants now are put beside it, and are found there when they are wanted again.
        """
        make_asked(self.folder)
        held = self.held()
        found = {record.id: record for record in held if record.id in wanted and record.done}
        others = {record.id: record for record in held if record.id not in wanted}
        # Runs go both ways: for a moment the one aside holds all, so that none is lost if this call ends in between.
        if others:
            _rewrite(self.aside, held)
        _rewrite(self.path, found.values())
        if others:
            _rewrite(self.aside, others.values())
        else:
            self.aside.unlink(missing_ok=True)
        return list(found.values())


def _rewrite(path: Path, records: Iterable[Record]) -> None:
    replace_file(path, "".join(line_of(record) + "\n" for record in records).encode(), path.parent)


def _read(path: Path) -> Iterator[Record]:
    """A line that was cut off, or is of another format, is as good as none: its run is done again."""
    if not path.exists():
        return
    for line in read_file(path, within=path.parent).decode(errors="replace").splitlines():
        try:
            yield record_of(line)
        except MalformedRecordError:
            continue
