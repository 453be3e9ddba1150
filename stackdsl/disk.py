"""Safe access to files and directories of untrusted projects, which may hold links, pipes, devices and hard links.

A path below a folder must stay below it: a path that leaves it through a link is refused. Only regular files are read,
since a pipe may have no writer and a device no end. Files are opened folder by folder without following links, so that
a link that is created after the check of a path leads nowhere else. The resolved path of a folder is cached at the
first use, so that a folder that is replaced by a link later is still checked against its first place. All errors are
OSErrors with a `strerror` and a `filename`, like those of the system.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EEXIST, EINVAL, EISDIR, ELOOP, EMLINK
from hashlib import sha256
from pathlib import Path
from secrets import token_hex
from stat import S_ISDIR, S_ISLNK, S_ISREG
from typing import Final, NamedTuple

NOT_REGULAR: Final = "it is not a regular file"
# Paths for `<(command)` in a shell, which ends, and for the streams of this process.
STREAMS: Final = ("/dev/fd/", "/dev/stdin", "/dev/stdout", "/dev/stderr", "/proc/self/fd/")
_NO_WAITING: Final = getattr(os, "O_NONBLOCK", 0)  # do not wait for the other end of a pipe
_NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
_BINARY: Final = getattr(os, "O_BINARY", 0)
_INNER_FOLDER: Final = _NO_LINK | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_PATH", os.O_RDONLY)


_RESOLVED: Final[dict[str, str]] = {}  # resolved paths of enclosing folders, by absolute path


class LeadsOutsideError(OSError):
    """A path leaves its folder through a link."""


def refuse_outside(path: Path, folder: Path) -> None:
    """Raise LeadsOutsideError if a path below a folder leads out of it through a link.

    A path that is not below the folder by its name is accepted.
    """
    if is_below(os.path.abspath(path), os.path.abspath(folder)) and leads_outside(path, folder):
        raise LeadsOutsideError(ELOOP, f"a link leads out of {called(folder)}", str(path))


def leads_outside(path: str | Path, folder: str | Path) -> bool:
    """Return whether a resolved path is outside of a folder. The file need not exist."""
    return not is_below(os.path.realpath(path), true_folder(folder))


def true_folder(folder: str | Path, true: str = "") -> str:
    """Return the resolved path of a folder at its first use in this process; `true` is that path if it is known."""
    written = os.path.abspath(folder)
    return _RESOLVED.setdefault(written, true or os.path.realpath(written))


def is_below(path: str, folder: str) -> bool:
    """Return whether a resolved path is a resolved folder, or below it."""
    return Path(path).is_relative_to(folder)


def is_stream(path: Path) -> bool:
    """Return whether a path names a stream of this process."""
    return str(path).startswith(STREAMS)


def unlinked(folder: Path, *parts: str) -> Path:
    """Return the path of `parts` below a folder. Raises LeadsOutsideError if the folder or a part of it is a link."""
    path = folder
    for part in ("", *parts):
        path = path / part
        with suppress(FileNotFoundError):
            if S_ISLNK(path.lstat().st_mode):
                raise LeadsOutsideError(ELOOP, "it is a link, which is not followed", str(path))
    return path


# --- one file, by its resolved path -----------------------------------------------------------------------------------


@contextmanager
def _named_in_folder(true: str, *, made: bool = False) -> Iterator[tuple[str, int | None]]:
    """Yield the name of a file and the descriptor of its folder; its path and None on systems without such calls.

    `true` is a resolved path. Raises OSError if a part of it has become a link. With `made`, missing folders are made.
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
    """Make a folder and its parents by resolved path, unless they exist. Raises OSError."""
    try:
        with _named_in_folder(os.path.join(true, "any"), made=True):
            pass
    except NotADirectoryError as error:
        if os.path.lexists(true):
            raise FileExistsError(EEXIST, os.strerror(EEXIST), true) from error
        raise


def make_folder(folder: Path, within: Path) -> None:
    """Make a folder inside another one. Raises OSError, and LeadsOutsideError if a link leads outside."""
    true = os.path.realpath(folder)
    _refuse_beyond(true, folder, within)
    make_true(true)


