"""Plain values -> a scenario, or all of its errors, each at its place in the file."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Final, NamedTuple, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from stackdsl.diagnostics import Diagnostic, did_you_mean, first_of, reading_order
from stackdsl.entry_points import offered
from stackdsl.language.bricks import known_bricks, laid
from stackdsl.language.distributions import sampled
from stackdsl.language.layouts.registry import place
from stackdsl.language.quantities import EchoError, MistakeError, shown, without_comma
from stackdsl.language.schema import Package, Scenario, is_installed, models
from stackdsl.language.value_types import PROVING
from stackdsl.language.variants import Variant
from stackdsl.language.yaml.source import KeyPath, Plain, Source

# Mistakes between the values of a scenario that are right in themselves.


def disagreements(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """All of them, in no order."""
    for check in (
        _systems_not_played,
        _marks_of_other_systems,
        _unanswerable,
        _unproven_truths,
        _after_a_collapse,
        _impossible_layouts,
        sampled,
    ):
        yield from check(scenario, source)


def _systems_not_played(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, expectation in enumerate(scenario.expect):
        for system in expectation.system or ():
            if system not in scenario.systems:
                message = f"the scenario is not played on '{system}', so this would never be checked"
                hint = f"add it to systems, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of(("expect", index, "system")), message, hint)


def _marks_of_other_systems(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Marks for systems that the scenario is not played on, and of what cannot fail."""
    for key, mark in (("skip", scenario.skip), ("xfail", scenario.xfail)):
        for system in (mark.system if mark is not None else None) or ():
            if system not in scenario.systems:
                message = f"the scenario is not played on '{system}', so this says nothing"
                hint = f"leave it out, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of((key, "system")), message, hint)
    if scenario.xfail is not None and not scenario.expect:
        message = "nothing is expected that could fail"
        yield Diagnostic(
            "SD104", source.key_span_of(("xfail",)), message, "say under `expect` what ought to come of it"
        )


