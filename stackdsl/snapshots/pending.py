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
from stackdsl.disk import read_file, refuse_outside, remove_file, replace_file, unlinked
from stackdsl.outcome import GoldenDifference, GoldenResult, GoldenStatus
from stackdsl.project_file import GOLDEN
from stackdsl.snapshots.file_names import NEW_NAME, OLD_NAME, golden_name, old_name
from stackdsl.snapshots.golden import content, identity_in, judge_text, refuse_in_ci, text_digest, write_golden

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

    def differences(self, goldens: "Waiting") -> tuple[GoldenDifference, ...]:
        """What it says other than the golden file does, as far as that can be read."""
        found = goldens.content(self.renamed_from or self.golden)
        if not isinstance(found, bytes):
            return ()
        got = json.loads(self.text)
        return judge_text(self.golden, found.decode("utf-8", "replace"), got).differences

    def is_stale(self, goldens: "Waiting") -> bool:
        """Whether the golden file has changed since it was compared."""
        now = text_digest(goldens.content(self.golden))
        return now not in (self.against, sha256(self.text.encode()).hexdigest())


@dataclass(frozen=True, slots=True)
class Waiting:
    """All that waits, in a directory such as `.stackdsl`, of becoming golden files in another one.

    Whoever sent the project may have made what waits: it counts only where its text is a snapshot, and where its names
    are those that this program gives to the golden files of such.
    """

    state: Path
    golden: Path | None = None  # the directory of golden files; by default the one beside the other

    @property
    def home(self) -> Path:
        """What golden files are seen from."""
        return self.state.parent

    @property
    def folder(self) -> Path:
        """Where golden files are."""
        return self.golden or self.home / GOLDEN

    def content(self, golden: str) -> bytes | GoldenResult:
        """What a golden file holds, by its name in what waits."""
        return content(self.home / golden, self.folder)

    def note(self, case: str, golden: GoldenResult, failed: tuple[str, ...], file: str = "") -> None:
        """Keep what differs from its golden file, and let go of what does not; `file` is the YAML that has the case."""
        key = os.path.relpath(golden.file, self.home)
        with suppress(OSError):  # it can be had again
            if golden.status not in OFFERED or not golden.offered:
                remove_file(unlinked(self.state, FOLDER) / self._file(key).name, self.home)
                return
            renamed = os.path.relpath(golden.renamed_from, self.home) if golden.renamed_from else ""
            source = os.path.relpath(file, self.home) if os.path.isfile(file) else ""
            kept = Pending(key, case, golden.status.value, golden.digest, renamed, failed, golden.offered, source)
            write_golden(unlinked(self.state, FOLDER) / self._file(key).name, json.dumps(asdict(kept)), self.home)
            ignored = self.state / ".gitignore"
            if not ignored.exists():
                replace_file(ignored, b"*\n", self.home)

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
        with suppress(OSError):
            for file in unlinked(self.state, FOLDER).glob("[0-9a-f]*.json"):
                with suppress(OSError, ValueError, TypeError, RecursionError, KeyError):
                    value = json.loads(read_file(unlinked(file), within=self.home))
                    pending = Pending(**{**value, "failed": tuple(value["failed"])})
                    texts = [getattr(pending, field.name) for field in fields(Pending) if field.name != "failed"]
                    is_text = all(isinstance(text, str) for text in (*texts, *pending.failed))
                    if is_text and file == self._file(pending.golden) and self._is_own(pending):
                        found.append(pending)
        yield from sorted(found, key=lambda pending: as_counted(pending.case))

    def _is_own(self, pending: Pending) -> bool:
        """Whether this program could have written it: a snapshot, its case, and the golden file of that."""
        identity = identity_in(pending.text)
        if identity is None or pending.case != f"{identity.scenario}[{identity.variant}]":
            return False
        names = golden_name(identity), old_name(identity)
        if pending.golden not in [os.path.relpath(self.folder / name, self.home) for name in names]:
            return False
        return not pending.renamed_from or self._is_golden_file(pending.renamed_from)

    def _is_golden_file(self, name: str) -> bool:
        """Whether it is the name of a golden file, as one sees it from where others are seen from."""
        inside = os.path.relpath(self.home / name, self.folder)
        folder, _, file = inside.rpartition("/")
        named = OLD_NAME.fullmatch(file) if not folder else NEW_NAME.fullmatch(file)
        return named is not None and "/" not in folder and folder != ".." and os.path.normpath(name) == name

    def accept(self, pending: Pending) -> None:
        """Let it become the golden file; a renamed one goes from where it was.

        Raises StaleError, OSError, and GoldenWriteRefusedError in CI. Whenever it is cut short, both files are whole,
        and it can be accepted again.
        """
        refuse_in_ci(os.environ)
        if not self._is_own(pending):
            raise StaleError(f"{pending.golden} is no golden file of {pending.case}: check it again")
        if pending.is_stale(self):
            raise StaleError(f"{pending.golden} has changed since it was compared: check {pending.case} again")
        for name in pending.files:
            refuse_outside((self.home / name).parent, self.folder)
        write_golden(self.home / pending.golden, pending.text, self.folder)
        if pending.renamed_from:
            remove_file(self.home / pending.renamed_from, self.folder)
        self.reject(pending)

    def reject(self, pending: Pending) -> None:
        """Forget it; the golden file stays as it is. Raises OSError."""
        unlinked(self.state, FOLDER)
        remove_file(self._file(pending.golden), self.home)

    def _file(self, golden: str) -> Path:
        return self.state / FOLDER / f"{sha256(golden.encode('utf-8', 'surrogateescape')).hexdigest()[:32]}.json"
