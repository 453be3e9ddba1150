"""Base classes of the language: validated mappings, registries of keywords, and times tied to events."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, ClassVar, Generic, Self, TypeVar

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

from stackdsl.language.quantities import DURATION, MistakeError, parse_quantity, quantity_pattern, shown
from stackdsl.language.value_types import NAME, REPEAT, Duration, JsonSchema, Reads, text_schema

# The kinds of mapping that an author writes, which the models of the language are made from.


class AuthorModel(BaseModel):
    """A mapping that an author writes."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _reject_nothing(cls, written: object) -> object:
        if written is None:
            raise MistakeError("SD103", "there is no value", "write one, or remove the key")
        return written


class ExactlyOneKey(AuthorModel):
    """A mapping that needs exactly one of several keys, and of others likewise."""

    one_of: ClassVar[tuple[str, ...]]
    also_one_of: ClassVar[tuple[str, ...]] = ()

    @property
    def kind(self) -> str:
        """The one of them that is written."""
        return next(key for key in self.one_of if getattr(self, key) is not None)

    @model_validator(mode="after")
    def _choose(self) -> Self:
        for keys in filter(None, (self.also_one_of, self.one_of)):
            written = [key for key in keys if getattr(self, key) is not None]
            if len(written) != 1:
                needed, found = (list(map(self._spelling, each)) for each in (keys, written))
                message = f"exactly one of {', '.join(needed)} is needed, not {' and '.join(found) or 'none'}"
                raise MistakeError("SD108", message, "keep one of them" if written else "write one of them")
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
    """A mapping of which at least one key is due."""

    defaults: ClassVar[tuple[str, ...]] = ()  # keys that ask nothing by themselves

    @property
    def asked(self) -> tuple[str, ...]:
        """The questions that are written."""
        return tuple(key for key in self._questions() if getattr(self, key) is not None)

    @classmethod
    def _questions(cls) -> tuple[str, ...]:
        return tuple(key for key in cls.model_fields if key not in cls.defaults)

    @model_validator(mode="after")
    def _ask_something(self) -> Self:
        if not self.asked:
            cause = "nothing is asked" if self.model_fields_set else "the mapping is empty"
            raise MistakeError("SD102", cause, f"give one of {', '.join(self._questions())}")
        return self


class Shorthand(AuthorModel):
    """A mapping that may also be written as one scalar: the value of one key, or a word that stands for no key.

    The scalar is spelt out as the mapping before validation. A union would report a mistake once for each alternative.
    """

    scalar_key: ClassVar[str] = ""
    scalar_word: ClassVar[str] = ""

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        """The scalar as a mapping, or as the model itself; `known` are the words that the scenario gives a meaning."""
        if cls.scalar_key:
            return {cls.scalar_key: scalar}
        if scalar == cls.scalar_word:
            return cls.model_construct()
        message = f"expected '{cls.scalar_word}' or a mapping, not {shown(scalar)}"
        raise MistakeError("SD104", message, f"write {cls.scalar_word}, or a mapping with {cls._keys()}")

    @classmethod
    def _remedy(cls) -> str:
        return f"{f'write {cls.scalar_word}, or ' if cls.scalar_word else ''}give one of {cls._keys()}"

    @classmethod
    def _keys(cls) -> str:
        return ", ".join(field.alias or name for name, field in cls.model_fields.items())

    @classmethod
    def scalar_schema(cls, properties: dict[str, JsonSchema]) -> JsonSchema:
        """What editors are told of the scalar."""
        return properties[cls.scalar_key] if cls.scalar_key else {"const": cls.scalar_word}

    @model_validator(mode="wrap")
    @classmethod
    def _spell_out(cls, written: object, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo) -> Self:
        if written == {}:
            raise MistakeError("SD102", "the mapping is empty", cls._remedy())
        spelt = written if isinstance(written, dict | list | cls) else cls.spelt_out(written, info.context or {})
        return spelt if isinstance(spelt, cls) else handler(spelt)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchema:
        mapping = super().__get_pydantic_json_schema__(core, handler)
        return {"anyOf": [cls.scalar_schema(handler.resolve_ref_schema(mapping)["properties"]), mapping]}


