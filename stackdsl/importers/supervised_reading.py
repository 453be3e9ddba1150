"""Reads files of other programs in a supervised process, so that a parser that hangs or crashes costs that file alone.

MuJoCo, the parser of URDF and Qhull are given what anybody wrote, so they never run in the process that supervises.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Import
from stackdsl.supervising.executors import supervised
from stackdsl.supervising.worker import Task, TaskStatus, memory_limited

TIME_LIMIT: Final = 60.0  # [s] of wall time; a hundred times what the largest load takes that may be built
MEMORY_LIMIT: Final = 2 << 30  # [bytes] that reading may take; as much as a file of MAX_IMPORTED takes in JSON
MOST_BESIDE: Final = 64 << 20  # [bytes] of all files that one names


@dataclass(frozen=True, slots=True)
class _Unknown:
    """Files that the reading asked for, and that it was not given."""

    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Mistakes:
    """Why a file is not taken."""

    diagnostics: tuple[Diagnostic, ...]


def load_supervised(data: bytes, file: str, asked: Import, beside: Callable[[str], bytes]) -> ImportedLoad:
    """The load in the bytes of a file, as `read_load`, in a process of its own. Raises UnreadableLoadError."""
    known: dict[str, bytes | OSError] = {}
    while True:
        done = supervised(Task(_read, (data, file, asked, known), TIME_LIMIT))
        match done.value:
            case ImportedLoad():
                return done.value
            case _Mistakes(diagnostics):
                raise UnreadableLoadError(diagnostics)
            case _Unknown(names):
                known |= _files(names, beside, file, known)
            case _:
                broken = "takes too long" if done.status is TaskStatus.TIMED_OUT else "breaks its reader"
                message = f"the file {broken}: {done.message}"
                hint = "mend it or make it simpler, until the program that its format comes from loads it"
                raise UnreadableLoadError([Diagnostic("SD114", Span(file, 1, 1, 1), message, hint)])


def _read(
    data: bytes, file: str, asked: Import, known: Mapping[str, bytes | OSError]
) -> ImportedLoad | _Mistakes | _Unknown:
    """What the worker does: read with the files that are known, and say which others are asked for."""
    unknown: dict[str, None] = {}

    def beside(name: str) -> bytes:
        found = known.get(name)
        if found is None:
            unknown[name] = None
            raise OSError("it is not known yet")
        if isinstance(found, OSError):
            raise found
        return found

    with memory_limited(MEMORY_LIMIT):
        try:
            load = read_load(data, file, asked, beside)
        except UnreadableLoadError as error:
            return _Unknown(tuple(unknown)) if unknown else _Mistakes(error.diagnostics)
    return load


def _files(
    names: tuple[str, ...], beside: Callable[[str], bytes], file: str, known: Mapping[str, bytes | OSError]
) -> Mapping[str, bytes | OSError]:
    """What these files hold, or why that cannot be read. Raises UnreadableLoadError for too much of it."""
    found: dict[str, bytes | OSError] = {}
    left = MOST_BESIDE - sum(len(each) for each in known.values() if isinstance(each, bytes))
    for name in names:
        try:
            found[name] = data = beside(name)
        except OSError as error:
            found[name] = OSError(error.errno, error.strerror) if error.errno else OSError(str(error))
            continue
        left -= len(data)
        if left < 0:
            message = f"the files that it names are larger than {MOST_BESIDE >> 20} MiB"
            raise UnreadableLoadError([Diagnostic("SD006", Span(file, 1, 1, 1), message, "make the meshes simpler")])
    return found
