"""`repeat: {i: 1 .. 18}`: a brick, a step, an impact or a claim as often as its variables have values.

Done for each variant before anything is worked out, so that all later stages see a list as if it had been written out,
and the place of every value in the file that it comes from.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final

from stackdsl.language.choices import Mistakes, add, check_name
from stackdsl.language.expressions import EarlierMistakeError, interpolate, value_of
from stackdsl.language.inner import Inner
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.ranges import values_of
from stackdsl.reading.places import Places
from stackdsl.reading.source import Path, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.expressions import Names, Value

REPEAT: Final = "repeat"
REPEATABLE: Final = ("build", "impacts", "expect", "truth")  # lists whose items may be repeated; and those of `bricks`
MAX_REPEATS: Final = 20_000  # of one item, all of its variables together
MAX_SPREAD: Final = 200_000  # values that all repeats of a scenario make; a second, and some hundred megabytes


class TooMuchError(Exception):
    """The scenario is larger than what can be worked out in time."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(message)
        self.path, self.message = path, message


@dataclass(slots=True)
class Budget:
    """How much all variants together may still cost."""

    spread: int = MAX_SPREAD


@dataclass(frozen=True, slots=True)
class Spread:
    """A scenario with its repeats written out."""

    source: Source
    scopes: Mapping[Path, "Names"] = field(default_factory=dict)  # the variables of each item that was repeated
    mistakes: Mistakes = field(default_factory=dict)  # at paths of the spread source


def spread(source: Source, names: "Names", budget: Budget) -> Spread:
    """The scenario with its repeats written out, given its other variables. Raises TooMuchError."""
    repeating = [key for key in REPEATABLE if _repeats(source.values.get(key))]
    if not repeating:
        return Spread(source)
    places = Places()
    places.keep(source, {(key,): None for key in repeating})
    spreading = _Spreading(source, budget, names, places)
    values = dict(source.values)
    for key in repeating:
        places.note(source, (key,), (key,))
        values[key] = spreading.list_of(values[key], (key,), (key,), _Scope(names))
    spread_source = replace(source, values=values, value_spans=places.value_spans, key_spans=places.key_spans)
    return Spread(spread_source, spreading.scopes, spreading.mistakes)


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
    places: Places
    scopes: dict[Path, "Names"] = field(default_factory=dict)
    mistakes: Mistakes = field(default_factory=dict)

    def list_of(self, items: Plain, old: Path, new: Path, scope: _Scope) -> Plain:
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

    def copy(self, value: Plain, old: Path, new: Path, scope: _Scope) -> Plain:
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

    def _member(self, key: str, member: Plain, old: Path, new: Path, scope: _Scope) -> Plain:
        if (
            key == "bricks"
            and len(old) == len(("build", 0, "bricks"))
            and old[0] == "build"
            and isinstance(member, list)
        ):
            self.places.note(self.source, old, new, scope.told)
            return self.list_of(member, old, new, scope)
        return self.copy(member, old, new, scope)

    def _repeated(self, item: dict[str, Plain], old: Path, new: Path, scope: _Scope) -> Iterator[Plain]:
        rest = {key: value for key, value in item.items() if key != REPEAT}
        first, start = int(new[-1]), new[:-1]
        for number, (own, words) in enumerate(self._turns(item[REPEAT], old, new, scope.names)):
            place = (*start, first + number)
            inner = _Scope(Inner(own, scope.names), ", ".join(filter(None, [scope.told, words])))
            self.scopes[place] = own
            written, sources = rest, dict[str, str]()
            if old[0] == "impacts" and number and "every" in rest:
                written, sources = _following(rest, first + number)
            copied = self.copy(written, old, place, inner)
            for key, other in sources.items():  # what is said once for all that follow
                self.places.note(self.source, (*old, other), (*place, key), inner.told)
            yield copied

    def _turns(self, loops: Plain, old: Path, new: Path, names: "Names") -> Iterator[tuple["Names", str]]:
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

    def _row(self, name: str, row: Plain, old: Path, new: Path, names: "Names") -> list[tuple[str, "Value | None"]]:
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

    def _wrong(self, old: Path, new: Path, mistake: MistakeError) -> None:
        self.places.note(self.source, (*old, REPEAT), (*new, REPEAT))
        add(self.mistakes, (*new, REPEAT), mistake)


_SILENT: Final = MistakeError("", "")  # what follows from a mistake that is told elsewhere


def _following(item: dict[str, Plain], number: int) -> tuple[dict[str, Plain], dict[str, str]]:
    """A repeated impact but the first, so long after the one before it; and of a key that is new, which key says so."""
    rest = {key: value for key, value in item.items() if key not in ("at", "after", "every")}
    return {**rest, "after": f"impact {number} + {item['every']}"}, {"after": "every"}
