"""The variants of a scenario: one for each combination of `matrix:`, with `let:` and all expressions worked out."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Final, TypeAlias

from stackdsl.diagnostics import Diagnostic, reading_order
from stackdsl.language.expressions import FUNCTIONS, VARIABLE, EarlierMistakeError, constant, interpolate
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.quantities import UNITS
from stackdsl.reading.source import Path, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.expressions import Names

# A mistake may turn up once a variant: where it is and what it says make it one.
Mistakes: TypeAlias = dict[tuple[Path, str], MistakeError]

FIXED: Final = ("scenario", "let", "matrix")  # what is not filled in like the rest
MAX_VARIANTS: Final = 256
MAX_EXPRESSIONS: Final = 20_000  # of all variants together; some seconds of arithmetic
_DECIMAL = re.compile(r"(?<!\w)(?<!\d\.)\d+\.\d+(?:[eE][+-]?\d+)?")  # but not the 3.2 of a brick L3.2


class _NameError(MistakeError):
    """The name of a variable is at fault, not its value."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A scenario with its variables filled in."""

    parameters: tuple[tuple[str, str], ...]  # the choice from each row of `matrix`, as written
    values: dict[str, Plain]


def expand(source: Source) -> tuple[tuple[Variant, ...], tuple[Diagnostic, ...]]:
    """One variant for each combination of `matrix`, in the author's order, and the mistakes of all expressions.

    A value whose expression is mistaken stays as written, so that the rest of its variant can still be validated.
    """
    axes, mistakes = _axes(source.values.get("matrix", {}))
    work = prod(len(row) for row in axes.values()) * sum(map(_expressions, source.values.values()))
    if work > MAX_EXPRESSIONS:
        message = f"the variants have {work} expressions in all, and {MAX_EXPRESSIONS} is the most"
        return (), (Diagnostic("SD206", source.key_span_of(("matrix",)), message, "make several scenarios of it"),)
    variants = []
    for choice in product(*axes.values()):
        variant, more = _variant(source.values, dict(zip(axes, choice, strict=True)))
        variants.append(variant)
        mistakes |= more
    found = {_diagnostic(source, path, mistake) for (path, _), mistake in mistakes.items()}
    return tuple(variants), tuple(sorted(found, key=reading_order))


def _expressions(value: Plain) -> int:
    """How many texts with expressions there are in a value."""
    if isinstance(value, dict | list):
        return sum(map(_expressions, value.values() if isinstance(value, dict) else value))
    return isinstance(value, str) and "${" in value


def compact(text: str) -> str:
    """A value of the matrix as it stands in the name of a case."""
    return "".join(text.split())


def repeated(written: Plain, filled: Plain) -> Plain:
    """A value of a variant for people to read: the numbers of its expressions in six digits, the rest as written."""
    if isinstance(written, dict) and isinstance(filled, dict):
        return {key: repeated(written[key], member) for key, member in filled.items()}
    if isinstance(written, list) and isinstance(filled, list):
        return [repeated(*pair) for pair in zip(written, filled, strict=True)]
    if not isinstance(written, str) or "${" not in written:
        return filled
    if isinstance(filled, str):
        return _DECIMAL.sub(lambda match: f"{float(match[0]):.6g}", filled)
    return float(f"{filled:.6g}") if isinstance(filled, float) else filled


def _diagnostic(source: Source, path: Path, mistake: MistakeError) -> Diagnostic:
    span = source.key_span_of(path) if isinstance(mistake, _NameError) else source.span_of(path)
    return Diagnostic(mistake.code, span, mistake.message, mistake.hint)


def _variant(values: dict[str, Plain], choice: dict[str, Plain]) -> tuple[Variant, Mistakes]:
    """One combination of the matrix, filled in; a row that is mistaken has the value None."""
    rows = {name: None if written is None else constant(written) for name, written in choice.items()}
    names, lets, mistakes = _let(values.get("let", {}), rows)
    name = values.get("scenario")
    if isinstance(name, str) and "${" in name:
        fixed = MistakeError(
            "SD109", "the name of a scenario cannot vary", "variants are told apart by their values of the matrix"
        )
        mistakes |= _at(("scenario",), fixed)
    body = {key: value for key, value in values.items() if key not in FIXED}
    filled = {key: _filled(value, (key,), names) for key, value in body.items()}
    found = _merged(found for _, found in filled.values())
    changed = {"let": lets, **{key: value for key, (value, _) in filled.items()}}
    parameters = tuple((name, str(written)) for name, written in choice.items() if written is not None)
    return Variant(parameters, {key: changed.get(key, value) for key, value in values.items()}), mistakes | found


