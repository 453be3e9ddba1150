"""The variants of a scenario: one for each combination of values, with `let:`, repeats and expressions evaluated."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from stackdsl.diagnostics import Diagnostic, capped, reading_order
from stackdsl.language.distributions import Distribution, Inline, Pick, distributions, is_inline, middle, named, subject
from stackdsl.language.expressions import (
    EarlierInputError,
    inner_names,
    interpolate,
    meant_expression,
    value_of,
    variables_in,
)
from stackdsl.language.quantities import InputError
from stackdsl.language.repeats import (
    REPEAT,
    Budget,
    Combination,
    InvalidNameError,
    Mistakes,
    TooMuchError,
    add,
    check_name,
    combinations_of,
    expand_repeats,
    names_in,
)
from stackdsl.language.yaml.includes import definitions_of
from stackdsl.language.yaml.source import KeyPath, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.expressions import Names, Value

CHOOSING: Final = ("matrix", "cases", "exclude")
FIXED: Final = ("scenario", "let", "uncertain", *CHOOSING)  # keys whose expressions are not evaluated with the rest
FRICTION: Final = "friction"  # the only key that can be fixed like a variable
NOTHING_FIXED: Final[Mapping[str, Plain]] = {}
UNDER: Final = "write the distribution under `uncertain`, or directly in place of a value"
MAX_EXPRESSIONS: Final = 20_000  # of all variants together; some seconds of arithmetic
_DECIMAL = re.compile(r"(?<!\w)(?<!\d\.)\d+\.\d+(?:[eE][+-]?\d+)?")  # does not match in a name such as L3.2


@dataclass(frozen=True, slots=True)
class Variant:
    """A scenario with its variables filled in."""

    parameters: tuple[tuple[str, str], ...]  # values that identify the variant, as written
    values: dict[str, Plain]  # with expressions evaluated
    source: Source  # with repeats expanded, expressions as written: the places of all values
    written: Source  # with repeats and expressions as written
    choice: Mapping[str, Plain]  # values of its combination, as written


def expand(source: Source) -> tuple[tuple[Variant, ...], tuple[Diagnostic, ...]]:
    """Return one variant for each combination, in the order of the file, and the mistakes in all expressions.

    A value whose expression has a mistake stays as written, so that the rest of its variant can still be validated.
    """
    choices = combinations_of(source.values)
    mistakes_by_source = [(source, choices.mistakes)]
    work = len(choices.all) * sum(map(_expressions, source.values.values()))
    if work > MAX_EXPRESSIONS:
        return (), (_too_many(source, f"the variants have {work} expressions in total"),)
    budget, variants, left = Budget(), [], MAX_EXPRESSIONS
    try:
        for choice in choices.all:
            variant, mistakes, done = _variant(source, choice, budget, left)
            variants.append(variant)
            mistakes_by_source.append((variant.source, mistakes))
            left -= done
    except TooMuchError as error:
        span = source.key_span_of(error.path)
        return (), (Diagnostic("SD206", span, error.message, "split it into several scenarios"),)
    mistaken = any(mistakes for _, mistakes in mistakes_by_source)
    diagnostics = diagnostics_of(mistakes_by_source) if mistaken else _unused(source)
    return tuple(variants), tuple(sorted(capped(diagnostics), key=reading_order))


def _too_many(source: Source, cause: str) -> Diagnostic:
    key = next((key for key in CHOOSING if key in source.values), "build")
    message = f"{cause}; the maximum is {MAX_EXPRESSIONS}"
    return Diagnostic("SD206", source.key_span_of((key,)), message, "split it into several scenarios")


def _expressions(value: Plain) -> int:
    """Return the number of expressions in a value."""
    if isinstance(value, dict | list):
        return sum(map(_expressions, value.values() if isinstance(value, dict) else value))
    return value.count("${") if isinstance(value, str) else 0


def repeated(written: Plain, filled: Plain) -> Plain:
    """Return a value of a variant for a report: computed numbers with six digits, the rest as written."""
    if isinstance(written, dict) and isinstance(filled, dict):
        return {key: repeated(written[key], member) for key, member in filled.items()}
    if isinstance(written, list) and isinstance(filled, list):
        return [repeated(*pair) for pair in zip(written, filled, strict=True)]
    if not isinstance(written, str) or "${" not in written:
        return filled
    if isinstance(filled, str):
        return _DECIMAL.sub(lambda match: f"{float(match[0]):.6g}", filled)
    return float(f"{filled:.6g}") if isinstance(filled, float) else filled


def diagnostics_of(mistakes_by_source: Iterable[tuple[Source, Mistakes]]) -> Iterable[Diagnostic]:
    """Yield the diagnostics of the mistakes in each source; a mistake that several variants share only once."""
    reported: set[tuple[KeyPath, str]] = set()
    for source, mistakes in mistakes_by_source:
        for (path, message), mistake in mistakes.items():
            if mistake.code and (path, message) not in reported:  # without a code it follows from another mistake
                reported.add((path, message))
                span = source.key_span_of(path) if isinstance(mistake, InvalidNameError) else source.span_of(path)
                yield Diagnostic(mistake.code, span, message, mistake.hint)


# --- one variant ------------------------------------------------------------------------------------------------------


def resampled(variant: Variant, pick: Pick, fixed: Mapping[str, Plain] = NOTHING_FIXED) -> tuple[Variant, Mistakes]:
    """Return a variant with other values of its random variables, and the mistakes that these values cause.

    `fixed` sets the values of variables, no matter where they are defined, and of the key `friction`.
    """

    def picked(name: str, each: Distribution) -> Plain:
        return fixed[name] if name in fixed else pick(name, each)

    values = variant.written.values
    choice = Combination({name: fixed.get(name, value) for name, value in variant.choice.items()}, variant.parameters)
    source = variant.written
    if FRICTION in fixed and FRICTION not in variables_of(variant):
        source = replace(source, values={**values, FRICTION: fixed[FRICTION]})
    let = values.get("let")
    if isinstance(let, dict) and fixed.keys() & let.keys():
        own = {name: fixed.get(name, value) for name, value in let.items()}
        source = replace(source, values={**source.values, "let": own})
    made, mistakes, _ = _variant(source, choice, Budget(), MAX_EXPRESSIONS, picked)
    return made, mistakes


def variables_of(variant: Variant) -> tuple[str, ...]:
    """Return the names of all variables of a variant, without those of repeats."""
    rows = (variant.choice, *(variant.written.values.get(key) for key in ("uncertain", "let")))
    return tuple(name for row in rows if isinstance(row, Mapping) for name in row)


def _variant(
    source: Source, choice: Combination, budget: Budget, most: int, pick: Pick = middle
) -> tuple[Variant, Mistakes, int]:
    """Return the variant of a combination, its mistakes at paths of its source, and its number of expressions.

    `pick` chooses the values of random variables: the nominal ones by default.
    """
    rows: dict[str, Value | None] = {
        name: None if written is None else value_of(written) for name, written in choice.values.items()
    }
    rows |= dict.fromkeys(_misplaced(source.values))
    filling = _Filling(most)
    if "uncertain" in source.values:
        uncertain = distributions(source.values["uncertain"], rows, filling.mistakes)
        values = {name: pick(name, each) for name, each in named(uncertain)}
        rows |= dict.fromkeys(uncertain) | {name: value_of(value) for name, value in values.items()}
    names, lets = _let(source.values.get("let", {}), rows, filling)
    _check_fixed(source, filling.mistakes)
    expanded = expand_repeats(source, names, budget)
    filling.mistakes |= expanded.mistakes
    filling.scopes = expanded.scopes
    values = expanded.source.values
    filled = {key: filling.of(value, (key,), names) for key, value in values.items() if key not in FIXED}
    inline = Inline(pick, filling.mistakes)
    changed = {key: inline.of(value, (key,)) for key, value in filled.items()}
    changed |= {"let": lets} if "let" in values else {}
    if inline.found and "samples" in values:
        named_variables = values.get("uncertain")
        unnamed: dict[str, Plain] = {subject(path): written for path, written in inline.found.items()}
        changed["uncertain"] = {**(named_variables if isinstance(named_variables, dict) else {}), **unnamed}
    else:
        filling.mistakes |= {(path, mistake.message): mistake for path, mistake in inline.without_samples()}
    return (
        Variant(choice.identity, values | changed, expanded.source, source, choice.values),
        filling.mistakes,
        filling.done,
    )


def _misplaced(values: Mapping[str, Plain]) -> Iterable[str]:
    """Return the variables under a misspelt key, such as `matrixx`, which validation reports."""
    from stackdsl.language.schema import models  # noqa: PLC0415 -- it imports all layouts and claims

    unknown = values.keys() - {field.alias or key for key, field in models().Scenario.model_fields.items()}
    return [name for key in unknown for name in names_in(values[key])]


def _check_fixed(source: Source, mistakes: Mistakes) -> None:
    """Reject a scenario name that varies, and `every` of an impact without `repeat`."""
    name = source.values.get("scenario")
    if isinstance(name, str) and "${" in name:
        hint = "write a fixed name; the values of `matrix` and `cases` distinguish the variants"
        add(
            mistakes,
            ("scenario",),
            InputError("SD109", "the name of a scenario cannot contain expressions", hint),
        )
    impacts = source.values.get("impacts")
    for number, impact in enumerate(impacts if isinstance(impacts, list) else ()):
        if isinstance(impact, dict) and "every" in impact and REPEAT not in impact:
            message = "`every` is the time between repetitions, but this impact has no `repeat`"
            add(
                mistakes,
                ("impacts", number, "every"),
                InvalidNameError(
                    "SD102", message, "add, for example, `repeat: {i: 1 .. 3}`, or use `at` in place of `every`"
                ),
            )


def _let(let: Plain, rows: "Names", filling: "_Filling") -> tuple["Names", Plain]:
    """Return all variables, and `let` with its expressions evaluated."""
    if not isinstance(let, dict):
        add(
            filling.mistakes,
            ("let",),
            InputError("SD103", "expected a mapping of variables to values", "write, for example, {length: 120 mm}"),
        )
        return {**rows, **dict.fromkeys(names_in(let))}, let
    names, lets = dict(rows), dict(let)
    for name, written in let.items():
        filled = filling.of(written, ("let", name), names)
        names[name], lets[name] = None, filled
        try:
            check_name(name, rows, "the matrix")
            if is_inline(filled):
                raise InputError("SD109", f"'{filled}' is a distribution, which `let` cannot define", UNDER)
            if not (isinstance(filled, str) and "${" in filled):
                names[name] = value_of(filled, names)
        except InputError as mistake:
            add(filling.mistakes, ("let", name), mistake)
    return names, lets


@dataclass(slots=True)
class _Filling:
    """Evaluates expressions, and collects their mistakes."""

    most: int  # expressions that may be evaluated
    scopes: Mapping[KeyPath, "Names"] = field(default_factory=dict)  # variables of repetitions, by path
    mistakes: Mistakes = field(default_factory=dict)
    done: int = 0  # expressions evaluated so far

    def of(self, value: Plain, path: KeyPath, names: "Names") -> Plain:
        """Return a value with its expressions evaluated; those with mistakes stay as written."""
        if path in self.scopes:
            names = inner_names(self.scopes[path], names)
        if isinstance(value, dict):
            return {key: self.of(member, (*path, key), names) for key, member in value.items()}
        if isinstance(value, list):
            return [self.of(item, (*path, index), names) for index, item in enumerate(value)]
        if not isinstance(value, str) or "${" not in value:
            return value
        self.done += value.count("${")
        if self.done > self.most:
            message = f"the variants and their repetitions have more than {MAX_EXPRESSIONS} expressions in total"
            raise TooMuchError(path[:1], message)
        try:
            return interpolate(value, names)
        except InputError as mistake:
            add(self.mistakes, path, mistake)
        except EarlierInputError:
            pass
        return value


# --- unused variables and kinds of bricks -----------------------------------------------------------------------------


KINDS: Final = "brick_types"
PROSE: Final = ("scenario", "description", "tags")  # keys whose words name nothing


def _unused(source: Source) -> Iterable[Diagnostic]:
    """Yield variables that nothing uses, except the one that names the cases."""
    definitions = [path for path in definitions_of(source.values) if path[0] != KINDS]
    names = {str(path[-1]) for path in definitions}
    texts = _texts({key: value for key, value in source.values.items() if key not in (*CHOOSING, *PROSE)})
    used = {name for text in texts for name in variables_in(meant_expression(text, names) or text)}
    naming = next((path for path in definitions if path[0] == "cases"), None)
    for path in definitions:
        name = str(path[-1])
        if name not in used and path not in source.inherited and path != naming:
            message = f"the variable '{name}' is unused"
            yield Diagnostic("SD112", source.key_span_of(path), message, f"use it as ${{{name}}}, or remove it")


def unused_kinds(source: Source, variants: Iterable[Variant]) -> Iterable[Diagnostic]:
    """Yield the kinds of bricks that no variant of a valid scenario uses."""
    defined = [path for path in definitions_of(source.values) if path[0] == KINDS and path not in source.inherited]
    used = set(_words([source.values, *(variant.values for variant in variants)])) if defined else set()
    for path in defined:
        if (name := str(path[-1])) not in used:
            message = f"the kind of brick '{name}' is unused"
            yield Diagnostic("SD112", source.key_span_of(path), message, f"use it as `brick: {name}`, or remove it")


def _words(documents: Iterable[Mapping[str, Plain]]) -> Iterable[str]:
    """Yield the words of documents that may name a kind of brick."""
    for values in documents:
        for text in _texts({key: value for key, value in values.items() if key not in (*PROSE, KINDS)}):
            yield from re.findall(r"[\w.-]+", text)


def _texts(value: Plain) -> Iterable[str]:
    if isinstance(value, dict | list):
        for member in value.values() if isinstance(value, dict) else value:
            yield from _texts(member)
    elif isinstance(value, str):
        yield value
