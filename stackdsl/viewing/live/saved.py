"""Whether files were saved: looked up a hundred times a second, which costs next to nothing for those of a scenario.

Libraries that are told by the system bring threads, see no files on some network drives, and lose files that an editor
replaces; and what a scenario takes from others can lie anywhere.
"""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from time import sleep
from typing import TypeAlias, TypeVar

INTERVAL = 0.01  # [s] between looks
TICK = 0.01  # [s] of the clock of a file system: of two saves within one, stamps may know the first alone
SETTLED = 0.02  # [s] without a change, after which a file that makes no sense counts as written

Stamps: TypeAlias = Mapping[Path, tuple[int, int, int] | None]
Read = TypeVar("Read")


def stamps_of(files: Iterable[Path]) -> Stamps:
    """What tells of each file whether it is as it was; None of one that is not there."""
    return {file: _stamp(file) for file in files}


def read_whole(
    files: Iterable[Path], read: Callable[[], Read], makes_sense: Callable[[Read], bool]
) -> tuple[Stamps, Read]:
    """What `read` makes of files that nobody changed meanwhile, and the stamps that they had.

    Many editors empty a file before they write it: what makes no sense is believed only after a while without a change.
    """
    files = list(files)
    while True:
        sleep(TICK)
        stamps = stamps_of(files)
        found = read()
        if not makes_sense(found):
            sleep(SETTLED)
        if not is_saved_since(stamps):
            return stamps, found


def is_saved_since(stamps: Stamps) -> bool:
    """Whether a file is not as it was."""
    return any(_stamp(file) != stamp for file, stamp in stamps.items())


def _stamp(file: Path) -> tuple[int, int, int] | None:
    try:
        found = os.stat(file)
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
