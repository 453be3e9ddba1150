"""What an author may write: the models of one scenario, and the description of every key.

Where a value may be one scalar or a mapping, the scalar is spelt out as the mapping before validation. Unions would
report a mistake once for each alternative.
"""

import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Literal, Self, TypeAlias, get_args

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    WithJsonSchema,
    create_model,
    model_validator,
)
from pydantic_core import CoreSchema

from stability.model import GROUND, Vec3
from stackdsl import quantities as q
from stackdsl.catalogue import CATALOGUE
from stackdsl.diagnostics import did_you_mean
from stackdsl.layouts import LAYOUTS, MAX_BRICKS, LayoutParams, Levels
from stackdsl.quantities import AuthorModel, Choice, MistakeError, Reads, default, shown, text_schema

System: TypeAlias = Literal["thesis", "tuned", "stock"]
SYSTEMS: Final[tuple[System, ...]] = get_args(System)


# --- words ------------------------------------------------------------------------------------------------------------

_SLUG = r"[a-z0-9][a-z0-9-]{0,63}"
_NAME = r"[A-Za-z][A-Za-z0-9_.-]{0,63}"


def _read_text(written: object, pattern: str, noun: str, advice: str) -> str:
    if not isinstance(written, str):
        raise MistakeError("SD103", f"expected {noun}, not {shown(written)}", advice)
    if not re.fullmatch(pattern, written):
        raise MistakeError("SD104", f"{shown(written)} is not {noun}", advice)
    return written


def _text(pattern: str, noun: str, advice: str, example: str) -> Reads:
    read = partial(_read_text, pattern=pattern, noun=noun, advice=advice)
    return Reads(read, text_schema(pattern, noun, example))


_NAME_ADVICE = "begin with a letter, then letters, digits, _ . or -"
_SLUG_ADVICE = "write small letters, digits and -, at most 64"
Slug = Annotated[str, _text(_SLUG, "a name for files", _SLUG_ADVICE, "slant-tower")]
BodyName = Annotated[str, _text(_NAME, "the name of a brick", _NAME_ADVICE, "L3.2")]
BrickName = Annotated[
    str, _text(rf"(?!(?:{GROUND}|wall[0-9]+)$){_NAME}", "a name that a brick can have", _NAME_ADVICE, "keystone")
]


@dataclass(frozen=True, slots=True)
class Anchor:
    """A time tied to an event: the start, the end of building, or when a brick or the first of a level is set."""

    event: str  # start, built, level, or brick
    name: str = ""  # of the brick, or the number of the level
    offset: float = 0.0  # after the event [s]


_EVENT = rf"start|built|level\s+[1-9]\d{{0,5}}|brick\s+{_NAME}"


def parse_anchor(written: object) -> Anchor:
    """An anchor such as `built`, `level 9 + 1 s`, or `brick L3.2`."""
    match = re.fullmatch(rf"({_EVENT})(?:\s*\+\s*(.+))?", written.strip()) if isinstance(written, str) else None
    if match is None:
        hint = "write start, built, level 9, or brick L3.2, and if need be + 1 s; for a clock time there is `at`"
        raise MistakeError("SD110", f"{shown(written)} is not an event", hint)
    offset = q.parse_quantity(match[2], q.DURATION) if match[2] else 0.0
    event, *name = match[1].split()
    return Anchor(event, "".join(name), offset)


_ANCHOR = rf"(?:{_EVENT})(?:\s*\+\s*{q.quantity_pattern(q.DURATION)})?"
AnchorText = Annotated[
    Anchor, Reads(parse_anchor, text_schema(_ANCHOR, "an event, and a time after it", "built + 2 s"))
]


