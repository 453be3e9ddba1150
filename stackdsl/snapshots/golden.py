"""Golden files: a snapshot each, read on every run, written only when a person asks for it."""

import json
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from secrets import token_hex
from time import time

from stackdsl.disk import (
    NOT_REGULAR,
    LeadsOutsideError,
    make_folder,
    read_file,
    remove_file,
    remove_folder,
    replace_file,
)
from stackdsl.outcome import GoldenDifference, GoldenResult, GoldenStatus
from stackdsl.shown_text import visible
from stackdsl.snapshots.canonical import document
from stackdsl.snapshots.compact import golden_text
from stackdsl.snapshots.comparison import compare_documents
from stackdsl.snapshots.file_names import NEW_NAME, OLD_NAME, directory_of, golden_file
from stackdsl.snapshots.keepers import is_kept, is_there, keeper_in
from stackdsl.snapshots.record import COMPACT_FORMAT, FORMAT, Identity, MalformedSnapshotError, Snapshot
from stackdsl.snapshots.stamp import differ_in_engine, stamp_note

WRITABLE = "make room for it, or name another directory by --golden"
CONFLICT = re.compile(r"^(?:<{7}|>{7})(?: |$)", re.MULTILINE)  # as git leaves it
STAMP_LINE = re.compile(r'^  "stamp": \{[^\n]*\},$', re.MULTILINE)
FORMAT_KEY = re.compile(rb'"format":\s*(\d+)')
TEMPORARY = ".golden.tmp"  # ends the name of a file that is being written
LEFT_NAME = re.compile(r"\.[0-9a-f]+" + re.escape(TEMPORARY))
HEAD = 256  # [bytes] of a golden file that say what it is
LEFT_OVER = 3600.0  # [s] a temporary file of this age belongs to a run that was killed
NOT_CI = ("", "0", "false", "no")  # values of the environment variable CI that mean the opposite


LEFT_ALONE = (GoldenStatus.SAME, GoldenStatus.NEWER, GoldenStatus.OTHER_ENGINE)  # by an update


class NewerFormatError(MalformedSnapshotError):
    """A newer version wrote a golden file: what it locks is not known here, so it is left alone."""


class GoldenWriteRefusedError(RuntimeError):
    """Golden files are written by people, who review them as a diff; a CI run only reads them."""


def check_golden(
    snapshot: Snapshot, directory: Path, update: bool, lock_new: bool = False, kept_by: str = ""
) -> GoldenResult:
    """Hold a snapshot against its file; with `update`, write the file unless it agrees within tolerance.

    Of one that agrees only the stamp is written, if that has changed: who accepts what comes out need not hear again
    what it was made with before. With `lock_new`, a file that there is not is written as well.

    A file that was made with another engine is not written over, for those who have that one: whoever means to removes
    it first. `kept_by` is who keeps a file in which nobody is named who is still there, as `keepers.keeper_of` says.

    Raises GoldenWriteRefusedError if asked to update in CI.
    """
    if update or lock_new:
        refuse_in_ci(os.environ)
    path = golden_file(directory, snapshot.identity)
    found = content(path, directory)
    kept, keeper = keeper_in(found), kept_by
    if is_there(kept, directory):
        keeper = kept
    text = golden_text(replace(snapshot, kept_by=keeper or None))
    if found == text.encode("ascii"):  # as most are; of a large scene, reading what it says takes three times as long
        return GoldenResult(GoldenStatus.SAME, path.as_posix(), digest=text_digest(found))
    result = judged_content(path.as_posix(), found, document(snapshot))
    if result.status is GoldenStatus.MISSING and lock_new and not update:
        return _written(path, directory, text, result, GoldenStatus.NEW)
    agrees = result.status is GoldenStatus.SAME
    of_another_format = isinstance(found, bytes) and _format_of(found) != _format_of(text.encode("ascii"))
    outgrown = agrees and (of_another_format or kept != keeper)
    if not update or (result.status in LEFT_ALONE and not (agrees and (result.note or outgrown))):
        return replace(result, offered="" if agrees else text)
    was = found.decode("utf-8") if isinstance(found, bytes) and agrees and not outgrown else ""
    return _written(path, directory, restamped(was, text) if agrees else text, result, GoldenStatus.WRITTEN)


