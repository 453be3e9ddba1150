"""Golden files: read on every run, written only on request; owners, and changes that await review."""

import json
import os
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields, replace
from errno import ENAMETOOLONG
from hashlib import sha256
from pathlib import Path
from secrets import token_hex
from time import time
from typing import Final, NamedTuple

from stability.name_order import in_order, natural_key
from stackdsl.disk import (
    NOT_REGULAR,
    LeadsOutsideError,
    leads_outside,
    make_folder,
    read_file,
    refuse_outside,
    remove_file,
    remove_folder,
    replace_file,
    unlinked,
)
from stackdsl.goldens.comparison import compare_documents, fallen_in, unclear_in
from stackdsl.goldens.file_format import GOLDEN_NAME, canonical_text, directory_of, document, golden_name
from stackdsl.goldens.snapshot import (
    FORMAT,
    Identity,
    MalformedSnapshotError,
    Snapshot,
    made_by_other_engine,
    stamp_note,
)
from stackdsl.project_file import GOLDEN
from stackdsl.results import GoldenDifference, GoldenResult, GoldenStatus, Unclear
from stackdsl.shown_text import visible

# Owner of a golden file outside the project's scenarios: a test in Python, or YAML elsewhere.
#
# The file names its owner in one line, so that a check of all scenarios does not remove it as unused. The line is not
# compared with anything.


ELSEWHERE: Final = "elsewhere"  # name of an owner outside the project, or without a file, such as a notebook
LINE: Final = re.compile(rb'^  "kept_by": ("(?:[^"\\\n]|\\.)*"),?\r?$', re.MULTILINE)


def keeper_of(file: str, golden: Path, scenarios: Path) -> str:
    """Return the owner that a golden file names; empty for scenarios below the directory of scenarios.

    `file` contains the scenario or the test; `golden` is the directory of golden files, `scenarios` that of the
    scenarios checked together with it.
    """
    ways = [(Path(way(file)), Path(way(scenarios)), Path(way(golden.parent))) for way in (_absolute, os.path.realpath)]
    if any(own.is_relative_to(folder) for own, folder, _ in ways):
        return ""
    inside = [own.relative_to(home).as_posix() for own, _, home in ways if own.is_relative_to(home)]
    return next((name for name in inside if is_there(name, golden)), ELSEWHERE)


def _absolute(path: str | Path) -> str:
    return os.path.abspath(path)  # links are not resolved


def keeper_in(content: object) -> str:
    """Return the owner named in the content of a golden file; empty if it names none."""
    found = LINE.search(content) if isinstance(content, bytes) else None
    with suppress(ValueError):
        value = json.loads(found[1]) if found is not None else ""
        return value if isinstance(value, str) else ""
    return ""


def with_keeper(content: bytes, keeper: str) -> bytes:
    """Return the content of a golden file that names an owner, with another owner."""
    return LINE.sub(lambda line: line[0].replace(line[1], json.dumps(keeper).encode("ascii")), content, count=1)


def is_there(keeper: str, golden: Path) -> bool:
    """Return whether the owner of a golden file still exists; an owner outside the project does not count."""
    if keeper in ("", ELSEWHERE):
        return bool(keeper)
    try:
        return not leads_outside(golden.parent / keeper, golden.parent) and os.path.isfile(golden.parent / keeper)
    except OSError as error:  # a file in an unreadable directory may exist
        return error.errno != ENAMETOOLONG
    except ValueError:  # a name that no file has
        return False


def is_lost(keeper: str, golden: Path) -> bool:
    """Return whether an owner is a Python file of the project that no longer exists.

    It may be renamed. Only pytest knows whether a test uses the golden file, so `stackdsl check` keeps it.
    """
    with suppress(OSError, ValueError):
        inside = keeper.endswith(".py") and not leads_outside(golden.parent / keeper, golden.parent)
        return inside and not is_there(keeper, golden)
    return False


def is_kept(file: Path, golden: Path, checked: Collection[str]) -> bool:
    """Return whether a golden file has an owner other than the checked files, given by their real paths."""
    try:
        keeper = keeper_in(read_file(file, within=golden))
    except OSError:
        return False
    exists = is_there(keeper, golden) and os.path.realpath(golden.parent / keeper) not in checked
    return exists or is_lost(keeper, golden)


