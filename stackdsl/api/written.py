"""What a caller writes in Python: the values that YAML would hold, and the line of the program that each came from."""

import linecache
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from types import FrameType
from typing import Final

from stackdsl.diagnostics import Span
from stackdsl.reading.source import Path, Plain

HERE: Final = str(FilePath(__file__).parent)


class Written(dict[str, "Plain"]):
    """A mapping that knows where it was written."""

    def __init__(self, values: Mapping[str, Plain], span: Span) -> None:
        super().__init__(values)
        self.span = span


def written(values: Mapping[str, object]) -> Written:
    """The keys that have a value, written where the caller of this package stands. Raises TypeError."""
    kept = {key: plain(value) for key, value in values.items() if value is not None}
    return Written(kept, callers_place())


def plain(value: object) -> Plain:
    """A value as YAML knows it; keys of mappings without a value are left out. Raises TypeError."""
    if isinstance(value, Written | str | bool | int | float):
        return float(value) if type(value) not in (str, bool, int) and isinstance(value, float) else value
    if isinstance(value, Mapping):
        return {str(key): plain(member) for key, member in value.items() if member is not None}
    if isinstance(value, Sequence):
        return [plain(item) for item in value]
    if callable(number := getattr(value, "item", None)):  # a number, or a whole array, of numpy
        return plain(getattr(value, "tolist", number)())
    raise TypeError(f"a scenario holds texts, numbers, lists and mappings, not {type(value).__name__}: {value!r}")


def callers_place() -> Span:
    """The line outside of this package that is being carried out."""
    frame: FrameType | None = sys._getframe()
    while frame is not None and str(FilePath(frame.f_code.co_filename).parent) == HERE:
        frame = frame.f_back
    if frame is None:
        return Span("<python>", 1, 1, 2)
    name, line = frame.f_code.co_filename, frame.f_lineno
    text = linecache.getline(name, line).rstrip()
    column = len(text) - len(text.lstrip()) + 1
    return Span(_relative(name), line, column, max(column + 1, len(text) + 1), text)


def _relative(name: str) -> str:
    """A file as it is called from where the program runs, if it is below that."""
    path = FilePath(name)
    return path.relative_to(FilePath.cwd()).as_posix() if path.is_relative_to(FilePath.cwd()) else name


def spans_of(value: Plain, path: Path = ()) -> dict[Path, Span]:
    """By path, the place of every mapping that was written in Python."""
    found = {path: value.span} if isinstance(value, Written) else {}
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, member in members:
        found |= spans_of(member, (*path, key))
    return found


def copied(value: Plain) -> Plain:
    """The same in plain mappings and lists."""
    if isinstance(value, dict):
        return {key: copied(member) for key, member in value.items()}
    return [copied(item) for item in value] if isinstance(value, list) else value