def _unanswerable(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Questions about proofs to systems that prove nothing."""
    for index, expectation in enumerate(scenario.expect):
        asked = [system for system in expectation.system or scenario.systems if system not in PROVING]
        if expectation.stated.needs_statics and asked:
            message = f"`{expectation.kind}` is known to statics alone, and not to '{asked[0]}'"
            span = source.key_span_of(("expect", index, expectation.kind))
            yield Diagnostic("SD104", span, message, f"say `system: {PROVING[0]}`, and name it in `systems`")


def _unproven_truths(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is known of proofs, where no system proves anything."""
    for index, truth in enumerate(scenario.truth):
        if truth.stated.needs_statics and not set(PROVING).intersection(scenario.systems):
            message = f"`{truth.kind}` is known to statics alone, so this would never be compared"
            span = source.key_span_of(("truth", index, truth.kind))
            yield Diagnostic("SD104", span, message, f"add {PROVING[0]} to systems")


def _after_a_collapse(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What is to be built, or done, after a step that goes on until a collapse."""
    for index, step in enumerate(scenario.build[:-1]):
        if step.until is not None:
            message = "nothing is built after a collapse, and this step goes on until there is one"
            yield Diagnostic("SD104", source.span_of(("build", index, "until")), message, "let it be the last step")
    if scenario.impacts and scenario.build[-1].until is not None:
        message = "nothing can be done to a structure that has been built until it fell"
        hint = "say how much is built instead of `until: collapse`, or leave the impacts out"
        yield Diagnostic("SD205", source.key_span_of(("impacts",)), message, hint)


def _impossible_layouts(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, step in enumerate(scenario.build):
        if step.layout is None:
            continue
        name, params = step.layout
        try:
            form = (step.brick or scenario.brick).form
            for spec in place(name, params, form.size):
                laid(form, spec)
        except MistakeError as mistake:
            yield Diagnostic(mistake.code, source.span_of(("build", index, name)), mistake.message, mistake.hint)


# From plain values to a scenario, or to everything that is wrong with them: in plain words, each in its place.


# What pydantic's errors of type wanted.
WANTED: Final = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "model_type": "a mapping",
}
# What pydantic's errors of range say, with the value and pydantic's own terms filled in.
RANGES: Final = {
    "greater_than_equal": "{value} is less than {ge:g}",
    "less_than_equal": "{value} is more than {le:g}",
    "finite_number": "{value} is not a finite number",
    "string_too_short": "the text is empty",
    "string_too_long": "the text is longer than {max_length} characters",
    "too_short": "the list has {actual_length} items, and {min_length} is the least",
    "too_long": "the list has {actual_length} items, and {max_length} is the most",
}

MISWRITTEN: Final = re.compile(r"\$[A-Za-z]\w*|\$?\{[^{}]*\}")  # an expression, as other languages write it
# What the JSON Schema calls limits, and of what they are.
LIMITS: Final = (
    ("minimum", "maximum", ""),
    ("minItems", "maxItems", " items"),
    ("minLength", "maxLength", " characters"),
)


MOST_COMPARED: Final = 20  # unknown keys with one that is missing
MOST_EXPLAINED: Final = 4  # keys of a mapping that is missing
_ITEMS: Final = "begin each item with `- `"


class _Told(NamedTuple):
    """A mistake in plain words."""

    code: str
    message: str
    hint: str = ""


def validate(source: Source, variant: Variant) -> tuple[Scenario | None, tuple[Diagnostic, ...]]:
    """The scenario of a variant, or all of its mistakes in the order of the text.

    Values whose expression `expand` could not work out are passed over in silence, for it has reported them: then the
    scenario may be None without a diagnostic.
    """
    try:
        known = known_bricks(variant.values.get("brick_types"), source.files)
        scenario = models().Scenario.model_validate(variant.values, context=known)
    except ValidationError as error:
        details = _without_echoes(_of_first_repetitions(error.errors(include_url=False), source))
        return None, _in_order(first_of(_diagnostic(source, detail) for detail in details))
    mistakes = _in_order(first_of(disagreements(scenario, source)))
    return (None if mistakes else scenario), mistakes


def mistakes_at(error: ValidationError, source: Source, path: KeyPath) -> tuple[Diagnostic, ...]:
    """The mistakes of a value that is validated by itself, and stands at a path of the source."""
    details = error.errors(include_url=False)
    return _in_order(_diagnostic(source, {**detail, "loc": (*path, *detail["loc"])}) for detail in details)


def _in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(set(diagnostics), key=reading_order))


def _of_first_repetitions(details: Iterable[ErrorDetails], source: Source) -> list[ErrorDetails]:
    """The errors, without those alike of later repetitions: to work out the remedies of thousands takes minutes."""
    first: dict[object, ErrorDetails] = {}
    for detail in details:
        span = source.span_of(detail["loc"])
        place = (span.file, span.line, span.column, detail["loc"][-1:]) if span.where else detail["loc"]
        first.setdefault((detail["type"], place), detail)
    return list(first.values())


def _without_echoes(details: Sequence[ErrorDetails]) -> Iterator[ErrorDetails]:
    """The errors that do not follow from others; a key that is written wrongly is not missing as well."""
    unknown: defaultdict[KeyPath, list[str]] = defaultdict(list)
    for detail in details:
        if detail["type"] == "extra_forbidden":
            unknown[detail["loc"][:-1]].append(str(detail["loc"][-1]))
    for detail in details:
        *path, last = detail["loc"] or ("",)
        misspelt = detail["type"] == "missing" and get_close_matches(str(last), unknown[tuple(path)][:MOST_COMPARED])
        if not misspelt and not _is_echo(detail):
            yield detail


def _is_echo(detail: ErrorDetails) -> bool:
    """Whether an error only follows from one that is reported elsewhere."""
    written = detail["input"]
    if (isinstance(written, str) and "${" in written) or isinstance(detail.get("ctx", {}).get("error"), EchoError):
        return True
    # Pydantic counts the items that are valid.
    return detail["type"] == "too_short" and len(written) >= detail["ctx"]["min_length"]


def _diagnostic(source: Source, detail: ErrorDetails) -> Diagnostic:
    """One of pydantic's errors; levels of its path that the file has not are left to `span_of`."""
    path = detail["loc"]
    told = _told(detail)
    if path[-1:] == ("[key]",):  # as pydantic calls the key of a mapping
        return Diagnostic(told.code, source.key_span_of(path[:-1]), told.message, told.hint)
    if told.code == "SD102" and detail["type"] == "missing":
        span = source.span_of(path[:-1])
    else:
        span = source.key_span_of(path) if told.code == "SD101" else source.span_of(path)
    return Diagnostic(told.code, span, told.message, told.hint)


def _told(detail: ErrorDetails) -> _Told:
    from stackdsl.language.json_schema import description_at  # noqa: PLC0415 -- only mistakes need it

    kind, path, written, terms = detail["type"], detail["loc"], detail["input"], detail.get("ctx", {})
    last = path[-1] if path else ""
    mistake = terms.get("error")
    if isinstance(mistake, MistakeError):
        return _Told(mistake.code, mistake.message, without_comma(written) or mistake.hint)
    if (remedy := without_comma(written)) and kind in ("int_type", "float_type"):
        return _Told("SD103", f"expected {WANTED[kind]}, not {shown(written)}", remedy)
    if kind == "too_long" and any(isinstance(one, int | float) for one in written):
        terms = {**terms, "more": "; a decimal comma is written as a point"}
    match kind:
        case "extra_forbidden":
            return _Told("SD101", f"unknown key '{last}'", _known_key(str(last), path[:-1]))
        case "missing" if isinstance(last, int):
            return _Told("SD103", "the list has too few items", f"write all of them: {description_at(path[:-1])}")
        case "missing":
            return _Told("SD102", f"missing key '{last}'", f"add `{last}`, {description_at(path)}")
        case "literal_error":
            choices = re.findall("'([^']*)'", terms["expected"])
            hint = did_you_mean(str(written), choices) + (_of_others() if "systems" in path else "")
            return _Told("SD104", f"{shown(written)} is not one of the choices", hint)
        case "model_type":
            return _Told("SD103", f"expected a mapping, not {shown(written)}", _as_mapping(written, path))
    if kind in RANGES:
        hint = _with_meaning(_within(path), path) + terms.get("more", "")
        return _Told("SD104", RANGES[kind].format(value=shown(written), **terms), hint)
    return _Told(
        "SD103", f"expected {WANTED.get(kind, kind)}, not {shown(written)}", _with_meaning(_form(detail), path)
    )


def _known_key(key: str, path: KeyPath) -> str:
    """The key that was meant, or the mapping beside it that takes the key, or all keys."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    beside = keys_at(path)
    homes = [other for other in beside if key in keys_at((*path, other))]
    return f"it belongs in `{homes[0]}`" if len(homes) == 1 else did_you_mean(key, beside)


def _as_mapping(written: object, path: KeyPath) -> str:
    """How a mapping is written where there is none: what its keys are for, or the one that the value is for."""
    from stackdsl.language.json_schema import description_at, keys_at, nodes_at  # noqa: PLC0415 -- only mistakes need it

    keys = keys_at(path)
    if written in keys:
        return _with_value(str(written), path)
    if isinstance(written, int) and not isinstance(written, bool):
        counts = [key for key in keys if any(node.get("type") == "integer" for node in nodes_at((*path, key)))]
        if len(counts) == 1:
            return f"write {{{counts[0]}: {written}}}: {description_at((*path, counts[0]))}"
    if len(keys) > MOST_EXPLAINED:
        return f"its keys: {', '.join(keys)}"
    meant = {key: description_at((*path, key)).partition(";")[0] for key in keys}
    return f"its keys: {', '.join(f'{key} ({what})' for key, what in meant.items())}"


def _with_value(key: str, path: KeyPath) -> str:
    """A key of the mapping at a path, and the word that may be its value, if there is one: `stands: all`."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    word = next((node["const"] for node in nodes_at((*path, key)) if isinstance(node.get("const"), str)), "")
    return f"write `{key}: {word}`" + (" and its value" * (not word))


def _of_others() -> str:
    """Where systems are asked for that a scenario cannot name, as it is to be right or wrong alike for everybody."""
    found = f", and installed are: {', '.join(offered())}" if offered() else ""
    return f"; systems of other packages are asked for by --system{found}"


def _with_meaning(remedy: str, path: KeyPath) -> str:
    """What to write, and what the value is for."""
    from stackdsl.language.json_schema import description_at  # noqa: PLC0415 -- only mistakes need it

    return ": ".join(filter(None, [remedy, description_at(path)]))


def _within(path: KeyPath) -> str:
    """Between which limits a value is to be written."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    known = {key: limit for node in reversed(list(nodes_at(path))) for key, limit in node.items()}
    for least, most, noun in LIMITS:
        if least in known and most in known:
            return f"write {known[least]:g} to {known[most]:g}{noun}"
        if least in known:
            return f"write at least {known[least]:g}{noun}"
    return ""


def _list_of(written: float | str, path: KeyPath) -> str:
    """A list in place of one value: around it, unless more are due, or mappings."""
    from stackdsl.language.json_schema import keys_at, nodes_at  # noqa: PLC0415 -- only mistakes need it

    if keys := keys_at((*path, 0)):
        return _with_value(str(written), (*path, 0)).replace("`", "`- ", 1) if written in keys else _ITEMS
    due = next((int(node["minItems"]) for node in nodes_at(path) if "minItems" in node), 1)
    return f"write [{written}]" if due == 1 else f"write a list of {due}"


def _form(detail: ErrorDetails) -> str:
    """How a value of the type that is wanted is written."""
    written = detail["input"]
    match detail["type"]:
        case "tuple_type" if isinstance(written, dict):
            return _ITEMS
        case "tuple_type" if isinstance(written, str | int | float):
            return _list_of(written, detail["loc"])
        case "int_type" | "float_type" if isinstance(written, str) and MISWRITTEN.fullmatch(written):
            return f"write ${{{written.strip('${}')}}} if it is an expression"
        case "int_type" | "float_type":
            return _within(detail["loc"]) or f"write {WANTED[detail['type']]}"
        case "string_type":
            return "quote it"
    return f"write {WANTED[detail['type']]}" if detail["type"] in WANTED else ""


# Scenarios that are made of what cannot be read here, and that say so: `skip: {reason: ..., without: mujoco}`.


_TOLD: Final = ("scenario", "description", "tags", "systems", "let", "matrix", "cases", "exclude", "skip")
_ANYTHING: Final[dict[str, Plain]] = {"brick": "kapla", "build": [{"column": {"levels": 1}}]}


def report_missing_dependency(source: Source) -> Source | None:
    """What can be told of a scenario that is not played without a package which is not here; None of all others.

    What it builds is left out, since reading that may take the package.
    """
    skip = source.values.get("skip")
    package = skip.get("without") if isinstance(skip, dict) else None
    if not isinstance(package, str) or package not in get_args(Package) or is_installed(package):
        return None
    values: dict[str, Plain] = {key: source.values[key] for key in _TOLD if key in source.values}
    return replace(source, values=values | _ANYTHING)