def kept_by_python(golden: Path) -> Mapping[str, list[str]]:
    """Return the golden files by the Python file that keeps them, or kept them before it was renamed or deleted."""
    kept = defaultdict[str, list[str]](list)
    for file in sorted(golden.glob("*/*.json")):
        keeper = keeper_in(content_of(str(file)))
        if keeper.endswith(".py") and (is_there(keeper, golden) or is_lost(keeper, golden)):
            kept[keeper].append(file.as_posix())
    return kept


# Golden files: one snapshot each, read on every run, written only on request.


WRITABLE = "make the directory writable, or choose another one with --golden"
CONFLICT = re.compile(r"^(?:<{7}|>{7})(?: |$)", re.MULTILINE)  # conflict markers of git
STAMP_LINE = re.compile(r'^  "stamp": \{[^\n]*\},$', re.MULTILINE)
TEMPORARY = ".golden.tmp"  # ends the name of a file that is being written
LEFT_NAME = re.compile(r"\.[0-9a-f]+" + re.escape(TEMPORARY))
HEAD = 256  # [bytes] start of a golden file, which identifies it
LEFT_OVER = 3600.0  # [s] a temporary file of this age belongs to a run that was killed
REFUSED = "golden files are not written in CI; update them locally and review the diff"
NOT_CI = ("", "0", "false", "no")  # values of the environment variable CI that mean the opposite


COMPARED: Final = set[str]()  # paths of golden files that this process has compared: pytest tells the others
LEFT_ALONE = (GoldenStatus.SAME, GoldenStatus.NEWER, GoldenStatus.OTHER_ENGINE)  # not changed by an update


class NewerFormatError(MalformedSnapshotError):
    """A newer version wrote a golden file; it is left unchanged, as its content is unknown."""


class GoldenWriteRefusedError(RuntimeError):
    """Golden files must not be written in CI, where nobody reviews the differences."""


class StoredGolden(NamedTuple):
    """Content of a golden file."""

    content: bytes | GoldenResult  # or the reason why it cannot be read
    digest: str  # SHA-256; empty if it cannot be read


def stored_golden(path: Path, directory: Path) -> StoredGolden:
    """Read a golden file in a directory."""
    found = content(path, directory)
    return StoredGolden(found, text_digest(found))


@dataclass(frozen=True, slots=True)
class GoldenReader:
    """Reads each golden file once."""

    _read: dict[Path, StoredGolden] = field(default_factory=dict)

    def digest(self, path: Path, directory: Path) -> str:
        """Return the SHA-256 of a golden file; empty if it cannot be read. Its content is kept for `take`."""
        if path not in self._read:
            self._read[path] = stored_golden(path, directory)
        return self._read[path].digest

    def take(self, path: Path, directory: Path) -> StoredGolden:
        """Return a golden file, and keep its content no longer."""
        return self._read.pop(path, None) or stored_golden(path, directory)


def check_golden(
    snapshot: Snapshot,
    directory: Path,
    update: bool,
    write_new_goldens: bool = False,
    stored: StoredGolden | None = None,
) -> GoldenResult:
    """Compare a snapshot with its golden file; with `update`, write the file unless it agrees within tolerance.

    In a file that agrees, only a changed stamp is replaced, so that the note about versions does not appear again.
    With `write_new_goldens`, a missing file is written as well.

    A file made with another engine is not overwritten: remove it first. `snapshot.kept_by` is the owner from
    `keeper_of`, used if the file names no existing owner. `stored` is the content of the file if it was read before.

    Raises GoldenWriteRefusedError if asked to update in CI.
    """
    if update or write_new_goldens:
        refuse_in_ci(os.environ)
    path = directory / golden_name(snapshot.identity)
    COMPARED.add(os.path.abspath(path))
    found, digest = stored or stored_golden(path, directory)
    kept, keeper = keeper_in(found), snapshot.kept_by or ""
    if is_there(kept, directory):
        keeper = kept
    text = canonical_text(replace(snapshot, kept_by=keeper or None))
    slid = tuple(map(visible, in_order(snapshot.slid)))
    if found == text.encode("ascii"):  # the usual case; parsing the file of a large scene takes three times as long
        unclear = replace(_visible_unclear(unclear_in(document(snapshot))), slid=slid)
        return GoldenResult(GoldenStatus.SAME, path.as_posix(), digest=digest, unclear=unclear)
    result = replace(judged_content(path.as_posix(), found, document(snapshot)), digest=digest)
    if result.fallen is not None and snapshot.fallen is not None:  # the run knows more than its snapshot
        result = replace(result, fallen=replace(result.fallen, now=snapshot.fallen, unclear_now=0))
    result = replace(result, unclear=replace(result.unclear, slid=slid))
    if result.status is GoldenStatus.MISSING and write_new_goldens and not update:
        return _written(path, directory, text, result, GoldenStatus.NEW)
    agrees = result.status is GoldenStatus.SAME
    kept_by_another = agrees and kept != keeper
    if not update or (result.status in LEFT_ALONE and not (agrees and (result.note or kept_by_another))):
        return replace(result, offered="" if agrees else text)
    was = found.decode("utf-8") if isinstance(found, bytes) and agrees and not kept_by_another else ""
    return _written(path, directory, restamped(was, text) if agrees else text, result, GoldenStatus.WRITTEN)


