"""From plain values to a scenario, or to everything that is wrong with them: in plain words, each in its place."""

import json
import re
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Final, NamedTuple

from pydantic import ValidationError
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import ErrorDetails, core_schema

from stackdsl.diagnostics import Diagnostic, did_you_mean, reading_order
from stackdsl.entry_points import offered
from stackdsl.language.author_types import EXPRESSION_PATTERN
from stackdsl.language.disagreements import disagreements
from stackdsl.language.mistakes import MistakeError, shown
from stackdsl.language.schema import Scenario, models
from stackdsl.language.variants import Variant
from stackdsl.reading.source import Path, Source

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"

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
        scenario = models().Scenario.model_validate(variant.values)
    except ValidationError as error:
        details = error.errors(include_url=False)
        return None, _in_order(_diagnostic(source, detail) for detail in details if not _is_echo(detail))
    mistakes = _in_order(disagreements(scenario, source))
    return (None if mistakes else scenario), mistakes


def _in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    return tuple(sorted(set(diagnostics), key=reading_order))


def _is_echo(detail: ErrorDetails) -> bool:
    """Whether an error only follows from one that is reported elsewhere."""
    written = detail["input"]
    if isinstance(written, str) and "${" in written:
        return True
    # Pydantic counts the items that are valid.
    return detail["type"] == "too_short" and len(written) >= detail["ctx"]["min_length"]


def _diagnostic(source: Source, detail: ErrorDetails) -> Diagnostic:
    """One of pydantic's errors; levels of its path that the file has not are left to `span_of`."""
    path = detail["loc"]
    told = _told(detail)
    if told.code == "SD102" and detail["type"] == "missing":
        span = source.span_of(path[:-1])
    else:
        span = source.key_span_of(path) if told.code == "SD101" else source.span_of(path)
    return Diagnostic(told.code, span, told.message, told.hint)


def _told(detail: ErrorDetails) -> _Told:
    kind, path, written, terms = detail["type"], detail["loc"], detail["input"], detail.get("ctx", {})
    last = path[-1] if path else ""
    mistake = terms.get("error")
    if isinstance(mistake, MistakeError):
        return _Told(mistake.code, mistake.message, mistake.hint)
    match kind:
        case "extra_forbidden":
            return _Told("SD101", f"unknown key '{last}'", did_you_mean(str(last), keys_at(path[:-1])))
        case "missing" if isinstance(last, int):
            return _Told("SD103", "the list has too few items", f"write all of them: {_description(path[:-1])}")
        case "missing":
            return _Told("SD102", f"missing key '{last}'", f"add `{last}`, {_description(path)}")
        case "literal_error":
            choices = re.findall("'([^']*)'", terms["expected"])
            hint = did_you_mean(str(written), choices) + (_of_others() if "systems" in path else "")
            return _Told("SD104", f"{shown(written)} is not one of the choices", hint)
        case "model_type":
            return _Told("SD103", f"expected a mapping, not {shown(written)}", f"its keys: {', '.join(keys_at(path))}")
    if kind in RANGES:
        return _Told("SD104", RANGES[kind].format(value=shown(written), **terms), _with_meaning(_within(path), path))
    return _Told(
        "SD103", f"expected {WANTED.get(kind, kind)}, not {shown(written)}", _with_meaning(_form(detail), path)
    )


def _of_others() -> str:
    """Where systems are asked for that a scenario cannot name, as it is to be right or wrong alike for everybody."""
    found = f", and installed are: {', '.join(offered())}" if offered() else ""
    return f"; systems of other packages are asked for by --system{found}"


def _with_meaning(remedy: str, path: Path) -> str:
    """What to write, and what the value is for."""
    return ": ".join(filter(None, [remedy, _description(path)]))


