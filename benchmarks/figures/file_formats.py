"""The tables of file formats, from the registries of readers, reports and options. <!-- files: read --> inserts one."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

import click

from stackdsl.checking.cases import SUFFIXES
from stackdsl.cli.main import app
from stackdsl.cli.options import REPORT_FORMATS, FilePath, OutputChoice
from stackdsl.language.imports import LOAD_FORMATS
from stackdsl.project_file import OWN_FILE, SHARED_FILE

FILES = re.compile(r"(<!-- files: (?P<kind>[a-z]+) -->\n)(?:\|[^\n]*\n)*(<!-- end -->)")
ENDING: Final = re.compile(r"\.[a-z0-9]+\b")

# A format without a sentence here, and a sentence without a format, are errors.
LOADS: Final = {
    "table": "cartons as a CSV or JSON table, one row per box",
    "pallet-sim": "orders of the package `pallet-sim`, as JSON",
    "bed-bpp": "packing plans of BED-BPP, as JSON",
    "compas": "assemblies of COMPAS 2, as JSON",
    "obj": "Wavefront OBJ, a brick per object",
    "stl": "STL, as text or binary, a brick per closed surface",
    "ply": "PLY, as text or binary, a brick per closed surface",
    "mjcf": "scenes of MuJoCo, as XML",
    "urdf": "scenes of robots, as XML",
    "stablelego": "structures of LEGO bricks of StableLego, as JSON",
    "apex-mr": "tasks of APEX-MR, as JSON",
    "brickgpt": "structures of LEGO bricks of BrickGPT, as lines",
    "ldraw": "LDraw models of LEGO bricks, `.ldr` and `.mpd`",
}
REPORTS: Final = {
    "text": "what the terminal shows",
    "json": "all results; `stackdsl schema --report` prints its JSON Schema",
    "junit": "JUnit XML for CI servers",
    "github": "annotations of GitHub Actions",
    "markdown": "Markdown for `$GITHUB_STEP_SUMMARY`",
    "csv": "one row per case, see [columns](columns.md#csv)",
}
READ_ONLY: Final = frozenset({"--to", "--golden"})  # options whose files or folders are not outputs


def with_files(text: str) -> str:
    """Return a text with the current tables of file formats that it names."""
    return FILES.sub(lambda found: f"{found[1]}{TABLES[found['kind']]()}{found[3]}", text)


def commands() -> Iterator[tuple[str, click.Parameter]]:
    """Yield each parameter of each command, with the name of the command."""
    context = click.Context(app)
    for name in app.list_commands(context):
        command = app.get_command(context, name)
        assert command is not None
        yield from ((name, parameter) for parameter in command.params)


def read_table() -> str:
    """Return the files that are read."""
    assert LOADS.keys() == set(LOAD_FORMATS)
    loads = [(f"`{name}`", LOADS[name], "[`import`](loads.md#formats)") for name in LOAD_FORMATS]
    scenario = (" ".join(f"`{each}`" for each in SUFFIXES), "scenarios", "[all commands](language.md)")
    project = (f"`{OWN_FILE}`, `{SHARED_FILE}`", "settings of a project", "[`check`](command.md#the-project)")
    golden = ("`golden/*/*.json`", "accepted results", "[`check`, `golden`](command.md#golden)")
    return _table(("file or format", "content", "read by"), [scenario, project, golden, *loads])


def report_table() -> str:
    """Return the formats of reports, with the commands that write each."""
    assert REPORTS.keys() == REPORT_FORMATS.keys()
    offered = {name: [*_offering(name)] for name in REPORTS}
    rows = [(f"`{name}`", told, " ".join(f"`{each}`" for each in offered[name])) for name, told in REPORTS.items()]
    return _table(("`--format`", "content", "commands"), rows)


def _offering(form: str) -> Iterator[str]:
    for command, parameter in commands():
        offers = parameter.type.choices if isinstance(parameter.type, click.Choice) else ()
        if isinstance(parameter.type, OutputChoice) or ("--format" in parameter.opts and form in offers):
            yield command


def written_table() -> str:
    """Return the options that write files, with the endings of these files."""
    rows = []
    for name, option in commands():
        if not isinstance(option, click.Option) or option.type is not FilePath or READ_ONLY.intersection(option.opts):
            continue
        told = option.help or ""
        endings = " ".join(f"`{each}`" for each in dict.fromkeys(ENDING.findall(told))) or "a folder"
        rows.append((endings, f"[`{name} {max(option.opts, key=len)}`](command.md#{name})", told))
    return _table(("file", "option", "what it does"), rows)


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return (
        "".join("| " + " | ".join(line) + " |\n" for line in lines).replace("| --- ", "|---").replace("--- |", "---|")
    )


TABLES: Final[Mapping[str, Callable[[], str]]] = {"read": read_table, "reports": report_table, "written": written_table}
