"""Locks of files that one process writes to, and that no copy of that process keeps."""

import errno
import fcntl
import os
from pathlib import Path
from typing import Final

from stackdsl.sweeping.row_text import RowsError

IN_USE: Final = "another sweep writes to it now: wait for that, or write to another file"
_HELD: Final[set[int]] = set()  # the descriptors of what is locked


def lock(descriptor: int, path: Path) -> None:
    """Let nobody else write to what is open, until `unlock`. Raises RowsError."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            raise RowsError(f"{path} is in use: {IN_USE}") from error
        return  # a file system without locks: then it is up to whoever calls
    _HELD.add(descriptor)


def unlock(descriptor: int) -> None:
    """No longer keep what is about to be closed from others; nothing happens if it was not locked."""
    _HELD.discard(descriptor)


def _let_go() -> None:
    """A copy of this process would hold what is locked for as long as it lives, even if this one is killed."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in _HELD:
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
    _HELD.clear()


os.register_at_fork(after_in_child=_let_go)
