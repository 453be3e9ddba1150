"""Values of a scenario written in Python, each with the line of the program that wrote it."""

import linecache
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path as FilePath
from types import FrameType
from typing import Final

import yaml

from stackdsl.api.python_remedies import python_name
from stackdsl.diagnostics import Span
from stackdsl.language.yaml.source import KeyPath, Plain

HERE: Final = str(FilePath(__file__).parent)
WIDTH: Final = 120  # [characters] of a YAML line
CELL: Final = "In["  # begins the name of a cell, which is no file


class Part(StrEnum):
    """A part of a scenario, by the functions that return it."""

    LAYOUT = "layout"
    BRICK = "brick"
    IMPACT = "impact"
    CLAIM = "claim"


# The key of a list, and its parts.
HOLDS: Final = {
    "build": Part.LAYOUT,
    "bricks": Part.BRICK,
    "impacts": Part.IMPACT,
    "expect": Part.CLAIM,
    "truth": Part.CLAIM,
}
BELONGS: Final = {
    Part.LAYOUT: "a step of building belongs in `build`",
    Part.BRICK: "a brick belongs in a step, as in build=[bricks([brick(...)])]",
    Part.IMPACT: "an impact belongs in `impacts`",
    Part.CLAIM: "a claim belongs in `expect` or `truth`",
}


class Written(dict[str, "Plain"]):
    """A mapping with the place in the program where it was written."""

    def __init__(self, values: Mapping[str, Plain], span: Span, part: Part | None = None) -> None:
        super().__init__(values)
        self.span = span
        self.part = part


def written(values: Mapping[str, object], part: Part | None = None) -> Written:
    """Return the keys that are not None, at the place of the caller of this package.

    Raises TypeError for values that YAML does not have, and for parts in the wrong list.
    """
    for key, holds in HOLDS.items():
        listed = values.get(key)
        for number, item in enumerate(listed if isinstance(listed, Sequence) else ()):
            if isinstance(item, Written) and item.part not in (None, holds):
                raise TypeError(f"`{key}[{number}]` is in the wrong list; {BELONGS[item.part]}")
    kept = {key: plain(value, _keyed("", key, value)) for key, value in values.items() if value is not None}
    return Written(kept, callers_place(), part)


def plain(value: object, called: str) -> Plain:
    """Convert a value to types of YAML, and leave out keys that are None. `called` is its name for the error.

    Raises TypeError for other types.
    """
    if isinstance(value, Written | str | bool | int | float):
        return float(value) if type(value) not in (str, bool, int) and isinstance(value, float) else value
    if isinstance(value, Mapping):
        return {
            str(key): plain(part, _keyed(called, str(key), part)) for key, part in value.items() if part is not None
        }
    if isinstance(value, Sequence):
        return [plain(item, f"{called}[{number}]") for number, item in enumerate(value)]
    if callable(number := getattr(value, "item", None)):  # a numpy scalar or array
        return plain(getattr(value, "tolist", number)(), called)
    call = f"; call it: {getattr(value, '__name__', 'it')}(...)" if callable(value) else ""
    kind = type(value).__name__
    raise TypeError(f"`{called}` must be a string, number, list or mapping, not {kind}: {value!r}{call}")


def callers_place() -> Span:
    """Return the line of the innermost caller outside of this package."""
    frame: FrameType | None = sys._getframe()
    while frame is not None and str(FilePath(frame.f_code.co_filename).parent) == HERE:
        frame = frame.f_back
    if frame is None:
        return Span("<python>", 1, 1, 2)
    name, line = frame.f_code.co_filename, frame.f_lineno
    text = linecache.getline(name, line).rstrip()
    column = len(text) - len(text.lstrip()) + 1
    return Span(cell_of(name) or _relative(name), line, column, max(column + 1, len(text) + 1), text)


def cell_of(name: str) -> str:
    """Return the cell of a notebook that has the code of a file, such as `In[3]`; empty for other files."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    label = shell.compile.format_code_name(name) if shell is not None else None
    return label[1] if label is not None else ""


def _relative(name: str) -> str:
    """Return a file name relative to the working directory if it is below it; otherwise unchanged."""
    path = FilePath(name)
    return path.relative_to(FilePath.cwd()).as_posix() if path.is_relative_to(FilePath.cwd()) else name


def spans_of(value: Plain, path: KeyPath = (), within: Span | None = None) -> dict[KeyPath, Span]:
    """Return the place of every value by its path; `within` is the place of the enclosing value."""
    span = value.span if isinstance(value, Written) else within
    spans = {path: span} if span is not None else {}
    if isinstance(value, Written) and within is not None and path and isinstance(path[-1], str):
        spans[path] = replace(value.span, key=within.key)
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, member in members:
        own = None if span is None else replace(span, key=_keyed(span.key, key, member))
        spans |= spans_of(member, (*path, key), own)
    return spans


def _keyed(within: str, key: str | int, member: object) -> str:
    """Return the name of a value in Python: `column.step`, `build[0]`; the time of a step is `when`."""
    if isinstance(key, int):
        return f"{within}[{key}]"
    if within:
        return f"{within}.{python_name(key)}"
    is_time = key == "at" and isinstance(member, str | int | float)  # the place of a brick is a list
    return "when" if is_time else "name" if key == "scenario" else python_name(key)


def yaml_text(values: Plain) -> str:
    """Return values as YAML."""
    return yaml.safe_dump(copied(values), sort_keys=False, allow_unicode=True, width=WIDTH)


def copied(value: Plain) -> Plain:
    """Return a copy of plain mappings and lists."""
    if isinstance(value, dict):
        return {key: copied(member) for key, member in value.items()}
    return [copied(item) for item in value] if isinstance(value, list) else value
