"""Files and directories as whoever sent a project may have made them: links, pipes, devices and hard links among them.

A path that is written as below a folder stays below it: one that leaves it through a link is refused. Only regular
files are read, for a pipe may have no writer and a device no end. A file is written in the place of the one that is
there, so that nothing else that has the same content by a hard link changes. All errors are OSErrors with a `strerror`
and a `filename`, as those of the system are.
"""

import os
from contextlib import suppress
from errno import EINVAL, EISDIR, ELOOP
from pathlib import Path
from secrets import token_hex
from stat import S_ISDIR, S_ISLNK, S_ISREG
from typing import Final

NOT_REGULAR: Final = "it is no regular file"
STREAMS: Final = ("/dev/fd/", "/dev/stdin", "/proc/self/fd/")  # what a shell puts for `<(command)`, which ends
_NO_WAITING: Final = getattr(os, "O_NONBLOCK", 0)  # of a pipe that nobody writes to or reads from


class LeadsOutsideError(OSError):
    """A path leaves the folder that it is written to be in, through a link."""


def refuse_outside(path: Path, folder: Path) -> None:
    """Raise LeadsOutsideError if a path that is written as below a folder leads out of it, through a link.

    A path that is written as elsewhere is left to whoever wrote it.
    """
    if is_below(os.path.abspath(path), os.path.abspath(folder)) and leads_outside(path, folder):
        raise LeadsOutsideError(ELOOP, f"a link leads out of {_shown(folder)}", str(path))


def leads_outside(path: str | Path, folder: str | Path) -> bool:
    """Whether a path, however it is written, ends outside of a folder. Where there is no file, its place counts."""
    return not is_below(os.path.realpath(path), os.path.realpath(folder))


def is_below(path: str, folder: str) -> bool:
    """Whether a path without links is a folder without links, or below it."""
    return Path(path).is_relative_to(folder)


def unlinked(folder: Path, *parts: str) -> Path:
    """The path of what is below a folder by these names. Raises LeadsOutsideError if it or a part of it is a link."""
    path = folder
    for part in ("", *parts):
        path = path / part
        with suppress(FileNotFoundError):
            if S_ISLNK(path.lstat().st_mode):
                raise LeadsOutsideError(ELOOP, "it is a link, and nothing of this kind is followed", str(path))
    return path


def read_file(path: Path, most: int = -1) -> bytes:
    """The content of a regular file, up to `most` bytes of it. Raises OSError, also for what is no regular file."""
    if str(path).startswith(STREAMS):
        with path.open("rb") as stream:
            return stream.read(most)
    _refuse_irregular(os.stat(path).st_mode, path)  # first without opening it: a device may obey that
    descriptor = os.open(path, os.O_RDONLY | _NO_WAITING | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as stream:
        _refuse_irregular(os.fstat(descriptor).st_mode, path)
        return stream.read(most)


def _refuse_irregular(mode: int, path: Path) -> None:
    if S_ISDIR(mode):
        raise IsADirectoryError(EISDIR, os.strerror(EISDIR), str(path))
    if not S_ISREG(mode):
        raise OSError(EINVAL, NOT_REGULAR, str(path))


def replace_file(path: Path, data: bytes) -> None:
    """Write a file as a whole: another process, or one that is killed, leaves it as it was, or as it is to be."""
    fresh = path.with_name(f".{token_hex(8)}.tmp")
    try:
        with fresh.open("xb") as stream:
            stream.write(data)
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)


def make_asked(folder: Path, project: Path) -> None:
    """Make a folder that somebody asked for by name. Raises OSError, also where a link leads it out of the project."""
    refuse_outside(folder, project)
    folder.mkdir(parents=True, exist_ok=True)


def write_asked(path: Path, data: bytes, project: Path) -> None:
    """Write a file that somebody asked for by name, which may be a pipe or a device. Raises OSError.

    Where it is written as below the project, no link leads it elsewhere, and a hard link is cut first.
    """
    refuse_outside(path, project)
    with suppress(FileNotFoundError):
        found = path.stat()
        if S_ISREG(found.st_mode) and found.st_nlink > 1:
            path.unlink()
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | _NO_WAITING | getattr(os, "O_BINARY", 0), 0o666)
    with os.fdopen(descriptor, "wb") as stream:
        os.set_blocking(descriptor, True)
        stream.write(data)


def _shown(folder: Path) -> str:
    return os.path.relpath(folder) if folder != Path() else "this directory"
