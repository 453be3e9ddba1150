"""`stackdsl new`: writes a scenario to start from."""

import os
from importlib.resources import files
from pathlib import Path
from shlex import quote
from typing import Final

import click

from stackdsl.asked_files import make_asked, open_asked
from stackdsl.checking.gathering import cases_of
from stackdsl.commands.options import FilePath
from stackdsl.commands.terminal import write
from stackdsl.reading.source import parse

SCHEMA: Final = "scenario.schema.json"  # what the JSON Schema is called in a project and in the package


@click.command("new")
@click.argument("name")
@click.option("--to", "folder", type=FilePath, default=Path("scenarios"), show_default=True, help="Where to write it.")
def new_command(name: str, folder: Path) -> None:
    """Write a scenario called NAME to start from; never over an existing file."""
    path = folder / f"{name}.yaml"
    text = first_text(name, schema_seen_from(folder))
    for mistake in cases_of(parse(text, str(path)))[1]:
        raise click.UsageError(f"{mistake.message}; {mistake.hint}")
    make_folder(folder)
    write_new(path, text)
    write(f"wrote {path}; next: stackdsl check {quote(str(path))}")


def first_text(name: str, schema: str) -> str:
    """The scenario to start from, with the path of the schema for editors, or without if that is empty."""
    template = files("stackdsl").joinpath("template.yaml").read_text(encoding="utf-8")
    first, _, rest = template.partition("\n")
    return (first.replace("SCHEMA", schema) + "\n" if schema else "") + rest.replace("NAME", name)


def schema_seen_from(folder: Path) -> str:
    """The relative path of the schema: the project's own, or the packaged one within it; a project may move."""
    inside = os.path.realpath(folder)
    for home in (Path(inside), *Path(inside).parents):
        if os.path.isfile(own := home / SCHEMA):
            return Path(os.path.relpath(own, inside)).as_posix()
    packaged = Path(str(files("stackdsl").joinpath(SCHEMA))).resolve()
    return Path(os.path.relpath(packaged, inside)).as_posix() if packaged.is_relative_to(Path.cwd()) else ""


def make_folder(folder: Path) -> None:
    try:
        make_asked(folder)
    except FileExistsError as error:
        raise click.UsageError(f"{folder} is no directory; write to another one") from error
    except OSError as error:
        raise click.UsageError(f"{folder} cannot be made: {error.strerror}") from error


def write_new(path: Path, text: str) -> None:
    try:
        with os.fdopen(open_asked(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
            file.write(text.encode())
    except FileExistsError as error:
        raise click.UsageError(f"{path} exists already; choose another name") from error
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error