def _axes(matrix: Plain) -> tuple[dict[str, list[Plain]], Mistakes]:
    """The rows of `matrix`; a mistaken one has the single value None."""
    if not isinstance(matrix, dict):
        return {}, _at(("matrix",), MistakeError("SD103", "expected a mapping", "write {step: [10 mm, 12 mm]}"))
    found = {name: _row_mistakes(name, row) for name, row in matrix.items()}
    mistakes = _merged(found.values())
    axes: dict[str, list[Plain]] = {
        name: row if isinstance(row, list) and not found[name] else [None] for name, row in matrix.items()
    }
    count = 1
    for row in axes.values():
        count *= len(row)
        if count > MAX_VARIANTS:  # told without the number, which may have thousands of digits
            message = f"the matrix has more than {MAX_VARIANTS} combinations, which are the most"
            return {name: [None] for name in axes}, mistakes | _at(
                ("matrix",), MistakeError("SD206", message, "make several scenarios of it")
            )
    return axes, mistakes


def _row_mistakes(name: str, row: Plain) -> Mistakes:
    path: Path = ("matrix", name)
    try:
        _check_name(name)
    except MistakeError as mistake:
        return _at(path, mistake)
    if not isinstance(row, list) or not row:
        return _at(path, MistakeError("SD103", "expected a list of values", "write [10 mm, 12 mm]"))
    mistakes: Mistakes = {}
    seen: set[Plain] = set()  # values, and what they are in the name of a case
    for index, written in enumerate(row):
        try:
            constant(written)
            if written in seen or compact(str(written)) in seen:
                raise MistakeError("SD104", f"{shown(written)} is in the row already", "write each value once")
            seen |= {written, compact(str(written))}
        except MistakeError as mistake:
            mistakes |= _at((*path, index), mistake)
    return mistakes


def _let(let: Plain, rows: "Names") -> tuple["Names", Plain, Mistakes]:
    """All variables; `let` with their values in place of its expressions; and its mistakes."""
    if not isinstance(let, dict):
        return rows, let, _at(("let",), MistakeError("SD103", "expected a mapping", "write {length: 120 mm}"))
    names, lets, mistakes = dict(rows), dict(let), _merged(())
    for name, written in let.items():
        filled, found = _filled(written, ("let", name), names)
        names[name], lets[name] = None, filled
        try:
            _check_name(name, rows)
            if not (isinstance(filled, str) and "${" in filled):
                names[name] = constant(filled)
        except MistakeError as mistake:
            found |= _at(("let", name), mistake)
        mistakes |= found
    return names, lets, mistakes


def _check_name(name: str, taken: Iterable[str] = ()) -> None:
    if not VARIABLE.fullmatch(name):
        raise _NameError("SD109", f"'{name}' cannot name a variable", "write letters, digits and _, a letter first")
    if name in UNITS or name in FUNCTIONS or name == "pi":
        raise _NameError("SD109", f"'{name}' {_meaning(name)}, and cannot name a variable", "take another name")
    if name in taken:
        raise _NameError("SD109", f"'{name}' is a variable of the matrix already", "take another name")


def _meaning(name: str) -> str:
    """What a name means in every expression."""
    if name == "pi":
        return "is a number"
    return "is a unit" if name in UNITS else "is a function"


def _filled(value: Plain, path: Path, names: "Names") -> tuple[Plain, Mistakes]:
    """A value with its expressions worked out, save those with mistakes."""
    if isinstance(value, dict):
        members = {key: _filled(member, (*path, key), names) for key, member in value.items()}
        return {key: member for key, (member, _) in members.items()}, _merged(found for _, found in members.values())
    if isinstance(value, list):
        items = [_filled(item, (*path, index), names) for index, item in enumerate(value)]
        return [item for item, _ in items], _merged(found for _, found in items)
    if not isinstance(value, str) or "${" not in value:
        return value, {}
    try:
        return interpolate(value, names), {}
    except MistakeError as mistake:
        return value, _at(path, mistake)
    except EarlierMistakeError:
        return value, {}


def _at(path: Path, mistake: MistakeError) -> Mistakes:
    return {(path, mistake.message): mistake}


def _merged(many: Iterable[Mistakes]) -> Mistakes:
    return {key: mistake for mistakes in many for key, mistake in mistakes.items()}