class Shorthand(AuthorModel):
    """A mapping that may also be written as one scalar: the value of one key, or a word that stands for no key."""

    scalar_key: ClassVar[str] = ""
    scalar_word: ClassVar[str] = ""

    @classmethod
    def spelt_out(cls, scalar: object) -> object:
        """The scalar as a mapping, or as the model itself."""
        if cls.scalar_key:
            return {cls.scalar_key: scalar}
        if scalar == cls.scalar_word:
            return cls.model_construct()
        message = f"expected '{cls.scalar_word}' or a mapping, not {shown(scalar)}"
        raise MistakeError("SD104", message, f"write {cls.scalar_word}, or a mapping with {cls._keys()}")

    @classmethod
    def _keys(cls) -> str:
        return ", ".join(field.alias or name for name, field in cls.model_fields.items())

    @classmethod
    def scalar_schema(cls, properties: dict[str, q.JsonSchema]) -> q.JsonSchema:
        """What editors are told of the scalar."""
        return properties[cls.scalar_key] if cls.scalar_key else {"const": cls.scalar_word}

    @model_validator(mode="wrap")
    @classmethod
    def _spell_out(cls, written: object, handler: ModelWrapValidatorHandler[Self]) -> Self:
        if written == {}:
            raise MistakeError("SD102", "the mapping is empty", f"give one of {cls._keys()}")
        spelt = written if isinstance(written, dict | list | cls) else cls.spelt_out(written)
        return spelt if isinstance(spelt, cls) else handler(spelt)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> q.JsonSchema:
        mapping = super().__get_pydantic_json_schema__(core, handler)
        return {"anyOf": [cls.scalar_schema(handler.resolve_ref_schema(mapping)["properties"]), mapping]}


Text = Annotated[str, Field(min_length=1, max_length=2000)]


# --- given: bricks and world ------------------------------------------------------------------------------------------


class BrickKind(Shorthand, Choice):
    """A brick from the catalogue, or one of its own."""

    size: tuple[q.PositiveLength, q.PositiveLength, q.PositiveLength] = Field(description="length, width, thickness")
    density: q.Density | None = Field(None, description="density; or else give the mass")
    mass: q.Mass | None = Field(None, description="mass of a whole brick; or else give the density")

    one_of: ClassVar[tuple[str, ...]] = ("density", "mass")

    @classmethod
    def spelt_out(cls, scalar: object) -> object:
        if not isinstance(scalar, str) or scalar not in CATALOGUE:
            hint = did_you_mean(str(scalar), tuple(CATALOGUE))
            raise MistakeError("SD104", f"the catalogue has no brick {shown(scalar)}", hint)
        known = CATALOGUE[scalar]
        return cls.model_construct(size=known.size, density=known.density)

    @classmethod
    def scalar_schema(cls, _properties: dict[str, q.JsonSchema]) -> q.JsonSchema:
        return {"type": "string", "anyOf": [{"enum": list(CATALOGUE)}, {"pattern": q.EXPRESSION_PATTERN}]}

    def mass_of(self, size: Vec3) -> float:
        """Mass of a piece of this size, of the same material [kg]."""
        if self.mass is None:
            return (self.density or 0.0) * size[0] * size[1] * size[2]
        return self.mass * (size[0] * size[1] * size[2]) / (self.size[0] * self.size[1] * self.size[2])


class Ground(AuthorModel):
    """The level ground."""

    friction: q.Friction | None = Field(None, description="of a brick on the ground; default: the scenario's")


class Wall(AuthorModel):
    """A vertical wall that faces the origin."""

    bearing: q.Angle = Field(description="where the wall is, seen from the origin: 0 deg = +x, 90 deg = +y")
    distance: q.NonNegativeLength = Field(description="from the origin to the wall")
    friction: q.Friction | None = Field(None, description="of a brick on the wall; default: the scenario's")


class Tilt(Shorthand):
    """How far the whole scene is tilted."""

    angle: q.Slope = Field(description="between the ground and the horizontal")
    towards: q.Angle = default("0 deg", "bearing of downhill: 0 deg = +x, 90 deg = +y")

    scalar_key: ClassVar[str] = "angle"


