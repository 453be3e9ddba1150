"""What came out other than a golden file says, kept until somebody accepts it or not.

A file each, in the directory where a project remembers things, named after the golden file that it would become.
"""

import json
import os
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import Final

from stability.name_order import as_counted
from stackdsl.outcome import GoldenDifference, GoldenResult, GoldenStatus
from stackdsl.snapshots.golden import content, judge_text, refuse_in_ci, text_digest, write_golden

FOLDER: Final = "pending"
OFFERED: Final = (GoldenStatus.MISSING, GoldenStatus.DIFFERENT, GoldenStatus.RENAMED, GoldenStatus.UNREADABLE)


class StaleError(RuntimeError):
    """A golden file is another than the one that was compared: what would be accepted is not what was seen."""


@dataclass(frozen=True, slots=True)
class Pending:
    """One snapshot that waits for a decision."""

    golden: str  # the file that it would become, as seen from the directory above the one where things are remembered
    case: str
    status: str  # of the golden file when it was compared
    against: str  # digest of that file; empty where there was none
    renamed_from: str  # as `golden`; empty where nothing is renamed
    failed: tuple[str, ...]  # expectations that the run did not meet
    text: str
    file: str = ""  # of YAML that has the case, as `golden`; empty where that cannot be told

    @property
    def files(self) -> tuple[str, ...]:
        """The golden files that accepting it writes or removes."""
        return tuple(filter(None, (self.golden, self.renamed_from)))

    def differences(self, home: Path) -> tuple[GoldenDifference, ...]:
        """What it says other than the golden file does, as far as that can be read."""
        found = content(home / (self.renamed_from or self.golden))
        if not isinstance(found, bytes):
            return ()
        got = json.loads(self.text)
        return judge_text(self.golden, found.decode("utf-8", "replace"), got).differences

    def is_stale(self, home: Path) -> bool:
        """Whether the golden file has changed since it was compared."""
        now = text_digest(content(home / self.golden))
        return now not in (self.against, sha256(self.text.encode()).hexdigest())


@dataclass(frozen=True, slots=True)
class Waiting:
    """All that waits, in a directory such as `.stackdsl`."""

    state: Path

    @property
    def home(self) -> Path:
        """What golden files are seen from."""
        return self.state.parent

    def note(self, case: str, golden: GoldenResult, failed: tuple[str, ...], file: str = "") -> None:
        """Keep what differs from its golden file, and let go of what does not; `file` is the YAML that has the case."""
        key = os.path.relpath(golden.file, self.home)
        with suppress(OSError):  # it can be had again
            if golden.status not in OFFERED or not golden.offered:
                self._file(key).unlink(missing_ok=True)
                return
            renamed = os.path.relpath(golden.renamed_from, self.home) if golden.renamed_from else ""
            source = os.path.relpath(file, self.home) if Path(file).is_file() else ""
            kept = Pending(key, case, golden.status.value, golden.digest, renamed, failed, golden.offered, source)
            write_golden(self._file(key), json.dumps(asdict(kept)))
            ignored = self.state / ".gitignore"
            if not ignored.exists():
                ignored.write_text("*\n", encoding="utf-8")

    def forget(self, agreeing: Iterable[str]) -> None:
        """Let go of what no longer differs, and of what would take away a golden file that agrees."""
        keys = {os.path.relpath(file, self.home) for file in agreeing}
        for pending in self.all():
            if keys & {pending.golden, pending.renamed_from}:
                with suppress(OSError):
                    self.reject(pending)

    def forget_gone(self, names: Collection[str], files: Iterable[str]) -> None:
        """Let go of what came from one of these files, and is none of the cases that they have now."""
        known = {os.path.relpath(file, self.home) for file in files}
        for pending in self.all():
            if pending.file in known and pending.case not in names:
                with suppress(OSError):
                    self.reject(pending)

    def all(self) -> Iterator[Pending]:
        """All of it, by the names of cases; a file that is none is passed over."""
        found = []
        for file in (self.state / FOLDER).glob("[0-9a-f]*.json"):
            with suppress(OSError, ValueError, TypeError, RecursionError):
                value = json.loads(file.read_bytes())
                pending = Pending(**{**value, "failed": tuple(value["failed"])})
                texts = [getattr(pending, field.name) for field in fields(Pending) if field.name != "failed"]
                if all(isinstance(text, str) for text in (*texts, *pending.failed)):
                    found.append(pending)
        yield from sorted(found, key=lambda pending: as_counted(pending.case))

    def accept(self, pending: Pending) -> None:
        """Let it become the golden file; a renamed one goes from where it was.

        Raises StaleError, OSError, and GoldenWriteRefusedError in CI. Whenever it is cut short, both files are whole,
        and it can be accepted again.
        """
        refuse_in_ci(os.environ)
        if pending.is_stale(self.home):
            raise StaleError(f"{pending.golden} has changed since it was compared: check {pending.case} again")
        write_golden(self.home / pending.golden, pending.text)
        if pending.renamed_from:
            (self.home / pending.renamed_from).unlink(missing_ok=True)
        self.reject(pending)

    def reject(self, pending: Pending) -> None:
        """Forget it; the golden file stays as it is. Raises OSError."""
        self._file(pending.golden).unlink(missing_ok=True)

    def _file(self, golden: str) -> Path:
        return self.state / FOLDER / f"{sha256(golden.encode('utf-8', 'surrogateescape')).hexdigest()[:32]}.json"
