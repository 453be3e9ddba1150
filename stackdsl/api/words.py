"""Functions of the Python API: one for each layout, impact and claim, generated from their models.

Parameters and descriptions are those of the JSON Schema, so that YAML and Python have the same keys. A function is
generated at its first use. For type checkers and editors, a build writes all signatures to `.pyi` files.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, wraps
from inspect import signature
from pathlib import Path
from typing import Any, Final, TypeAlias

from pydantic import BaseModel, TypeAdapter

from stackdsl.api.python_remedies import python_name
from stackdsl.api.written import HERE, Part, Written, written
from stackdsl.diagnostics import choice_text, meant_choice, missing_attribute
from stackdsl.language.claims.claim import Expectation, Truth
from stackdsl.language.claims.claim_kind import CLAIMS
from stackdsl.language.impacts import IMPACTS, Impact
from stackdsl.language.layouts.registry import LAYOUTS
from stackdsl.language.model_base import Kinds
from stackdsl.language.schema import BuildStep
from stackdsl.language.validation import keys_called

Schema: TypeAlias = Mapping[str, Any]
Keys: TypeAlias = dict[str, tuple[str, str]]  # Python type and description, by key
Function: TypeAlias = Callable[..., Written]

TIME: Final = {"at": "when"}  # the time of a step, since some layouts have a position `at`
NOT_TAKEN: Final = ("repeat", "bricks", "imported")  # Python has loops, and `single_bricks` has the others
DESCRIPTIONS: Final = {"source": "for a claim under `truth`: the source of the value"}  # of keys without one
WIDTH: Final = 116  # [characters] of a line of a docstring
SCALARS: Final = {"integer": "int", "number": "float", "boolean": "bool", "string": "str"}


class Words:
    """The generated functions of one module of this package."""

    def __init__(self, name: str, kinds: Kinds[Any], attribute: str, *beside: type[BaseModel]) -> None:
        self.name, self._kinds, self._attribute, self._models = name, kinds, attribute, beside
        self._made: dict[str, Function] = {}

    def names(self) -> list[str]:
        return list(map(python_name, self._kinds))

    def function(self, name: str) -> Function:
        """Return the function of a name. Raises AttributeError for an unknown name, as modules do."""
        if name not in self._made:
            key = next((key for key in self._kinds if python_name(key) == name), None)
            if key is None:
                raise missing_attribute(self.name, name, self._remedy(name))
            self._made[name] = self._function(key)
        return self._made[name]

    def _remedy(self, name: str) -> str:
        """Return the remedy for an unknown name: a call that has its meaning, or the names."""
        meant = next(iter(keys_called(name, self._kinds)), "") or meant_choice(name, self.names())
        plain = self._shape(meant)[0] if meant in self._kinds else []
        word = next((shape["const"] for shape in plain if isinstance(shape.get("const"), str)), "")
        return f'write {self.name}.{meant}("{word}")' if word else choice_text(meant or name, self.names())

    def stub(self) -> str:
        """Return the text of the `.pyi` file of the module."""
        functions = [f"{self._head(key, *self._shape(key))}    ...\n" for key in self._kinds]
        head = "from collections.abc import Mapping, Sequence\n\nfrom stackdsl.api.written import Written\n"
        return "\n".join([head, *functions])

    def _function(self, key: str) -> Function:
        plain, own = self._shape(key)

        def collected(arguments: Mapping[str, object]) -> Written:
            what = arguments.get("what")
            value = {name: arguments[python_name(name)] for name in own} if what is None else what
            values = {key: value, **{name: arguments[_beside(name)] for name in self._beside}}
            return written(values, Part(self.name.removesuffix("s")))

        names: dict[str, Any] = {"Mapping": Mapping, "Sequence": Sequence, "Written": Written, "collected": collected}
        names["__name__"] = f"{__package__}.{self.name}"
        code = f"{self._head(key, plain, own)}    return collected(locals())\n"
        # Executed as source code, so that Python checks the arguments of a call. The file name is in this folder, so
        # that `callers_place` skips the frame.
        exec(compile(code, str(Path(HERE, f"<{key}>")), "exec"), names)
        made: Function = names[python_name(key)]
        parameters = [name for name in signature(made).parameters if name != "what"]

        @wraps(made)
        def checked(*what: object, **keys: object) -> Written:
            __tracebackhide__ = True  # pytest shows the line of the caller
            for name in keys.keys() - parameters:
                raise TypeError(f"{self.name}.{made.__name__} has no key '{name}'; {choice_text(name, parameters)}")
            return made(*what, **keys)

        return checked

    def _shape(self, key: str) -> tuple[list[Schema], Keys]:
        """Return the schemas of values that may replace the keys of a kind, and these keys."""
        schema = TypeAdapter(getattr(self._kinds[key], self._attribute)).json_schema()
        shapes = schema.get("anyOf", [schema])
        mapping: Schema = next((shape for shape in shapes if "properties" in shape), {})
        return [shape for shape in shapes if "properties" not in shape], _keys_of(mapping, schema.get("$defs", {}))

    @cached_property
    def _beside(self) -> Keys:
        """The common keys of all kinds, such as the time of a step."""
        fields = {key: field for model in self._models for key, field in model.model_fields.items()}
        keys = {}
        for key, field in fields.items():
            if key not in NOT_TAKEN:
                schema = TypeAdapter(field.rebuild_annotation()).json_schema()
                keys[key] = _type(schema, schema.get("$defs", {})), DESCRIPTIONS.get(key) or field.description or ""
        return keys

    def _head(self, key: str, plain: Sequence[Schema], own: Keys) -> str:
        """Return the source code of a function, up to its docstring."""
        parameters = {python_name(name): described for name, described in own.items()}
        parameters |= {_beside(name): described for name, described in self._beside.items()}
        if len(parameters) < len(own) + len(self._beside):
            raise ValueError(
                f"a key of {key} is also a common key of all kinds: give one of them another name in Python"
            )
        lines = [f"def {python_name(key)}("]
        if plain:
            kinds_of_plain = " | ".join(dict.fromkeys(_type(shape, {}) for shape in plain))
            lines += [f"    what: {kinds_of_plain}{' | None = None' if own else ''},", "    /,"]
        lines += ["    *,", *(f"    {name}: {kind} | None = None," for name, (kind, _) in parameters.items())]
        lines += [") -> Written:", f'    """{_sentence(self._kinds[key].summary)}', ""]
        lines += _wrapped("what", _plain_text(plain)) if plain else []
        lines += [line for name, (_, description) in parameters.items() for line in _wrapped(name, description)]
        return "\n".join([*lines, '    """', ""])