def open_regular(true: str, flags: int, *, alone: bool = False) -> int:
    """Open a regular file by its resolved path, and return the descriptor. Raises OSError.

    With `alone`, a file with several hard links is refused, since writing would change it under its other names.
    """
    with _named_in_folder(true) as (name, folder):
        with suppress(FileNotFoundError):  # check before opening, since opening a device may have effects
            _refuse_irregular(os.stat(name, dir_fd=folder, follow_symlinks=False), true, alone)
        descriptor = os.open(name, flags | _NO_LINK | _NO_WAITING | _BINARY, 0o666, dir_fd=folder)
    try:
        _refuse_irregular(os.fstat(descriptor), true, alone)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _refuse_irregular(status: os.stat_result, path: str, alone: bool) -> None:
    if S_ISDIR(status.st_mode):
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), path)
    if not S_ISREG(status.st_mode):
        raise OSError(EINVAL, NOT_REGULAR, path)
    if alone and status.st_nlink > 1:
        raise OSError(EMLINK, "it has several hard links and is not changed", path)


def read_file(path: Path, most: int = -1, within: str | Path | None = None) -> bytes:
    """Return the content of a regular file, at most `most` bytes. Raises OSError, also for an irregular file.

    Raises LeadsOutsideError if the resolved path is not within the folder `within`.
    """
    if within is None and is_stream(path):
        return read_stream(path, most)
    true = os.path.realpath(path)
    _refuse_beyond(true, path, within)
    return read_true(true, most)


class Content(NamedTuple):
    """Bytes of a file, and their SHA-256."""

    data: bytes
    digest: str


def with_digest(data: bytes) -> Content:
    """Return the bytes of a file with their digest."""
    return Content(data, sha256(data).hexdigest())


def _refuse_beyond(true: str, path: Path, folder: str | Path | None) -> None:
    if folder is not None and not is_below(true, true_folder(folder)):
        raise LeadsOutsideError(ELOOP, f"a link leads out of {called(folder)}", str(path))


def read_stream(path: Path, most: int = -1) -> bytes:
    """Return the content of a stream of this process, at most `most` bytes. Raises OSError."""
    with path.open("rb") as stream:
        return stream.read(most)


def read_true(true: str, most: int = -1) -> bytes:
    """Return the content of a regular file by its resolved path, at most `most` bytes. Raises OSError."""
    with os.fdopen(open_regular(true, os.O_RDONLY), "rb") as stream:
        return stream.read(most)


def replace_file(path: Path, data: bytes, within: Path, *, fresh: str = "", synced: bool = False) -> None:
    """Write a file atomically: other processes see the old or the new content, even if this one is killed.

    A link in its place is replaced, not followed. `fresh` is the name of the temporary file; with `synced` it is
    flushed to the disk before it is renamed. Raises OSError, and LeadsOutsideError if a link leads outside of `within`.
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
    """Remove a file or a link, if it exists. Raises OSError, and LeadsOutsideError as `replace_file` does."""
    with suppress(FileNotFoundError), _named_in_folder(_place(path, within)) as (name, folder):
        os.unlink(name, dir_fd=folder)


def remove_folder(path: Path, within: Path) -> None:
    """Remove an empty folder. Raises OSError as `remove_file` does."""
    with _named_in_folder(_place(path, within)) as (name, folder):
        os.rmdir(name, dir_fd=folder)


def _place(path: Path, within: Path) -> str:
    """Return the resolved path of the folder of a file, with the name of the file, which may be a link."""
    true = os.path.join(os.path.realpath(path.parent), path.name)
    _refuse_beyond(true, path, within)
    return true


def write_true(true: str, data: bytes) -> None:
    """Write a file by its resolved path, which may be a pipe or a device. Replace a hard link by a new file.

    Raises OSError.
    """
    with _named_in_folder(true) as (name, folder):
        with suppress(FileNotFoundError):
            status = os.stat(name, dir_fd=folder, follow_symlinks=False)
            if S_ISREG(status.st_mode) and status.st_nlink > 1:
                os.unlink(name, dir_fd=folder)
        flags = os.O_WRONLY | os.O_CREAT | _NO_LINK | _NO_WAITING | _BINARY
        descriptor = os.open(name, flags, 0o666, dir_fd=folder)
    with os.fdopen(descriptor, "wb") as stream:
        if S_ISREG((status := os.fstat(descriptor)).st_mode):
            _refuse_irregular(status, true, alone=True)
            os.ftruncate(descriptor, 0)
        os.set_blocking(descriptor, True)
        stream.write(data)


def called(folder: str | Path) -> str:
    """Return the name of a folder for a message."""
    seen = os.path.relpath(folder)
    return "this directory" if seen == os.curdir else seen
