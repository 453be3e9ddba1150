"""Compares test tools by running them on the needs of a team: the tables of docs/compared.md.

Each other tool is searched on the path, or in the folder of programs that `--with pytest=DIRECTORY` names. Missing
tools are listed and keep their present cells; a cell that a run contradicts is removed.

Run: python -m benchmarks.compared [--with TOOL=DIRECTORY ...] [--only TOOL] [-k WORDS] [--write]
"""

import argparse
import re
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from rich.console import Console
from rich.progress import track

from benchmarks.compared.asking import PROJECT, complaints, environment, in_shell
from benchmarks.compared.probes import DOCUMENTED, NOT_TRIED, OWN, Probe, Tool, needs, tools
from benchmarks.figures.data import Row, Rows, file_of, load
from benchmarks.figures.recording import parser, record

NAME: Final = "compared"
COMMAND: Final = "python -m benchmarks.compared --write"
Cells = Mapping[str, str]  # by need


def main() -> int:
    """Run all available tools, print each result that contradicts its cell, and store the cells on request."""
    arguments = _arguments()
    console = Console(stderr=True)
    found: dict[str, Cells] = {}
    about: dict[str, Row] = {}
    wrong = 0
    for tool in tools():
        if arguments.only and tool.name not in arguments.only:
            continue
        programs = arguments.programs.get(tool.name)
        if tool.finds and not at_hand(tool, programs):
            console.print(f"skipped: {tool.name} is not at hand, there is no program `{tool.finds}`")
            continue
        probes = [each for each in tool.probes.values() if arguments.words in each.need]
        cells: dict[str, str] = {}
        for probe in track(probes, tool.name, console=console, transient=True):
            said = list(_asked(tool, probe, programs))
            sys.stdout.writelines(f"{each}\n" for each in said)
            sys.stdout.flush()
            cells[probe.need] = NOT_TRIED if said else shown(probe)
            wrong += 1 if said else 0
        found[tool.name] = cells
        about[tool.name] = _about(tool, version_of(tool, programs))
    console.print(f"{sum(map(len, found.values())) - wrong} cells are as they say, {wrong} are not")
    if arguments.write:
        record(NAME, COMMAND, tables(found, about, before=_before()))
    return min(wrong, 1)


def _arguments() -> argparse.Namespace:
    asked = parser(__doc__)
    asked.add_argument("--with", dest="programs", action="append", default=[], metavar="TOOL=DIRECTORY")
    asked.add_argument("--only", action="append", default=[], metavar="TOOL")
    asked.add_argument("-k", dest="words", default="", metavar="WORDS")
    arguments = asked.parse_args()
    named = (each.partition("=") for each in arguments.programs)
    arguments.programs = {name: Path(folder).absolute() for name, _, folder in named}
    return arguments


def at_hand(tool: Tool, programs: Path | None) -> bool:
    """Return whether the program of a tool is available."""
    return tool.name == OWN or shutil.which(tool.finds, path=_values(programs)["PATH"]) is not None


def _values(programs: Path | None) -> Mapping[str, str]:
    own = Path(sys.executable).parent
    return environment(programs or own, own)


def _asked(tool: Tool, probe: Probe, programs: Path | None) -> Iterator[str]:
    if probe.documented:
        return
    values = dict(_values(programs))
    if tool.name == OWN:
        values["PYTHONPATH"] = str(PROJECT)
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        if programs and programs.parent.name == "node_modules":
            (Path(folder) / "node_modules").symlink_to(programs.parent)
        yield from complaints(tool, probe, Path(folder), lambda where, command: in_shell(where, command, values))


def version_of(tool: Tool, programs: Path | None) -> str:
    """Return the version that a tool prints; for a tool that is not run, the version of its documentation."""
    if not tool.finds:
        return tool.version
    values = dict(_values(programs)) | ({"PYTHONPATH": str(PROJECT)} if tool.name == OWN else {})
    with TemporaryDirectory() as folder:
        said = in_shell(Path(folder), tool.version, values).text
    numbers = re.findall(r"\d+\.\d+[\d.]*", said)
    return ", ".join(numbers[: tool.version.count(";") + 1])


def _about(tool: Tool, version: str) -> Row:
    probes = tool.probes.values()
    asked = [need for group in needs().values() for need in group]
    return {
        "version": version,
        "run": sum(not each.documented for each in probes),
        "documented": sum(bool(each.documented) for each in probes),
        "not_tried": len(asked) - len(probes),
    }


def shown(probe: Probe) -> str:
    """Return the cell as displayed in the table."""
    return probe.cell.replace("|", "\\|") + (DOCUMENTED if probe.documented else "")


def _before() -> Mapping[str, Rows]:
    return load(NAME).tables if file_of(NAME).exists() else {}


def tables(found: Mapping[str, Cells], about: Rows, before: Mapping[str, Rows]) -> dict[str, Rows]:
    """Return one table per group of needs, and one of the tools; cells of tools that did not run are kept."""
    names = [tool.name for tool in tools()]

    def cell(group: str, need: str, name: str) -> str:
        if need in found.get(name, {}):
            return found[name][need]
        return str(before.get(group, {}).get(need, {}).get(name, NOT_TRIED))

    def rows(group: str, asked: Sequence[str]) -> Rows:
        return {need: {name: cell(group, need, name) for name in names} for need in asked}

    kept = {name: about.get(name, before.get("tools", {}).get(name, {})) for name in names}
    return {"tools": kept, **{group: rows(group, asked) for group, asked in needs().items()}}


if __name__ == "__main__":
    sys.exit(main())
