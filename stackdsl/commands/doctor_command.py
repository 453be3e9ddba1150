"""`stackdsl doctor`: tells what is installed and in order, and what to do about the rest."""

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path
from shlex import quote
from typing import Final

import click

from stackdsl.commands.new_command import SCHEMA
from stackdsl.commands.terminal import write
from stackdsl.disk import read_file
from stackdsl.exits import ExitCode
from stackdsl.project_file import LINKED, ProjectError, confined, project_of
from stackdsl.shown_text import visible
from stackdsl.systems.known_systems import KNOWN, needs_of

LIBRARIES: Final = ("stackdsl", "numpy", "scipy", "clarabel", "pydantic", "pyyaml", "click", "rich")
OPTIONAL: Final = {
    "pytest": "`pytest scenarios`; try: pip install pytest",
    "syrupy": "golden files in tests in Python; try: pip install 'stackdsl[pytest]'",
    "matplotlib": "the plot of `stackdsl bench`; try: pip install 'stackdsl[bench]'",
    "distributed": "`stackdsl sweep --executor dask`; try: pip install 'stackdsl[dask]'",
    "pyarrow": "rows of `stackdsl sweep` as Parquet; try: pip install 'stackdsl[parquet]'",
}  # and what each is for


class State(StrEnum):
    """How it stands with one thing."""

    OK = "ok"
    NOTE = "note"  # works without
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was looked at."""

    state: State
    text: str


@click.command("doctor", epilog="The exit code is 1 if anything is wrong, and 0 if there are but notes.")
@click.pass_context
def doctor_command(context: click.Context) -> None:
    """Tell what is installed, what is missing and how to get it, and whether this directory is in order."""
    findings = [*_libraries(), *_engines(), *_optional(), *_reading(), *_project()]
    write("\n".join(f"{each.state:5}  {visible(each.text)}" for each in findings))
    context.exit(ExitCode.FAILED if any(each.state is State.WRONG for each in findings) else ExitCode.OK)


def _libraries() -> Iterator[Finding]:
    yield Finding(State.OK, f"Python {sys.version.split()[0]} at {sys.executable}, {os.cpu_count() or 1} cores")
    for name in LIBRARIES:
        found = _version(name)
        missing = f"is not installed; try: pip install {name}"
        yield Finding(State.OK if found else State.WRONG, f"{name} {found or missing}")


def _engines() -> Iterator[Finding]:
    """Each engine once, with the systems that it plays."""
    needs = needs_of(KNOWN)
    for package in dict.fromkeys(package for _, package in needs):
        systems = ", ".join(name for name, needed in needs if needed == package)
        if package.installed:
            yield Finding(State.OK, f"{package.name} {_version(package.name)}: plays {systems}")
            continue
        yield Finding(
            State.NOTE, f"{package.name} is not installed, so these are skipped: {systems}; try: {package.remedy}"
        )


def _optional() -> Iterator[Finding]:
    for name, purpose in OPTIONAL.items():
        found = _version(name)
        yield Finding(State.OK, f"{name} {found}") if found else Finding(State.NOTE, f"{name} is missing for {purpose}")


def _reading() -> Iterator[Finding]:
    import yaml  # noqa: PLC0415 -- so that its absence can be told

    quick = hasattr(yaml, "CSafeLoader")
    slow = "YAML is read by pyyaml without libyaml, ten times as slowly; try: pip install --force-reinstall pyyaml"
    yield Finding(State.OK, "YAML is read by libyaml") if quick else Finding(State.NOTE, slow)
    if os.environ.get("CI"):
        yield Finding(State.NOTE, "the variable CI is set: golden files are compared and never written")


def _project() -> Iterator[Finding]:
    """Of the project around the directory that this was called from, or else of that directory."""
    try:
        project = project_of(())
    except ProjectError as error:
        yield Finding(State.WRONG, str(error))
        return
    scenarios, golden = project.scenarios, project.golden
    schema = (project.root or Path()) / SCHEMA
    if project.root is not None:
        yield Finding(State.OK, f"the root of the project is {project.root.resolve()}")
    if not os.path.isdir(scenarios):
        there = "scenarios here" if scenarios == Path("scenarios") else str(scenarios)
        yield Finding(State.NOTE, f"there is no directory {there}; begin one by: stackdsl init")
        return
    try:
        confined(scenarios)
    except OSError as error:
        yield Finding(State.WRONG, f"{scenarios}: {error.strerror}; {LINKED}")
        return
    count = sum(name.lower().endswith((".yaml", ".yml")) for _, _, names in os.walk(scenarios) for name in names)
    yield Finding(State.OK, f"{count} files in {scenarios}")
    if os.path.isdir(golden) and not os.access(golden, os.W_OK):
        yield Finding(State.WRONG, f"{golden} cannot be written, so --update cannot accept anything; let it be written")
    elif not os.path.isdir(golden):
        yield Finding(State.NOTE, "there are no golden files yet; write them by: stackdsl check")
    if os.path.lexists(schema):
        yield from _schema(schema)


def _schema(schema: Path) -> Iterator[Finding]:
    current = files("stackdsl").joinpath(SCHEMA).read_bytes()
    try:
        if read_file(schema, len(current) + 1, within=schema.parent) != current:
            anew = f"stackdsl schema > {quote(str(schema))}"
            yield Finding(State.NOTE, f"{schema} is of another version; write it anew by: {anew}")
    except OSError as error:
        yield Finding(State.WRONG, f"{schema}: {error.strerror}; remove it")


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""
