"""The file that runs are written to as they come: one line each, read again to go on where it was left."""

import os
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from stackdsl.bench.run_record import MalformedRecordError, Record, line_of, record_of
from stackdsl.disk import make_asked, read_file, refuse_outside, write_asked
from stackdsl.project_file import home_of

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
        make_asked(self.folder, home_of(Path()))
        if self.path.exists():
            self.path.replace(self.path.with_suffix(".jsonl.old"))
        self.path.touch()

    def add(self, record: Record) -> None:
        """Write one run, and see it on its way to the disk."""
        refuse_outside(self.path, self.folder)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(line_of(record) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def held(self) -> list[Record]:
        """All runs that the file holds by now, and those that were put aside."""
        return [*_read(self.aside), *_read(self.path)]

    def go_on(self, wanted: Collection[str]) -> list[Record]:
        """What was done before of what is wanted now, by id; the file keeps these runs and no other.

        Those that nobody wants now are put beside it, and are found there when they are wanted again.
        """
        make_asked(self.folder, home_of(Path()))
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
    fresh = path.with_suffix(".jsonl.new")
    write_asked(fresh, "".join(line_of(record) + "\n" for record in records).encode(), path.parent)
    fresh.replace(path)


def _read(path: Path) -> Iterator[Record]:
    """A line that was cut off, or is of another format, is as good as none: its run is done again."""
    if not path.exists():
        return
    for line in read_file(path).decode(errors="replace").splitlines():
        try:
            yield record_of(line)
        except MalformedRecordError:
            continue
