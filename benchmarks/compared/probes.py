"""Which tool is asked what, and what must be seen for its cell of the table to be right: the files beside this one.

A cell that begins with `no` or `part` says so of the need; any other tells by what the tool answers it. A cell is shown
if its commands came out as they say, or, marked, if it is `documented` and the tool could not be run for it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import yaml

FOLDER: Final = Path(__file__).parent
OWN: Final = "StackDSL"
NOT_TRIED: Final = "not tried"
DOCUMENTED: Final = " †"  # behind what only the documentation says


@dataclass(frozen=True, slots=True)
class Probe:
    """One need, of one tool."""

    need: str
    cell: str  # as shown
    run: Sequence[str] = ()  # commands of a shell, one after the other; the last one is looked at
    code: int | None = 0  # of the last one; any if None
    shows: Sequence[str] = ()  # parts of what it prints
    hides: Sequence[str] = ()  # what it must not print
    files: Mapping[str, str] = field(default_factory=dict)  # by path, beside those of the tool
    documented: str = ""  # where its documentation says so; nothing is run then


@dataclass(frozen=True, slots=True)
class Tool:
    """One tool, and its answers by need."""

    name: str
    finds: str  # program without which it is not at hand; none if empty
    version: str  # command that prints it, or what was read where it could not be run
    files: Mapping[str, str]  # that all its probes find
    probes: Mapping[str, Probe]


def needs(folder: Path = FOLDER) -> Mapping[str, Sequence[str]]:
    """What is asked, by the table of the page."""
    read: Mapping[str, Sequence[str]] = yaml.safe_load((folder / "needs.yaml").read_text(encoding="utf-8"))
    return read


def tools(folder: Path = FOLDER) -> Iterator[Tool]:
    """Ours first, then the others by name."""
    read = [read_tool(path) for path in sorted(folder.glob("*.yaml")) if path.name != "needs.yaml"]
    return iter(sorted(read, key=lambda tool: (tool.name != OWN, tool.name.casefold())))


def read_tool(path: Path) -> Tool:
    """One file; a ValueError names a need that is none, or a cell that nothing would check."""
    said: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    known = {need for group in needs(path.parent).values() for need in group}
    if strange := set(said["rows"]) - known:
        raise ValueError(f"{path.name}: not in needs.yaml: {', '.join(sorted(strange))}")
    probes = {need: _probe(path, need, row) for need, row in said["rows"].items()}
    return Tool(said["tool"], said.get("finds", ""), said["version"], said.get("files", {}), probes)


def _probe(path: Path, need: str, row: Mapping[str, Any]) -> Probe:
    run = row.get("run", ())
    commands = (run,) if isinstance(run, str) else tuple(run)
    code = row.get("code", 0)
    rest = {key: value for key, value in row.items() if key not in ("run", "code")}
    probe = Probe(need, run=commands, code=None if code == "any" else code, **rest)
    if not (probe.documented or (probe.run and (probe.shows or probe.hides or code))):
        raise ValueError(f"{path.name}: {need}: nothing checks what its cell says")
    return probe
