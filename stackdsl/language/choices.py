"""Which combinations of values a scenario is played with: `matrix:`, `cases:` and `exclude:`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final, TypeAlias

from stackdsl.diagnostics import did_you_mean
from stackdsl.language.expressions import FUNCTIONS, VARIABLE, value_of
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import UNITS
from stackdsl.language.ranges import told_apart, values_of
from stackdsl.reading.source import Path, Plain

if TYPE_CHECKING:
    from stackdsl.language.expressions import Value

MAX_VARIANTS: Final = 256
_FEWER: Final = f"write at most {MAX_VARIANTS}, or make several scenarios of it"

# A mistake may turn up once a variant: where it is and what it says make it one.
Mistakes: TypeAlias = dict[tuple[Path, str], MistakeError]


class NameMistakeError(MistakeError):
    """The name of a variable is at fault, not its value."""


@dataclass(frozen=True, slots=True)
class Choice:
    """One combination: the value of each variable, as written; None where that is mistaken."""

    values: Mapping[str, Plain]
    called: tuple[tuple[str, str], ...]  # the variables that tell it from the others, each with its value as written


@dataclass(frozen=True, slots=True)
class Choices:
    """All combinations, in the author's order."""

    all: tuple[Choice, ...]
    names: frozenset[str] = frozenset()  # of the variables
    mistakes: Mistakes = field(default_factory=dict)


def choices_of(values: Mapping[str, Plain]) -> Choices:
    """What a scenario is played with; where there are too many combinations, one of no values."""
    mistakes: Mistakes = {}
    cases = _cases(values["cases"], mistakes) if "cases" in values else [{}]
    rows = _rows(values["matrix"], mistakes) if "matrix" in values else {}
    for name in sorted(rows.keys() & cases[0].keys()):
        add(mistakes, ("matrix", name), _taken(name, "the cases"))
    names = frozenset((*rows, *cases[0]))
    if prod(map(len, rows.values()), start=len(cases)) > MAX_VARIANTS:  # told without the number, which may be long
        message = f"the matrix has more than {MAX_VARIANTS} combinations, which are the most"
        add(mistakes, ("matrix",), MistakeError("SD206", message, "make several scenarios of it"))
        return Choices((Choice(dict.fromkeys(names), ()),), names, mistakes)
    made = [_choice(case, dict(zip(rows, row, strict=True))) for case in cases for row in product(*rows.values())]
    kept = _kept(made, values.get("exclude"), names, mistakes)
    return Choices(tuple(kept), names, mistakes)


def _choice(case: Mapping[str, Plain], row: Mapping[str, Plain]) -> Choice:
    first = next(iter(case), None)
    told = {**({} if first is None else {first: case[first]}), **row}
    called = tuple((name, str(written)) for name, written in told.items() if written is not None)
    return Choice({**case, **row}, called)


def compact(text: str) -> str:
    """A value of a choice as it stands in the name of a case."""
    return "".join(text.split())


# --- the parts --------------------------------------------------------------------------------------------------------


def _rows(matrix: Plain, mistakes: Mistakes) -> dict[str, list[Plain]]:
    """The rows of `matrix`; a mistaken one has the single value None."""
    if not isinstance(matrix, dict):
        add(mistakes, ("matrix",), MistakeError("SD103", "expected a mapping", "write {step: [10 mm, 12 mm]}"))
        return {}
    if len(matrix) > MAX_VARIANTS:
        add(mistakes, ("matrix",), MistakeError("SD206", f"the matrix has more than {MAX_VARIANTS} rows", _FEWER))
        return {}
    return {name: _row(name, row, mistakes) for name, row in matrix.items()}


def _row(name: str, row: Plain, mistakes: Mistakes) -> list[Plain]:
    path: Path = ("matrix", name)
    before = len(mistakes)
    try:
        check_name(name)
        values = values_of(row, MAX_VARIANTS)
    except MistakeError as mistake:
        add(mistakes, path, mistake)
        return [None]
    seen: set[str] = set()
    for index, wrong in told_apart(values):
        add(mistakes, (*path, index), wrong)
    for index, written in enumerate(values):
        if compact(str(written)) in seen:  # the number 1 and the text '1' name one case
            add(
                mistakes,
                (*path, index),
                MistakeError("SD104", f"{shown(written)} is in the row already", "write each value once"),
            )
        seen.add(compact(str(written)))
    return [None] if len(mistakes) > before else values