def refusal(snapshot: Snapshot, option: str) -> str:
    """Return why the golden file of a failing run is not written, and the option that writes it."""
    return f"not written, since the run fails its expectations: {'; '.join(snapshot.missed)}; {option} accepts it"


def _written(path: Path, directory: Path, text: str, result: GoldenResult, status: GoldenStatus) -> GoldenResult:
    try:
        write_golden(path, text, directory)
    except OSError as error:
        return replace(result, note=f"cannot be written: {error.strerror}; {WRITABLE}")
    unclear = result.unclear if result.differences else _visible_unclear(unclear_in(json.loads(text)))
    unclear = replace(unclear, slid=result.unclear.slid)
    return replace(result, status=status, note="", digest="", unclear=unclear)


def _visible_unclear(unclear: Unclear) -> Unclear:
    told = (tuple(map(visible, names)) for names in (unclear.states, unclear.places, unclear.others, unclear.bricks))
    return Unclear(*told)


def content(path: Path, directory: Path) -> bytes | GoldenResult:
    """Return the content of a golden file in a directory, or the reason why it cannot be read."""
    file = path.as_posix()
    try:
        return read_file(path, within=directory)
    except FileNotFoundError:
        return GoldenResult(GoldenStatus.MISSING, file)
    except LeadsOutsideError as error:
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=str(error.strerror))
    except OSError as error:
        note = NOT_REGULAR if error.strerror == NOT_REGULAR else f"it cannot be read: {error.strerror}"
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=note)


def content_of(file: str) -> bytes | GoldenResult:
    """Return the content of a golden file, or the reason why it cannot be read."""
    return content(Path(file), directory_of(Path(file)))


def text_digest(found: bytes | GoldenResult) -> str:
    """Return the SHA-256 of the content of a golden file; empty if it cannot be read."""
    return sha256(found).hexdigest() if isinstance(found, bytes) else ""


def restamped(was: str, now: str) -> str:
    """Return the text of a golden file with the stamp of another; if it has no stamp line, the text of the other."""
    stamp = STAMP_LINE.search(now)
    return STAMP_LINE.sub(lambda _: stamp.group(), was) if stamp and len(STAMP_LINE.findall(was)) == 1 else now


def judged_content(file: str, found: bytes | GoldenResult, got: Mapping[str, object]) -> GoldenResult:
    """Compare the JSON value of a snapshot with the content of a golden file."""
    if not isinstance(found, bytes):
        return found
    try:
        text = found.decode("utf-8")
    except UnicodeDecodeError as error:
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=f"it is not UTF-8 text: {error}")
    return judge_text(file, text, got)


