"""Output and error stream: results go to the output, progress and remarks to the error stream.

A reader may close either at any time, which changes neither the work nor its exit code.
"""

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from itertools import count
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Final, Protocol, TextIO

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID


PAUSE = 0.1  # [s] least time between two updates of a bar, since drawing can take longer than a verdict
SIGN_OF_LIFE = 30.0  # [s] between two lines of a log on the number of finished cases
# Conclusions without a line in a log.
UNREMARKABLE = ("passed", "skipped", "unchecked", "xfailed", "recorded", "golden of another engine")
NO_TERMINAL = 160  # [characters] width of output that does not go to a terminal, unless COLUMNS is set


WIDTH: Final = re.compile(r"[1-9][0-9]{1,3}")  # of a terminal, as COLUMNS gives it [characters]


class DisplayedResult(Protocol):
    """The properties of a result that a progress display shows."""

    @property
    def name(self) -> str:
        """Return the name for people."""

    @property
    def conclusion(self) -> str:
        """Return the result in a few words."""


class Bar(Protocol):
    """A progress display."""

    def tell(self, result: DisplayedResult) -> None:
        """Show one more finished case."""

    def wait(self) -> None:
        """Refresh the display while nothing finishes."""

    def drawn(self, name: str, count: int, most: int) -> None:
        """Show the number of drawn samples of a case, out of the most."""


def occupy_standard_streams() -> None:
    """Open standard streams that were closed at the start as null devices.

    Otherwise a pipe or file that is opened later would get their number and their output, also of native libraries.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)  # gets the least free number, which is this one
            os.set_inheritable(nowhere, True)


# Marks and typographic characters of reports, for terminals and files that cannot show them.
ASCII_MARKS: Final = str.maketrans({"\u2713": "v", "\u2717": "X", "\u2260": "~", "\u2013": "-", "\u00b7": "-"})


def with_known_marks(text: str) -> str:
    """Replace marks that the encoding of the output stream does not have."""
    try:
        text.encode(getattr(sys.stdout, "encoding", None) or "utf-8")
    except (LookupError, UnicodeEncodeError):
        return text.translate(ASCII_MARKS)
    return text


def write(text: str) -> None:
    """Print text for people on the output stream; no line of it can be a workflow command of GitHub."""
    from stackdsl.shown_text import without_commands  # noqa: PLC0415 -- help does without

    _print(without_commands(text))


UNWRAPPED: Final = ("see it", "traceback")  # labels of a command, which is to be copied


def write_wrapped(text: str) -> None:
    """Print text for people, with lines wrapped to the width of the terminal below their last column."""
    from stackdsl.report.blocks import hanging  # noqa: PLC0415 -- help does without

    width, _ = paper()
    lines = text.removesuffix("\n").split("\n")
    wrapped = ([line] if line.strip().startswith(UNWRAPPED) else hanging(line, width) for line in lines)
    write("\n".join(part for parts in wrapped for part in parts) + "\n")


def write_data(text: str, form: str) -> None:
    """Print data for programs on the output stream, in a format such as `json`; escapes do not change its meaning."""
    from stackdsl.shown_text import data_without_commands  # noqa: PLC0415 -- as in `write`

    _print(data_without_commands(text, form))


def _print(text: str) -> None:
    """Print text; a closed output ends neither the work nor changes its exit code."""
    try:
        with _without_bars():
            click.echo(text, nl=not text.endswith("\n"))
    except BrokenPipeError:
        silence(sys.stdout)
    except OSError as error:
        silence(sys.stdout)
        raise click.ClickException(f"the standard output cannot be written: {error.strerror}") from error


def tell(text: str) -> None:
    """Print on the error stream, if it is open."""
    try:
        from stackdsl.shown_text import without_commands  # noqa: PLC0415 -- help does without

        with _without_bars():
            click.echo(without_commands(text), err=True)
    except OSError:
        silence(sys.stderr)


def silence(stream: TextIO) -> None:
    """Redirect a stream to the null device; closing it would fail, as would Python's flush at exit."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


_SHOWN: Final[list["Progress"]] = []  # the bars on the terminal


@contextmanager
def _without_bars() -> Iterator[None]:
    """Remove the bars from the terminal while other text is printed; a bar that is not removed would stay there."""
    for bar in _SHOWN:
        bar.stop()
    try:
        yield
    finally:
        for bar in _SHOWN:
            bar.start()


