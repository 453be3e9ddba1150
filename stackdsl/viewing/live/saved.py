"""Whether files were saved: looked up thirty times a second, which costs nothing for the few files of a scenario.

Libraries that are told by the system bring threads, see no files on some network drives, and lose files that an editor
replaces; and what a scenario takes from others can lie anywhere.
"""

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from time import sleep
from typing import TypeAlias

INTERVAL = 0.03  # [s] between looks
SETTLED = 0.02  # [s] without a change, after which a file counts as written

Stamps: TypeAlias = Mapping[Path, tuple[int, int, int] | None]


def stamps_of(files: Iterable[Path]) -> Stamps:
    """What tells of each file whether it is as it was; None of one that is not there."""
    return {file: _stamp(file) for file in files}


def settled_stamps_of(files: Iterable[Path]) -> Stamps:
    """The same, once two looks find the same: many editors empty a file before they write it."""
    files = list(files)
    before, now = None, stamps_of(files)
    while now != before:
        sleep(SETTLED)
        before, now = now, stamps_of(files)
    return now


def is_saved_since(stamps: Stamps) -> bool:
    """Whether a file is not as it was."""
    return any(_stamp(file) != stamp for file, stamp in stamps.items())


def _stamp(file: Path) -> tuple[int, int, int] | None:
    try:
        found = os.stat(file)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
