"""Validates plain values into a scenario, or into diagnostics, each at its place in the file."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Final, NamedTuple, get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from stackdsl.diagnostics import Diagnostic, Span, capped, did_you_mean, meant_choice, reading_order
from stackdsl.entry_points import engine_remedy, offered_systems
from stackdsl.language.bricks import CATALOGUE, ROUND_KEYS, BrickKind, SetBrick, known_bricks, laid
from stackdsl.language.claims.protocol import TILTING, Protocol
from stackdsl.language.distributions import sampled
from stackdsl.language.expressions import meant_expression
from stackdsl.language.layouts.registry import place
from stackdsl.language.model_base import NoWordError
from stackdsl.language.quantities import QUANTITY, ConsequentialError, InputError, number_remedy, shown, triple
from stackdsl.language.round_words import (
    LENGTHS_ALONG,
    ROUND_LENGTHS,
    ROUND_WORDS,
    SHAPE_WORDS,
    round_brick,
    round_entry,
    round_word,
    twice,
)
from stackdsl.language.schema import Package, Scenario, is_installed, models
from stackdsl.language.value_types import PROVING
from stackdsl.language.variants import KINDS, Variant
from stackdsl.language.yaml.includes import INCLUDE, LISTS, OutsideError, definitions_of, file_in_project, root_of
from stackdsl.language.yaml.source import KeyPath, Plain, Source, load

# Conflicts between values of a scenario that are valid by themselves.


def conflicts(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield all conflicts, in no particular order."""
    for check in (
        _unused_systems,
        _marks_of_other_systems,
        _expectations_without_proofs,
        _truths_without_proofs,
        _after_a_collapse,
        _protocols_of_other_ground,
        _impossible_layouts,
        _studs_without_studs,
        sampled,
    ):
        yield from check(scenario, source)


