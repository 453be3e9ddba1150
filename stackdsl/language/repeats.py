"""Expands `repeat:`, `matrix:`, `cases:` and `exclude:`."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final, TypeAlias

from stackdsl.diagnostics import did_you_mean
from stackdsl.language.expressions import (
    FUNCTIONS,
    VARIABLE,
    EarlierMistakeError,
    inner_names,
    interpolate,
    told_apart,
    value_of,
    values_of,
)
from stackdsl.language.quantities import UNITS, MistakeError, shown
from stackdsl.language.yaml.source import KeyPath, PlaceBuilder, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.expressions import Names, Value


# Which combinations of values a scenario is played with: `matrix:`, `cases:` and `exclude:`.


MAX_VARIANTS: Final = 256
_FEWER: Final = f"write at most {MAX_VARIANTS}, or make several scenarios of it"

# A mistake may turn up once a variant: where it is and what it says make it one.
Mistakes: TypeAlias = dict[tuple[KeyPath, str], MistakeError]


class NameMistakeError(MistakeError):
    """The name of a variable is at fault, not its value."""


@dataclass(frozen=True, slots=True)
class Combination:
    """One combination: the value of each variable, as written; None where that is mistaken."""

    values: Mapping[str, Plain]
    called: tuple[tuple[str, str], ...]  # the variables that tell it from the others, each with its value as written


@dataclass(frozen=True, slots=True)
class Combinations:
    """All combinations, in the author's order."""

    all: tuple[Combination, ...]
    names: frozenset[str] = frozenset()  # of the variables
    mistakes: Mistakes = field(default_factory=dict)


def combinations_of(values: Mapping[str, Plain]) -> Combinations:
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
        return Combinations((Combination(dict.fromkeys(names), ()),), names, mistakes)
    made = [_choice(case, dict(zip(rows, row, strict=True))) for case in cases for row in product(*rows.values())]
    kept = _kept(made, values.get("exclude"), names, mistakes)
    return Combinations(tuple(kept), names, mistakes)


def _choice(case: Mapping[str, Plain], row: Mapping[str, Plain]) -> Combination:
    first = next(iter(case), None)
    told = {**({} if first is None else {first: case[first]}), **row}
    called = tuple((name, str(written)) for name, written in told.items() if written is not None)
    return Combination({**case, **row}, called)


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
    path: KeyPath = ("matrix", name)
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
        path: KeyPath = ("cases", number, name)
        try:
            if name not in first:
                raise _unknown("SD101", name, tuple(first), "give it to all cases")
            check_name(name)
            value_of(written)
        except MistakeError as mistake:
            add(mistakes, path, mistake)


def _unknown(code: str, name: str, known: Sequence[str], otherwise: str = "") -> MistakeError:
    return NameMistakeError(code, f"unknown variable '{name}'", lambda: did_you_mean(name, known) or otherwise)


def _kept(made: list[Combination], exclude: Plain, names: frozenset[str], mistakes: Mistakes) -> list[Combination]:
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


def add(mistakes: Mistakes, path: KeyPath, mistake: MistakeError) -> None:
    """Note a mistake of the value, or the key, at a path."""
    mistakes[path, mistake.message] = mistake.with_traceback(None)  # whose frames would keep all that they knew


# `repeat: {i: 1 .. 18}`: a brick, a step, an impact or a claim as often as its variables have values.
#
# Done for each variant before anything is worked out, so that all later stages see a list as if it had been written
# out, and the place of every value in the file that it comes from.


REPEAT: Final = "repeat"
REPEATABLE: Final = ("build", "impacts", "expect", "truth")  # lists whose items may be repeated; and those of `bricks`
MAX_REPEATS: Final = 20_000  # of one item, all of its variables together
MAX_SPREAD: Final = 200_000  # values that all repeats of a scenario make; a second, and some hundred megabytes


class TooMuchError(Exception):
    """The scenario is larger than what can be worked out in time."""

    def __init__(self, path: KeyPath, message: str) -> None:
        super().__init__(message)
        self.path, self.message = path, message


@dataclass(slots=True)
class Budget:
    """How much all variants together may still cost."""

    spread: int = MAX_SPREAD


@dataclass(frozen=True, slots=True)
class ExpandedScenario:
    """A scenario with its repeats written out."""

    source: Source
    scopes: Mapping[KeyPath, "Names"] = field(default_factory=dict)  # the variables of each item that was repeated
    mistakes: Mistakes = field(default_factory=dict)  # at paths of the spread source


def expand_repeats(source: Source, names: "Names", budget: Budget) -> ExpandedScenario:
    """The scenario with its repeats written out, given its other variables. Raises TooMuchError."""
    repeating = [key for key in REPEATABLE if _repeats(source.values.get(key))]
    if not repeating:
        return ExpandedScenario(source)
    places = PlaceBuilder()
    places.keep(source, {(key,): None for key in repeating})
    spreading = _Spreading(source, budget, names, places)
    values = dict(source.values)
    for key in repeating:
        places.note(source, (key,), (key,))
        values[key] = spreading.list_of(values[key], (key,), (key,), _Scope(names))
    spread_source = replace(source, values=values, value_spans=places.value_spans, key_spans=places.key_spans)
    return ExpandedScenario(spread_source, spreading.scopes, spreading.mistakes)


