"""The two streams of a terminal: what is asked for goes to the output, how it goes to the error stream.

A reader may close either at any time; that ends the reading, and neither the work nor its exit code.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn


class Told(Protocol):
    """What progress is told of."""

    @property
    def name(self) -> str:
        """What people call it."""

    @property
    def conclusion(self) -> str:
        """What came of it, in a few words."""


OnTold = Callable[[Told], None]


def write(text: str) -> None:
    """Print on the output stream; a reader who has seen enough ends the reading, not the work nor its exit code."""
    try:
        click.echo(text, nl=not text.endswith("\n"))
    except BrokenPipeError:
        silence(sys.stdout)
    except OSError as error:
        silence(sys.stdout)
        raise click.ClickException(f"the output cannot be written: {error.strerror}") from error


def tell(text: str) -> None:
    """Print on the error stream, as long as that takes anything."""
    try:
        click.echo(text, err=True)
    except OSError:
        silence(sys.stderr)


def silence(stream: TextIO) -> None:
    """Let a stream lead nowhere; closing it would fail, and so would Python's own look at it in the end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def paper() -> tuple[int, bool]:
    """Width of the paper, and whether it takes colour."""
    console = Console()
    return (console.width if console.is_terminal else 160), console.is_terminal and "NO_COLOR" not in os.environ


@contextmanager
def progress(total: int) -> Iterator[OnTold]:
    """A bar on a terminal, a line a case elsewhere; both on the error stream, so that output stays clean."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _line_by_line(total)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("playing", total=total)
        yield lambda result: bar.update(task, advance=1, description=result.name)


def _line_by_line(total: int) -> OnTold:
    done = 0

    def one_more(result: Told) -> None:
        nonlocal done
        done += 1
        tell(f"[{done}/{total}] {result.name}: {result.conclusion}")

    return one_more


def show_error(error: click.ClickException) -> None:
    """Show what was wrong with the call."""
    try:
        error.show()
    except OSError:
        silence(sys.stderr)