def _unused_systems(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, expectation in enumerate(scenario.expect):
        for system in expectation.system or ():
            if system not in scenario.systems:
                message = f"the scenario does not run on '{system}', so this expectation is never checked"
                hint = f"add this system to `systems`, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of(("expect", index, "system")), message, hint)


def _marks_of_other_systems(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield marks for systems that are not in `systems`, and `xfail` without expectations."""
    for key, mark in (("skip", scenario.skip), ("xfail", scenario.xfail)):
        for system in (mark.system if mark is not None else None) or ():
            if system not in scenario.systems:
                message = f"the scenario does not run on '{system}', so this key has no effect"
                hint = f"remove the system, or choose from: {', '.join(scenario.systems)}"
                yield Diagnostic("SD104", source.span_of((key, "system")), message, hint)
    if scenario.xfail is not None and not scenario.expect:
        message = "`xfail` has no effect without expectations"
        yield Diagnostic(
            "SD104",
            source.key_span_of(("xfail",)),
            message,
            "write the expectation that is known to fail under `expect`",
        )


def _expectations_without_proofs(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield expectations that need statics, but apply to a system without proofs."""
    for index, expectation in enumerate(scenario.expect):
        without = [system for system in expectation.system or scenario.systems if system not in PROVING]
        if expectation.content.needs_statics and without:
            message = f"`{expectation.kind}` needs proofs of statics, which the system '{without[0]}' does not have"
            span = source.key_span_of(("expect", index, expectation.kind))
            yield Diagnostic(
                "SD104", span, message, f"add `system: {PROVING[0]}` to this expectation, and {PROVING[0]} to `systems`"
            )


def _truths_without_proofs(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield truths that need statics where no system has proofs."""
    for index, truth in enumerate(scenario.truth):
        if truth.content.needs_statics and not set(PROVING).intersection(scenario.systems):
            message = f"`{truth.kind}` needs proofs of statics, so this truth is never compared"
            span = source.key_span_of(("truth", index, truth.kind))
            yield Diagnostic("SD104", span, message, f"add {PROVING[0]} to `systems`")


def _after_a_collapse(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield steps and impacts after a step with `until: collapse`."""
    for index, step in enumerate(scenario.build[:-1]):
        if step.until is not None:
            message = "a step with `until: collapse` must be the last step"
            yield Diagnostic(
                "SD104", source.span_of(("build", index, "until")), message, "move it to the end of `build`"
            )
    if scenario.impacts and scenario.build[-1].until is not None:
        message = "impacts cannot follow a step with `until: collapse`"
        hint = "replace `until: collapse` by a number of levels, or remove the impacts"
        yield Diagnostic("SD205", source.key_span_of(("impacts",)), message, hint)


def _protocols_of_other_ground(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield protocols on ground that shakes or is tilted, and tilts of loaded bricks."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            if not isinstance(claim.content, Protocol):
                continue
            span = source.key_span_of((key, number, claim.kind))
            name = claim.content.name
            if scenario.world.shake is not None:
                message = f"the protocol `{name}` accelerates the ground by itself, but the scenario has a `shake`"
                yield Diagnostic("SD104", span, message, "remove `shake`, or judge each in a scenario of its own")
            if scenario.world.tilt.angle:
                message = f"the protocol `{name}` begins on level ground, but the scenario has a `tilt`"
                yield Diagnostic("SD104", span, message, "remove `tilt`")
            if (scenario.loads or scenario.ties) and name == TILTING:
                code, acting, bricks = ("SD211", "loads", "loaded") if scenario.loads else ("SD214", "ties", "tied")
                message = f"the tilt that {bricks} bricks bear is not computed"
                yield Diagnostic(code, span, message, f"remove `{acting}`, or use the protocol `en-12195-1`")


def _impossible_layouts(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for index, step in enumerate(scenario.build):
        if step.layout is None:
            continue
        name, params = step.layout
        try:
            form = (step.brick or scenario.brick).form
            for spec in place(name, params, form.size):
                laid(form, spec)
        except InputError as mistake:
            yield Diagnostic(mistake.code, source.span_of(("build", index, name)), mistake.message, mistake.hint)


def _studs_without_studs(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield bricks with `stud` whose kind, that of the step or of the scenario, has no studs."""
    for index, step in enumerate(scenario.build):
        for number, brick in enumerate(step.bricks or ()):
            yield from _studless(brick, step.brick or scenario.brick, source, ("build", index, "bricks", number))
    for index, impact in enumerate(scenario.impacts):
        if impact.content.slid_in is not None:
            yield from _studless(impact.content.slid_in, scenario.brick, source, ("impacts", index, impact.kind))


def _studless(brick: SetBrick, usual: BrickKind, source: Source, path: KeyPath) -> Iterator[Diagnostic]:
    if brick.stud is not None:
        try:
            brick.on_studs(brick.brick or usual)
        except InputError as mistake:
            yield Diagnostic(mistake.code, source.key_span_of((*path, "stud")), mistake.message, mistake.hint)


# Validation by pydantic, and translation of its errors.


# The expected type, by the kind of pydantic's error.
WANTED: Final = {
    "int_type": "a whole number",
    "float_type": "a number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "model_type": "a mapping",
    "dict_type": "a mapping",
}
# Messages of range errors, by the kind of pydantic's error, with the value and pydantic's context filled in.
RANGES: Final = {
    "greater_than_equal": "{value} is below the minimum of {ge:g}",
    "less_than_equal": "{value} exceeds the maximum of {le:g}",
    "finite_number": "{value} is not a finite number",
    "string_too_short": "the text is empty",
    "string_too_long": "the text is longer than {max_length} characters",
    "too_short": "the list has {actual_length} items; the minimum is {min_length}",
    "too_long": "the list has {actual_length} items; the maximum is {max_length}",
}

# Limits in the JSON schema: keys of the lower and the upper limit, and the counted noun.
LIMITS: Final = (
    ("minimum", "maximum", ""),
    ("minItems", "maxItems", " items"),
    ("minLength", "maxLength", " characters"),
)


VALUE_CODES: Final = ("SD103", "SD104", "SD106", "SD110")  # of a value of the wrong form
ANY_WORD: Final = "word"  # permitted where any name is
NOTHING_MEANT: Final[Mapping[KeyPath, str]] = {}
LONGEST_LITERAL: Final = 70  # [characters] of a value in a remedy
MOST_COMPARED: Final = 20  # unknown keys that are compared with a missing key
MOST_EXPLAINED: Final = 4  # keys with a description in the remedy for a missing mapping
_ITEMS: Final = "begin each item with `- `"


class _Explanation(NamedTuple):
    """Code, message and hint for an error of pydantic."""

    code: str
    message: str
    hint: str = ""


def validate(source: Source, variant: Variant) -> tuple[Scenario | None, tuple[Diagnostic, ...]]:
    """Return the scenario of a variant, or None and all of its mistakes in the order of the text.

    Values whose expressions `expand` could not evaluate are ignored, since it has reported them. The scenario can
    therefore be None without a diagnostic.
    """
    try:
        known = known_bricks(variant.values.get("brick_types"), source.files)
        scenario = models().Scenario.model_validate(variant.values, context=known)
    except ValidationError as error:
        details = _of_first_repetitions(error.errors(include_url=False), source)
        meant = _meant_keys(details, source)
        remaining = _without_echoes(details, meant)
        return None, _in_order(capped(_diagnostic(source, detail, meant) for detail in remaining))
    mistakes = _in_order(capped(conflicts(scenario, source)))
    return (None if mistakes else scenario), mistakes


def mistakes_at(error: ValidationError, source: Source, path: KeyPath) -> tuple[Diagnostic, ...]:
    """Return the mistakes in the value at a path of the source, which was validated by itself."""
    details = error.errors(include_url=False)
    return _in_order(_diagnostic(source, {**detail, "loc": (*path, *detail["loc"])}) for detail in details)


def _in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(set(diagnostics), key=reading_order))


def _of_first_repetitions(details: Iterable[ErrorDetails], source: Source) -> list[ErrorDetails]:
    """Drop equal errors in later repetitions, since the remedies of thousands of errors take minutes to compute."""
    first: dict[object, ErrorDetails] = {}
    for detail in details:
        span = source.span_of(detail["loc"])
        place = (span.file, span.line, span.column, detail["loc"][-1:]) if span.where else detail["loc"]
        first.setdefault((detail["type"], place), detail)
    return list(first.values())


def _meant_keys(details: Iterable[ErrorDetails], source: Source) -> dict[KeyPath, str]:
    """Return the key that the author means for each invalid text that suits exactly one other key of its mapping.

    That is a missing key, or an optional one whose values are neither any words nor quantities: `built` under `at`
    means `after`.
    """
    from stackdsl.language.json_schema import keys_at, rivals_at  # noqa: PLC0415 -- only mistakes need it

    missing: defaultdict[KeyPath, list[str]] = defaultdict(list)
    for detail in details:
        if detail["type"] == "missing":
            missing[detail["loc"][:-1]].append(str(detail["loc"][-1]))
    meant: dict[KeyPath, str] = {}
    for detail in details:
        path, written = detail["loc"], detail["input"]
        if not isinstance(written, str) or not path or (code := _explain(detail, source).code) not in VALUE_CODES:
            continue
        around = path[:-1]
        # A key of which a mapping has exactly one can only be exchanged for another of these.
        possible = rivals_at(path) or keys_at(around)
        free = (key for key in possible if (*around, key) not in source.value_spans)
        fitting = [key for key in missing[around] if _permits((*around, key), written)]
        if not fitting and (code == "SD106" or not QUANTITY.fullmatch(written)):
            fitting = [key for key in free if _is_value_of((*around, key), written)]
        if len(fitting) == 1:
            meant[path] = fitting[0]
    unknown = _unknown_keys(details)
    for around, keys in missing.items():
        others = unknown[around]
        if len(keys) != 1 or len(others) != 1:
            continue
        value = _written_at(source, (*around, others[0]))
        if _fits((*around, keys[0]), value) and not _counterpart(others[0], value, around, source):
            meant[*around, others[0]] = keys[0]
    return meant


def _unknown_keys(details: Iterable[ErrorDetails]) -> defaultdict[KeyPath, list[str]]:
    unknown: defaultdict[KeyPath, list[str]] = defaultdict(list)
    for detail in details:
        if detail["type"] == "extra_forbidden":
            unknown[detail["loc"][:-1]].append(str(detail["loc"][-1]))
    return unknown


def _without_echoes(details: Sequence[ErrorDetails], meant: dict[KeyPath, str]) -> Iterator[ErrorDetails]:
    """Yield the errors that do not follow from others. A misspelt key is not also reported as missing."""
    unknown = _unknown_keys(details)
    supplied = {(*path[:-1], key) for path, key in meant.items()}
    for detail in details:
        *path, last = detail["loc"] or ("",)
        others = unknown[tuple(path)][:MOST_COMPARED]
        is_supplied = detail["loc"] in supplied or any(keys_called(other, [str(last)]) for other in others)
        is_supplied = is_supplied or last in unknown[tuple(path[:-1])]  # beside the mapping in place of in it
        misspelt = detail["type"] == "missing" and (is_supplied or meant_choice(str(last), others))
        if not misspelt and not _is_echo(detail) and not (last in others and _is_length_of_round(str(last), others)):
            yield detail


def _is_length_of_round(key: str, unknown: Sequence[str]) -> bool:
    """Return whether an unknown key is a length of a round brick that another unknown key beside it stands for."""
    if key not in {*ROUND_LENGTHS, *LENGTHS_ALONG}:
        return False
    stands = [each for each in unknown if each in SHAPE_WORDS] or [each for each in unknown if each in ROUND_LENGTHS]
    return bool(stands) and key != stands[0]


def _is_echo(detail: ErrorDetails) -> bool:
    """Return whether an error only follows from another that is reported elsewhere."""
    written = detail["input"]
    if (isinstance(written, str) and "${" in written) or isinstance(
        detail.get("ctx", {}).get("error"), ConsequentialError
    ):
        return True
    # Pydantic counts valid items only, so an invalid item can make a list too short.
    return detail["type"] == "too_short" and len(written) >= detail["ctx"]["min_length"]


def _diagnostic(source: Source, detail: ErrorDetails, meant: Mapping[KeyPath, str] = NOTHING_MEANT) -> Diagnostic:
    """Convert an error of pydantic. `span_of` handles parts of its path that are not in the file."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    path = detail["loc"]
    if detail["type"] == "tuple_type" and (listed := _as_items(source, path, detail["input"])):
        place, hint = listed
        return Diagnostic("SD103", place, "expected a list, not a mapping", hint)
    code, message, hint = _explain(detail, source)
    if code in ("SD105", "SD106") and "${" in source.span_of(path).text:
        message, hint = _of_expression(code, message, hint, detail["input"], _definition_at(source, path))
    elif detail["type"] == "int_type" and "${" in source.span_of(path).text:
        message = f"the expression gives {shown(detail['input'])}, not a whole number"
        hint = "round it with floor, ceil or round" if isinstance(detail["input"], float) else hint
    elif path in meant:
        message, hint = _of_other_key(detail, message, meant[path])
    elif code != "SD101" and (expression := meant_expression(detail["input"], _variables(source))):
        hint = f'write "{expression}" for the value of the variable'
    elif code != "SD101" and isinstance(detail["input"], list) and f"{path[-1]}s" in keys_at(path[:-1]):
        hint = f"write `{path[-1]}s` in place of `{path[-1]}`"
    if code == "SD108" and message.endswith("not none") and isinstance(path[-1], int) and path[-1] > 0:
        hint += ", or remove the '- ' if its keys belong to the item above"
    if path[-1:] == ("[key]",):  # pydantic's path to the key of a mapping
        return Diagnostic(code, source.key_span_of(path[:-1]), message, hint)
    if code == "SD102" and detail["type"] == "missing":
        span = source.span_of(path[:-1])
    else:
        span = source.key_span_of(path) if code == "SD101" else source.span_of(path)
    return Diagnostic(code, span, message, hint)


def _of_other_key(detail: ErrorDetails, message: str, meant: str) -> tuple[str, str]:
    """Return message and remedy for an unknown key, or a value, that means another key."""
    path, written = detail["loc"], detail["input"]
    if detail["type"] == "extra_forbidden":
        return message, _with_meaning(f"write `{meant}` in place of `{path[-1]}`", (*path[:-1], meant))
    return (
        f"{shown(written)} is a value of `{meant}`, not of `{path[-1]}`",
        f"write `{meant}: {in_flow_style(written)}` in place of `{path[-1]}`",
    )


def _variables(source: Source) -> set[str]:
    return {str(path[-1]) for path in definitions_of(source.values) if path[0] != KINDS}


def _definition_at(source: Source, path: KeyPath) -> str:
    """Return the place that defines the variable which alone is the value at a path; empty for other values."""
    here = source.span_of(path)
    name = re.fullmatch(r"['\"]?\$\{\s*(\w+)\s*\}['\"]?", here.text)
    if name is None or (defined := ("let", name[1])) not in source.value_spans:
        return ""
    there = source.value_spans[defined]
    return f"as the value of '{name[1]}' at {there.seen_from(here)}" if QUANTITY.fullmatch(there.text) else ""


def _of_expression(code: str, message: str, hint: str, value: object, defined: str) -> tuple[str, str]:
    """Return message and remedy for an expression whose value has no unit, or a wrong one."""
    gives = f"the expression gives {shown(value)}"
    if code == "SD105":
        literal = hint.partition(", such as ")[2]
        remedy = f"write {literal} {defined}" if literal and defined else "multiply it by a unit, such as `* 1 mm`"
        return f"{gives}, without a unit; {message.partition('; ')[2]}", remedy
    units = hint.removeprefix("choose from: ")
    return f"{gives}, and {message}", f"change the expression; its unit must be one of {units}"


def _as_items(source: Source, path: KeyPath, written: object) -> tuple[Span, str] | None:
    """Return place and remedy for the keys of items in place of a list; None if the items have no such keys."""
    from stackdsl.language.json_schema import choices_at, keys_at  # noqa: PLC0415 -- only mistakes need it

    item = (*path, 0)
    if not isinstance(written, dict) or not written or not {*written} & {*keys_at(item)}:
        return None
    items: list[dict[str, object]] = [{}]
    for key, value in written.items():
        if key in choices_at(item) and any(other in choices_at(item) for other in items[-1]):
            items.append({})
        items[-1][key] = value
    span = source.span_of(path)
    if span.key:  # of a program in Python, where `in_python` has the words
        return None
    if span.text.startswith("{"):
        return span, f"write `{path[-1]}: {in_flow_style(items)}`"
    keys = {key: source.key_span_of((*path, key)) for key in written}
    heads = [next(iter(each)) for each in items]
    begin = keys[heads[0]]
    line = begin.excerpt[begin.column - begin.excerpt_column :].split(" #")[0].rstrip()
    literal = [line if "…" not in line else f"{heads[0]}:", *(f"{head}:" for head in heads[1:])]
    below = [key for key in written if key not in heads]
    indented = f", and indent {_named(below)} by two more spaces" if below else ""
    return begin, f"write {' and '.join(f'`- {each}`' for each in literal)}{indented}"


def _named(keys: Iterable[str]) -> str:
    return ", ".join(f"`{key}`" for key in keys)


def _written_at(source: Source, path: KeyPath) -> object:
    """Return the value that a scenario has at a path; None if there is none."""
    value: object = source.values
    for key in path:
        try:
            value = value[key]  # type: ignore[index]  # what has no such item is caught
        except (KeyError, IndexError, TypeError):
            return None
    return value


def _explain(detail: ErrorDetails, source: Source) -> _Explanation:
    from stackdsl.language.json_schema import description_at  # noqa: PLC0415 -- only mistakes need it

    kind, path, written, terms = detail["type"], detail["loc"], detail["input"], detail.get("ctx", {})
    last = path[-1] if path else ""
    mistake = terms.get("error")
    if isinstance(mistake, InputError):
        entry = _entry_for(written, path) if isinstance(mistake, NoWordError) else ""
        hint = f"write {entry}" if entry else number_remedy(written) or mistake.hint
        return _Explanation(mistake.code, mistake.message, hint)
    if (remedy := number_remedy(written)) and kind in ("int_type", "float_type"):
        return _Explanation("SD103", f"expected {WANTED[kind]}, not {shown(written)}", remedy)
    if kind == "too_long" and any(isinstance(item, int | float) for item in written):
        terms = {**terms, "more": "; write decimals with a point instead of a comma"}
    match kind:
        case "extra_forbidden":
            return _Explanation("SD101", f"unknown key '{last}'", _known_key(str(last), written, path[:-1], source))
        case "missing" if isinstance(last, int):
            items = re.search(r"\[([\w, ]+)\]", all_items := description_at(path[:-1]))
            absent = items[1].split(", ")[len(written) :] if items else []
            verb = "is" if len(absent) == 1 else "are"
            message = f"{' and '.join(absent)} {verb} missing" if absent else "the list has too few items"
            return _Explanation("SD103", message, f"write all items: {all_items}")
        case "missing":
            return _Explanation("SD102", f"missing key '{last}'", f"add {_entry_at(path)}, {description_at(path)}")
        case "literal_error":
            choices = re.findall("'([^']*)'", terms["expected"])
            hint = _system(str(written), choices) if "systems" in path else did_you_mean(str(written), choices)
            hint = hint or (f"write `{last}: true`, or remove the key" if terms["expected"] == "True" else "")
            return _Explanation("SD104", f"{shown(written)} is not a permitted value", hint)
        case "model_type":
            return _Explanation("SD103", f"expected a mapping, not {shown(written)}", _as_mapping(written, path))
    if kind in RANGES:
        hint = _with_meaning(_within(path), path) + terms.get("more", "")
        return _Explanation("SD104", RANGES[kind].format(value=shown(written), **terms), hint)
    return _Explanation(
        "SD103", f"expected {WANTED.get(kind, kind)}, not {shown(written)}", _with_meaning(_form(detail), path)
    )


NUMBER: Final = re.compile(r"([-+]?\d+(?:\.\d+)?)\s*([%;]?)")
REST: Final = {"": "quotes", "%": "'%'", ";": "';'"}  # what follows a number as text
# Words of new users for each key. A word that stands at several keys means the first that is permitted at its place.
WORDS: Final = {
    "scenario": "name title id",
    "description": "comment note notes",
    "extends": "base inherits inherit extend",
    "systems": "system engine engines simulator solver backend",
    "let": "variables vars constants parameters define",
    "matrix": "params parametrize sweep variants",
    "brick_types": "types kinds materials",
    "build": "steps structure layout layouts scene objects stack column",
    "impacts": "actions events disturbances impact",
    "expect": "assert asserts assertions claims checks expectations should tests then verify",
    "watch": "duration hold",
    "column": "stack tower pile",
    "bricks": "box boxes block blocks cube cubes cuboid body bodies objects count number levels",
    "levels": "courses layers rows storeys stories floors height count number",
    "brick": "type kind material brick_type",
    "name": "id label",
    "joints": "joint bonds connections",
    "ties": "tie strap straps strapping wrap wraps bands band lashings lashing chains ropes rods tie_rods",
    "around": "bricks strap wrap band lashing wraps holds of all",
    "along": "axis across direction plane",
    "bond": "glue mortar cement adhesive",
    "pull": "magnet magnets tape velcro force",
    "studs": "stud lego",
    "tension": "tensile tensile_strength pretension preload force",
    "cohesion": "shear_strength",
    "mass": "weight",
    "density": "rho",
    "size": "dimensions dims extents length width height thickness",
    "diameter": "radius d outer outer_diameter",
    "bottom": "radius diameter",
    "wall": "thickness wall_thickness",
    "height": "length h thickness",
    "gravity": "g",
    "friction": "mu cof coefficient friction_coefficient",
    "origin": "at position pos offset",
    "after": "when event",
    "at": "position pos location coordinates time when start target brick level",
    "onto": "on at target",
    "on": "onto support",
    "rotate": "rotation orientation angle yaw",
    "every": "interval period delay",
    "gap": "spacing distance",
    "spacing": "gap distance step",
    "remove": "pull pull_out take extract",
    "throw": "hit shoot launch",
    "push": "shove nudge poke kick",
    "impulse": "force momentum",
    "speed": "velocity",
    "stands": "stable standing upright",
    "collapses": "unstable topples fails",
    "displaced": "moves moved",
}
BRAKING: Final = frozenset({"acceleration", "braking", "brake", "survive", "survives"})
BRAKES: Final = (
    'under `expect`, `margin: {acceleration: ">= 0.5 g"}` requires that the structure survives a steady acceleration, '
    "as in braking, in every direction; `world: {shake: {acceleration: 0.5 g, frequency: 2 Hz, for: 2 s}}` shakes it"
)


HITS: Final = frozenset({"hit", "hits", "strikes", "touches", "contact", "arrives"})
EFFECTS: Final = (
    "no claim is about a hit itself: `stackdsl run` prints when, where and how fast each hit is; claim what it does, "
    "such as `falls: {count: <= 4}`, `displaced: {bricks: <= 6, by: '> 5 mm'}`, `drift: {is: '> 5 mm', bricks: [a]}` "
    "or `untouched: {levels: 3}`"
)


CONDITIONS: Final = frozenset({"when", "if", "unless", "only", "for_case", "cases", "case"})
NO_CONDITION: Final = (
    "a claim applies to every case; give each case its own limit, as in `cases: [{name: slow, most: 0}, "
    "{name: fast, most: 9}]` with `falls: {count: '<= ${most}'}`, or write a second scenario with `extends`; "
    "docs/language.md, Variables"
)


SHIFT_OF_ONE: Final = (
    "`displaced` counts bricks; for the shift of one brick write `drift: {{is: <= 1 mm, bricks: [{}]}}`"
)


def _known_key(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for an unknown key: what it means, or that it means nothing here."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    if meant := _counterpart(key, written, path, source):
        return meant
    keys = keys_at(path)
    around = _written_at(source, path)
    if not isinstance(around, dict) or len(around) > 1:
        return f"remove it; the keys here are {', '.join(keys)}"
    fitting = [each for each in keys if _is_value_of((*path, each), written)]
    meant = f"`{fitting[0]}`" if len(fitting) == 1 else f"one of {', '.join(keys)}"
    return f"write {meant} in place of `{key}`"


def _is_value_of(path: KeyPath, written: object) -> bool:
    """Return whether a text has the form of the values at a path, where not just any word may stand."""
    return isinstance(written, str) and _permits(path, written) and not _permits(path, ANY_WORD)


def _counterpart(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for an unknown key that means another key or place; empty for any other."""
    return (
        _of_subject(key, written, path, source)
        or _meant_here(key, written, path, source)
        or _elsewhere(key, written, path, source)
    )


def _of_subject(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for a key about a subject that the language treats in another way; empty for others."""
    if round_remedy := _of_round_brick(key, written, path, source):
        return round_remedy
    if key in BRAKING and (path in ((), ("world",)) or path[:1] == ("expect",)):
        return BRAKES
    if key in HITS and path[:1] == ("expect",):
        return EFFECTS
    if key in CONDITIONS and path[:1] == ("expect",):
        return NO_CONDITION
    if key == "brick" and path[-1:] == ("displaced",):
        return SHIFT_OF_ONE.format(shown(written).strip("'"))
    return ""


def _of_round_brick(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for a key about a round brick that is not written as one; empty for others."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    keys = keys_at(path)
    if path[-1:] and path[-1] in ROUND_KEYS:
        return _of_round_lengths(key, written, keys)
    around = _written_at(source, path)
    beside = around if isinstance(around, dict) else {key: written}
    shapes = [word for each in SHAPE_WORDS if (word := round_word(beside.get(each)))]
    if key in ROUND_WORDS:
        word, lengths = key, written
    elif key in SHAPE_WORDS and isinstance(written, dict) and round_word(written):
        word, lengths = round_word(written), written[round_word(written)]
    elif (key in SHAPE_WORDS and round_word(written)) or key in ROUND_LENGTHS:
        is_tall = any(each in beside for each in LENGTHS_ALONG)
        word, lengths = (shapes or ["cylinder" if is_tall else "sphere"])[0], beside
    else:
        return ""
    taken = [key, *(each for each in (*ROUND_LENGTHS, *LENGTHS_ALONG) if lengths is beside and each in beside)]
    replaced = f"in place of {_named(dict.fromkeys(taken))}"
    if "sphere" in keys:
        other = "" if key in ROUND_WORDS or shapes else f", or `{round_entry('cylinder', beside)}`,"
        return f"write `{round_entry(word, lengths)}`{'' if word == 'cylinder' else other} {replaced}"
    if "brick" not in keys:
        return f"write a round brick as a kind of `brick_types`, such as `{{round: {round_brick(word, lengths)}}}`"
    brick = f"brick: {round_brick(word, lengths)}"
    return f"write `{f'bricks: [{{on: ground, {brick}}}]' if 'bricks' in keys else brick}` {replaced}"


def _of_round_lengths(key: str, written: object, keys: Sequence[str]) -> str:
    """Return the remedy for a key in the mapping of a round shape, such as a radius; empty for others."""
    across = keys[0]
    if key == "radius" and (doubled := twice(written)):
        return f"write `{across}: {doubled}`, twice the radius, in place of `radius`"
    return f"write `{across}` in place of `{key}`, and give the diameter" if key in ROUND_LENGTHS else ""


def _meant_here(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for a key that belongs in a mapping here, or means another key here; empty for others."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    if key == INCLUDE and not path:
        files = written if isinstance(written, list) else [written]
        items = (
            f"`- {INCLUDE}: {in_flow_style(file)}` as an item of {_lists_of(file, source)}"
            for file in files[:MOST_EXPLAINED]
        )
        return f"write {', and '.join(items)}"
    siblings = keys_at(path)
    for sibling in siblings:
        inner = _written_at(source, (*path, sibling))
        if isinstance(inner, dict) and key not in inner and key in keys_at((*path, sibling)):
            whole = in_flow_style({**inner, key: written})
            literal = f": write `{sibling}: {whole}`" if len(whole) <= LONGEST_LITERAL else ""
            return f"this key belongs in `{sibling}`{literal}"
    if meant := _synonym(key, siblings, written, path):
        return _with_meaning(_in_place_of(key, meant, written, path), (*path, meant))
    first, _, rest = key.partition(" ")
    if rest and first in siblings:
        return f"put a colon after it: `{first}: {{{rest}: {shown(written)}}}`".replace("'", "")
    if fitting := meant_choice(key, [each for each in siblings if _fits((*path, each), written)]):
        return f"did you mean '{fitting}'?"
    return ""


def _elsewhere(key: str, written: object, path: KeyPath, source: Source) -> str:
    """Return the remedy for a key of another mapping, or for a slip of a key here; empty for others."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    if place := _place_of(key, path, written, source):
        return place
    elsewhere = ((meant, _place_of(meant, path, written, source)) for meant in keys_called(key, WORDS))
    other = next((f"write `{meant}`; {place}" for meant, place in elsewhere if place), "")
    return f"did you mean '{near}'?" if (near := meant_choice(key, keys_at(path))) else other


def _in_place_of(key: str, meant: str, written: object, path: KeyPath) -> str:
    """Return the remedy for a key that means another: the key alone, or with the form of value that it takes."""
    from stackdsl.language.json_schema import example_at, keys_at, nodes_at, word_at  # noqa: PLC0415 -- only mistakes need it

    here = (*path, meant)
    is_list = any(node.get("type") == "array" and node.get("minItems") == 1 for node in nodes_at(here))
    if is_list and isinstance(written, str) and not keys_at((*here, 0)):
        return f"write `{meant}: [{written}]`"
    if isinstance(written, str | bool) and written in COUNTS and (counted := _counted(here)):
        return f"write `{meant}: {{{counted}: {in_flow_style(COUNTS[written])}}}`"
    if (word := word_at(here)) and not isinstance(written, dict) and written != word:
        return f"write `{meant}: {_entry_for(written, here) or word}`"
    example = example_at(here) if isinstance(written, str | int | float) and not _fits(here, written) else None
    such = "" if example is None else f", such as `{meant}: {in_flow_style(example)}`,"
    return f"write `{meant}`{such} in place of `{key}`"


def _counted(path: KeyPath) -> str:
    """Return the key of a mapping that counts bricks; empty if it has none."""
    from stackdsl.language.json_schema import description_at, keys_at  # noqa: PLC0415 -- only mistakes need it

    keys = (key for key in keys_at(path) if _permits((*path, key), "<= 0"))
    return next((key for key in keys if description_at((*path, key)).startswith("number of")), "")


def _lists_of(written: object, source: Source) -> str:
    """Return the lists that a file to be included has; all lists if it cannot be read."""
    found: list[str] = []
    try:
        root = root_of(source.file)
        file = file_in_project(str(written), source.file, root)
        found = [key for key in LISTS if any(key in each.values for each in load(FilePath(file), root).sources)]
    except (OutsideError, OSError):
        pass
    return _named(found).replace(", ", " or of ") if found else f"the list that the file has: {_named(LISTS)}"


def _place_of(key: str, path: KeyPath, written: object, source: Source) -> str:
    """Return the remedy for a key that belongs beside the mapping at a path, or in a value of it; empty if neither."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    for depth in reversed(range(len(path))):
        if depth == 0 and path[:1] != ("build",):
            break  # a key of all bricks means something else in a claim or an impact
        if isinstance(path[depth], str) and key in keys_at(path[:depth]):
            place = (*path[:depth], key)
            if place not in source.value_spans:
                return f"this key belongs beside `{path[depth]}`, not in it"
            line = source.key_span_of(place).line
            own = _own_kind(key, path, written, source)
            return f"`{key}` is set beside `{path[depth]}` in line {line}, so remove it here{own}"
    parents = [sibling for sibling in keys_at(path) if key in keys_at((*path, sibling))]
    lists = [sibling for sibling in keys_at(path) if key in keys_at((*path, sibling, 0))]
    if len(parents) == 1:
        return f"this key belongs in `{parents[0]}`: write `{parents[0]}: {in_flow_style({key: written})}`"
    if lists:
        return f"this key belongs in an item of `{lists[0]}`"
    of_all = [first for first in keys_at(()) if key in keys_at((first,))] if path else []
    return f"this key belongs in `{of_all[0]}`, beside `build`" if len(of_all) == 1 else ""


def _own_kind(key: str, path: KeyPath, written: object, source: Source) -> str:
    """Return how the bricks of one step get their own value of a key of all bricks; empty for other keys."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    if path[:1] != ("build",) or key not in keys_at(("brick",)):
        return ""
    whole: object = source.values.get("brick", "kapla")
    if isinstance(whole, str) and whole in CATALOGUE:
        sides = [f"{1000 * side:g} mm" for side in CATALOGUE[whole].size]
        whole = {"size": sides, "density": f"{CATALOGUE[whole].density:g} kg/m3"}
    kind = (
        in_flow_style({**whole, key: written})
        if isinstance(whole, dict)
        else f"{{..., {key}: {in_flow_style(written)}}}"
    )
    return f"; for the bricks of this step alone, write `brick: {kind}` beside `{path[2]}`"


def keys_called(word: str, keys: Iterable[str]) -> list[str]:
    """Return the keys that new users call by this word."""
    return [key for key, words in WORDS.items() if key in keys and word.lower() in words.split()]


def _synonym(word: str, keys: Iterable[str], written: object, path: KeyPath) -> str:
    """Return the key meant by a word in the mapping at a path: the first that permits its value, or the first."""
    meant = keys_called(word, keys)
    suits = (key for key in meant if isinstance(written, str) and _permits((*path, key), written))
    return next(suits, meant[0] if meant else "")


SINE: Final = ", frequency: 2 Hz, for: 2 s"  # the other keys of a shake


ENTRY: Final = re.compile(r"\(?\s*(\w+)\s*[=:]?\s*([^\s=:].*?)\s*\)?")  # a key and its value in one text
COUNTS: Final[Mapping[str | bool, str]] = {"any": ">= 1", True: ">= 1", "none": "<= 0", False: "<= 0"}


def _as_mapping(written: object, path: KeyPath) -> str:
    """Return the remedy for a scalar in place of a mapping: the key for the scalar, or the keys of the mapping."""
    from stackdsl.language.json_schema import description_at, keys_at, nodes_at  # noqa: PLC0415 -- only mistakes need it

    keys = keys_at(path)
    if remedy := _in_other_form(written, path, keys):
        return remedy
    if isinstance(written, int) and not isinstance(written, bool):
        counts = [key for key in keys if any(node.get("type") == "integer" for node in nodes_at((*path, key)))]
        if len(counts) == 1:
            return f"write {{{counts[0]}: {written}}}: {description_at((*path, counts[0]))}"
    if isinstance(written, str) and (pair := ENTRY.fullmatch(written)) and pair[1] in keys:
        return f"write {{{pair[1]}: {pair[2]}}}"
    if PLACED.fullmatch(str(written)) and (entry := _entry_for(written, path)):
        return f"write {entry}"
    if isinstance(written, str | bool) and written in COUNTS and (counted := _counted(path)):
        return f"write {{{counted}: {in_flow_style(COUNTS[written])}}}"
    key, text = _key_for(written, path, keys), in_flow_style(written)
    companion = f", density: {BrickKind.examples['density']}" * (key == "size" and "density" in keys)
    if key and isinstance(written, str) and _permits((*path, key), limit := f">= {written}"):
        text = f'"{limit}"'
    companion = SINE if path[-1:] == ("shake",) and key == "acceleration" else companion
    entry = f"{{{key}: {text}{companion}}}"
    example = f"write {entry}; " if key else ""
    if len(keys) > MOST_EXPLAINED:
        return f"{example}the keys are {', '.join(keys)}"
    descriptions = {key: description_at((*path, key)).partition(";")[0] for key in keys}
    return f"{example}the keys are {', '.join(f'{key} ({text})' for key, text in descriptions.items())}"


def _in_other_form(written: object, path: KeyPath, keys: Sequence[str]) -> str:
    """Return the remedy for a value that is no mapping, but has or names one; empty for other values."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    for depth in reversed(range(len(path) - 1)):  # the same key above, such as the friction of all bricks
        is_above = path[-1] in keys_at(path[:depth]) and _has_type_of((*path[:depth], path[-1]), written)
        if isinstance(written, int | float) and is_above:
            return f"write `{path[-1]}: {written}` beside `{path[depth]}`"
    if isinstance(written, list) and any(isinstance(item, dict) for item in written):
        return "write the mapping itself, without the list around it: remove its '- ' or its brackets"
    if written in keys:
        return _with_value(str(written), path)
    pair = ENTRY.fullmatch(written) if isinstance(written, str) else None
    return f"write {{{pair[1]}: {pair[2]}}}" if pair and pair[1] in keys else ""


def _key_for(written: object, path: KeyPath, keys: Sequence[str]) -> str:
    """Return the key whose value the text or list may be: the first that permits it; empty if none does."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    fitting = [key for key in keys if _has_type_of((*path, key), written)]
    if not isinstance(written, str):
        return fitting[0] if len(fitting) == 1 or (fitting and isinstance(written, list | tuple)) else ""
    for text in (written, f">= {written}"):  # a value, or the limit of a tolerance
        if key := next((key for key in fitting if _permits((*path, key), text)), ""):
            return key
    is_free = any(node.get("type") == "string" and "pattern" not in node for node in nodes_at((*path, *keys[:1])))
    return keys[0] if keys and is_free else ""


def _entry_for(written: object, path: KeyPath) -> str:
    """Return the mapping with the one key whose values have this form: `{at: level 10}`; empty if none has."""
    from stackdsl.language.json_schema import keys_at  # noqa: PLC0415 -- only mistakes need it

    if not isinstance(written, str):
        return ""
    for items in ((), (0,)):  # a value, or an item of a list
        for key in keys_at(path):
            here = (*path, key, *items)
            if _permits(here, written) and (PLACED.fullmatch(written) or not _permits(here, ANY_WORD)):
                return f"{{{key}: {f'[{written}]' if items else in_flow_style(written)}}}"
    limits = (key for key in keys_at(path) if _permits((*path, key), f">= {written}"))
    return next((f'{{{key}: ">= {written}"}}' for key in limits), "")


PLACED: Final = re.compile(r"L\d+\.\d+")  # the name of a brick of a layout


def _fits(path: KeyPath, written: object) -> bool:
    """Return whether a value may stand at a path, as far as its form shows."""
    from stackdsl.language.json_schema import keys_at, nodes_at  # noqa: PLC0415 -- only mistakes need it

    if isinstance(written, dict):
        return bool(written) and {*written} <= {*keys_at(path)}
    if not isinstance(written, str):
        return _has_type_of(path, written)
    names = (node.get("enum", ()) for node in nodes_at(path))
    return _permits(path, written) or any(written in each for each in names)


def _has_type_of(path: KeyPath, written: object) -> bool:
    """Return whether the values at a path may be lists, texts or numbers, as this value is."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    is_list, is_text = isinstance(written, list | tuple), isinstance(written, str)
    types = ("array",) if is_list else ("string",) if is_text else ("number", "integer")
    return not isinstance(written, bool) and any(node.get("type") in types for node in nodes_at(path))


def _permits(path: KeyPath, text: str) -> bool:
    """Return whether a text has the form of the values at a path."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    patterns = (node["pattern"] for node in nodes_at(path) if node.get("type") == "string" and "pattern" in node)
    return any(re.fullmatch(pattern, text) for pattern in patterns)


def in_flow_style(written: object) -> str:
    """Return a value as YAML in braces."""
    if isinstance(written, dict):
        return f"{{{', '.join(f'{key}: {in_flow_style(value)}' for key, value in written.items())}}}"
    if isinstance(written, bool):
        return str(written).lower()
    if isinstance(written, list | tuple):
        return f"[{', '.join(map(in_flow_style, written))}]"
    text = str(written)
    return f'"{text}"' if re.search(r"^[>@&*!|%`]|[{}\[\],:#]", text) else text


def _with_value(key: str, path: KeyPath) -> str:
    """Return the remedy for a key without a value: `stands: all` if the value can be a word."""
    from stackdsl.language.json_schema import word_at  # noqa: PLC0415 -- only mistakes need it

    word = word_at((*path, key))
    return f"write `{key}: {word}`" + (" and its value" * (not word))


def _entry_at(path: KeyPath) -> str:
    """Return a missing key with a value that is valid there, if the schema has one."""
    from stackdsl.language.json_schema import example_at  # noqa: PLC0415 -- only mistakes need it

    example = example_at(path)
    return f"`{path[-1]}`" if example is None else f"`{path[-1]}: {in_flow_style(example)}`"


def _system(written: str, choices: Sequence[str]) -> str:
    """Return the remedy for a word that is no system."""
    return engine_remedy(written) or did_you_mean(written, choices) + _other_systems()


def _other_systems() -> str:
    """Return the hint on systems of other packages, which a scenario cannot name, as not every user has them."""
    installed = f"; installed: {', '.join(offered_systems())}" if offered_systems() else ""
    return f"; systems of other packages are chosen with --system{installed}"


def _with_meaning(remedy: str, path: KeyPath) -> str:
    """Return a remedy with the description of the value."""
    from stackdsl.language.json_schema import description_at  # noqa: PLC0415 -- only mistakes need it

    return ": ".join(filter(None, [remedy, description_at(path)]))


def _within(path: KeyPath) -> str:
    """Return the remedy for a value beyond its limits."""
    from stackdsl.language.json_schema import nodes_at  # noqa: PLC0415 -- only mistakes need it

    schema = {key: limit for node in reversed(list(nodes_at(path))) for key, limit in node.items()}
    for least, most, noun in LIMITS:
        if least not in schema:
            continue
        nouns = noun.removesuffix("s") if schema[least] == 1 else noun
        if schema.get(most) == schema[least]:
            return f"write {schema[least]:g}{nouns}"
        return (
            f"write {schema[least]:g} to {schema[most]:g}{noun}"
            if most in schema
            else (f"write at least {schema[least]:g}{nouns}")
        )
    return ""


def _list_of(written: float | str, path: KeyPath) -> str:
    """Return the remedy for a scalar in place of a list."""
    from stackdsl.language.json_schema import keys_at, nodes_at  # noqa: PLC0415 -- only mistakes need it

    if keys := keys_at((*path, 0)):
        return _with_value(str(written), (*path, 0)).replace("`", "`- ", 1) if written in keys else _ITEMS
    permitted = [value for node in nodes_at((*path, 0)) for value in node.get("enum", ())]
    if permitted and written not in permitted:
        return ("systems" in path and engine_remedy(str(written))) or did_you_mean(str(written), permitted)
    least = next((int(node["minItems"]) for node in nodes_at(path) if "minItems" in node), 1)
    if least == 3 and (listed := triple(str(written))):  # noqa: PLR2004 -- axes
        return f"write {listed}"
    if path[-1:] == ("rotate",):
        unit = "" if str(written).endswith(("deg", "rad", "°")) else " deg"
        return f"write [0 deg, 0 deg, {written}{unit}] to turn it about z"
    return f"write [{written}]" if least == 1 else f"write a list of {least} items"


def _form(detail: ErrorDetails) -> str:
    """Return the remedy for a value of the wrong type."""
    written = detail["input"]
    match detail["type"]:
        case "tuple_type" if isinstance(written, dict):
            return _ITEMS
        case "tuple_type" if isinstance(written, str | int | float):
            return _list_of(written, detail["loc"])
        case "int_type" | "float_type" if isinstance(written, str) and written[:1] in "${":
            return f'write "${{{written.strip("${} ")}}}" if it is an expression'
        case "int_type" | "float_type" if isinstance(written, str) and (number := NUMBER.fullmatch(written.strip())):
            bare = f"{float(number[1]) / 100:g}" if number[2] == "%" else number[1]
            return f"write {bare}, without {REST[number[2]]}"
        case "int_type" if isinstance(written, float) and written.is_integer():
            return f"write {int(written)}"
        case "int_type" | "float_type" if isinstance(written, str) and re.fullmatch(
            r"[\d.()]+\s*[*/+][\d\s.*/+()]+", written
        ):
            return f'write "${{{written}}}"'
        case "int_type" | "float_type":
            return _within(detail["loc"]) or f"write {WANTED[detail['type']]}"
        case "string_type":
            return "write text in its place" if isinstance(written, bool) else "quote it"
    return f"write {WANTED[detail['type']]}" if detail["type"] in WANTED else ""


# Scenarios that are skipped without an optional package: `skip: {reason: ..., without: mujoco}`.


_REPORTED_KEYS: Final = ("scenario", "description", "tags", "systems", "let", "matrix", "cases", "exclude", "skip")
_PLACEHOLDER: Final[dict[str, Plain]] = {"brick": "kapla", "build": [{"column": {"levels": 1}}]}


def report_missing_dependency(source: Source) -> Source | None:
    """Return a stand-in for a scenario that is skipped since a package is missing; None for any other scenario.

    Its build steps are replaced by a placeholder, since reading them may need the package.
    """
    skip = source.values.get("skip")
    package = skip.get("without") if isinstance(skip, dict) else None
    if not isinstance(package, str) or package not in get_args(Package) or is_installed(package):
        return None
    values: dict[str, Plain] = {key: source.values[key] for key in _REPORTED_KEYS if key in source.values}
    return replace(source, values=values | _PLACEHOLDER)