def default(written: object, description: str) -> Any:  # noqa: ANN401 -- as `Field`, it stands for a value of any type
    """A key that may be absent, with its default as an author would write it, so that editors show it so."""
    return Field(default=written, validate_default=True, description=description)


# Kinds: what an author may write under a key of its own, each registered by the one module that knows all of it.
#
# There are kinds of layouts, of claims and of impacts. Who meets one asks it, and nobody lists them.


Entry = TypeVar("Entry")
Model = TypeVar("Model", bound=ExactlyOneKey)


class Kinds(Mapping[str, Entry], Generic[Entry]):
    """By the key that an author writes, in the order in which they registered: that of the JSON Schema."""

    def __init__(self, noun: str) -> None:
        self._noun, self._entries = noun, dict[str, Entry]()

    def __getitem__(self, key: str) -> Entry:
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def register(self, key: str, entry: Entry) -> None:
        """Let a kind be known. Raises ValueError if its key is taken."""
        if key in self._entries:
            raise ValueError(f"there is a {self._noun} '{key}' already")
        self._entries[key] = entry

    def forget(self, key: str) -> None:
        """Let a kind be unknown again. Raises KeyError if it is."""
        del self._entries[key]


def with_kinds(base: type[Model], keys: Mapping[str, tuple[type, str]], *others: str) -> type[Model]:
    """The choice with a key for each kind, whose value is read by a type and described in a phrase, beside others.

    The keys of the base come first, in its JSON Schema as well.
    """
    fields = {key: (value | None, Field(None, description=summary)) for key, (value, summary) in keys.items()}
    made: type[Model] = create_model(  # type: ignore[call-overload]  # likewise
        base.__name__, __base__=base, __doc__=base.__doc__, __module__=base.__module__, **fields
    )
    made.one_of = (*keys, *others)
    return made


# Times tied to events, as people write them: `built`, `level 9 + 1 s`, `brick L3.2`, `impact 1`.


@dataclass(frozen=True, slots=True)
class Anchor:
    """A time tied to an event: the start, the end of building, a brick or the last of a level set, or an impact."""

    event: str  # start, built, level, brick, or impact
    name: str = ""  # of the brick, or the number of the level or the impact
    offset: float = 0.0  # after the event [s]


_EVENT = rf"start|built|(?:level|impact)\s+[1-9][0-9]{{0,5}}|brick\s+{NAME}"


def parse_anchor(written: object) -> Anchor:
    """An anchor such as `built`, `level 9 + 1 s`, or `brick L3.2`."""
    match = re.fullmatch(rf"({_EVENT})(?:\s*\+\s*(.+))?", written.strip()) if isinstance(written, str) else None
    if match is None:
        raise MistakeError("SD110", f"{shown(written)} is not an event", _meant(written))
    offset = parse_quantity(match[2], DURATION) if match[2] else 0.0
    event, *name = match[1].split()
    return Anchor(event, "".join(name), offset)


def _meant(written: object) -> str:
    """What to write instead; of a word that is close to one of ours, which one that may be."""
    hint = "write start, built, level 9, brick L3.2, or impact 1, perhaps + 1 s; for a clock time there is `at`"
    word, *rest = str(written).split(maxsplit=1) or [""]
    close = get_close_matches(word, ("start", "built", "level", "brick", "impact"), n=1, cutoff=0.6)
    return f"did you mean '{' '.join([close[0], *rest])}'? Else {hint}" if close and close[0] != word else hint


_ANCHOR = rf"(?:{_EVENT})(?:\s*\+\s*{quantity_pattern(DURATION)})?"
AnchorText = Annotated[
    Anchor, Reads(parse_anchor, text_schema(_ANCHOR, "an event, and a time after it", "built + 2 s"))
]


class Timed(ExactlyOneKey):
    """A step that begins at a time, or after an event, or else after what comes before it."""

    repeat: REPEAT = Field(None, description="variables that each repetition has its own values of")
    at: Duration | None = Field(None, description="when the step begins; default: after the previous step")
    after: AnchorText | None = Field(None, description="the event that the step begins after")

    @model_validator(mode="after")
    def _begin_once(self) -> Self:
        if self.at is not None and self.after is not None:
            raise MistakeError("SD108", "a step begins `at` a time or `after` an event, not both", "remove one of them")
        return self
