"""Writes the functions of `stackdsl.api` that stand for layouts, impacts and claims, from the models of the language.

Run by `make words`; a test sees that what is committed is what this writes. Signatures and descriptions are those of
the JSON Schema, so that YAML and Python take the same words.
"""

from collections.abc import Iterator, Mapping
from keyword import iskeyword
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter

from stackdsl.language.claims.claim_kind import CLAIMS
from stackdsl.language.impacts import IMPACTS
from stackdsl.language.layouts.registry import LAYOUTS
from stackdsl.language.model_base import Kinds
from stackdsl.language.schema import models

Schema = Mapping[str, Any]

API: Final = Path(__file__).parent.parent / "stackdsl" / "api"
HEAD: Final = '''"""{title}

Written by `make words` from the models of the language; docs/language.md says more of every key. What is left out, or
None, is not written, and has its default there. Quantities are texts with their units, as in YAML: "12 mm".
"""

from collections.abc import Mapping, Sequence

from stackdsl.api.written import Written, written

'''
TIME: Final = {"at": "when"}  # of a step; `at` is a place in what it does
LOOPS: Final = ("repeat",)  # Python has its own
WIDTH: Final = 116  # [characters] of a line of a docstring
SCALARS: Final = {"integer": "int", "number": "float", "boolean": "bool", "string": "str"}


def texts() -> Iterator[tuple[Path, str]]:
    """The path and the text of each module."""
    made = models()
    step = _fields(made.BuildStep, [*LAYOUTS, "bricks", "import"])
    yield API / "layouts.py", _module("Layouts, each a step of the build.", LAYOUTS, "params", step)
    yield API / "impacts.py", _module("Impacts.", IMPACTS, "model", _fields(made.Impact, IMPACTS))
    told = _fields(made.Expectation, CLAIMS) | _fields(made.Truth, CLAIMS)
    told["source"] = (told["source"][0], "of what is known from outside: where from")
    yield API / "claims.py", _module("Claims, for what is expected and for what is known.", CLAIMS, "model", told)


def _fields(model: type, but: Any) -> dict[str, tuple[str, str]]:  # noqa: ANN401 -- any container of names
    """Type and description of the keys of a model that are not among others."""
    schema = TypeAdapter(model).json_schema()
    found = _properties(schema, schema.get("$defs", {}))
    return {key: value for key, value in found.items() if key not in but and key not in LOOPS}


def _properties(schema: Schema, defs: Schema) -> dict[str, tuple[str, str]]:
    return {
        key: (_type(value, defs), value.get("description", "")) for key, value in schema.get("properties", {}).items()
    }


def _type(schema: Schema, defs: Schema) -> str:
    """The type of what a schema describes, as Python writes it."""
    if "$ref" in schema:
        return _type(defs[schema["$ref"].rsplit("/", 1)[-1]], defs)
    if "anyOf" in schema and schema.get("type") != "string":
        parts = (_type(part, defs) for part in schema["anyOf"] if part.get("type") != "null")
        return " | ".join(dict.fromkeys(one for part in parts for one in part.split(" | ")))
    if "allOf" in schema:
        return _type(schema["allOf"][0], defs)
    if "enum" in schema or "const" in schema:
        values = schema.get("enum", [schema.get("const")])
        return " | ".join(dict.fromkeys(type(value).__name__ for value in values))
    match schema.get("type"):
        case "array":
            items = schema.get("items") or schema["prefixItems"][0]
            return f"Sequence[{_type(items, defs)}]"
        case "object":
            return "Mapping[str, object]"
        case str(name):
            return SCALARS[name]
    return "object"


def _module(title: str, kinds: Kinds[Any], attribute: str, common: dict[str, tuple[str, str]]) -> str:
    functions = [_function(key, getattr(kind, attribute), kind.summary, common) for key, kind in kinds.items()]
    body = "\n\n".join(functions)
    head = HEAD.format(title=title)
    used = [name for name in ("Mapping", "Sequence") if f"{name}[" in body]
    head = head.replace("import Mapping, Sequence", f"import {', '.join(used)}")
    return f"{head}\n{body}"


def _function(key: str, model: type, summary: str, common: dict[str, tuple[str, str]]) -> str:
    schema = TypeAdapter(model).json_schema()
    defs = schema.get("$defs", {})
    shapes = schema.get("anyOf", [schema])
    mapping = next((shape for shape in shapes if "properties" in shape), {})
    plain = [shape for shape in shapes if "properties" not in shape]
    own = _properties(mapping, defs)
    parameters = {_name(name): told for name, told in own.items()}
    parameters |= {TIME.get(name, _name(name)): told for name, told in common.items()}
    if len(parameters) < len(own) + len(common):
        raise SystemExit(f"a key of {key} is one of all that stand beside it, too: give it another name here")
    lines = [f"def {_name(key)}("]
    if plain:
        kinds_of_plain = " | ".join(dict.fromkeys(_type(shape, defs) for shape in plain))
        optional = f"{kinds_of_plain} | None = None" if own else kinds_of_plain
        lines += [f"    what: {optional},", "    /,"]
    lines += ["    *,"]
    lines += [f"    {name}: {kind} | None = None," for name, (kind, _) in parameters.items()]
    lines += [") -> Written:", f'    """{_sentence(summary)}', ""]
    if plain:
        lines += _told("what", _plain_text(plain))
    for name, (_, description) in parameters.items():
        lines += _told(name, description)
    lines += ['    """', f"    what_is_written = {_mapping(own)}"]
    value = (
        "what if what is not None else what_is_written" if plain and own else ("what" if plain else "what_is_written")
    )
    others = ", ".join(f'"{name}": {TIME.get(name, _name(name))}' for name in common)
    lines += [f'    return written({{"{key}": {value}, {others}}})', ""]
    if not own:
        lines = [line for line in lines if not line.strip().startswith("what_is_written =")]
    return "\n".join(lines)


def _plain_text(plain: list[Schema]) -> str:
    """What may stand in place of the keys."""
    words = [value for shape in plain for value in shape.get("enum", [shape["const"]] if "const" in shape else [])]
    if words:
        return " or ".join(f"`{word}`" for word in words)
    return next((shape["description"] for shape in plain if "description" in shape), "the value alone")


def _told(name: str, description: str) -> list[str]:
    """One line of a docstring, cut into as many as fit."""
    words = f"{name}: {description}".split()
    lines, line = [], "   "
    for word in words:
        if len(line) + 1 + len(word) > WIDTH:
            lines.append(line)
            line = "       "
        line += f" {word}"
    return [*lines, line]


def _sentence(summary: str) -> str:
    text = summary[:1].upper() + summary[1:]
    return text if text.endswith((".", "?")) else f"{text}."


def _mapping(own: dict[str, tuple[str, str]]) -> str:
    return "{" + ", ".join(f'"{name}": {_name(name)}' for name in own) + "}"


def _name(key: str) -> str:
    return f"{key}_" if iskeyword(key) else key


if __name__ == "__main__":
    for path, text in texts():
        path.write_text(text, encoding="utf-8")
