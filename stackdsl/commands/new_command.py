"""`stackdsl new`: writes a scenario to start from."""

import os
from importlib.resources import files
from pathlib import Path

import click

from stackdsl.checking.gathering import cases_of
from stackdsl.commands.options import FilePath
from stackdsl.commands.terminal import write
from stackdsl.reading.source import parse


@click.command("new")
@click.argument("name")
@click.option("--to", "folder", type=FilePath, default=Path("scenarios"), show_default=True, help="Where to write it.")
def new_command(name: str, folder: Path) -> None:
    """Write a scenario called NAME to start from; never over an existing file."""
    path = folder / f"{name}.yaml"
    template = files("stackdsl").joinpath("template.yaml").read_text(encoding="utf-8")
    text = template.replace("NAME", name).replace("SCHEMA", _schema_seen_from(folder))
    for mistake in cases_of(parse(text, str(path)))[1]:
        raise click.UsageError(f"{mistake.message}; {mistake.hint}")
    _make(folder)
    _write_new(path, text)
    write(f"wrote {path}; next: stackdsl check {path}")


def _schema_seen_from(folder: Path) -> str:
    """The path of the packaged schema: relative if it is a part of the project at hand, which may be kept anywhere."""
    schema = Path(str(files("stackdsl").joinpath("scenario.schema.json"))).resolve()
    if not schema.is_relative_to(Path.cwd()):
        return schema.as_posix()
    return Path(os.path.relpath(schema, folder)).as_posix()


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise click.UsageError(f"{folder} is no directory; write to another one") from error
    except OSError as error:
        raise click.UsageError(f"{folder} cannot be made: {error.strerror}") from error


def _write_new(path: Path, text: str) -> None:
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise click.UsageError(f"{path} exists already; choose another name") from error
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error