def _cases(cases: Plain, mistakes: Mistakes) -> list[dict[str, Plain]]:
    """The cases, each a mapping of the same variables; without any that can be used, one without variables."""
    if not isinstance(cases, list) or not cases or not all(isinstance(case, dict) and case for case in cases):
        mistake = MistakeError(
            "SD103", "expected a list of mappings", "write - {speed: 1 m/s, shift: 34 mm}, a line a case"
        )
        add(mistakes, ("cases",), mistake)
        return [{}]
    if len(cases) > MAX_VARIANTS:
        add(mistakes, ("cases",), MistakeError("SD206", f"there are {len(cases)} cases", _FEWER))
        return [{}]
    listed = [case for case in cases if isinstance(case, dict)]
    first = next(iter(listed[0]))
    before = len(mistakes)
    for number, case in enumerate(listed):
        _check_case(number, case, listed[0], mistakes)
    if len(mistakes) == before:
        for number, mistake in told_apart([case[first] for case in listed]):
            message = f"two cases have {first} {shown(listed[number][first])}, by which they are told apart"
            hint = "begin each case with a variable whose value is its own, such as name: slow"
            add(mistakes, ("cases", number, first), MistakeError(mistake.code, message, hint))
    return listed if len(mistakes) == before else [dict.fromkeys(listed[0])]


def _check_case(number: int, case: Mapping[str, Plain], first: Mapping[str, Plain], mistakes: Mistakes) -> None:
    for name in first:
        if name not in case:
            add(
                mistakes,
                ("cases", number),
                MistakeError("SD102", f"this case has no '{name}'", f"add `{name}`, as in the first case"),
            )
    for name, written in case.items():
        path: Path = ("cases", number, name)
        try:
            if name not in first:
                raise _unknown("SD101", name, tuple(first), "give it to all cases")
            check_name(name)
            value_of(written)
        except MistakeError as mistake:
            add(mistakes, path, mistake)


def _unknown(code: str, name: str, known: Sequence[str], otherwise: str = "") -> MistakeError:
    return NameMistakeError(code, f"unknown variable '{name}'", lambda: did_you_mean(name, known) or otherwise)


def _kept(made: list[Choice], exclude: Plain, names: frozenset[str], mistakes: Mistakes) -> list[Choice]:
    """The combinations that none of `exclude` speaks of."""
    if exclude is None:
        return made
    if not isinstance(exclude, list) or not exclude or not all(isinstance(each, dict) and each for each in exclude):
        mistake = MistakeError(
            "SD103", "expected a list of mappings", "write - {step: 12 mm, levels: 3}, a line a combination"
        )
        add(mistakes, ("exclude",), mistake)
        return made
    if len(exclude) > MAX_VARIANTS:
        add(mistakes, ("exclude",), MistakeError("SD206", f"{len(exclude)} combinations are left out", _FEWER))
        return made
    known = [({name: _value(written) for name, written in choice.values.items()}, choice) for choice in made]
    left = known
    for number, each in enumerate(exclude):
        wanted = dict(_excluded(number, each, names, mistakes)) if isinstance(each, dict) else {}
        if not any(_has(values, wanted) for values, _ in known) and not mistakes:
            hint = "write values that the matrix or the cases have together"
            add(mistakes, ("exclude", number), MistakeError("SD104", "there is no such combination to leave out", hint))
        left = [pair for pair in left if not _has(pair[0], wanted)] if wanted else left
    if not left:
        add(mistakes, ("exclude",), MistakeError("SD104", "no combination is left", "leave out fewer"))
    return [choice for _, choice in left] or made[:1]


def _value(written: Plain) -> "Value | None":
    return None if written is None else value_of(written)


def _has(values: Mapping[str, "Value | None"], wanted: Mapping[str, "Value"]) -> bool:
    return all(values[name] == value for name, value in wanted.items())


def _excluded(
    number: int, each: Mapping[str, Plain], names: frozenset[str], mistakes: Mistakes
) -> Iterator[tuple[str, "Value"]]:
    """The variables that one of `exclude` speaks of, each with its value."""
    for name, written in each.items():
        try:
            if name not in names:
                raise _unknown("SD109", name, sorted(names))
            yield name, value_of(written)
        except MistakeError as mistake:
            add(mistakes, ("exclude", number, name), mistake)


# --- names ------------------------------------------------------------------------------------------------------------


def check_name(name: str, taken: Iterable[str] = (), where: str = "") -> None:
    """Raise MistakeError if a variable cannot be called so, or if the name is taken `where` others are."""
    if not VARIABLE.fullmatch(name):
        raise NameMistakeError(
            "SD109", f"'{name}' cannot name a variable", "write letters, digits and _, a letter first"
        )
    if name in UNITS or name in FUNCTIONS or name == "pi":
        raise NameMistakeError("SD109", f"'{name}' {_meaning(name)}, and cannot name a variable", "take another name")
    if name in taken:
        raise _taken(name, where)


def _taken(name: str, where: str) -> MistakeError:
    return NameMistakeError("SD109", f"'{name}' is a variable of {where} already", "take another name")


def _meaning(name: str) -> str:
    """What a name means in every expression."""
    if name == "pi":
        return "is a number"
    return "is a unit" if name in UNITS else "is a function"


def add(mistakes: Mistakes, path: Path, mistake: MistakeError) -> None:
    """Note a mistake of the value, or the key, at a path."""
    mistakes[path, mistake.message] = mistake.with_traceback(None)  # whose frames would keep all that they knew
