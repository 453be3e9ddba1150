"""Expands `repeat:`, `matrix:`, `cases:` and `exclude:`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final, TypeAlias

from stackdsl.diagnostics import did_you_mean, meant_choice
from stackdsl.language.expressions import (
    FUNCTIONS,
    VARIABLE,
    EarlierInputError,
    inner_names,
    interpolate,
    value_mistakes,
    value_of,
    values_of,
)
from stackdsl.language.quantities import ALSO_VARIABLES, UNITS, InputError, shown
from stackdsl.language.yaml.source import KeyPath, PlaceBuilder, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.expressions import Names, Value


# Combinations of values, one for each variant: `matrix:`, `cases:` and `exclude:`.


MAX_VARIANTS: Final = 256
_FEWER: Final = f"write at most {MAX_VARIANTS}, or split it into several scenarios"

# By path and message, so that a mistake that occurs in every variant is reported once.
Mistakes: TypeAlias = dict[tuple[KeyPath, str], InputError]


class InvalidNameError(InputError):
    """A mistake in the name of a variable, not in its value."""


@dataclass(frozen=True, slots=True)
class Combination:
    """One combination of values."""

    values: Mapping[str, Plain]  # of all variables, as written; None for a mistaken value
    identity: tuple[tuple[str, str], ...]  # variables that identify the combination, each with its value as written


@dataclass(frozen=True, slots=True)
class Combinations:
    """All combinations, in the order of the file."""

    all: tuple[Combination, ...]
    names: frozenset[str] = frozenset()  # of the variables
    mistakes: Mistakes = field(default_factory=dict)


def combinations_of(values: Mapping[str, Plain]) -> Combinations:
    """Return the combinations of a scenario; if there are too many, a single one without values."""
    mistakes: Mistakes = {}
    cases = _cases(values["cases"], mistakes) if "cases" in values else [{}]
    rows = _rows(values["matrix"], mistakes) if "matrix" in values else {}
    for name in sorted(rows.keys() & cases[0].keys()):
        add(mistakes, ("matrix", name), _taken(name, "the cases"))
    names = frozenset((*rows, *cases[0]))
    if prod(map(len, rows.values()), start=len(cases)) > MAX_VARIANTS:  # the number may be too long for the message
        message = f"the matrix has more than the maximum of {MAX_VARIANTS} combinations"
        add(mistakes, ("matrix",), InputError("SD206", message, "split it into several scenarios"))
        return Combinations((Combination(dict.fromkeys(names), ()),), names, mistakes)
    combinations = [
        _combination(case, dict(zip(rows, row, strict=True))) for case in cases for row in product(*rows.values())
    ]
    included = _included(combinations, values.get("exclude"), names, mistakes)
    return Combinations(tuple(included), names, mistakes)


def _combination(case: Mapping[str, Plain], row: Mapping[str, Plain]) -> Combination:
    first = next(iter(case), None)
    identifying = {**({} if first is None else {first: case[first]}), **row}
    identity = tuple((name, str(written)) for name, written in identifying.items() if written is not None)
    return Combination({**case, **row}, identity)


def compact(text: str) -> str:
    """Remove white space from a value, for the name of a case."""
    return "".join(text.split())


# --- the parts --------------------------------------------------------------------------------------------------------


def names_in(value: Plain) -> tuple[str, ...]:
    """Return the keys of a mapping, or of the mappings in a list: variables, wherever they are written."""
    mappings = value if isinstance(value, list) else [value]
    return tuple(name for mapping in mappings if isinstance(mapping, dict) for name in mapping)[:MAX_VARIANTS]


def _rows(matrix: Plain, mistakes: Mistakes) -> dict[str, list[Plain]]:
    """Return the rows of `matrix`; a row with a mistake has the single value None."""
    if not isinstance(matrix, dict):
        add(
            mistakes,
            ("matrix",),
            InputError(
                "SD103",
                "expected a mapping of variables to values",
                "write each variable without '- '"
                if isinstance(matrix, list)
                else "write, for example, {step: [10 mm, 12 mm]}",
            ),
        )
        return {name: [None] for name in names_in(matrix)}
    if len(matrix) > MAX_VARIANTS:
        add(mistakes, ("matrix",), InputError("SD206", f"the matrix has more than {MAX_VARIANTS} rows", _FEWER))
        return {}
    return {name: _row(name, row, mistakes) for name, row in matrix.items()}


def _row(name: str, row: Plain, mistakes: Mistakes) -> list[Plain]:
    path: KeyPath = ("matrix", name)
    before = len(mistakes)
    try:
        check_name(name)
        values = values_of(row, MAX_VARIANTS)
    except InputError as mistake:
        add(mistakes, path, mistake)
        return [None]
    seen: set[str] = set()
    for index, wrong in value_mistakes(values):
        add(mistakes, (*path, index), wrong)
    for index, written in enumerate(values):
        if compact(str(written)) in seen:  # the number 1 and the text '1' name one case
            add(
                mistakes,
                (*path, index),
                InputError("SD104", f"the list contains {shown(written)} twice", "write each value once"),
            )
        seen.add(compact(str(written)))
    return [None] if len(mistakes) > before else values


def _cases(cases: Plain, mistakes: Mistakes) -> list[dict[str, Plain]]:
    """Return the cases, each a mapping of the same variables; a single empty one if `cases` is malformed."""
    if not isinstance(cases, list) or not cases or not all(isinstance(case, dict) and case for case in cases):
        mistake = InputError(
            "SD103",
            "expected a list of mappings",
            "write one line for each case, such as - {speed: 1 m/s, shift: 34 mm}",
        )
        add(mistakes, ("cases",), mistake)
        return [dict.fromkeys(names_in(cases))]
    if len(cases) > MAX_VARIANTS:
        add(mistakes, ("cases",), InputError("SD206", f"`cases` has {len(cases)} items", _FEWER))
        return [{}]
    listed = [case for case in cases if isinstance(case, dict)]
    first = next(iter(listed[0]))
    before = len(mistakes)
    for number, case in enumerate(listed):
        _check_case(number, case, listed[0], mistakes)
    if len(mistakes) == before:
        for number, mistake in value_mistakes([case[first] for case in listed]):
            message = f"two cases have the same first value, and so the same name: {shown(listed[number][first])}"
            hint = "begin each case with a variable that has a different value in each, such as name: slow"
            add(mistakes, ("cases", number, first), InputError(mistake.code, message, hint))
    return listed if len(mistakes) == before else [dict.fromkeys(listed[0])]


def _check_case(number: int, case: Mapping[str, Plain], first: Mapping[str, Plain], mistakes: Mistakes) -> None:
    for name in first:
        misspelt = any(meant_choice(other, [name]) for other in case if other not in first)
        if name not in case and not misspelt:
            add(
                mistakes,
                ("cases", number),
                InputError("SD102", f"this case has no value for '{name}'", f"add `{name}`, as in the first case"),
            )
    for name, written in case.items():
        path: KeyPath = ("cases", number, name)
        try:
            if name not in first:
                raise _unknown("SD101", name, tuple(first), "add this variable to all cases")
            check_name(name)
            value_of(written)
        except InputError as mistake:
            add(mistakes, path, mistake)


def _unknown(code: str, name: str, known: Sequence[str], otherwise: str = "") -> InputError:
    return InvalidNameError(code, f"unknown variable '{name}'", lambda: did_you_mean(name, known) or otherwise)


def _included(made: list[Combination], exclude: Plain, names: frozenset[str], mistakes: Mistakes) -> list[Combination]:
    """Return the combinations that do not match an item of `exclude`."""
    if exclude is None:
        return made
    if not isinstance(exclude, list) or not exclude or not all(isinstance(item, dict) and item for item in exclude):
        mistake = InputError(
            "SD103",
            "expected a list of mappings",
            "write one line for each combination, such as - {step: 12 mm, levels: 3}",
        )
        add(mistakes, ("exclude",), mistake)
        return made
    if len(exclude) > MAX_VARIANTS:
        add(mistakes, ("exclude",), InputError("SD206", f"`exclude` has {len(exclude)} items", _FEWER))
        return made
    parsed = [({name: _value(written) for name, written in each.values.items()}, each) for each in made]
    left = parsed
    for number, item in enumerate(exclude):
        values = dict(_excluded(number, item, names, mistakes)) if isinstance(item, dict) else {}
        if not any(_has(own, values) for own, _ in parsed) and not mistakes:
            hint = "write values that occur together in `matrix` or `cases`"
            add(mistakes, ("exclude", number), InputError("SD104", "no combination has these values", hint))
        left = [pair for pair in left if not _has(pair[0], values)] if values else left
    if not left:
        add(
            mistakes,
            ("exclude",),
            InputError("SD104", "`exclude` removes all combinations", "exclude fewer combinations"),
        )
    return [each for _, each in left] or made[:1]


def _value(written: Plain) -> "Value | None":
    return None if written is None else value_of(written)


def _has(values: Mapping[str, "Value | None"], wanted: Mapping[str, "Value"]) -> bool:
    return all(values[name] == value for name, value in wanted.items())


def _excluded(
    number: int, item: Mapping[str, Plain], names: frozenset[str], mistakes: Mistakes
) -> Iterator[tuple[str, "Value"]]:
    """Yield the variables of an item of `exclude`, each with its value."""
    for name, written in item.items():
        try:
            if name not in names:
                raise _unknown("SD109", name, sorted(names))
            yield name, value_of(written)
        except InputError as mistake:
            add(mistakes, ("exclude", number, name), mistake)


# --- names ------------------------------------------------------------------------------------------------------------


def check_name(name: str, used_names: Iterable[str] = (), where: str = "") -> None:
    """Raise InputError if a name is invalid, or used already `where` the names in used_names are defined."""
    if not VARIABLE.fullmatch(name):
        raise InvalidNameError(
            "SD109",
            f"'{name}' is not a valid name of a variable",
            "begin with a letter, then use letters, digits and _",
        )
    if name in UNITS.keys() - ALSO_VARIABLES or name in FUNCTIONS or name == "pi":
        raise InvalidNameError(
            "SD109",
            f"'{name}' {_meaning(name)} in expressions, and cannot be the name of a variable",
            "use another name",
        )
    if name in used_names:
        raise _taken(name, where)


def _taken(name: str, where: str) -> InputError:
    return InvalidNameError("SD109", f"'{name}' is already a variable of {where}", "use another name")


def _meaning(name: str) -> str:
    """Describe the fixed meaning of a name in expressions."""
    if name == "pi":
        return "is a constant"
    return "is a unit" if name in UNITS else "is a function"


def add(mistakes: Mistakes, path: KeyPath, mistake: InputError) -> None:
    """Record a mistake in the value, or the key, at a path."""
    mistakes[path, mistake.message] = mistake.with_traceback(None)  # frees the frames and their objects


# `repeat: {i: 1 .. 18}`: repeats a brick, a step, an impact or a claim for each combination of its variables.
#
# Repeats are expanded in each variant before expressions, so that all later stages see a plain list, with the place of
# every value in the original file.


REPEAT: Final = "repeat"
REPEATABLE: Final = (
    "build",
    "impacts",
    "loads",
    "supports",
    "ties",
    "expect",
    "truth",
)  # lists of repeatable items, besides `bricks` of a step
MAX_REPEATS: Final = 20_000  # combinations of the variables of one item
MAX_SPREAD: Final = 200_000  # values from all repeats of a scenario; a second, and some hundred megabytes


class TooMuchError(Exception):
    """The scenario is too large to be expanded in time."""

    def __init__(self, path: KeyPath, message: str) -> None:
        super().__init__(message)
        self.path, self.message = path, message


@dataclass(slots=True)
class Budget:
    """Number of values that repeats may still make, in all variants together."""

    spread: int = MAX_SPREAD


@dataclass(frozen=True, slots=True)
class ExpandedScenario:
    """A scenario with its repeats expanded."""

    source: Source
    scopes: Mapping[KeyPath, "Names"] = field(default_factory=dict)  # variables of each repetition, by path
    mistakes: Mistakes = field(default_factory=dict)  # at paths of the expanded source


def expand_repeats(source: Source, names: "Names", budget: Budget) -> ExpandedScenario:
    """Expand the repeats of a scenario; `names` are its other variables. Raises TooMuchError."""
    repeating = [key for key in REPEATABLE if _repeats(source.values.get(key))]
    if not repeating:
        return ExpandedScenario(source)
    places = PlaceBuilder()
    places.keep(source, {(key,): None for key in repeating})
    expansion = _Expansion(source, budget, names, places)
    values = dict(source.values)
    for key in repeating:
        places.note(source, (key,), (key,))
        values[key] = expansion.list_of(values[key], (key,), (key,), _Scope(names))
    expanded = replace(source, values=values, value_spans=places.value_spans, key_spans=places.key_spans)
    return ExpandedScenario(expanded, expansion.scopes, expansion.mistakes)


def _repeats(items: Plain) -> bool:
    """Return whether an item of a list, or of `bricks` in it, has the key `repeat`."""
    if not isinstance(items, list):
        return False
    mappings = [item for item in items if isinstance(item, dict)]
    return any(REPEAT in item or _repeats(item.get("bricks")) for item in mappings)


@dataclass(slots=True)
class _Scope:
    """Variables of one repetition."""

    names: "Names"
    label: str = ""  # such as `i = 3`


@dataclass(slots=True)
class _Expansion:
    """Expands the repeats of one variant. Methods take the path of a value in the file and in the expansion."""

    source: Source
    budget: Budget
    scenario_names: "Names"
    places: PlaceBuilder
    scopes: dict[KeyPath, "Names"] = field(default_factory=dict)
    mistakes: Mistakes = field(default_factory=dict)

    def list_of(self, items: Plain, old: KeyPath, new: KeyPath, scope: _Scope) -> Plain:
        """Return a list with its items repeated."""
        if not isinstance(items, list):
            return self.copy(items, old, new, scope)
        items_: list[Plain] = []
        for index, item in enumerate(items):
            if isinstance(item, dict) and REPEAT in item:
                items_ += self._repeated(item, (*old, index), (*new, len(items_)), scope)
            else:
                items_.append(self.copy(item, (*old, index), (*new, len(items_)), scope))
        return items_

    def copy(self, value: Plain, old: KeyPath, new: KeyPath, scope: _Scope) -> Plain:
        """Return a value, and record its places in the file for its path in the expansion."""
        self.budget.spread -= 1
        if self.budget.spread < 0:
            message = f"the repetitions expand to more than {MAX_SPREAD} values, counted over all variants"
            raise TooMuchError(old, message)
        self.places.note(self.source, old, new, scope.label)
        if isinstance(value, dict):
            return {key: self._member(key, member, (*old, key), (*new, key), scope) for key, member in value.items()}
        if isinstance(value, list):
            return [self.copy(item, (*old, i), (*new, i), scope) for i, item in enumerate(value)]
        return value

    def _member(self, key: str, member: Plain, old: KeyPath, new: KeyPath, scope: _Scope) -> Plain:
        if (
            key == "bricks"
            and len(old) == len(("build", 0, "bricks"))
            and old[0] == "build"
            and isinstance(member, list)
        ):
            self.places.note(self.source, old, new, scope.label)
            return self.list_of(member, old, new, scope)
        return self.copy(member, old, new, scope)

    def _repeated(self, item: dict[str, Plain], old: KeyPath, new: KeyPath, scope: _Scope) -> Iterator[Plain]:
        rest = {key: value for key, value in item.items() if key != REPEAT}
        first, start = int(new[-1]), new[:-1]
        for number, (own, label) in enumerate(self._repetitions(item[REPEAT], old, new, scope.names)):
            place = (*start, first + number)
            inner = _Scope(inner_names(own, scope.names), ", ".join(filter(None, [scope.label, label])))
            self.scopes[place] = own
            written, sources = rest, dict[str, str]()
            if old[0] == "impacts" and number and "every" in rest:
                written, sources = _following(rest, first + number)
            copied = self.copy(written, old, place, inner)
            for key, other in sources.items():  # added keys have the place of the key that they come from
                self.places.note(self.source, (*old, other), (*place, key), inner.label)
            yield copied

    def _repetitions(self, loops: Plain, old: KeyPath, new: KeyPath, names: "Names") -> Iterator[tuple["Names", str]]:
        """Yield variables and label of each repetition; for a mistaken loop a single one, with unknown values."""
        before = len(self.mistakes)
        written = loops if isinstance(loops, dict) and loops else {}
        if not written:
            self._wrong(
                old,
                new,
                InputError(
                    "SD103",
                    f"expected variables and their values, not {shown(loops)}",
                    "write, for example, {i: 1 .. 18}",
                ),
            )
        rows = {
            name: self._row(name, row, (*old, REPEAT, name), (*new, REPEAT, name), names)
            for name, row in written.items()
        }
        count = prod(len(row) for row in rows.values())
        if count > MAX_REPEATS:
            self._wrong(
                old,
                new,
                InputError(
                    "SD206",
                    f"`repeat` yields more than the maximum of {MAX_REPEATS} repetitions",
                    "write fewer values",
                ),
            )
        if len(self.mistakes) > before:
            yield dict.fromkeys(rows), ""
            return
        for values in product(*rows.values()):
            label = ", ".join(f"{name} = {text}" for name, (text, _) in zip(rows, values, strict=True))
            yield {name: value for name, (_, value) in zip(rows, values, strict=True)}, label

    def _row(
        self, name: str, row: Plain, old: KeyPath, new: KeyPath, names: "Names"
    ) -> list[tuple[str, "Value | None"]]:
        """Return the values of one variable, each as text and parsed."""
        try:
            check_name(name, names, "the scenario" if name in self.scenario_names else "an outer `repeat`")
            written = [
                interpolate(value, names) if isinstance(value, str) and "${" in value else value
                for value in (row if isinstance(row, list) else [row])
            ]
            values = values_of(written if isinstance(row, list) else written[0], MAX_REPEATS)
            return [(str(value), value_of(value, names)) for value in values]
        except InputError as mistake:
            self.places.note(self.source, old, new)
            add(self.mistakes, new, mistake)
        except EarlierInputError:
            self.places.note(self.source, old, new)
            add(self.mistakes, new, _SILENT)
        return [("", None)]

    def _wrong(self, old: KeyPath, new: KeyPath, mistake: InputError) -> None:
        self.places.note(self.source, (*old, REPEAT), (*new, REPEAT))
        add(self.mistakes, (*new, REPEAT), mistake)


_SILENT: Final = InputError("", "")  # follows from a mistake that is reported elsewhere


def _following(item: dict[str, Plain], number: int) -> tuple[dict[str, Plain], dict[str, str]]:
    """Return an impact after the first of a repeat with `every`, and the source keys of its added keys.

    The impact begins the time `every` after the impact before it.
    """
    rest = {key: value for key, value in item.items() if key not in ("at", "after", "every")}
    return {**rest, "after": f"impact {number} + {item['every']}"}, {"after": "every"}
