"""Files and directories as whoever sent a project may have made them: links, pipes, devices and hard links among them.

A path that is written as below a folder stays below it: one that leaves it through a link is refused. Only regular
files are read, for a pipe may have no writer and a device no end. What is opened is found from folder to folder without
following links, so that none that is put in the way after a path was looked at leads elsewhere. Where a folder truly is
counts as it was when this process first asked: one that is replaced by a link meanwhile does not vouch for itself. All
errors are OSErrors with a `strerror` and a `filename`, as those of the system are.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EEXIST, EINVAL, EISDIR, ELOOP, EMLINK
from pathlib import Path
from secrets import token_hex
from stat import S_ISDIR, S_ISLNK, S_ISREG
from typing import Final

NOT_REGULAR: Final = "it is no regular file"
# What a shell puts for `<(command)`, which ends, and what stands for the streams of this process.
STREAMS: Final = ("/dev/fd/", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc/self/fd/")
_NO_WAITING: Final = getattr(os, "O_NONBLOCK", 0)  # of a pipe that nobody writes to or reads from
_NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
_BINARY: Final = getattr(os, "O_BINARY", 0)
_INNER_FOLDER: Final = _NO_LINK | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_PATH", os.O_RDONLY)


_HELD: Final[dict[str, str]] = {}  # the true paths of folders that something is to be within, by their absolute ones


class LeadsOutsideError(OSError):
    """A path leaves the folder that it is written to be in, through a link."""


def refuse_outside(path: Path, folder: Path) -> None:
    """Raise LeadsOutsideError if a path that is written as below a folder leads out of it, through a link.

    A path that is written as elsewhere is left to whoever wrote it.
    """
    if is_below(os.path.abspath(path), os.path.abspath(folder)) and leads_outside(path, folder):
        raise LeadsOutsideError(ELOOP, f"a link leads out of {called(folder)}", str(path))


def leads_outside(path: str | Path, folder: str | Path) -> bool:
    """Whether a path, however it is written, ends outside of a folder. Where there is no file, its place counts."""
    return not is_below(os.path.realpath(path), true_folder(folder))


def true_folder(folder: str | Path, true: str = "") -> str:
    """The true path that a folder had when this process first asked. `true` is that path, where it is known."""
    written = os.path.abspath(folder)
    return _HELD.setdefault(written, true or os.path.realpath(written))


def is_below(path: str, folder: str) -> bool:
    """Whether a path without links is a folder without links, or below it."""
    return Path(path).is_relative_to(folder)


def is_stream(path: Path) -> bool:
    """Whether a path stands for a stream of this process rather than for a file."""
    return str(path).startswith(STREAMS)


def unlinked(folder: Path, *parts: str) -> Path:
    """The path of what is below a folder by these names. Raises LeadsOutsideError if it or a part of it is a link."""
    path = folder
    for part in ("", *parts):
        path = path / part
        with suppress(FileNotFoundError):
            if S_ISLNK(path.lstat().st_mode):
                raise LeadsOutsideError(ELOOP, "it is a link, and nothing of this kind is followed", str(path))
    return path


# --- one file, by its true path ---------------------------------------------------------------------------------------


@contextmanager
def _named_in_folder(true: str, *, made: bool = False) -> Iterator[tuple[str, int | None]]:
    """The name of a file, and the descriptor of its folder; or its path, and None where the system has no such calls.

    `true` is a path without links: where one has come to be a part of it, OSError is raised. With `made`, folders that
    are not there are made.
    """
    if os.open not in os.supports_dir_fd or not os.path.isabs(true):
        if made:
            os.makedirs(os.path.dirname(true), exist_ok=True)
        yield true, None
        return
    root, *parts = Path(true).parts
    folder = os.open(root, _INNER_FOLDER)
    try:
        for part in parts[:-1]:
            try:
                if made and not _is_there(part, folder):
                    with suppress(FileExistsError):  # another process may make it
                        os.mkdir(part, dir_fd=folder)
                outer, folder = folder, os.open(part, _INNER_FOLDER, dir_fd=folder)
            except NotADirectoryError as error:
                if S_ISLNK(os.stat(part, dir_fd=folder, follow_symlinks=False).st_mode):
                    raise OSError(ELOOP, os.strerror(ELOOP), true) from error
                raise
            os.close(outer)
        yield parts[-1] if parts else ".", folder
    finally:
        os.close(folder)


def _is_there(name: str, folder: int) -> bool:
    try:
        os.stat(name, dir_fd=folder, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return True


def make_true(true: str) -> None:
    """Make a folder by its path without links, and those that it is in, where they are not there. Raises OSError."""
    try:
        with _named_in_folder(os.path.join(true, "any"), made=True):
            pass
    except NotADirectoryError as error:
        if os.path.lexists(true):
            raise FileExistsError(EEXIST, os.strerror(EEXIST), true) from error
        raise


def make_folder(folder: Path, within: Path) -> None:
    """Make a folder inside another one. Raises OSError, and LeadsOutsideError if a link leads out of that one."""
    true = os.path.realpath(folder)
    _refuse_beyond(true, folder, within)
    make_true(true)


def open_regular(true: str, flags: int, *, alone: bool = False) -> int:
    """The descriptor of a regular file by its path without links. Raises OSError.

    With `alone`, one that has another name as well, by a hard link, is refused: what is written there would change it.
    """
    with _named_in_folder(true) as (name, folder):
        with suppress(FileNotFoundError):  # first without opening it: a device may obey that
            _refuse_irregular(os.stat(name, dir_fd=folder, follow_symlinks=False), true, alone)
        descriptor = os.open(name, flags | _NO_LINK | _NO_WAITING | _BINARY, 0o666, dir_fd=folder)
    try:
        _refuse_irregular(os.fstat(descriptor), true, alone)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _refuse_irregular(found: os.stat_result, path: str, alone: bool) -> None:
    if S_ISDIR(found.st_mode):
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), path)
    if not S_ISREG(found.st_mode):
        raise OSError(EINVAL, NOT_REGULAR, path)
    if alone and found.st_nlink > 1:
        raise OSError(EMLINK, "it has another name as well, by a hard link, and is left as it is", path)


def read_file(path: Path, most: int = -1, within: str | Path | None = None) -> bytes:
    """The content of a regular file, up to `most` bytes of it. Raises OSError, also for what is no regular file.

    Raises LeadsOutsideError if it is not truly within that folder, where one is given.
    """
    if within is None and is_stream(path):
        return read_stream(path, most)
    true = os.path.realpath(path)
    _refuse_beyond(true, path, within)
    return read_true(true, most)


def _refuse_beyond(true: str, path: Path, folder: str | Path | None) -> None:
    if folder is not None and not is_below(true, true_folder(folder)):
        raise LeadsOutsideError(ELOOP, f"a link leads out of {called(folder)}", str(path))


def read_stream(path: Path, most: int = -1) -> bytes:
    """What comes by a stream of this process, up to `most` bytes of it. Raises OSError."""
    with path.open("rb") as stream:
        return stream.read(most)


def read_true(true: str, most: int = -1) -> bytes:
    """The content of a regular file by its path without links, up to `most` bytes of it. Raises OSError."""
    with os.fdopen(open_regular(true, os.O_RDONLY), "rb") as stream:
        return stream.read(most)


def replace_file(path: Path, data: bytes, within: Path, *, fresh: str = "", synced: bool = False) -> None:
    """Write a file as a whole: another process, or one that is killed, leaves it as it was, or as it is to be.

    What is in its place, such as a link, is replaced and not written to. `fresh` is what the file is called until it is
    whole; `synced`, whether it is on the disk before it has its name. Raises OSError, and LeadsOutsideError where a
    link leads to another place than within that folder.
    """
    fresh = fresh or f".{token_hex(8)}.tmp"
    true = _place(path, within)
    with _named_in_folder(true) as (name, folder):
        temporary = fresh if folder is not None else os.path.join(os.path.dirname(true), fresh)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINK | _BINARY
        try:
            with os.fdopen(os.open(temporary, flags, 0o666, dir_fd=folder), "wb") as stream:
                stream.write(data)
                stream.flush()
                if synced:
                    os.fsync(stream.fileno())
            os.replace(temporary, name, src_dir_fd=folder, dst_dir_fd=folder)
        except BaseException:
            with suppress(OSError):
                os.unlink(temporary, dir_fd=folder)
            raise


def remove_file(path: Path, within: Path) -> None:
    """Remove a file, or a link, where there is one. Raises OSError, and LeadsOutsideError as `replace_file` does."""
    with suppress(FileNotFoundError), _named_in_folder(_place(path, within)) as (name, folder):
        os.unlink(name, dir_fd=folder)


def remove_folder(path: Path, within: Path) -> None:
    """Remove a folder that is empty. Raises OSError as `remove_file` does."""
    with _named_in_folder(_place(path, within)) as (name, folder):
        os.rmdir(name, dir_fd=folder)


def _place(path: Path, within: Path) -> str:
    """Where a file is, whatever it is: the true path of its folder, and its name."""
    true = os.path.join(os.path.realpath(path.parent), path.name)
    _refuse_beyond(true, path, within)
    return true


def write_true(true: str, data: bytes) -> None:
    """Write a file by its path without links, which may be a pipe or a device; a hard link is cut. Raises OSError."""
    with _named_in_folder(true) as (name, folder):
        with suppress(FileNotFoundError):
            found = os.stat(name, dir_fd=folder, follow_symlinks=False)
            if S_ISREG(found.st_mode) and found.st_nlink > 1:
                os.unlink(name, dir_fd=folder)
        flags = os.O_WRONLY | os.O_CREAT | _NO_LINK | _NO_WAITING | _BINARY
        descriptor = os.open(name, flags, 0o666, dir_fd=folder)
    with os.fdopen(descriptor, "wb") as stream:
        if S_ISREG((found := os.fstat(descriptor)).st_mode):
            _refuse_irregular(found, true, alone=True)
            os.ftruncate(descriptor, 0)
        os.set_blocking(descriptor, True)
        stream.write(data)


def called(folder: str | Path) -> str:
    """What a folder is called in a message."""
    seen = os.path.relpath(folder)
    return "this directory" if seen == os.curdir else seen
