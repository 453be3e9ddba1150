"""Frame of the commands that apply statics to one file: cases, limits of work, and output."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import update_wrapper
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final, Generic, TypeAlias, TypeVar

import click

from stability.contact_law import OtherLawError
from stability.work_limit import TooMuchWorkError, limited
from stackdsl import work
from stackdsl.checking.cases import Case, GatheredCases
from stackdsl.checking.selection import Selection
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import (
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    code_without_runs,
    prepare_file,
    selected_of,
    unwritable,
    variants_of,
)
from stackdsl.cli.terminal import tell, write_data, write_wrapped
from stackdsl.exits import ExitCode
from stackdsl.report.study_table import Part, StudyTable, parts_table
from stackdsl.user_files import write_user_file
from stackdsl.viewing.svg import png_has_text

PLOTS: Final = (".svg", ".png")
NO_PNG: Final = "write a .svg file, which needs nothing, or try: pip install 'stackdsl[picture]'"

Found = TypeVar("Found")


def _picture(_context: click.Context, _parameter: click.Parameter, path: Path | None) -> Path | None:
    """Check the name of a picture file. Raises click.UsageError."""
    if path is not None and path.suffix.lower() not in PLOTS:
        raise click.UsageError(f"{path}: the file name must end in {' or '.join(PLOTS)}")
    if path is not None and path.suffix.lower() == ".png" and find_spec("resvg_py") is None:
        raise click.ClickException(f"{path}: .png needs resvg_py, which is not installed; {NO_PNG}")
    if path is not None:
        prepare_file(path)
    return path


ON_FORM: Final = click.option(
    "--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="Format of the output."
)
ON_PLOT: Final = click.option(
    "--plot", type=FilePath, callback=_picture, help="Draw one case to this .svg or .png file."
)

ON_PICTURE: Final = click.option(
    "--picture",
    type=FilePath,
    callback=_picture,
    help="Draw the first and the last position to this .svg or .png file.",
)


def refuse_several(plot: Path | None, cases: int) -> None:
    """Raise click.UsageError if more than one case would be drawn."""
    if plot is not None and cases > 1:
        raise click.UsageError(f"--plot draws one case, but {cases} are selected; choose one with -k")


def warn_of_missing_text(path: Path) -> None:
    """Warn if a picture has no text, because no usual font is installed."""
    if path.suffix.lower() != ".svg" and not png_has_text():
        fonts = "no font such as DejaVu Sans or Liberation Sans is installed"
        click.echo(f"warning: {path} has no text, since {fonts}; install one, or write a .svg file", err=True)


def draw(drawn: Callable[[str], bytes], path: Path) -> None:
    """Write a plot in the format of its file name. Raises click.ClickException."""
    try:
        write_user_file(path, drawn(path.suffix))
        warn_of_missing_text(path)
    except ModuleNotFoundError as error:
        raise click.ClickException(f"{path}: .png needs {error.name}, which is not installed; {NO_PNG}") from error
    except OSError as error:
        raise unwritable(path, error) from error


@dataclass(frozen=True)  # no slots: they would prevent calls of its generic alias
class Writing(Generic[Found]):
    """The output of a command: text line by line, other formats as a whole."""

    text: Callable[[Found], Iterable[str]]  # lines
    table: Callable[[Sequence[Found]], StudyTable]


@dataclass
class Request:
    """The options that all of these commands have."""

    command: str
    file: Path
    selection: Selection
    form: str
    plot: Path | None = None
    gathered: GatheredCases = field(init=False)
    selected: Sequence[Case] = field(init=False)

    def __post_init__(self) -> None:
        self.gathered, self.selected = selected_of(self.file, self.selection)

    def variants(self, but: str = "") -> Mapping[str, Case]:
        """Return the cases, each variant once, regardless of the value of one variable."""
        return variants_of(self.selected, but)

    def answer(
        self, questions: Iterable[tuple[str, Iterable[Found]]], writing: Writing[Found], instead: str
    ) -> tuple[list[Found], ExitCode]:
        """Write the results for each case, also after an interrupt; return them and the exit code.

        A case that takes too much work is refused with the advice `instead`, and the other cases continue.
        """
        found: list[Found] = []
        code = code_without_runs(self.gathered, self.selected)
        try:
            for name, answers in questions:
                with refusing(f"{name}: `{self.command}`", instead) as refused:
                    for each in answers:
                        found.append(each)
                        if self.form == "text" and (lines := list(writing.text(each))):
                            write_wrapped("\n".join(lines) + "\n")
                code = ExitCode.INVALID if refused else code
        except KeyboardInterrupt:
            tell("interrupted")
            code = ExitCode.INTERRUPTED
        finally:
            if self.form != "text":
                write_data(writing.table(found).written_as(self.form), self.form)
        return found, code


@contextmanager
def refusing(what: str, instead: str) -> Iterator[list[str]]:
    """Stop the block if it takes too much work or does not support joints, and report it in the list."""
    refused: list[str] = []
    try:
        with limited(work.limit()):
            yield refused
    except TooMuchWorkError as error:
        refused.append(str(error))
        tell(f"{what} takes too much work: {error}; {instead}, {work.HINT}")
    except OtherLawError as error:
        refused.append(str(error))
        tell(f"{what}: {error}; see `stackdsl explain`")


def statics_command(name: str, plot: bool = False) -> Callable[[Callable[..., ExitCode]], click.Command]:
    """Make a command with the common options; the function gets a `Request`, then its own options."""

    def made(asked: Callable[..., ExitCode]) -> click.Command:
        @click.pass_context
        def command(  # noqa: PLR0913, PLR0917 -- one parameter an option
            context: click.Context,
            /,
            file: Path,
            systems: tuple[str, ...],
            keyword: str,
            form: str,
            plot: Path | None = None,
            **options: Any,  # noqa: ANN401 -- its own
        ) -> None:
            context.exit(asked(Request(name, file, Selection(systems, keyword), form, plot), **options))

        update_wrapper(command, asked)
        for option in (*([ON_PLOT] if plot else []), ON_FORM, ON_KEYWORD, ON_SYSTEMS):
            option(command)
        return click.command(name, cls=ExplainedCommand)(ONE_FILE(command))

    return made


Parts: TypeAlias = Iterator[Part]
IN_PARTS: Final = Writing[Part](lambda part: part.lines, parts_table)
