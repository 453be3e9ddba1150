"""Options, messages and output formats that several commands share."""

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from errno import EISDIR
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution
from math import isfinite
from pathlib import Path
from typing import Any, Final, TypeAlias

import click

from stackdsl.checking.cases import Case, GatheredCases, gather
from stackdsl.checking.check import FoundCases
from stackdsl.checking.selection import KeywordError, Selectable, Selection, expression_of, nothing_selected_text
from stackdsl.cli.terminal import paper, tell, with_known_marks, write, write_data
from stackdsl.diagnostics import Diagnostic
from stackdsl.exits import ExitCode
from stackdsl.report.blocks import TextStyle
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.results import Report
from stackdsl.shown_text import harmless
from stackdsl.simulation.known_systems import KNOWN, needs_of
from stackdsl.user_files import make_user_folder, write_user_file

# Options that several commands have.


class _FilePath(click.Path):
    """Path of a file or directory. An empty one, such as that of an unset shell variable, is no path."""

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> str | bytes | os.PathLike[str]:
        """Refuse an empty path."""
        if value == "":
            self.fail("the path is empty, such as that of an unset shell variable", param, ctx)
        return super().convert(value, param, ctx)


FilePath = _FilePath(path_type=Path)


class Number(click.FloatRange):
    """A number within a range; `nan`, which no bound excludes, is refused."""

    name = "number"

    def convert(self, value: float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"'{value}' is not a finite number", param, ctx)
        return number


class SystemChoice(click.Choice[str]):
    """The name of a listed system, or of one from another package."""

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name. Systems of other packages are looked up only for unknown names."""
        if value in self.choices:
            return value
        from stackdsl.simulation.plugins import ForeignSystemError, foreign_system  # noqa: PLC0415 -- rare

        try:
            return foreign_system(value).name
        except ForeignSystemError as error:
            self.fail(str(error), param, ctx)


SYSTEM_CHOICE = SystemChoice(list(KNOWN))


def playable(systems: tuple[str, ...]) -> tuple[str, ...]:
    """Return the requested systems, each once. Raises click.BadParameter for a missing package."""
    for name, package in needs_of(systems):
        if not package.installed:
            told = f"'{name}' needs {package.name}, which is not installed"
            raise click.BadParameter(f"{told}; try: {package.remedy}")
    return tuple(dict.fromkeys(systems))


ONE_FILE = click.argument("file", type=FilePath)
ON_SYSTEMS = click.option(
    "--system",
    "systems",
    multiple=True,
    type=SYSTEM_CHOICE,
    callback=lambda *given: playable(given[-1]),
    metavar="SYSTEM",
    help=f"Select a system: {', '.join(KNOWN)}, or one of a plugin. Can be repeated. Systems on engines other than "
    "PyBullet run every selected scenario.",
)


def _expression(texts: tuple[str, ...]) -> str:
    """Join the given expressions."""
    for text in texts:
        try:
            expression_of(text)
        except KeywordError as error:
            raise click.BadParameter(str(error)) from error
    given = [text for text in texts if text.strip()]
    return given[0] if len(given) == 1 else " and ".join(f"({text})" for text in given)


ON_KEYWORD = click.option(
    "-k",
    "keyword",
    multiple=True,
    callback=lambda *given: _expression(given[-1]),
    help="Select cases whose name contains this, such as 'tower and not (tuned or stock)'. If repeated, all must hold.",
)
ON_TAGS = click.option(
    "--tag", "tags", multiple=True, help="Select scenarios with this tag, or without it if it begins with !."
)
CORES: Final = os.cpu_count() or 1


class ProcessCount(click.IntRange):
    """A number of processes: at least one; more than two per core would only wait, at 60 MB each."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:  # noqa: ANN401 -- as click
        """Return the number, at most the largest."""
        return min(int(super().convert(value, param, ctx)), 2 * CORES)


ON_JOBS: Final = click.option(
    "-j",
    "--jobs",
    type=ProcessCount(1),
    default=CORES,
    help="Number of processes. Default: one per core. Largest: two per core.",
)
LONGEST_LIMIT = 1e6  # [s] eleven days; a wait is limited to 2**31 milliseconds


# Reading and selection of cases, with their error messages.


def selected_of(file: Path, selection: Selection) -> tuple[GatheredCases, Sequence[Case]]:
    """Return the content of a file and its selected cases; report mistakes and an empty selection.

    Scenarios that their author skips here are reported and left out.
    """
    gathered = gather([file])
    complain(gathered.diagnostics)
    selected = selection.of(gathered.cases)
    warn_of_nothing(selection, gathered, selected, [file])
    for name, skip in {case.scenario_name: case.scenario.skip for case in selected if case.is_unread}.items():
        tell(f"{name} is skipped: {skip.reason}; try: pip install 'stackdsl[{skip.without}]'" if skip else name)
    return gathered, [case for case in selected if not case.is_unread]


def complain(diagnostics: Iterable[Diagnostic]) -> None:
    """Report mistakes."""
    for diagnostic in diagnostics:
        tell(diagnostic_text(diagnostic))


def warn_of_nothing(
    selection: Selection, gathered: FoundCases, selected: Sequence[Selectable], paths: Sequence[Path]
) -> None:
    """Report why nothing or no case of a system is selected, unless mistakes were reported, which may be the reason."""
    if not selected and not gathered.diagnostics:
        tell(nothing_selected_text(selection, gathered.cases, paths))
    missing = [system for system in selection.systems if not any(case.system == system for case in selected)]
    if selected and missing:
        tell(f"no selected scenario has {' or '.join(missing)} among its `systems`; add it there")


