"""The probes of each tool: commands, and the expected output that supports a cell of the table, in the files nearby.

A cell that begins with `no` or `part` describes a missing or partial answer to the need; any other names the feature. A
cell is shown if its commands gave the expected output or, with a mark, if it is `documented` and the tool was not run.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import yaml

FOLDER: Final = Path(__file__).parent
OWN: Final = "StackDSL"
NOT_TRIED: Final = "not tried"
DOCUMENTED: Final = " †"  # marks a cell that only the documentation supports


@dataclass(frozen=True, slots=True)
class Probe:
    """One need, for one tool."""

    need: str
    cell: str  # as displayed
    run: Sequence[str] = ()  # shell commands in order; the last one is checked
    code: int | None = 0  # exit code of the last one; any if None
    shows: Sequence[str] = ()  # expected parts of its output
    hides: Sequence[str] = ()  # parts that its output must not contain
    files: Mapping[str, str] = field(default_factory=dict)  # by path, in addition to those of the tool
    documented: str = ""  # place in its documentation; then nothing is run


@dataclass(frozen=True, slots=True)
class Tool:
    """Tool with its probes by need."""

    name: str
    finds: str  # program that the tool needs; empty if none
    version: str  # command that prints it, or the documented version of a tool that was not run
    files: Mapping[str, str]  # shared by all its probes
    probes: Mapping[str, Probe]


def needs(folder: Path = FOLDER) -> Mapping[str, Sequence[str]]:
    """Return the needs, by the table of the page."""
    read: Mapping[str, Sequence[str]] = yaml.safe_load((folder / "needs.yaml").read_text(encoding="utf-8"))
    return read


def tools(folder: Path = FOLDER) -> Iterator[Tool]:
    """Yield this project first, then the other tools by name."""
    read = [read_tool(path) for path in sorted(folder.glob("*.yaml")) if path.name != "needs.yaml"]
    return iter(sorted(read, key=lambda tool: (tool.name != OWN, tool.name.casefold())))


def read_tool(path: Path) -> Tool:
    """Read one file. Raises ValueError for an unknown need, or for a cell without a check."""
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
