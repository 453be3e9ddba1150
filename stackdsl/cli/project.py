"""`stackdsl init`, `new` and `doctor`."""

import os
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path
from shlex import quote
from typing import Final

import click

from stability.engines.protocol import Package
from stackdsl.checking.cases import cases_of
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import VENDORED, FilePath, requirement
from stackdsl.cli.terminal import write
from stackdsl.disk import read_file
from stackdsl.exits import ExitCode
from stackdsl.language.json_schema import schema_text
from stackdsl.language.yaml.source import parse
from stackdsl.project_file import LINKED, SCENARIOS, ProjectError, confined, project_of
from stackdsl.shown_text import visible
from stackdsl.simulation.known_systems import KNOWN
from stackdsl.simulation.plugins import packages_text, usable_and_not
from stackdsl.user_files import make_user_folder, open_user_file

# `stackdsl new`: creates a first scenario.


SCHEMA: Final = "scenario.schema.json"  # file name of the JSON Schema in a project, and in an installed package


@click.command("new", cls=ExplainedCommand)
@click.argument("name")
@click.option(
    "--to", "folder", type=FilePath, default=Path(SCENARIOS), show_default=True, help="Directory of the new file."
)
def new_command(name: str, folder: Path) -> None:
    """Create a first scenario called NAME. An existing file is not changed."""
    path = folder / f"{name}.yaml"
    text = first_text(name, schema_seen_from(folder))
    for mistake in cases_of(parse(text, str(path)))[1]:
        raise click.UsageError(f"{mistake.message}; {mistake.hint}{_valid_call(Path(name), folder)}")
    make_folder(folder)
    write_new(path, text)
    write(f"wrote {path}; next: stackdsl check {quote(str(path))}")


def _valid_call(name: Path, folder: Path) -> str:
    """Return the call with a valid name like an invalid one, which may be a path; empty if there is none."""
    valid = re.sub(r"[^a-z0-9]+", "-", name.stem.lower()).strip("-")
    home = name.parent if len(name.parts) > 1 else folder
    to = "" if home == Path(SCENARIOS) else f" --to {quote(str(home))}"
    return f"; write `stackdsl new {valid}{to}`" if valid else ""


def first_text(name: str, schema: str) -> str:
    """Return the first scenario, with the path of the schema for editors unless that is empty."""
    template = files("stackdsl").joinpath("template.yaml").read_text(encoding="utf-8")
    first, _, rest = template.partition("\n")
    return (first.replace("SCHEMA", schema) + "\n" if schema else "") + rest.replace("NAME", name)


def schema_seen_from(folder: Path) -> str:
    """Return the path of the project's schema or of the packaged one, relative so that the project can move."""
    inside = os.path.realpath(folder)
    for home in (Path(inside), *Path(inside).parents):
        if os.path.isfile(own := home / SCHEMA):
            return Path(os.path.relpath(own, inside)).as_posix()
    packaged = Path(str(files("stackdsl").joinpath(SCHEMA))).resolve()
    is_within = packaged.is_relative_to(Path.cwd()) and packaged.is_file()
    return Path(os.path.relpath(packaged, inside)).as_posix() if is_within else ""


def make_folder(folder: Path) -> None:
    try:
        make_user_folder(folder)
    except FileExistsError as error:
        raise click.UsageError(f"{folder} is not a directory; choose another one") from error
    except OSError as error:
        raise click.UsageError(f"{folder} cannot be created: {error.strerror}") from error