def judge_text(file: str, text: str, got: Mapping[str, object]) -> GoldenResult:
    """Compare the JSON value of a snapshot with the text of a golden file, which may be anything.

    Text of the file in the result is escaped for terminals, pages and annotations.
    """
    try:
        expected = _parsed(text)
        stamps = expected.get("stamp"), got.get("stamp")
        other_engine = made_by_other_engine(*stamps)
        differences = compare_documents(expected, got, other_engine=other_engine)
        unclear = Unclear() if other_engine else _visible_unclear(unclear_in(expected, got))
        fallen = None if other_engine else fallen_in(expected, got)
    except NewerFormatError as error:
        return GoldenResult(GoldenStatus.NEWER, file, note=visible(str(error)))
    except (ValueError, RecursionError) as error:
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=visible(_why_not(text, error)))
    agrees = GoldenStatus.OTHER_ENGINE if other_engine else GoldenStatus.SAME
    status = GoldenStatus.DIFFERENT if differences else agrees
    escaped = tuple(map(_escaped, differences))
    return GoldenResult(status, file, escaped, visible(stamp_note(*stamps)), unclear=unclear, fallen=fallen)


def _escaped(found: GoldenDifference) -> GoldenDifference:
    told = visible(found.subject), visible(found.quantity), visible(found.expected), visible(found.got)
    return replace(found, subject=told[0], quantity=told[1], expected=told[2], got=told[3])


def _why_not(text: str, error: Exception) -> str:
    """Return the reason why a text is no snapshot."""
    if marker := CONFLICT.search(text):
        line = text.count("\n", 0, marker.start()) + 1
        return f"it has a merge conflict at line {line}; keep one version, or accept the result to write the file again"
    return f"it is not a valid snapshot: {error}"


def renamed_from(snapshot: Snapshot, files: Iterable[str]) -> str:
    """Return the golden file that equals this snapshot except for its name; empty if there is none."""
    got = document(snapshot)
    own = {key: got[key] for key in ("scenario", "variant", "system")}
    for file in files:
        with suppress(ValueError, RecursionError):
            found = content_of(file)
            expected = _parsed(found.decode("utf-8")) if isinstance(found, bytes) else {}
            if expected.get("system") == own["system"] and not compare_documents({**expected, **own}, got):
                return file
    return ""


def identity_in(text: str) -> Identity | None:
    """Return the identity of the run in a snapshot text; None if this version cannot read all of it."""
    try:
        value = _parsed(text)
        if compare_documents(value, value):
            return None
    except (ValueError, RecursionError):
        return None
    names = [value.get(key) for key in ("scenario", "variant", "system")]
    return Identity(*names) if all(isinstance(name, str) for name in names) else None  # type: ignore[arg-type]


def _parsed(text: str) -> Mapping[str, object]:
    """Return the JSON value of a golden file of this format. Raises ValueError or RecursionError."""
    value = json.loads(text, object_pairs_hook=_without_duplicates)
    if not isinstance(value, Mapping):
        raise MalformedSnapshotError("the file is not a JSON object")
    if "\\u" in text:  # an escaped half of a surrogate pair could be read but never be printed
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    was = value.get("format", "none")
    if isinstance(was, int) and not isinstance(was, bool) and was > FORMAT:
        raise NewerFormatError(
            f"it has format {was} of a newer version of stackdsl, and this one reads up to {FORMAT}; update stackdsl"
        )
    if was is True or was != FORMAT:
        raise MalformedSnapshotError(
            f"it has format {was}, and this version reads {FORMAT}; accept the result to write it again"
        )
    return value


def _without_duplicates(pairs: list[tuple[str, object]]) -> dict[str, object]:
    values = dict(pairs)
    if len(values) < len(pairs):
        raise MalformedSnapshotError("a key is written twice")
    return values


def is_ci(environment: Mapping[str, str]) -> bool:
    """Return whether environment variables are those of a CI run."""
    return environment.get("CI", "").strip().lower() not in NOT_CI


def refuse_in_ci(environment: Mapping[str, str]) -> None:
    """Raise GoldenWriteRefusedError if the environment is that of a CI run."""
    if is_ci(environment):
        raise GoldenWriteRefusedError(REFUSED)


def write_golden(path: Path, text: str, directory: Path) -> None:
    """Replace a file in a directory atomically, so that neither a reader nor a crash leaves half of it.

    Raises OSError, and LeadsOutsideError where a link leads it out of the directory.
    """
    make_folder(path.parent, directory)
    _remove_left_over(path.parent, directory)
    # A random name, not the process id: two containers that share a volume may have the same one.
    fresh = f".{token_hex(16)}{TEMPORARY}"
    replace_file(path, text.encode("utf-8"), directory, fresh=fresh, synced=True)