def _format_of(text: bytes) -> bytes:
    """The format that a golden file says it has."""
    found = FORMAT_KEY.search(text[:HEAD])
    return found[1] if found else b""


def _written(path: Path, directory: Path, text: str, result: GoldenResult, status: GoldenStatus) -> GoldenResult:
    try:
        write_golden(path, text, directory)
    except OSError as error:
        return replace(result, note=f"cannot be written: {error.strerror}; {WRITABLE}")
    return replace(result, status=status, note="", digest="")


def content(path: Path, directory: Path) -> bytes | GoldenResult:
    """All that a golden file in a directory holds, or why it cannot be read."""
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
    """All that a golden file holds, or why it cannot be read."""
    return content(Path(file), directory_of(Path(file)))


def text_digest(found: bytes | GoldenResult) -> str:
    """The SHA-256 of what a golden file holds; empty where it cannot be read."""
    return sha256(found).hexdigest() if isinstance(found, bytes) else ""


def restamped(was: str, now: str) -> str:
    """The text of a golden file with the stamp of another one; that other one as a whole, if it has no line for it."""
    stamp = STAMP_LINE.search(now)
    return STAMP_LINE.sub(lambda _: stamp.group(), was) if stamp and len(STAMP_LINE.findall(was)) == 1 else now


def judged_content(file: str, found: bytes | GoldenResult, got: Mapping[str, object]) -> GoldenResult:
    """The comparison of a snapshot's JSON value with what was read of a golden file."""
    if not isinstance(found, bytes):
        return found
    try:
        text = found.decode("utf-8")
    except UnicodeDecodeError as error:
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=f"it is not UTF-8 text: {error}")
    return replace(judge_text(file, text, got), digest=text_digest(found))


def judge_text(file: str, text: str, got: Mapping[str, object]) -> GoldenResult:
    """The comparison of a snapshot's JSON value with the text of a golden file, which may hold anything.

    What is told of it is escaped here, for terminals, pages and annotations alike.
    """
    try:
        expected = _parsed(text)
        stamps = expected.get("stamp"), got.get("stamp")
        other_engine = differ_in_engine(*stamps)
        differences = compare_documents(expected, got, other_engine=other_engine)
    except NewerFormatError as error:
        return GoldenResult(GoldenStatus.NEWER, file, note=visible(str(error)))
    except (ValueError, RecursionError) as error:
        return GoldenResult(GoldenStatus.UNREADABLE, file, note=visible(_why_not(text, error)))
    agrees = GoldenStatus.OTHER_ENGINE if other_engine else GoldenStatus.SAME
    status = GoldenStatus.DIFFERENT if differences else agrees
    return GoldenResult(status, file, tuple(map(_escaped, differences)), visible(stamp_note(*stamps)))


def _escaped(found: GoldenDifference) -> GoldenDifference:
    told = visible(found.subject), visible(found.quantity), visible(found.expected), visible(found.got)
    return replace(found, subject=told[0], quantity=told[1], expected=told[2], got=told[3])


def _why_not(text: str, error: Exception) -> str:
    """Why a text holds no snapshot."""
    if marker := CONFLICT.search(text):
        line = text.count("\n", 0, marker.start()) + 1
        return f"it holds two versions, with the markers of a merge from line {line} on; keep one, or write it anew"
    return f"it holds no snapshot: {error}"


def renamed_from(snapshot: Snapshot, files: Iterable[str]) -> str:
    """The golden file, of some, that says all that this snapshot does but what it is called; empty if none does."""
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
    """Which run a text is the snapshot of; None where it is no snapshot that this version reads as a whole."""
    try:
        value = _parsed(text)
        if compare_documents(value, value):
            return None
    except (ValueError, RecursionError):
        return None
    names = [value.get(key) for key in ("scenario", "variant", "system")]
    return Identity(*names) if all(isinstance(name, str) for name in names) else None  # type: ignore[arg-type]