def _repeats(items: Plain) -> bool:
    """Whether anything in a list is repeated, or wants to be."""
    if not isinstance(items, list):
        return False
    mappings = [item for item in items if isinstance(item, dict)]
    return any(REPEAT in item or _repeats(item.get("bricks")) for item in mappings)


@dataclass(slots=True)
class _Scope:
    """In which repetition a value stands."""

    names: "Names"
    told: str = ""  # such as `i = 3`


@dataclass(slots=True)
class _Spreading:
    source: Source
    budget: Budget
    taken: "Names"  # the variables of the scenario
    places: PlaceBuilder
    scopes: dict[KeyPath, "Names"] = field(default_factory=dict)
    mistakes: Mistakes = field(default_factory=dict)

    def list_of(self, items: Plain, old: KeyPath, new: KeyPath, scope: _Scope) -> Plain:
        """A list with its items as often as they say."""
        if not isinstance(items, list):
            return self.copy(items, old, new, scope)
        made: list[Plain] = []
        for index, item in enumerate(items):
            if isinstance(item, dict) and REPEAT in item:
                made += self._repeated(item, (*old, index), (*new, len(made)), scope)
            else:
                made.append(self.copy(item, (*old, index), (*new, len(made)), scope))
        return made

    def copy(self, value: Plain, old: KeyPath, new: KeyPath, scope: _Scope) -> Plain:
        """A value that stands elsewhere, with the places that it comes from."""
        self.budget.spread -= 1
        if self.budget.spread < 0:
            message = f"what is repeated comes to more than {MAX_SPREAD} values in all variants"
            raise TooMuchError(old, message)
        self.places.note(self.source, old, new, scope.told)
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
            self.places.note(self.source, old, new, scope.told)
            return self.list_of(member, old, new, scope)
        return self.copy(member, old, new, scope)

    def _repeated(self, item: dict[str, Plain], old: KeyPath, new: KeyPath, scope: _Scope) -> Iterator[Plain]:
        rest = {key: value for key, value in item.items() if key != REPEAT}
        first, start = int(new[-1]), new[:-1]
        for number, (own, words) in enumerate(self._turns(item[REPEAT], old, new, scope.names)):
            place = (*start, first + number)
            inner = _Scope(inner_names(own, scope.names), ", ".join(filter(None, [scope.told, words])))
            self.scopes[place] = own
            written, sources = rest, dict[str, str]()
            if old[0] == "impacts" and number and "every" in rest:
                written, sources = _following(rest, first + number)
            copied = self.copy(written, old, place, inner)
            for key, other in sources.items():  # what is said once for all that follow
                self.places.note(self.source, (*old, other), (*place, key), inner.told)
            yield copied

    def _turns(self, loops: Plain, old: KeyPath, new: KeyPath, names: "Names") -> Iterator[tuple["Names", str]]:
        """The variables of each repetition, and what is told of them; of a mistaken loop one, with unknown values."""
        before = len(self.mistakes)
        written = loops if isinstance(loops, dict) and loops else {}
        if not written:
            self._wrong(
                old,
                new,
                MistakeError(
                    "SD103", f"expected variables with their values, not {shown(loops)}", "write {i: 1 .. 18}"
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
                MistakeError(
                    "SD206",
                    f"this is repeated more than {MAX_REPEATS} times, which is the most",
                    "repeat it less often",
                ),
            )
        if len(self.mistakes) > before:
            yield dict.fromkeys(rows), ""
            return
        for turn in product(*rows.values()):
            told = ", ".join(f"{name} = {text}" for name, (text, _) in zip(rows, turn, strict=True))
            yield {name: value for name, (_, value) in zip(rows, turn, strict=True)}, told

    def _row(
        self, name: str, row: Plain, old: KeyPath, new: KeyPath, names: "Names"
    ) -> list[tuple[str, "Value | None"]]:
        """The values of one variable, each as written and as it is."""
        try:
            check_name(name, names, "the scenario" if name in self.taken else "an outer `repeat`")
            written = [
                interpolate(each, names) if isinstance(each, str) and "${" in each else each
                for each in (row if isinstance(row, list) else [row])
            ]
            values = values_of(written if isinstance(row, list) else written[0], MAX_REPEATS)
            return [(str(each), value_of(each, names)) for each in values]
        except MistakeError as mistake:
            self.places.note(self.source, old, new)
            add(self.mistakes, new, mistake)
        except EarlierMistakeError:
            self.places.note(self.source, old, new)
            add(self.mistakes, new, _SILENT)
        return [("", None)]

    def _wrong(self, old: KeyPath, new: KeyPath, mistake: MistakeError) -> None:
        self.places.note(self.source, (*old, REPEAT), (*new, REPEAT))
        add(self.mistakes, (*new, REPEAT), mistake)


_SILENT: Final = MistakeError("", "")  # what follows from a mistake that is told elsewhere


def _following(item: dict[str, Plain], number: int) -> tuple[dict[str, Plain], dict[str, str]]:
    """A repeated impact but the first, so long after the one before it; and of a key that is new, which key says so."""
    rest = {key: value for key, value in item.items() if key not in ("at", "after", "every")}
    return {**rest, "after": f"impact {number} + {item['every']}"}, {"after": "every"}
