"""JSON schema of a scenario, for editors and for the remedies of mistakes."""

import json
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, lru_cache
from typing import Any, Final

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from stackdsl.language import value_types
from stackdsl.language.layouts.registry import LayoutParams
from stackdsl.language.schema import Scenario, models
from stackdsl.language.value_types import DISTRIBUTION_PATTERN, EXPRESSION_PATTERN, FILE, Reads
from stackdsl.language.yaml.includes import INCLUDE, LISTS
from stackdsl.language.yaml.source import KeyPath

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"
PUBLISHED: Final = "http://json-schema.org/draft-07/schema#"  # also read by old language servers for YAML


_INCLUDE: Final = {
    "description": "Insert all items of the list with the same key in another file.",
    "type": "object",
    "properties": {INCLUDE: FILE},
    "required": [INCLUDE],
    "additionalProperties": False,
}


class _ForEditors(GenerateJsonSchema):
    """Schema generator: any scalar may be an expression; a key may be absent, but not null."""

    def int_schema(self, schema: core_schema.IntSchema) -> JsonSchemaValue:
        return _or_expression(super().int_schema(schema))

    def float_schema(self, schema: core_schema.FloatSchema) -> JsonSchemaValue:
        return _or_expression(super().float_schema(schema), f"{EXPRESSION_PATTERN}|{DISTRIBUTION_PATTERN}")

    def bool_schema(self, schema: core_schema.BoolSchema) -> JsonSchemaValue:
        return _or_expression(super().bool_schema(schema))

    def nullable_schema(self, schema: core_schema.NullableSchema) -> JsonSchemaValue:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
        json_schema = super().default_schema(schema)
        return {key: value for key, value in json_schema.items() if (key, value) != ("default", None)}

    def field_title_should_be_set(self, schema: object) -> bool:
        return False


def _or_expression(schema: JsonSchemaValue, pattern: str = EXPRESSION_PATTERN) -> JsonSchemaValue:
    return {"anyOf": [schema, {"type": "string", "pattern": pattern}]}


def json_schema() -> JsonSchemaValue:
    """Return the JSON schema of a scenario. The content of expressions is not checked."""
    return _json_schema_of(models().Scenario)


@cache
def _json_schema_of(scenario: type[Scenario]) -> JsonSchemaValue:
    schema = scenario.model_json_schema(schema_generator=_ForEditors)
    for owner, key in [*((schema, key) for key in LISTS), (schema["$defs"]["BuildStep"], "bricks")]:
        items = owner["properties"][key]
        items["items"] = {"anyOf": [items["items"], {"$ref": "#/$defs/Include"}]}
    schema["$defs"]["Include"] = _INCLUDE
    return {"$schema": DIALECT, **schema, "title": "StackDSL scenario"}


def schema_text() -> str:
    """Return the text of the JSON schema for editors, in draft 7. Repeated parts are written once, in `$defs`."""
    quantities, layout_keys = _quantities(), _keys_of_layouts()
    names = {_text_of(_bare(schema)): name for name, schema in reversed(quantities.items())}
    schema = json_schema()
    definitions = {**_shared(layout_keys, names), **quantities}
    names |= {_text_of(schema): name for name, schema in layout_keys.items()}
    whole = {**_shared(schema, names), "$schema": PUBLISHED}
    used = json.dumps(whole) + json.dumps(definitions)
    whole["$defs"] |= {name: each for name, each in definitions.items() if f'"{_reference(name)}"' in used}
    return json.dumps(_as_draft_7(whole), indent=2, ensure_ascii=False) + "\n"


def _quantities() -> dict[str, JsonSchemaValue]:
    """Return the schemas of quantities by the names of their types."""
    kinds = {name: getattr(kind, "__metadata__", ()) for name, kind in vars(value_types).items()}
    return {name: dict(read.schema) for name, kind in kinds.items() for read in kind[:1] if isinstance(read, Reads)}


def _keys_of_layouts() -> dict[str, JsonSchemaValue]:
    """Return the schemas of the keys that all layouts have."""
    keys = LayoutParams.model_json_schema(schema_generator=_ForEditors)["properties"]
    return {f"Layout{key.capitalize()}": schema for key, schema in keys.items()}


def _shared(value: Any, names: Mapping[str, str]) -> Any:  # noqa: ANN401 -- JSON
    """Return a part of a schema with named schemas replaced by references."""
    if isinstance(value, list):
        return [_shared(item, names) for item in value]
    if not isinstance(value, dict):
        return value
    if name := names.get(_text_of(value)):
        return {"$ref": _reference(name)}
    if name := names.get(_text_of(bare := _bare(value))):
        return {"$ref": _reference(name), **{key: member for key, member in value.items() if key not in bare}}
    return {key: _shared(member, names) for key, member in value.items()}


def _bare(schema: JsonSchemaValue) -> JsonSchemaValue:
    """Return a schema without the keys that depend on its place: description and default."""
    return {key: member for key, member in schema.items() if key not in ("description", "default")}


def _text_of(schema: JsonSchemaValue) -> str:
    return json.dumps(schema, sort_keys=True)