def _remove_left_over(folder: Path, directory: Path) -> None:
    """Remove the temporary files of killed runs, which are older than any write takes."""
    for file in folder.glob(f".*{TEMPORARY}"):
        with suppress(OSError):  # another run may remove it, too
            if LEFT_NAME.fullmatch(file.name) and time() - file.stat(follow_symlinks=False).st_mtime > LEFT_OVER:
                remove_file(file, directory)


def obsolete(directory: Path, expected: Iterable[str], whole_set: bool, checked: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the golden files that are not among the `expected` file names and have no other owner.

    The answer is empty unless the whole set of scenarios was selected and valid, as the others may own any file.
    `checked` are the files of that set: a golden file that names one of these and is not expected is obsolete.
    """
    if not whole_set:
        return ()
    names, used = set[str](), frozenset(expected)
    # An unreadable directory is reported with each snapshot in it.
    with suppress(OSError):
        entries = list(directory.iterdir())
        # The target of a link belongs to another project.
        for folder in (entry for entry in entries if entry.is_dir() and not entry.is_symlink()):
            entries_by_name = {f"{folder.name}/{entry.name}": entry for entry in folder.iterdir()}
            names |= {name for name, entry in entries_by_name.items() if name not in used and _is_golden(entry)}
    known = {os.path.realpath(file) for file in checked}
    unused = [directory / name for name in sorted(names)]
    return tuple(file.as_posix() for file in unused if not is_kept(file, directory, known))


def _is_golden(file: Path) -> bool:
    """Return whether a file in a directory of a scenario is a golden file; other files are left alone."""
    with suppress(OSError):
        return GOLDEN_NAME.fullmatch(file.name) is not None and b'"format"' in read_file(file, HEAD, file.parent.parent)
    return False


def remove_obsolete(files: Iterable[str]) -> tuple[str, ...]:
    """Remove golden files; return the removed ones. Files that cannot be removed are skipped.

    Raises GoldenWriteRefusedError in CI.
    """
    refuse_in_ci(os.environ)
    removed = []
    for file in files:
        with suppress(OSError):
            remove_file(Path(file), directory_of(Path(file)))
            removed.append(file)
        _remove_if_empty(Path(file).parent, directory_of(Path(file)))
    return tuple(removed)


def _remove_if_empty(folder: Path, within: Path) -> None:
    """Remove the directory of a scenario that has no golden files any more."""
    with suppress(OSError):  # a directory that is not empty stays
        remove_folder(folder, within)


# Snapshots that differ from their golden files, kept until they are accepted or rejected.
#
# Each is a file in the state directory of the project, named after the golden file that it would become.


FOLDER: Final = "pending"
OFFERED: Final = (GoldenStatus.MISSING, GoldenStatus.DIFFERENT, GoldenStatus.RENAMED, GoldenStatus.UNREADABLE)


class StaleError(RuntimeError):
    """The golden file changed after the comparison, so accepting would not accept the difference that was shown."""


@dataclass(frozen=True, slots=True)
class Pending:
    """A snapshot that awaits a decision."""

    golden: str  # the file that it would become, relative to the parent of the state directory
    case: str
    status: str  # of the golden file when it was compared
    against: str  # digest of that file; empty where there was none
    renamed_from: str  # as `golden`; empty where nothing is renamed
    failed: tuple[str, ...]  # expectations that the run did not meet
    text: str
    file: str = ""  # YAML file of the case, as `golden`; empty if it is unknown

    @property
    def files(self) -> tuple[str, ...]:
        """The golden files that `accept` writes or removes."""
        return tuple(filter(None, (self.golden, self.renamed_from)))

    def compared(self, goldens: "PendingStore") -> GoldenResult:
        """Return the comparison with the golden file, without differences as far as it is not readable."""
        found = goldens.content(self.renamed_from or self.golden)
        return judged_content(self.golden, found, json.loads(self.text))

    @property
    def unclear(self) -> Unclear:
        """Return the unclear observations, which the golden file does not lock."""
        return _visible_unclear(unclear_in(json.loads(self.text)))

    def is_stale(self, goldens: "PendingStore") -> bool:
        """Return whether the golden file has changed since the comparison."""
        now = text_digest(goldens.content(self.golden))
        return now not in (self.against, sha256(self.text.encode()).hexdigest())


@dataclass(frozen=True, slots=True)
class PendingStore:
    """The pending snapshots in a state directory such as `.stackdsl`.

    A pending file may come with a project: it counts only if its text is a snapshot and its names are those that this
    program gives to the golden files of such a snapshot.
    """

    state: Path
    golden: Path | None = None  # the directory of golden files; by default the one beside the other

    @property
    def home(self) -> Path:
        """Return the directory to which names of golden files are relative."""
        return self.state.parent

    @property
    def folder(self) -> Path:
        """Return the directory of golden files."""
        return self.golden or self.home / GOLDEN

    def content(self, golden: str) -> bytes | GoldenResult:
        """Return the content of a golden file, by its name in a pending snapshot."""
        return content(self.home / golden, self.folder)

    def note(self, case: str, golden: GoldenResult, failed: tuple[str, ...], file: str = "") -> None:
        """Store a snapshot that differs from its golden file, drop one that agrees; `file` is the YAML of the case."""
        key = os.path.relpath(golden.file, self.home)
        with suppress(OSError):  # the next check stores it again
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
        """Drop snapshots that no longer differ, and renames of golden files that agree."""
        keys = {os.path.relpath(file, self.home) for file in agreeing}
        for pending in self.all():
            if keys & {pending.golden, pending.renamed_from}:
                with suppress(OSError):
                    self.reject(pending)

    def forget_gone(self, names: Collection[str], files: Iterable[str]) -> None:
        """Drop snapshots from these files that are no longer among their cases."""
        known = {os.path.relpath(file, self.home) for file in files}
        for pending in self.all():
            if pending.file in known and pending.case not in names:
                with suppress(OSError):
                    self.reject(pending)

    def all(self) -> Iterator[Pending]:
        """Yield all pending snapshots by the names of cases; other files are skipped."""
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
        yield from sorted(found, key=lambda pending: natural_key(pending.case))

    def _is_own(self, pending: Pending) -> bool:
        """Return whether this program could have written a pending file: a snapshot, its case and its golden file."""
        identity = identity_in(pending.text)
        if identity is None or pending.case != identity.case:
            return False
        if pending.golden != os.path.relpath(self.folder / golden_name(identity), self.home):
            return False
        return not pending.renamed_from or self._is_golden_file(pending.renamed_from)

    def _is_golden_file(self, name: str) -> bool:
        """Return whether a relative name is that of a golden file."""
        inside = os.path.relpath(self.home / name, self.folder)
        folder, _, file = inside.rpartition("/")
        named = folder not in ("", "..") and "/" not in folder and GOLDEN_NAME.fullmatch(file) is not None
        return named and os.path.normpath(name) == name

    def accept(self, pending: Pending) -> None:
        """Write a pending snapshot to its golden file, and remove the file that it was renamed from.

        Raises StaleError, OSError, and GoldenWriteRefusedError in CI. After an interrupt, both files are complete, and
        the snapshot can be accepted again.
        """
        refuse_in_ci(os.environ)
        if not self._is_own(pending):
            raise StaleError(f"{pending.golden} is not the golden file of {pending.case}: check the case again")
        if pending.is_stale(self):
            raise StaleError(f"{pending.golden} has changed since the check: check {pending.case} again")
        for name in pending.files:
            refuse_outside((self.home / name).parent, self.folder)
        write_golden(self.home / pending.golden, pending.text, self.folder)
        if pending.renamed_from:
            remove_file(self.home / pending.renamed_from, self.folder)
            _remove_if_empty((self.home / pending.renamed_from).parent, self.folder)
        self.reject(pending)

    def reject(self, pending: Pending) -> None:
        """Drop a pending snapshot; the golden file is not changed. Raises OSError."""
        unlinked(self.state, FOLDER)
        remove_file(self._file(pending.golden), self.home)

    def _file(self, golden: str) -> Path:
        return self.state / FOLDER / f"{sha256(golden.encode('utf-8', 'surrogateescape')).hexdigest()[:32]}.json"
