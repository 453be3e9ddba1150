"""Reads scenarios in YAML, and takes the one case that a function of the API needs."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final, Protocol, TypeAlias

from stackdsl.api.python_remedies import in_python
from stackdsl.checking.cases import Case, cases_of, gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.importers.expansion import expand_file
from stackdsl.language.yaml.includes import Library
from stackdsl.language.yaml.source import parse
from stackdsl.report.diagnostics import diagnostic_text

TEXT: Final = "text"  # stands for the file of a text


class HasCases(Protocol):
    """A scenario in Python."""

    @property
    def cases(self) -> tuple[Case, ...]:
        """Every variant on every system."""


OneCase: TypeAlias = Case | HasCases | Sequence[Case]
SomeCases: TypeAlias = Case | HasCases | Iterable[Case]


class ScenarioError(ValueError):
    """A scenario is invalid. The text has every mistake with its line of Python or YAML."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(map(in_python, diagnostics))
        super().__init__("\n\n".join(map(diagnostic_text, self.diagnostics)))


def load(*paths: Path | str) -> tuple[Case, ...]:
    """Return the cases of all scenarios in YAML files, and in folders with YAML files.

    Raises ScenarioError if a scenario is invalid or a file cannot be read, and LookupError if there is no scenario.
    """
    for path in paths:
        if not isinstance(path, str | Path):
            raise TypeError(f"expected the path of a YAML file or a folder, not {_kind(path)}: {path!r:.60}")
        if "\n" in str(path):
            raise TypeError("expected the path of a YAML file, not its text; `stackdsl.loads` reads a text")
    if not paths:
        raise TypeError("load needs a path, such as load('scenarios/tower.yaml')")
    gathered = gather(map(Path, paths))
    return _valid(gathered.cases, gathered.diagnostics, " and ".join(map(str, paths)))


def loads(text: str, name: str = TEXT) -> tuple[Case, ...]:
    """Return the cases of all scenarios in a YAML text; `name` stands for its file in messages.

    Raises ScenarioError if a scenario is invalid, and LookupError if there is no scenario.
    """
    if not isinstance(text, str):
        raise TypeError(f"expected a YAML text, not {_kind(text)}; `stackdsl.load` reads a file")
    if "\n" not in text and text.endswith((".yaml", ".yml")):
        raise TypeError(f"expected a YAML text, not the path of a file; write stackdsl.load({text!r})")
    return _valid(*cases_of(expand_file(parse(text, name), Library())), name)


def _valid(cases: Sequence[Case], mistakes: Sequence[Diagnostic], where: str) -> tuple[Case, ...]:
    if mistakes:
        raise ScenarioError(mistakes)
    if not cases:
        raise LookupError(f"there is no scenario in {where}; a scenario is a YAML file that has the key `scenario`")
    return tuple(cases)


def one_case(given: OneCase) -> Case:
    """Return a case, or the only case of a scenario. Raises TypeError, LookupError unless there is exactly one."""
    if isinstance(given, Case):
        return given
    cases = some_cases(given)
    if len(cases) != 1:
        names = ", ".join(case.name for case in cases) or "none"
        what = "scenario" if hasattr(given, "cases") else "cases"
        index = f"{what}.cases[0]" if what == "scenario" else "cases[0]"
        raise LookupError(f"expected one case, but there are {len(cases)}: {names}; choose one, such as `{index}`")
    return cases[0]


def some_cases(given: SomeCases) -> tuple[Case, ...]:
    """Return all cases of a scenario or of several cases, or the single case. Raises TypeError."""
    if isinstance(given, Case):
        return (given,)
    held = getattr(given, "cases", given)
    if isinstance(held, Iterable) and not isinstance(held, str | bytes | dict):
        cases = tuple(held)
        if wrong := next((each for each in cases if not isinstance(each, Case)), None):
            raise TypeError(f"expected cases, but one of them is {_kind(wrong)}{_remedy(wrong)}")
        return cases
    raise TypeError(f"expected a Scenario, or a case of `scenario.cases` or `load`, not {_kind(given)}{_remedy(given)}")


def _kind(value: object) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _remedy(value: object) -> str:
    """Return what to write instead of a value of another kind."""
    if isinstance(value, str | Path):
        return f"; read a file with stackdsl.load({str(value)!r}), and a text with stackdsl.loads(text)"
    if hasattr(value, "case"):
        return "; a run has its case as `run.case`"
    if hasattr(value, "cases"):
        return "; give the cases of a scenario, `scenario.cases`"
    return "; write Scenario(name, build=[...])" if isinstance(value, dict) else ""
