"""The two streams of a terminal: what is asked for goes to the output, how it goes to the error stream.

A reader may close either at any time; that ends the reading, and neither the work nor its exit code.
"""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Protocol, TextIO

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID


PAUSE = 0.1  # [s] between two looks of a bar: to draw one takes longer than many a verdict
NO_TERMINAL = 160  # [characters] how wide output is that goes elsewhere


class Told(Protocol):
    """What progress is told of."""

    @property
    def name(self) -> str:
        """What people call it."""

    @property
    def conclusion(self) -> str:
        """What came of it, in a few words."""


class Bar(Protocol):
    """What shows how far the work is."""

    def tell(self, result: Told) -> None:
        """One more is done."""

    def wait(self) -> None:
        """Nothing is done, yet time goes on."""

    def drawn(self, name: str, count: int, most: int) -> None:
        """So many samples of one are drawn, of so many at most."""


def occupy_standard_streams() -> None:
    """Let streams that were closed from the start lead nowhere: a pipe or file opened later would come in their place.

    What is said to them, by native libraries too, would end up there.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)  # the least number that is free, which is this one
            os.set_inheritable(nowhere, True)


def write(text: str) -> None:
    """Print on the output stream what people read. Whoever wrote it, no line of it is a workflow command of GitHub."""
    from stackdsl.shown_text import without_commands  # noqa: PLC0415 -- help does without

    _print(without_commands(text))


def write_data(text: str, form: str) -> None:
    """Print on the output stream what programs read, in a format such as `json`; they read the same from it."""
    from stackdsl.shown_text import data_without_commands  # noqa: PLC0415 -- as in `write`

    _print(data_without_commands(text, form))


def _print(text: str) -> None:
    """A reader who has seen enough ends the reading, not the work nor its exit code."""
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
        from stackdsl.shown_text import without_commands  # noqa: PLC0415 -- help does without

        click.echo(without_commands(text), err=True)
    except OSError:
        silence(sys.stderr)


def silence(stream: TextIO) -> None:
    """Let a stream lead nowhere; closing it would fail, and so would Python's own look at it in the end."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def _is_no_terminal(stream: TextIO | None) -> bool:
    """Whether a stream is none, and is not to be taken for one, which rich decides by the environment."""
    return stream is None or not (stream.isatty() or {"FORCE_COLOR", "TTY_COMPATIBLE"} & os.environ.keys())


def paper() -> tuple[int, bool]:
    """Width of the paper, and whether it takes colour."""
    if _is_no_terminal(sys.stdout):
        return NO_TERMINAL, False
    from rich.console import Console  # noqa: PLC0415 -- most calls do without, and it takes a while to load

    console = Console()
    return (console.width if console.is_terminal else NO_TERMINAL), console.is_terminal and "NO_COLOR" not in os.environ


@contextmanager
def progress(total: int) -> Iterator[Bar]:
    """A bar on a terminal, a line a case elsewhere; both on the error stream, so that output stays clean."""
    if _is_no_terminal(sys.stderr):
        yield _Lines(total)
        return
    from rich.console import Console  # noqa: PLC0415 -- as in `paper`

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(total)
        return
    with _drawn(console) as bar:
        yield _DrawnBar(bar, bar.add_task("playing", total=total))


@contextmanager
def counted(total: int | None, what: str) -> Iterator[Callable[[int], None]]:
    """A bar on a terminal that is told how many are done, of how many if that is known, and nothing elsewhere."""
    if _is_no_terminal(sys.stderr):
        yield lambda _: None
        return
    from rich.console import Console  # noqa: PLC0415 -- as in `paper`

    with _drawn(Console(stderr=True)) as bar:
        task, drawn = bar.add_task(what, total=total), -inf

        def told(done: int) -> None:
            nonlocal drawn
            is_due = done == total or monotonic() - drawn > PAUSE
            drawn = monotonic() if is_due else drawn
            bar.update(task, completed=done, refresh=is_due)

        yield told


def _drawn(console: "Console") -> "Progress":
    from rich.progress import (  # noqa: PLC0415 -- most calls draw none
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
    )

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    # It is refreshed by whoever waits: beside a thread for that, no worker could be a copy of this process.
    return Progress(*columns, console=console, transient=True, auto_refresh=False)


class _DrawnBar:
    """A bar that rich draws."""

    def __init__(self, bar: "Progress", task: "TaskID") -> None:
        self._bar, self._task = bar, task
        self._samples: dict[str, TaskID] = {}

    def tell(self, result: Told) -> None:
        if result.name in self._samples:
            self._bar.remove_task(self._samples.pop(result.name))
        self._bar.update(self._task, advance=1, description=result.name, refresh=True)

    def wait(self) -> None:
        self._bar.refresh()

    def drawn(self, name: str, count: int, most: int) -> None:
        if name not in self._samples:
            self._samples[name] = self._bar.add_task(f"{name}: samples", total=most)
        self._bar.update(self._samples[name], completed=count, refresh=True)


class _Lines:
    """A line for each that is done."""

    def __init__(self, total: int) -> None:
        self._total, self._done = total, 0

    def tell(self, result: Told) -> None:
        self._done += 1
        tell(f"[{self._done}/{self._total}] {result.name}: {result.conclusion}")

    def wait(self) -> None:
        pass

    def drawn(self, name: str, count: int, most: int) -> None:
        pass


def show_error(error: click.ClickException) -> None:
    """Show what was wrong with the call."""
    shown = StringIO()
    error.show(shown)
    tell(shown.getvalue().removesuffix("\n"))
