"""Golden files of earlier versions, moved to the names that this one gives them."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from stackdsl.disk import make_folder, move_file, read_file
from stackdsl.snapshots.file_names import OLD_NAME, golden_name
from stackdsl.snapshots.record import Identity


def moved_to_new_names(directory: Path) -> Iterator[tuple[Path, Path | None]]:
    """Rename each file; what it was and is, and None where it says no name or another file has it. Raises OSError.

    Cut short, it has moved some, each as a whole, and can be called again.
    """
    for old in sorted(file for file in directory.glob("*.json") if OLD_NAME.fullmatch(file.name)):
        identity = _identity(old, directory)
        new = directory / golden_name(identity) if identity is not None else None
        if new is None or new.exists():
            yield old, None
            continue
        make_folder(new.parent, directory)
        move_file(old, new, directory)
        yield old, new


def _identity(file: Path, directory: Path) -> Identity | None:
    with suppress(OSError, ValueError, RecursionError, KeyError, TypeError):
        value = json.loads(read_file(file, within=directory))
        names = [value[key] for key in ("scenario", "variant", "system")]
        if all(isinstance(name, str) for name in names):
            return Identity(*names)
    return None
