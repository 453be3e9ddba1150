"""The kinds of mapping that an author writes, which the models of the language are made from."""

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from stackdsl.language.author_types import JsonSchema
from stackdsl.language.mistakes import MistakeError, shown


class AuthorModel(BaseModel):
    """A mapping that an author writes."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _reject_nothing(cls, written: object) -> object:
        if written is None:
            raise MistakeError("SD103", "there is no value", "write one, or remove the key")
        return written


class Choice(AuthorModel):
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


class Asking(AuthorModel):
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
