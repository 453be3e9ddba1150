"""Reads files of other programs in a supervised process, so that a parser that hangs or crashes affects only its file.

MuJoCo, the URDF parser and Qhull get untrusted input, so they never run in the supervising process.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Import
from stackdsl.supervising.executors import supervised
from stackdsl.supervising.worker import Task, TaskStatus, memory_limited

TIME_LIMIT: Final = 60.0  # [s] of wall time; a hundred times that of the largest load that may be built
MEMORY_LIMIT: Final = 2 << 30  # [bytes] for the reader; as much as JSON of MAX_IMPORTED needs
MOST_BESIDE: Final = 64 << 20  # [bytes] of all files that one file names


@dataclass(frozen=True, slots=True)
class _MissingFiles:
    """The reader needs these files, which were not passed to it."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Mistakes:
    """The file cannot be read as a load."""

    diagnostics: tuple[Diagnostic, ...]
    proposed: Mapping[str, Any]


def load_supervised(
    data: bytes,
    file: str,
    options: Import,
    read_file: Callable[[str], bytes],
    on_wait: Callable[[], None] = lambda: None,
) -> ImportedLoad:
    """Read a load like `read_load`, in a process of its own. Raises UnreadableLoadError.

    `on_wait` is called from time to time until the load is read.
    """
    files: dict[str, bytes | OSError] = {}
    while True:
        done = supervised(Task(_read, (data, file, options, files), TIME_LIMIT), on_wait)
        match done.value:
            case ImportedLoad():
                return done.value
            case _Mistakes(diagnostics, proposed):
                raise UnreadableLoadError(diagnostics, proposed)
            case _MissingFiles(names):
                files |= _contents(names, read_file, file, files)
            case _:
                failure = "takes too long to read" if done.status is TaskStatus.TIMED_OUT else "crashes its reader"
                message = f"the file {failure}: {done.message}"
                hint = "correct or simplify the file"
                raise UnreadableLoadError([Diagnostic("SD114", Span(file, 1, 1, 1), message, hint)])


def _read(
    data: bytes, file: str, options: Import, files: Mapping[str, bytes | OSError]
) -> ImportedLoad | _Mistakes | _MissingFiles:
    """Read the load in the worker with the files passed so far, or return the names of the missing ones."""
    missing: dict[str, None] = {}

    def read_file(name: str) -> bytes:
        content = files.get(name)
        if content is None:
            missing[name] = None
            raise OSError("the file is not yet available in the worker")
        if isinstance(content, OSError):
            raise content
        return content

    with memory_limited(MEMORY_LIMIT):
        try:
            load = read_load(data, file, options, read_file)
        except UnreadableLoadError as error:
            return _MissingFiles(tuple(missing)) if missing else _Mistakes(error.diagnostics, dict(error.proposed))
    return load


def _contents(
    names: tuple[str, ...], read_file: Callable[[str], bytes], file: str, files: Mapping[str, bytes | OSError]
) -> Mapping[str, bytes | OSError]:
    """Return the contents of files, or the error of each. Raises UnreadableLoadError if they are too large in total."""
    contents: dict[str, bytes | OSError] = {}
    left = MOST_BESIDE - sum(len(content) for content in files.values() if isinstance(content, bytes))
    for name in names:
        try:
            contents[name] = data = read_file(name)
        except OSError as error:
            contents[name] = OSError(error.errno, error.strerror) if error.errno else OSError(str(error))
            continue
        left -= len(data)
        if left < 0:
            message = f"the files that it names exceed {MOST_BESIDE >> 20} MiB in total"
            raise UnreadableLoadError([Diagnostic("SD006", Span(file, 1, 1, 1), message, "simplify the meshes")])
    return contents
