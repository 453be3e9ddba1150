"""What the commands that read scenarios tell of what they found, and of what they were asked for."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from stackdsl.checking.check import Found
from stackdsl.checking.gathering import Case, Gathered, gather
from stackdsl.checking.selection import Selectable, Selection, why_nothing
from stackdsl.commands.terminal import tell
from stackdsl.diagnostics import Diagnostic
from stackdsl.exits import ExitCode
from stackdsl.report.diagnostic_text import diagnostic_text


def selected_of(file: Path, selection: Selection) -> tuple[Gathered, Sequence[Case]]:
    """What one file holds, and the cases selected of it; its mistakes are told, and why nothing is selected.

    Of what is not read here, since its author said so, nothing is known: it is told, and left out.
    """
    gathered = gather([file])
    complain(gathered.diagnostics)
    selected = selection.of(gathered.cases)
    warn_of_nothing(selection, gathered, selected, [file])
    for name, skip in {case.scenario_name: case.scenario.skip for case in selected if case.is_unread}.items():
        tell(f"{name} is skipped: {skip.reason}; try: pip install 'stackdsl[{skip.without}]'" if skip else name)
    return gathered, [case for case in selected if not case.is_unread]


def complain(diagnostics: Iterable[Diagnostic]) -> None:
    """Tell of mistakes."""
    for diagnostic in diagnostics:
        tell(diagnostic_text(diagnostic))


def warn_of_nothing(
    selection: Selection, gathered: Found, selected: Sequence[Selectable], paths: Sequence[Path]
) -> None:
    """Tell why nothing is selected, unless mistakes are told that may be why."""
    if not selected and not gathered.diagnostics:
        tell(why_nothing(selection, gathered.cases, paths))


def code_without_runs(gathered: Found, selected: Sequence[Selectable]) -> ExitCode:
    """The exit code of a call that plays nothing."""
    if gathered.diagnostics:
        return ExitCode.INVALID
    return ExitCode.OK if selected else ExitCode.USAGE


def variants_of(cases: Sequence[Case], but: str = "") -> dict[str, Case]:
    """Each variant once by its name, whatever it is played on, and whatever it has of one variable."""
    found: dict[tuple[object, ...], tuple[str, Case]] = {}
    for case in cases:
        fixed = tuple((name, str(value)) for name, value in case.variant.choice.items() if name != but)
        chosen = ",".join(f"{name}={text}" for name, text in case.parameters if name != but)
        name = f"{case.scenario.scenario}[{chosen}]" if chosen else case.scenario.scenario
        found.setdefault((case.scenario.scenario, fixed), (name, case))
    return dict(found.values())
