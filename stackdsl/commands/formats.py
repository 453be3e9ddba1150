"""How a report may be written, and where to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Final, TypeAlias

import click

from stackdsl.asked_files import make_asked, write_asked
from stackdsl.commands.terminal import paper, write, write_data
from stackdsl.outcome import Report
from stackdsl.shown_text import harmless


@dataclass(frozen=True, slots=True)
class Style:
    """What of a report is wanted as text."""

    verbosity: int = 0  # -1: only what failed; 1: also what passed
    durations: int = 0  # how many of the slowest cases


Renderer: TypeAlias = Callable[[Report, Style], str]


def _text(report: Report, style: Style) -> str:
    from stackdsl.report.text import report_text  # noqa: PLC0415 -- only the one that is asked for

    return report_text(report, *paper(), verbosity=style.verbosity, durations=style.durations)


def _of(name: str) -> Renderer:
    def render(report: Report, _: Style) -> str:
        module = import_module(f"stackdsl.report.{name}")
        text: str = getattr(module, f"report_{name}")(report)
        return harmless(text)

    return render


# As docs/command.md lists them; each but text is `report_<name>` of the module of that name.
FORMATS: Final[Mapping[str, Renderer]] = {
    "text": _text,
    **{name: _of(name) for name in ("json", "junit", "github", "markdown", "csv")},
}


@dataclass(frozen=True, slots=True)
class Output:
    """One way to write the report."""

    form: str
    file: Path | None = None  # None for the output stream

    def __str__(self) -> str:
        return self.form if self.file is None else f"{self.form}={self.file}"


class OutputChoice(click.ParamType[Output]):
    """The name of a format, or the name, `=` and a file."""

    name = "format"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Output:
        """The output."""
        if isinstance(value, Output):
            return value
        form, named, file = str(value).partition("=")
        if form not in FORMATS:
            listed = ", ".join(f"'{known}'" for known in FORMATS)
            self.fail(f"'{form}' is not one of {listed}", param, ctx)
        if named and not file:
            self.fail(f"'{value}' names no file; write {form} or {form}=FILE", param, ctx)
        return Output(form, Path(file) if named else None)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """As it is shown in the help."""
        return f"[{'|'.join(FORMATS)}][=FILE]"


def outputs_of(asked: Sequence[Output]) -> Sequence[Output]:
    """What is to be written: text goes to the output stream unless something else does. Raises click.UsageError."""
    streamed = [output for output in asked if output.file is None]
    if len(streamed) > 1:
        raise click.UsageError(
            f"{' and '.join(map(str, streamed))} cannot both go to the output; name a file, as in "
            f"--format {streamed[0]}=FILE"
        )
    return asked if streamed else (*asked, Output("text"))


def write_report(report: Report, outputs: Sequence[Output], style: Style) -> None:
    """Write a report in every way that was asked for; what goes to files comes first. Raises click.ClickException."""
    for output in sorted(outputs, key=lambda output: output.file is None):
        text = FORMATS[output.form](report, style)
        if output.file is None:
            if output.form in ("text", "markdown"):
                write(text)
            else:
                write_data(text, output.form)
            continue
        try:
            make_asked(output.file.parent)
            write_asked(output.file, text.encode())
        except OSError as error:
            raise click.ClickException(f"{output.file} cannot be written: {error.strerror}") from error
