"""Reads and writes files that a user names. They may lie anywhere.

A path inside a project must also resolve to a file inside it: the project may come from somebody else, and the user
does not see which parts of the path are links.
"""

import os
from errno import EEXIST
from pathlib import Path

from stackdsl.disk import is_stream, make_true, open_regular, read_stream, read_true, write_true
from stackdsl.project_file import confined


def read_user_file(path: Path, most: int = -1) -> bytes:
    """Return the content of a regular file, at most `most` bytes. Raises OSError."""
    return read_stream(path, most) if is_stream(path) else read_true(confined(path), most)


def make_user_folder(folder: Path) -> None:
    """Make a folder. Raises OSError."""
    make_true(confined(folder))


def write_user_file(path: Path, data: bytes, *folders: Path) -> None:
    """Write a file, which may be a pipe or a device. Replace a hard link by a new file. Raises OSError."""
    if is_stream(path):
        path.write_bytes(data)
    else:
        write_true(confined(path, *folders), data)


def open_user_file(path: Path, flags: int, *folders: Path) -> int:
    """Open a regular file to append to it, and return its descriptor. Raises OSError, also for a hard link."""
    true = confined(path, *folders)
    if flags & os.O_EXCL and path.is_symlink():  # a new file is not created through a link
        raise FileExistsError(EEXIST, os.strerror(EEXIST), str(path))
    return open_regular(true, flags, alone=True)