def write_new(path: Path, text: str) -> None:
    try:
        with os.fdopen(open_user_file(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
            file.write(text.encode())
    except FileExistsError as error:
        raise click.UsageError(f"{path} already exists; choose another name") from error
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error


# `stackdsl init`: creates the files of a new project.


HOW_TO_VENDOR: Final = "build this wheel from the sources with `pip wheel --no-deps -w vendor PATH`"
FIRST: Final = "first-column"  # name of the first scenario
ROOT_FILE: Final = """\
# This file marks the root of a stackdsl project. All commands called below it use its golden files.
golden = "golden"
"""
WORKFLOW: Final = """\
# Plays every scenario and compares it with its golden file. A run in CI never writes golden files. With --strict, a
# scenario without expectations fails.
name: stackdsl
on: [push, pull_request]

permissions:
  contents: read

jobs:
  check:
    runs-on: ubuntu-latest
    timeout-minutes: 30
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with: {python-version: "3.11"}  # PyBullet has no wheels for newer ones
      - run: pip install {requirement}
      - run: stackdsl check scenarios --strict
"""
EDITOR: Final = """\
{
  "yaml.schemas": {
    "./scenario.schema.json": ["scenarios/**/*.yaml", "scenarios/**/*.yml"]
  }
}
"""


@click.command(
    "init",
    epilog="The files: stackdsl.toml, which marks the root of the project, a first scenario, the JSON Schema and a "
    "setting for editors, and a workflow for CI.",
)
@click.argument("directory", type=FilePath, default=Path())
def init_command(directory: Path) -> None:
    """Create the files of a new project in DIRECTORY (default: this one). Existing files are not changed."""
    told = []
    for path, text in _texts(directory).items():
        if os.path.lexists(path):  # also for a broken link, through which a write would create a file elsewhere
            told.append(f"kept   {path}, which already exists")
            continue
        make_folder(path.parent)
        write_new(path, text)
        told.append(f"wrote  {path}")
    write("\n".join(told))
    if requirement() == VENDORED:
        write(f"note: stackdsl is not on a package index, so the workflow installs {VENDORED}; {HOW_TO_VENDOR}")
    where = f"cd {directory}, then " if directory != Path() else ""
    write(f"next: {where}stackdsl check, which writes the first golden file; review it, and commit all files")


def _texts(directory: Path) -> Mapping[Path, str]:
    """Return the texts of a new project by path."""
    return {
        directory / "stackdsl.toml": ROOT_FILE,
        directory / "scenarios" / f"{FIRST}.yaml": first_text(FIRST, f"../{SCHEMA}"),
        directory / SCHEMA: schema_text(),
        directory / ".vscode" / "settings.json": EDITOR,
        directory / ".github" / "workflows" / "stackdsl.yml": WORKFLOW.replace("{requirement}", requirement()),
    }


# `stackdsl doctor`: lists installed and missing packages, and problems of the directory.


LIBRARIES: Final = ("stackdsl", "numpy", "scipy", "clarabel", "pydantic", "pyyaml", "click", "rich")
OPTIONAL: Final = {
    "pytest": "`pytest scenarios`; try: pip install pytest",
    "syrupy": "golden files in tests in Python; try: pip install 'stackdsl[pytest]'",
    "resvg_py": "pictures and plots as PNG; try: pip install 'stackdsl[picture]'",
    "distributed": "`stackdsl sweep --executor dask`; try: pip install 'stackdsl[dask]'",
    "pyarrow": "rows of `stackdsl sweep` as Parquet; try: pip install 'stackdsl[parquet]'",
}  # with the feature that needs each package


class State(StrEnum):
    """The state of a checked item."""

    OK = "ok"
    NOTE = "note"  # optional
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class DoctorFinding:
    """A checked item."""

    state: State
    text: str


@click.command("doctor", epilog="The exit code is 1 if an item is wrong, and 0 if there are only notes.")
@click.pass_context
def doctor_command(context: click.Context) -> None:
    """List installed and missing packages, how to install them, and problems of this directory."""
    findings = [*_libraries(), *_engines(), *_optional(), *_reading(), *_project()]
    write("\n".join(f"{each.state:5}  {visible(each.text)}" for each in findings))
    context.exit(ExitCode.FAILED if any(each.state is State.WRONG for each in findings) else ExitCode.OK)


def _libraries() -> Iterator[DoctorFinding]:
    yield DoctorFinding(State.OK, f"Python {sys.version.split()[0]} at {sys.executable}, {os.cpu_count() or 1} cores")
    for name in LIBRARIES:
        found = _version(name)
        missing = f"is not installed; try: pip install {name}"
        yield DoctorFinding(State.OK if found else State.WRONG, f"{name} {found or missing}")


def _engines() -> Iterator[DoctorFinding]:
    """Yield each engine with its systems, including those of other packages, and the plug-ins with an error."""
    plugins, errors = usable_and_not()
    yield from (DoctorFinding(State.WRONG, str(error)) for error in errors)
    systems: dict[tuple[str, Package], list[str]] = {}
    for system in (*KNOWN.values(), *plugins):
        package = system.engine.package
        text = f"{package.name} {_version(package.name)}" if system.name in KNOWN else packages_text(system.name)
        systems.setdefault((text, package), []).append(system.name)
    for (text, package), names in systems.items():
        if package.installed:
            yield DoctorFinding(State.OK, f"{text}: plays {', '.join(names)}")
            continue
        skipped = f"so these systems are skipped: {', '.join(names)}; try: {package.remedy}"
        yield DoctorFinding(State.NOTE, f"{package.name} is not installed, {skipped}")


def _optional() -> Iterator[DoctorFinding]:
    for name, purpose in OPTIONAL.items():
        found = _version(name)
        yield (
            DoctorFinding(State.OK, f"{name} {found}")
            if found
            else DoctorFinding(State.NOTE, f"{name} is not installed; it is needed for {purpose}")
        )


def _reading() -> Iterator[DoctorFinding]:
    import yaml  # noqa: PLC0415 -- so that the command runs without it

    quick = hasattr(yaml, "CSafeLoader")
    slow = "pyyaml has no libyaml and reads YAML ten times slower; try: pip install --force-reinstall pyyaml"
    yield DoctorFinding(State.OK, "YAML is read by libyaml") if quick else DoctorFinding(State.NOTE, slow)
    if os.environ.get("CI"):
        yield DoctorFinding(State.NOTE, "the variable CI is set: golden files are compared and never written")


def _project() -> Iterator[DoctorFinding]:
    """Yield findings on the project around the working directory, or on that directory."""
    try:
        project = project_of(())
    except ProjectError as error:
        yield DoctorFinding(State.WRONG, str(error))
        return
    scenarios, golden = project.scenarios, project.golden
    schema = (project.root or Path()) / SCHEMA
    if project.root is not None:
        yield DoctorFinding(State.OK, f"the root of the project is {project.root.resolve()}")
    if not os.path.isdir(scenarios):
        there = "scenarios here" if scenarios == Path("scenarios") else str(scenarios)
        yield DoctorFinding(State.NOTE, f"there is no directory {there}; create one with: stackdsl init")
        return
    try:
        confined(scenarios)
    except OSError as error:
        yield DoctorFinding(State.WRONG, f"{scenarios}: {error.strerror}; {LINKED}")
        return
    count = sum(name.lower().endswith((".yaml", ".yml")) for _, _, names in os.walk(scenarios) for name in names)
    yield DoctorFinding(State.OK, f"{count} files in {scenarios}")
    if os.path.isdir(golden) and not os.access(golden, os.W_OK):
        yield DoctorFinding(
            State.WRONG, f"{golden} is not writable, so --update cannot write golden files; change its permissions"
        )
    elif not os.path.isdir(golden):
        yield DoctorFinding(State.NOTE, "there are no golden files yet; write them with: stackdsl check")
    if os.path.lexists(schema):
        yield from _schema(schema)


def _schema(schema: Path) -> Iterator[DoctorFinding]:
    current = schema_text().encode()
    try:
        if read_file(schema, len(current) + 1, within=schema.parent) != current:
            anew = f"stackdsl schema > {quote(str(schema))}"
            yield DoctorFinding(State.NOTE, f"{schema} is from another version of stackdsl; update it with: {anew}")
    except OSError as error:
        yield DoctorFinding(State.WRONG, f"{schema}: {error.strerror}; remove it")


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""
