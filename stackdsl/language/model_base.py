"""Base classes of the language: validated mappings, registries of keywords, and times tied to events."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Final, Generic, Self, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from stackdsl.diagnostics import meant_choice
from stackdsl.language.quantities import LONG_DURATION, InputError, parse_quantity, quantity_pattern, shown
from stackdsl.language.value_types import NAME, REPEAT, JsonSchema, Reads, TimeOfStep, text_schema

# Kinds of mappings in YAML, the base classes of the models of the language.


class AuthorModel(BaseModel):
    """A mapping in YAML."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _reject_nothing(cls, written: object) -> object:
        if written is None:
            raise InputError("SD103", "the value is missing", "write a value, or remove the key")
        return written


class ExactlyOneKey(AuthorModel):
    """A mapping that needs exactly one key of `one_of`, and exactly one of `also_one_of` if there are any."""

    one_of: ClassVar[tuple[str, ...]]
    also_one_of: ClassVar[tuple[str, ...]] = ()
    examples: ClassVar[Mapping[str, str]] = {}  # values of keys, for remedies

    @classmethod
    def example_of(cls, keys: Iterable[str]) -> str:
        """Return the first of these keys that has an example, with its value."""
        return next((f", such as {key}: {cls.examples[key]}" for key in keys if key in cls.examples), "")

    @property
    def kind(self) -> str:
        """Return the key of `one_of` that is written."""
        return next(key for key in self.one_of if getattr(self, key) is not None)

    @model_validator(mode="after")
    def _choose(self) -> Self:
        for keys in filter(None, (self.also_one_of, self.one_of)):
            written = [key for key in keys if getattr(self, key) is not None]
            if len(written) != 1:
                needed, present = (list(map(self._spelling, names)) for names in (keys, written))
                message = (
                    f"exactly one of the keys {', '.join(needed)} is required, not {' and '.join(present) or 'none'}"
                )
                hint = (
                    "keep one of them, or begin another item" if written else f"add one of them{self.example_of(keys)}"
                )
                raise InputError("SD108", message, hint)
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        schema = handler(core)
        mapping, choices = handler.resolve_ref_schema(schema), filter(None, (cls.one_of, cls.also_one_of))
        several = [{"oneOf": [{"required": [cls._spelling(key)]} for key in keys]} for keys in choices]
        mapping |= several[0] if len(several) == 1 else {"allOf": several}
        return schema

    @classmethod
    def _spelling(cls, key: str) -> str:
        return cls.model_fields[key].alias or key


class AtLeastOneKey(AuthorModel):
    """A mapping that needs at least one key besides those of `defaults`."""

    defaults: ClassVar[tuple[str, ...]] = ()  # optional keys that do not count

    @property
    def written_keys(self) -> tuple[str, ...]:
        """Return the keys that are written, without those of `defaults`."""
        return tuple(key for key in self._counted_keys() if getattr(self, key) is not None)

    @classmethod
    def _counted_keys(cls) -> tuple[str, ...]:
        return tuple(key for key in cls.model_fields if key not in cls.defaults)

    @model_validator(mode="after")
    def _need_a_key(self) -> Self:
        if not self.written_keys:
            cause = "the mapping contains no condition" if self.model_fields_set else "the mapping is empty"
            raise InputError("SD102", cause, f"add one of the keys {', '.join(self._counted_keys())}")
        return self


class NoWordError(InputError):
    """A scalar is not the word that may stand in place of a mapping."""


AFFIRMATIONS: Final = frozenset({"true", "yes"})
NEGATIONS: Final = frozenset({"false", "never", "no", "none", "not", "nothing", "0"})