def code_without_runs(gathered: FoundCases, selected: Sequence[Selectable]) -> ExitCode:
    """Return the exit code of a call that plays nothing."""
    if gathered.diagnostics:
        return ExitCode.INVALID
    return ExitCode.OK if selected else ExitCode.USAGE


def variants_of(cases: Sequence[Case], but: str = "") -> dict[str, Case]:
    """Return each variant once by its name, regardless of the system and of the value of one variable."""
    found: dict[tuple[object, ...], tuple[str, Case]] = {}
    for case in cases:
        fixed = tuple((name, str(value)) for name, value in case.variant.choice.items() if name != but)
        chosen = ",".join(f"{name}={text}" for name, text in case.parameters if name != but)
        name = f"{case.scenario.scenario}[{chosen}]" if chosen else case.scenario.scenario
        found.setdefault((case.scenario.scenario, fixed), (name, case))
    return dict(found.values())


# Requirement with which `pip install` gets the installed version of stackdsl on another machine.


VENDORED = "./vendor/stackdsl-*.whl"  # a wheel inside the project, if the installation is not from a repository


def requirement() -> str:
    """Return the repository and commit of the installation (PEP 610), else a wheel within the project."""
    with suppress(PackageNotFoundError, ValueError, KeyError, TypeError):
        origin = json.loads(distribution("stackdsl").read_text("direct_url.json") or "{}")
        vcs = origin["vcs_info"]
        return f"'stackdsl @ {vcs['vcs']}+{origin['url']}@{vcs['commit_id']}'"
    return VENDORED


# Formats and files of a report.


Renderer: TypeAlias = Callable[[Report, TextStyle], str]


def _text(report: Report, style: TextStyle) -> str:
    from stackdsl.report.check_text import report_text  # noqa: PLC0415 -- only the requested one

    return with_known_marks(report_text(report, *paper(), style))


def _of(name: str) -> Renderer:
    def render(report: Report, _: TextStyle) -> str:
        text: str = getattr(import_module("stackdsl.report.formats"), f"report_{name}")(report)
        return harmless(text)

    return render


@dataclass(frozen=True, slots=True)
class ReportFormat:
    """A format of the report."""

    render: Renderer
    is_data: bool  # for programs, so that escapes on the output stream must not change its meaning


# In the order of docs/command.md. `_of` finds the function `report_<name>` of `report/formats.py`.
REPORT_FORMATS: Final[Mapping[str, ReportFormat]] = {
    "text": ReportFormat(_text, is_data=False),
    "json": ReportFormat(_of("json"), is_data=True),
    "junit": ReportFormat(_of("junit"), is_data=True),
    "github": ReportFormat(_of("github"), is_data=True),  # its workflow commands are its content
    "markdown": ReportFormat(_of("markdown"), is_data=False),
    "csv": ReportFormat(_of("csv"), is_data=True),
}


@dataclass(frozen=True, slots=True)
class Output:
    """One output of the report."""

    form: str
    file: Path | None = None  # None for the output stream

    def __str__(self) -> str:
        return self.form if self.file is None else f"{self.form}={self.file}"


class OutputChoice(click.ParamType[Output]):
    """A format name, or a format name, `=` and a file."""

    name = "format"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Output:
        """Return the output."""
        if isinstance(value, Output):
            return value
        form, named, file = str(value).partition("=")
        if form not in REPORT_FORMATS:
            listed = ", ".join(f"'{known}'" for known in REPORT_FORMATS)
            self.fail(f"'{form}' is not one of {listed}", param, ctx)
        if named and not file:
            self.fail(f"'{value}' has no file name; write {form} or {form}=FILE", param, ctx)
        return Output(form, Path(file) if named else None)

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Return the text for the help."""
        return f"[{'|'.join(REPORT_FORMATS)}][=FILE]"


def outputs_of(asked: Sequence[Output]) -> Sequence[Output]:
    """Return the outputs: text goes to the output stream unless another format does. Raises click.UsageError."""
    streamed = [output for output in asked if output.file is None]
    if len(streamed) > 1:
        raise click.UsageError(
            f"{' and '.join(map(str, streamed))} cannot both go to the standard output; give one a file, such as "
            f"--format {streamed[0]}=FILE"
        )
    return asked if streamed else (*asked, Output("text"))


def prepare_file(path: Path) -> None:
    """Create the folder of a requested file before the work for it. Raises click.ClickException if it cannot be."""
    try:
        if os.path.isdir(path):
            raise IsADirectoryError(EISDIR, os.strerror(EISDIR))
        make_user_folder(path.parent)
    except OSError as error:
        raise unwritable(path, error) from error


def unwritable(path: Path, error: OSError) -> click.ClickException:
    """Return the error for a file that cannot be written."""
    return click.ClickException(f"{path} cannot be written: {error.strerror}; choose another name")


def write_report(report: Report, outputs: Sequence[Output], style: TextStyle) -> None:
    """Write a report to all outputs, files first. Raises click.ClickException."""
    for output in sorted(outputs, key=lambda output: output.file is None):
        report_format = REPORT_FORMATS[output.form]
        text = report_format.render(report, style)
        if output.file is None:
            if report_format.is_data:
                write_data(text, output.form)
            else:
                write(text)
            continue
        try:
            make_user_folder(output.file.parent)
            write_user_file(output.file, text.encode())
        except OSError as error:
            raise unwritable(output.file, error) from error
