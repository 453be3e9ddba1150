"""Reads scenarios in YAML, and takes the one case that a function of the API needs."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final, Protocol, TypeAlias

from stackdsl.api.arguments import refuse_other_types
from stackdsl.api.python_remedies import in_python
from stackdsl.api.written import callers_place
from stackdsl.checking.cases import Case, cases_of, gather
from stackdsl.diagnostics import Diagnostic, Span, meant_choice
from stackdsl.importers.expansion import expand_file
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import QUANTITY, InputError
from stackdsl.language.yaml.includes import Library
from stackdsl.language.yaml.source import KeyPath, Loaded, Plain, Source, parse
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


def load(*paths: Path | str, **variables: str | float) -> tuple[Case, ...]:
    """Return the cases of all scenarios in YAML files, and in folders with YAML files.

    `variables` gives variables of `let` and `matrix` other values, such as `step="14 mm"`, which the names of the cases
    then have.

    Raises TypeError for a variable that no scenario has, and ValueError for a number without its unit.

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
    where = " and ".join(map(str, paths))
    return _with_values(_valid(gathered.cases, gathered.diagnostics, where), variables, where)


def loads(text: str, name: str = TEXT, **variables: str | float) -> tuple[Case, ...]:
    """Return the cases of all scenarios in a YAML text; `name` stands for its file in messages.

    `variables` gives variables other values, as in `load`.

    Raises ScenarioError if a scenario is invalid, and LookupError if there is no scenario.
    """
    if not isinstance(text, str):
        raise TypeError(f"expected a YAML text, not {_kind(text)}; `stackdsl.load` reads a file")
    if "\n" not in text and text.endswith((".yaml", ".yml")):
        raise TypeError(f"expected a YAML text, not the path of a file; write stackdsl.load({text!r})")
    cases = _valid(*cases_of(expand_file(parse(text, name), Library())), name)
    return _with_values(cases, variables, name)


def _with_values(cases: tuple[Case, ...], variables: Mapping[str, str | float], where: str) -> tuple[Case, ...]:
    """Return the cases of the same scenarios with other values of variables."""
    if not variables:
        return cases
    refuse_other_types(str | float | int, "a text with a unit, such as '14 mm', or a number", **variables)
    scenarios = list({id(case.written): case.written for case in cases}.values())
    known = sorted({name for written in scenarios for name in _names(written.values)})
    for name in variables:
        if name not in known:
            has = (
                f"; variables: {', '.join(known)}"
                if known
                else "; a variable is a key of `let` or `matrix`, used as ${name}"
            )
            meant = meant_choice(name, known)
            raise TypeError(
                f"no scenario in {where} has a variable '{name}'{f'; did you mean {meant!r}?' if meant else has}"
            )
    for written in scenarios:
        _refuse_other_units(_rows(written.values), variables)
    place = callers_place()
    found, mistakes = cases_of(Loaded(tuple(_fixed(written, variables, place) for written in scenarios), ()))
    return _valid(found, mistakes, where)


CHOICES: Final = ("let", "matrix")


def _names(values: Mapping[str, Plain]) -> Iterator[str]:
    """Yield the names of the variables of a scenario that have one value or a row of values."""
    for row in _rows(values).values():
        yield from row


def _rows(values: Mapping[str, Plain]) -> dict[str, dict[str, Plain]]:
    return {key: row for key in CHOICES if isinstance(row := values.get(key), dict)}


def _refuse_other_units(rows: Mapping[str, Mapping[str, Plain]], variables: Mapping[str, str | float]) -> None:
    """Raise ValueError for a number whose unit is not of the kind that the file has."""
    for name, value in variables.items():
        held = next((row[name] for row in rows.values() if name in row), None)
        was = QUANTITY.fullmatch(str(held[0] if isinstance(held, list) and held else held).strip())
        now = QUANTITY.fullmatch(str(value).strip())
        if was is None or now is None or (float(now["number"]) == 0.0 and not now["unit"]):
            continue  # a word or an expression, or a zero, which needs no unit
        remedy = f"write {name}='{now['number']} {was['unit']}'" if was["unit"] else f"write {name}={now['number']}"
        if bool(was["unit"]) != bool(now["unit"]):
            fault = "no unit" if was["unit"] else f"a unit, but '{name}' is a number without a unit"
            raise ValueError(f"{name}={value!r} has {fault}; {remedy}")
        try:
            same = unit_text(constant(was[0])) == unit_text(constant(now[0]))
        except InputError as mistake:
            raise ValueError(f"{name}={value!r}: {mistake.message}; {remedy}") from mistake
        if not same:
            raise ValueError(f"{name}={value!r} has another kind of unit than '{was[0]}' in the file; {remedy}")


def _fixed(written: Source, variables: Mapping[str, str | float], place: Span) -> Source:
    """Return a scenario whose matrix has one value for each of these variables, so that the names of cases tell it.

    `place` is that of the call with the values.
    """
    own: dict[str, Plain] = {name: [value] for name, value in variables.items() if name in _names(written.values)}
    spans: dict[KeyPath, Span] = {
        path: replace(place, key=name) for name in own for path in (("matrix", name), ("matrix", name, 0))
    }
    rows = _rows(written.values)
    let = {name: value for name, value in rows.get("let", {}).items() if name not in own}
    values = {key: value for key, value in written.values.items() if key not in CHOICES}
    values |= {"matrix": {**rows.get("matrix", {}), **own}} if own or "matrix" in rows else {}
    values |= {"let": let} if let else {}
    return replace(written, values=values, value_spans={**written.value_spans, **spans})


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