class Shorthand(AuthorModel):
    """A mapping that may also be written as one scalar: the value of one key, or a word for the default mapping.

    The scalar is replaced by the mapping before validation. A union would report a mistake once for each alternative.
    """

    scalar_key: ClassVar[str] = ""
    scalar_word: ClassVar[str] = ""
    opposite: ClassVar[str] = ""  # the entry that says the contrary of the word

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        """Return the scalar as a mapping or as an instance; `known` are the names that the scenario defines."""
        if cls.scalar_key:
            return {cls.scalar_key: scalar}
        if scalar == cls.scalar_word:
            return cls.model_construct()
        message = f"expected '{cls.scalar_word}' or a mapping, not {shown(scalar)}"
        if cls.opposite and str(scalar).lower() in NEGATIONS:
            raise InputError("SD104", message, f"write `{cls.opposite}` in its place")
        if str(scalar).lower() in AFFIRMATIONS:
            raise InputError("SD104", message, f"write {cls.scalar_word}")
        raise NoWordError("SD104", message, f"write {cls.scalar_word}, or a mapping with the keys {cls._keys()}")

    @classmethod
    def _remedy(cls) -> str:
        return f"{f'write {cls.scalar_word}, or ' if cls.scalar_word else ''}add one of the keys {cls._keys()}"

    @classmethod
    def _keys(cls) -> str:
        return ", ".join(field.alias or name for name, field in cls.model_fields.items())

    @classmethod
    def scalar_schema(cls, properties: dict[str, JsonSchema]) -> JsonSchema:
        """Return the JSON schema of the scalar."""
        return properties[cls.scalar_key] if cls.scalar_key else {"const": cls.scalar_word}

    @model_validator(mode="wrap")
    @classmethod
    def _spell_out(cls, written: object, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        if written == {}:
            raise InputError("SD102", "the mapping is empty", cls._remedy())
        spelt = written if isinstance(written, dict | list | cls) else cls.spelt_out(written, info.context or {})
        return spelt if isinstance(spelt, cls) else handler(spelt)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        mapping = super().__get_pydantic_json_schema__(core, handler)
        return {"anyOf": [cls.scalar_schema(handler.resolve_ref_schema(mapping)["properties"]), mapping]}


def default(written: object, description: str) -> Any:  # noqa: ANN401 -- as `Field`, it stands for a value of any type
    """Return the field of an optional key, with its default as written in YAML, which editors show."""
    return Field(default=written, validate_default=True, description=description)


# Registries of layouts, claims and impacts. Each kind has a key in YAML and is registered by its own module.
#
# Code that needs a property of a kind asks the kind itself. Only the order of the keys in the JSON schema is written in
# one place, so that it does not depend on the order of imports.


Entry = TypeVar("Entry")
Model = TypeVar("Model", bound=ExactlyOneKey)


class Kinds(Mapping[str, Entry], Generic[Entry]):
    """Registry of kinds by their key in YAML, in the order of the JSON schema.

    The keys of `first` come first, in this order; all others follow by name.
    """

    def __init__(self, noun: str, *first: str) -> None:
        self._noun, self._entries = noun, dict[str, Entry]()
        self._ranks = {key: rank for rank, key in enumerate(first)}

    def __getitem__(self, key: str) -> Entry:
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._entries, key=lambda key: (self._ranks.get(key, len(self._ranks)), key)))

    def __len__(self) -> int:
        return len(self._entries)

    def register(self, key: str, entry: Entry) -> None:
        """Add a kind. Raises ValueError if its key is registered already."""
        if key in self._entries:
            raise ValueError(f"the {self._noun} '{key}' is registered already")
        self._entries[key] = entry

    def forget(self, key: str) -> None:
        """Remove a kind. Raises KeyError if it is not registered."""
        del self._entries[key]


def with_kinds(base: type[Model], keys: Mapping[str, tuple[type, str]], *others: str) -> type[Model]:
    """Return a subclass of `base` with a key for each kind. `keys` maps a key to its type and description.

    Exactly one of these keys and `others` is needed. The keys of the base come first, also in the JSON schema.
    """
    fields = {key: (value | None, Field(None, description=summary)) for key, (value, summary) in keys.items()}
    made: type[Model] = create_model(  # type: ignore[call-overload]  # likewise
        base.__name__, __base__=base, __doc__=base.__doc__, __module__=base.__module__, **fields
    )
    made.one_of = (*keys, *others)
    return made


# Times tied to events: `built`, `level 9 + 1 s`, `brick L3.2`, `impact 1`.


@dataclass(frozen=True, slots=True)
class Anchor:
    """A time tied to an event: the start, the end of building, a brick or the last of a level set, or an impact."""

    event: str  # start, built, level, brick, or impact
    name: str = ""  # of the brick, or the number of the level or the impact
    offset: float = 0.0  # after the event [s]


_EVENT = rf"start|built|(?:level|impact)\s+[1-9][0-9]{{0,5}}|brick\s+{NAME}"


def parse_anchor(written: object) -> Anchor:
    """Read an anchor such as `built`, `level 9 + 1 s`, or `brick L3.2`."""
    match = re.fullmatch(rf"({_EVENT})(?:\s*\+\s*(.+))?", written.strip()) if isinstance(written, str) else None
    if match is None:
        raise InputError("SD110", f"{shown(written)} is not an event", _remedy(written))
    offset = parse_quantity(match[2], LONG_DURATION) if match[2] else 0.0
    event, *name = match[1].split()
    return Anchor(event, "".join(name), offset)


def _remedy(written: object) -> str:
    """Return the closest event if the word is near one, and the forms of events."""
    hint = "write start, built, level 9, brick L3.2, or impact 1, optionally + 1 s; for a fixed time use `at`"
    parts = re.match(r"\s*(level|brick|impact)\W*(\w\S*)(.*)", str(written), re.IGNORECASE)
    if parts and re.fullmatch(_EVENT, event := f"{parts[1].lower()} {parts[2]}"):
        return f"write {event}{parts[3]}"
    word, *rest = str(written).split(maxsplit=1) or [""]
    meant = meant_choice(word, ("start", "built", "level", "brick", "impact"))
    return f"did you mean '{' '.join([meant, *rest])}'? Otherwise {hint}" if meant not in ("", word) else hint


_ANCHOR = rf"(?:{_EVENT})(?:\s*\+\s*{quantity_pattern(LONG_DURATION)})?"
AnchorText = Annotated[
    Anchor, Reads(parse_anchor, text_schema(_ANCHOR, "an event, optionally with a delay", "built + 2 s"))
]


class Timed(ExactlyOneKey):
    """A step that begins at a time, after an event, or by default after the previous step."""

    repeat: REPEAT = Field(None, description="variables and their values; the item is repeated for each combination")
    at: TimeOfStep | None = Field(None, description="time at which the step begins; default: after the previous step")
    after: AnchorText | None = Field(None, description="event after which the step begins")

    @model_validator(mode="after")
    def _begin_once(self) -> Self:
        if self.at is not None and self.after is not None:
            raise InputError("SD108", "`at` and `after` exclude each other", "remove one of them")
        return self