def _is_no_terminal(stream: TextIO | None) -> bool:
    """Return whether a stream is no terminal and the environment does not force rich to treat it as one."""
    return stream is None or not (stream.isatty() or {"FORCE_COLOR", "TTY_COMPATIBLE"} & os.environ.keys())


def paper() -> tuple[int, bool]:
    """Return the width of the output and whether it is in colour."""
    if _is_no_terminal(sys.stdout):
        columns = os.environ.get("COLUMNS", "")
        return int(columns) if WIDTH.fullmatch(columns) else NO_TERMINAL, False
    from rich.console import Console  # noqa: PLC0415 -- most calls do without, and it takes a while to load

    console = Console()
    return (console.width if console.is_terminal else NO_TERMINAL), console.is_terminal and "NO_COLOR" not in os.environ


@contextmanager
def progress(total: int, every_case: bool = False) -> Iterator[Bar]:
    """Show a bar on a terminal, and lines elsewhere or for every case, on the error stream."""
    if every_case or _is_no_terminal(sys.stderr):
        yield _Lines(total, every_case)
        return
    from rich.console import Console  # noqa: PLC0415 -- as in `paper`

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Lines(total, every_case)
        return
    with _drawn(console) as bar:
        yield _DrawnBar(bar, bar.add_task("playing", total=total))


@contextmanager
def staged(what: str) -> Iterator[Callable[[str], None]]:
    """Show the running computation of a job without a known end on a terminal, and nothing elsewhere."""
    with counted(None, what) as known:
        stages = count(1)
        yield lambda stage: known(next(stages), f"{what}: {stage}")


class Counter(Protocol):
    """Shows the number done, and what is done now if that changes."""

    def __call__(self, done: int, what: str = "") -> None:
        """Show the number done."""


@contextmanager
def counted(total: int | None, what: str) -> Iterator[Counter]:
    """Show a bar of the number done on a terminal, out of a total if known, and nothing elsewhere."""
    if _is_no_terminal(sys.stderr):
        yield lambda done, what="": None
        return
    from rich.console import Console  # noqa: PLC0415 -- as in `paper`

    with _drawn(Console(stderr=True)) as bar:
        task, drawn = bar.add_task(what, total=total), -inf

        def told(done: int, what: str = "") -> None:
            nonlocal drawn
            is_due = done == total or bool(what) or monotonic() - drawn > PAUSE
            drawn = monotonic() if is_due else drawn
            bar.update(task, completed=done, refresh=is_due, description=what or None)

        yield told


@contextmanager
def _drawn(console: "Console") -> Iterator["Progress"]:
    """Show a bar on a terminal."""
    from rich.progress import (  # noqa: PLC0415 -- most calls draw none
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    what = TextColumn("{task.description}", markup=False)
    columns = (what, BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    # No automatic refresh: it needs a thread, with which workers could not be forks of this process.
    with Progress(*columns, console=console, transient=True, auto_refresh=False) as bar:
        _SHOWN.append(bar)
        try:
            yield bar
        finally:
            _SHOWN.remove(bar)


class _DrawnBar:
    """A progress bar of rich."""

    def __init__(self, bar: "Progress", task: "TaskID") -> None:
        self._bar, self._task = bar, task
        self._samples: dict[str, TaskID] = {}

    def tell(self, result: DisplayedResult) -> None:
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
    """A progress display for logs: each case that does not pass, and the number of finished cases every half minute."""

    def __init__(self, total: int, every_case: bool) -> None:
        self._total, self._done, self._every_case = total, 0, every_case
        self._told = monotonic()

    def tell(self, result: DisplayedResult) -> None:
        self._done += 1
        if self._every_case or result.conclusion not in UNREMARKABLE:
            tell(f"[{self._done}/{self._total}] {result.name}: {result.conclusion}")
        elif monotonic() - self._told > SIGN_OF_LIFE:
            tell(f"[{self._done}/{self._total}]")
            self._told = monotonic()

    def wait(self) -> None:
        pass

    def drawn(self, name: str, count: int, most: int) -> None:
        pass


def show_error(error: click.ClickException) -> None:
    """Show an error of the call."""
    shown = StringIO()
    error.show(shown)
    tell(shown.getvalue().removesuffix("\n"))