class World(AuthorModel):
    """What does not move."""

    gravity: q.Acceleration = default("9.81 m/s2", "acceleration of free fall")
    ground: Ground = Field(default_factory=Ground, description="the level ground")
    walls: Annotated[tuple[Wall, ...], Field(max_length=16)] = Field((), description="vertical walls")
    tilt: Tilt = default("0 deg", "how far the whole scene is tilted")


# --- when: the steps of building --------------------------------------------------------------------------------------


class PlacedBrick(AuthorModel):
    """One brick in any pose."""

    name: BrickName | None = Field(None, description="its name; default: by place, such as L3.2")
    at: tuple[q.Length, q.Length, q.Length] = Field(description="[x, y, z] of its centre")
    rotate: tuple[q.Angle, q.Angle, q.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "turn about x, then y, then z, the axes of the scene"
    )
    brick: BrickKind | None = Field(None, description="default: the brick of the step, or else of the scenario")
    drop: Annotated[bool, Field(strict=True)] = Field(False, description="let go in the air, rather than set down")
    level: Levels | None = Field(None, description="its level; default: judged by its height")


class Step(Choice):
    """One step of building, less the layouts, which `BuildStep` adds from their registry."""

    bricks: Annotated[tuple[PlacedBrick, ...], Field(min_length=1, max_length=MAX_BRICKS)] | None = Field(
        None, description="bricks in any pose, one by one"
    )
    name: BrickName | None = Field(None, description="goes before the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="what this step is built of; default: the scenario's brick")
    every: q.PositiveDuration | None = Field(None, description="time for each brick; default: all at one time")
    at: q.Duration | None = Field(None, description="when the step begins; default: after the previous step")
    after: AnchorText | None = Field(None, description="the event that the step begins after")

    one_of: ClassVar[tuple[str, ...]] = (*LAYOUTS, "bricks")

    @model_validator(mode="after")
    def _begin_once(self) -> Self:
        if self.at is not None and self.after is not None:
            raise MistakeError("SD108", "a step begins `at` a time or `after` an event, not both", "remove one of them")
        return self

    @property
    def layout(self) -> tuple[str, LayoutParams] | None:
        """Name and parameters of the layout, unless the step lists its bricks."""
        written = ((name, getattr(self, name)) for name in LAYOUTS)
        return next(((name, params) for name, params in written if params is not None), None)


if TYPE_CHECKING:
    BuildStep: TypeAlias = Step  # a type that is made while running cannot be checked
else:
    BuildStep = create_model(
        "BuildStep",
        __base__=Step,
        __doc__="One step of building: one layout, or bricks one by one.",
        **{name: (layout.params | None, Field(None, description=layout.summary)) for name, layout in LAYOUTS.items()},
    )


# --- then: what is expected -------------------------------------------------------------------------------------------

BodyNames = Annotated[tuple[BodyName, ...], Field(min_length=1, max_length=MAX_BRICKS)]


class Stands(Shorthand):
    """Bricks are where they came to rest."""

    levels: Levels | None = Field(None, description="at least so many levels, from the lowest")
    bricks: BodyNames | None = Field(None, description="these bricks")
    for_: q.PositiveDuration | None = Field(None, alias="for", description="this long after the last brick is placed")

    scalar_word: ClassVar[str] = "all"


class Collapses(Shorthand):
    """A brick that had come to rest leaves its place."""

    at: q.LevelTolerance | None = Field(None, description="the level under construction when it does")
    brick: BodyName | None = Field(None, description="the first brick that does")
    time: q.DurationTolerance | None = Field(None, description="when it does")

    scalar_word: ClassVar[str] = "any"


class Displaced(AuthorModel):
    """How many bricks have moved."""

    bricks: q.CountTolerance = Field(description="how many")
    by: q.LengthLowerBound = Field(description="how far a brick has at least moved to be counted")


class Drift(Shorthand):
    """The largest shift of a brick after it came to rest."""

    within: q.LengthTolerance = Field(alias="is", description="the shift")
    bricks: BodyNames | None = Field(None, description="of these bricks; default: of all")

    scalar_key: ClassVar[str] = "is"


class RestsOn(AuthorModel):
    """One brick is carried by another."""

    brick: BodyName = Field(description="the upper brick")
    support: BodyName = Field(description="the lower one, or ground")
    share: q.ShareTolerance | None = Field(None, description="part of its load that goes there")


class Height(Shorthand):
    """How high the structure reaches."""

    within: q.LengthTolerance = Field(alias="is", description="the height")
    of: BodyName | None = Field(None, description="the brick whose top is measured; default: the highest")

    scalar_key: ClassVar[str] = "is"


class Claim(Choice):
    """One statement about what happened."""

    stands: Stands | None = Field(None, description="bricks are where they came to rest")
    collapses: Collapses | None = Field(None, description="the structure collapses")
    displaced: Displaced | None = Field(None, description="how many bricks have moved")
    drift: Drift | None = Field(None, description="the largest shift of a brick after it came to rest")
    rests_on: RestsOn | None = Field(None, description="one brick is carried by another")
    height: Height | None = Field(None, description="how high the structure reaches")

    one_of: ClassVar[tuple[str, ...]] = ("stands", "collapses", "displaced", "drift", "rests_on", "height")

    @property
    def kind(self) -> str:
        """The key that is written, such as `stands`."""
        return next(key for key in self.one_of if getattr(self, key) is not None)


def _listed(written: object) -> object:
    return [written] if isinstance(written, str) else written


def _once(systems: tuple[System, ...]) -> tuple[System, ...]:
    if len(set(systems)) < len(systems):
        raise MistakeError("SD104", "a system is named twice", "name each once")
    return systems


Systems = Annotated[tuple[System, ...], Field(min_length=1), AfterValidator(_once)]


_ONE: Final[q.JsonSchema] = {"enum": list(SYSTEMS)}
_ONE_OR_MORE: Final[q.JsonSchema] = {"anyOf": [_ONE, {"type": "array", "items": _ONE, "minItems": 1}]}


class Expectation(Claim):
    """What must come of the scenario."""

    system: Annotated[Systems, BeforeValidator(_listed), WithJsonSchema(_ONE_OR_MORE)] | None = Field(
        None, description="the system, or systems, that this is expected of; default: all"
    )


class Truth(Claim):
    """What is known from outside; compared and reported, but never a failure."""

    source: Text = Field(description="where it is known from")
    because: Text | None = Field(None, description="why it is so")


# --- the whole --------------------------------------------------------------------------------------------------------

_VALUE = {"type": ["number", "string"]}


class Scenario(AuthorModel):
    """What is built, and what must come of it."""

    scenario: Slug = Field(description="its name, and that of its files")
    description: Text | None = Field(None, description="what it shows, in a sentence")
    tags: Annotated[tuple[Slug, ...], Field(max_length=32)] = Field((), description="words to select scenarios by")
    brick: BrickKind = default("kapla", "what is built with")
    friction: q.Friction = Field(0.5, description="Coulomb coefficient of brick on brick")
    world: World = Field(default_factory=World, description="gravity, ground, walls, tilt")
    # Judged by `expressions.expand`, which has filled them in before.
    let: Annotated[object, WithJsonSchema({"type": "object", "additionalProperties": _VALUE})] = Field(
        None, description="variables for ${...}, each of numbers, quantities, and variables above it"
    )
    matrix: Annotated[
        object,
        WithJsonSchema({"type": "object", "additionalProperties": {"type": "array", "items": _VALUE, "minItems": 1}}),
    ] = Field(None, description="variables with several values: a variant of the scenario for each combination")
    build: Annotated[tuple[BuildStep, ...], Field(min_length=1, max_length=1000)] = Field(
        description="what is built, step by step"
    )
    systems: Systems = Field(("thesis",), description="what the scenario is played on")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field((), description="what must come of it")
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field((), description="what is known from outside")