def _parsed(text: str) -> Mapping[str, object]:
    """The JSON value of a golden file of our format. Raises ValueError or RecursionError."""
    value = json.loads(text, object_pairs_hook=_without_duplicates)
    if not isinstance(value, Mapping):
        raise MalformedSnapshotError("its JSON is no object")
    if "\\u" in text:  # an escaped half of a surrogate pair could be read but never be printed
        json.dumps(value, ensure_ascii=False).encode("utf-8")
    was = value.get("format", "none")
    if isinstance(was, int) and not isinstance(was, bool) and was > COMPACT_FORMAT:
        raise NewerFormatError(
            f"its format is {was}, which a newer version wrote; this one reads up to {COMPACT_FORMAT}; update stackdsl"
        )
    if was is True or was not in (FORMAT, COMPACT_FORMAT):
        read = f"this version reads {FORMAT} and {COMPACT_FORMAT}"
        raise MalformedSnapshotError(f"its format is {was}, {read}; write it anew with --update")
    return value


def _without_duplicates(pairs: list[tuple[str, object]]) -> dict[str, object]:
    values = dict(pairs)
    if len(values) < len(pairs):
        raise MalformedSnapshotError("a key is written twice")
    return values


def is_ci(environment: Mapping[str, str]) -> bool:
    """Whether an environment is that of a CI run."""
    return environment.get("CI", "").strip().lower() not in NOT_CI


def refuse_in_ci(environment: Mapping[str, str]) -> None:
    """Raise GoldenWriteRefusedError if the environment is that of a CI run."""
    if is_ci(environment):
        raise GoldenWriteRefusedError("golden files are not written in CI: update them locally and review the diff")


def write_golden(path: Path, text: str, directory: Path) -> None:
    """Replace a file in a directory as a whole, so that no reader and no crash ever sees half of it.

    Raises OSError, and LeadsOutsideError where a link leads it out of the directory.
    """
    make_folder(path.parent, directory)
    _remove_left_over(path.parent, directory)
    # Not the process id: two containers that share a volume may both be number 7.
    fresh = f".{token_hex(16)}{TEMPORARY}"
    replace_file(
        path, text.encode("utf-8"), directory, fresh=fresh, synced=True
    )  # what people write into one that agrees stays


def _remove_left_over(folder: Path, directory: Path) -> None:
    """Remove the temporary files of runs that were killed: no write takes as long as these are old."""
    for file in folder.glob(f".*{TEMPORARY}"):
        with suppress(OSError):  # another run may do the same
            if LEFT_NAME.fullmatch(file.name) and time() - file.stat(follow_symlinks=False).st_mtime > LEFT_OVER:
                remove_file(file, directory)


def obsolete(directory: Path, expected: Iterable[str], whole_set: bool, checked: Iterable[str] = ()) -> tuple[str, ...]:
    """The golden files that belong to none of the `expected` file names, and that nobody else keeps.

    Answers only when the whole set of scenarios was selected and valid, else nobody knows what belongs to the rest.
    `checked` are the files of that set: what one of these says it keeps, and does not, is obsolete.
    """
    if not whole_set:
        return ()
    names: set[str] = set()
    # A directory that cannot be read is told for each snapshot that should be in it.
    with suppress(OSError):
        entries = list(directory.iterdir())
        names |= {entry.name for entry in entries if OLD_NAME.fullmatch(entry.name) and entry.is_file()}
        # What is behind a link belongs to somebody else.
        for folder in (entry for entry in entries if entry.is_dir() and not entry.is_symlink()):
            names |= {f"{folder.name}/{entry.name}" for entry in folder.iterdir() if _is_golden(entry)}
    known = {os.path.realpath(file) for file in checked}
    unused = [directory / name for name in sorted(names.difference(expected))]
    return tuple(file.as_posix() for file in unused if not is_kept(file, directory, known))


def _is_golden(file: Path) -> bool:
    """Whether a file in a directory of a scenario is a golden file: any other is nobody's business here."""
    with suppress(OSError):
        return NEW_NAME.fullmatch(file.name) is not None and b'"format"' in read_file(file, HEAD, file.parent.parent)
    return False


def remove_obsolete(files: Iterable[str]) -> tuple[str, ...]:
    """Remove golden files; those that are gone now, which are not all where the disk refuses.

    Raises GoldenWriteRefusedError in CI.
    """
    refuse_in_ci(os.environ)
    removed = []
    for file in files:
        with suppress(OSError):
            remove_file(Path(file), directory_of(Path(file)))
            removed.append(file)
        with suppress(OSError):  # one that is not empty stays
            if not OLD_NAME.fullmatch(Path(file).name):
                remove_folder(Path(file).parent, directory_of(Path(file)))
    return tuple(removed)