def _beside(key: str) -> str:
    return TIME.get(key, python_name(key))


def _keys_of(schema: Schema, definitions: Schema) -> Keys:
    properties = schema.get("properties", {})
    return {key: (_type(value, definitions), value.get("description", "")) for key, value in properties.items()}


def _type(schema: Schema, definitions: Schema) -> str:
    """Return the Python type of the values of a schema."""
    if "$ref" in schema:
        return _type(definitions[schema["$ref"].rsplit("/", 1)[-1]], definitions)
    if "anyOf" in schema and schema.get("type") != "string":
        parts = (_type(part, definitions) for part in schema["anyOf"] if part.get("type") != "null")
        return " | ".join(dict.fromkeys(kind for part in parts for kind in part.split(" | ")))
    if "allOf" in schema:
        return _type(schema["allOf"][0], definitions)
    if "enum" in schema or "const" in schema:
        values = schema.get("enum", [schema.get("const")])
        return " | ".join(dict.fromkeys(type(value).__name__ for value in values))
    match schema.get("type"):
        case "array":
            return f"Sequence[{_type(schema.get('items') or schema['prefixItems'][0], definitions)}]"
        case "object":
            return "Mapping[str, object]"
        case str(name):
            return SCALARS[name]
    return "object"


def _plain_text(plain: Sequence[Schema]) -> str:
    """Describe the values that may replace the keys."""
    words = [value for shape in plain for value in shape.get("enum", [shape["const"]] if "const" in shape else [])]
    if words:
        return " or ".join(f"`{word}`" for word in words)
    return next((shape["description"] for shape in plain if "description" in shape), "the value alone")


def _wrapped(name: str, description: str) -> list[str]:
    """Return the description of a parameter, wrapped to lines of a docstring."""
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


LAYOUT_WORDS: Final = Words("layouts", LAYOUTS, "params", BuildStep)
IMPACT_WORDS: Final = Words("impacts", IMPACTS, "model", Impact)
CLAIM_WORDS: Final = Words("claims", CLAIMS, "model", Expectation, Truth)