def _within(path: Path) -> str:
    """Between which limits a value is to be written."""
    known = {key: limit for node in reversed(list(_nodes(path))) for key, limit in node.items()}
    for least, most, noun in LIMITS:
        if least in known and most in known:
            return f"write {known[least]:g} to {known[most]:g}{noun}"
        if least in known:
            return f"write at least {known[least]:g}{noun}"
    return ""


def _list_of(written: float | str, path: Path) -> str:
    """A list in place of one value: around it, unless more are due."""
    due = next((int(node["minItems"]) for node in _nodes(path) if "minItems" in node), 1)
    return f"write [{written}]" if due == 1 else f"write a list of {due}"


def _form(detail: ErrorDetails) -> str:
    """How a value of the type that is wanted is written."""
    written = detail["input"]
    match detail["type"]:
        case "tuple_type" if isinstance(written, dict):
            return "begin each item with `- `"
        case "tuple_type" if isinstance(written, str | int | float):
            return _list_of(written, detail["loc"])
        case "int_type" | "float_type" if isinstance(written, str) and MISWRITTEN.fullmatch(written):
            return f"write ${{{written.strip('${}')}}} if it is an expression"
        case "int_type" | "float_type":
            return _within(detail["loc"]) or f"write {WANTED[detail['type']]}"
        case "string_type":
            return "quote it"
    return f"write {WANTED[detail['type']]}" if detail["type"] in WANTED else ""


# --- the same for editors ---------------------------------------------------------------------------------------------


class _ForEditors(GenerateJsonSchema):
    """Any scalar may be an expression; a key may be absent, but not without a value."""

    def int_schema(self, schema: core_schema.IntSchema) -> JsonSchemaValue:
        return _or_expression(super().int_schema(schema))

    def float_schema(self, schema: core_schema.FloatSchema) -> JsonSchemaValue:
        return _or_expression(super().float_schema(schema))

    def bool_schema(self, schema: core_schema.BoolSchema) -> JsonSchemaValue:
        return _or_expression(super().bool_schema(schema))

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        json_schema = super().default_schema(schema)
        return {key: value for key, value in json_schema.items() if (key, value) != ("default", None)}

    def field_title_should_be_set(self, schema: object) -> bool:
        return False


def _or_expression(schema: JsonSchemaValue) -> JsonSchemaValue:
    return {"anyOf": [schema, {"type": "string", "pattern": EXPRESSION_PATTERN}]}


def json_schema() -> JsonSchemaValue:
    """What an author may write, as JSON Schema; expressions are not looked into."""
    return _json_schema_of(models().Scenario)


@cache
def _json_schema_of(scenario: type[Scenario]) -> JsonSchemaValue:
    schema = scenario.model_json_schema(schema_generator=_ForEditors)
    return {"$schema": DIALECT, **schema, "title": "StackDSL scenario"}


def schema_text() -> str:
    """The JSON schema as it is kept in `scenario.schema.json`."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def keys_at(path: Path) -> tuple[str, ...]:
    """The keys that an author may write in the mapping at a path."""
    return tuple(key for node in _nodes(path) for key in node.get("properties", {}))


def _description(path: Path) -> str:
    return next((str(node["description"]) for node in _nodes(path) if "description" in node), "")


def _nodes(path: Path) -> Iterator[JsonSchemaValue]:
    """The parts of the schema that speak of a path, the nearest first."""
    if not path:
        yield from _alternatives(json_schema())
        return
    for parent in _nodes(path[:-1]):
        within = parent.get("items") if isinstance(path[-1], int) else parent.get("properties", {}).get(path[-1])
        if isinstance(within, dict):
            yield from _alternatives(within)


def _alternatives(node: JsonSchemaValue) -> Iterator[JsonSchemaValue]:
    """A node, and what stands behind its references and alternatives."""
    yield node
    definitions = json_schema().get("$defs", {})
    reference = str(node.get("$ref", "")).rpartition("/")[2]
    for other in [definitions.get(reference), *node.get("anyOf", [])]:
        if other is not None:
            yield from _alternatives(other)