def _reference(name: str) -> str:
    return f"#/$defs/{name}"


def _as_draft_7(value: Any) -> Any:  # noqa: ANN401 -- JSON
    """Convert a schema to draft 7: tuples by `items`, and no keys beside a `$ref`, since draft 7 ignores them."""
    if isinstance(value, list):
        return [_as_draft_7(item) for item in value]
    if not isinstance(value, dict):
        return value
    spelt = {{"prefixItems": "items"}.get(key, key): _as_draft_7(member) for key, member in value.items()}
    if "$ref" in spelt and len(spelt) > 1:
        return {"allOf": [{"$ref": spelt.pop("$ref")}], **spelt}
    return spelt


def keys_at(path: KeyPath) -> tuple[str, ...]:
    """Return the keys that are allowed in the mapping at a path."""
    return tuple(key for node in nodes_at(path) for key in node.get("properties", {}))


def description_at(path: KeyPath) -> str:
    """Return the description of the value at a path; empty if there is none."""
    return next((str(node["description"]) for node in nodes_at(path) if "description" in node), "")


def word_at(path: KeyPath) -> str:
    """Return the word that may stand at a path in place of a mapping, such as `all`; empty if there is none."""
    return next((node["const"] for node in nodes_at(path) if isinstance(node.get("const"), str)), "")


def choices_at(path: KeyPath) -> tuple[str, ...]:
    """Return the keys of which the mapping at a path has exactly one."""
    return tuple(key for node in nodes_at(path) for one in node.get("oneOf", ()) for key in one["required"])


def rivals_at(path: KeyPath) -> tuple[str, ...]:
    """Return the keys of which a mapping has exactly one, if the key at the end of a path is one of them."""
    nodes = [inner for node in nodes_at(path[:-1]) for inner in (node, *node.get("allOf", ()))]
    choices = [[key for one in node["oneOf"] for key in one.get("required", ())] for node in nodes if "oneOf" in node]
    return next((tuple(keys) for keys in choices if path[-1] in keys), ())


def example_at(path: KeyPath) -> Any:  # noqa: ANN401 -- any value of YAML
    """Return a value that is valid at a path; None if the schema has no example of it."""
    return _example(nodes_at(path))


def _example(nodes: Iterable[JsonSchemaValue]) -> Any:  # noqa: ANN401 -- likewise
    for node in nodes:
        if "examples" in node:
            return node["examples"][0]
        if isinstance(node.get("const"), str):
            return node["const"]
        if "enum" in node:
            return node["enum"][0]
        match node.get("type"):
            case "integer" | "number":
                return max(node.get("minimum", 1), 1)
            case "boolean":
                return True
            case "array":
                items = node.get("prefixItems") or [node["items"]] * max(node.get("minItems", 1), 1)
                listed = [_example(_alternatives(item)) for item in items]
                return None if None in listed else listed
            case "object" if "properties" in node:
                return _example_of_mapping(node)
    return None


def _example_of_mapping(node: JsonSchemaValue) -> Any:  # noqa: ANN401 -- likewise
    """Return a mapping with the required keys, and the first of the keys of which one is required."""
    several = [node, *node.get("allOf", ())]
    chosen = [key for each in several for key in each.get("oneOf", [{"required": []}])[0]["required"]]
    keys = dict.fromkeys([*chosen, *node.get("required", ())]) or list(node["properties"])[:1]
    counted = node.get("then", {}).get("properties", {})
    made = {}
    for key in keys:
        made[key] = _example(_alternatives(node["properties"][key]))
        for more in counted.get(key, {}).get("required", ()):
            made[key] = {**(made[key] or {}), more: 1}
    return None if None in made.values() else made


def nodes_at(path: KeyPath) -> Iterator[JsonSchemaValue]:
    """Return the schema nodes of a path, the nearest first."""
    yield from _nodes_at(tuple(0 if isinstance(key, int) else key for key in path), models().Scenario)


@lru_cache(maxsize=1000)  # one mistake repeated in a hundred bricks looks up the same path a hundred times
def _nodes_at(path: KeyPath, scenario: type[Scenario]) -> tuple[JsonSchemaValue, ...]:
    return tuple(_uncached_nodes_at(path, scenario))


def _uncached_nodes_at(path: KeyPath, scenario: type[Scenario]) -> Iterator[JsonSchemaValue]:
    if not path:
        yield from _alternatives(json_schema())
        return
    for parent in _nodes_at(path[:-1], scenario):
        child = parent.get("items") if isinstance(path[-1], int) else parent.get("properties", {}).get(path[-1])
        child = child or next(iter(parent.get("patternProperties", {}).values()), None)  # keys that authors choose
        if isinstance(child, dict):
            yield from _alternatives(child)


def _alternatives(node: JsonSchemaValue) -> Iterator[JsonSchemaValue]:
    """Yield a node and, recursively, the nodes of its references and alternatives."""
    yield node
    definitions = json_schema().get("$defs", {})
    reference = str(node.get("$ref", "")).rpartition("/")[2]
    for other in [definitions.get(reference), *node.get("anyOf", [])]:
        if other is not None:
            yield from _alternatives(other)
