"""What an author may write: the models of one scenario, and the description of every key."""

from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Literal, Self, TypeAlias

from pydantic import Field, GetJsonSchemaHandler, WithJsonSchema, create_model, model_validator
from pydantic_core import CoreSchema

from stackdsl.language import author_types as t
from stackdsl.language.anchors import Timed
from stackdsl.language.author_models import AuthorModel, Shorthand, default
from stackdsl.language.bricks import BrickKind, PlacedBrick
from stackdsl.language.claims import Expectation, Truth
from stackdsl.language.impacts import Impact
from stackdsl.language.layouts.registry import LAYOUTS, MAX_BRICKS, LayoutParams
from stackdsl.language.mistakes import MistakeError

# --- given: the world -------------------------------------------------------------------------------------------------


class Ground(AuthorModel):
    """The level ground."""

    friction: t.Friction | None = Field(None, description="of a brick on the ground; default: the scenario's")


class Wall(AuthorModel):
    """A vertical wall that faces the origin."""

    bearing: t.Angle = Field(description="where the wall is, seen from the origin: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = Field(description="from the origin to the wall")
    friction: t.Friction | None = Field(None, description="of a brick on the wall; default: the scenario's")


class Tilt(Shorthand):
    """How far the whole scene is tilted."""

    angle: t.Slope = Field(description="between the ground and the horizontal")
    towards: t.Angle = default("0 deg", "bearing of downhill: 0 deg = +x, 90 deg = +y")

    scalar_key: ClassVar[str] = "angle"


class World(AuthorModel):
    """What does not move."""

    gravity: t.Acceleration = default("9.81 m/s2", "acceleration of free fall")
    ground: Ground = Field(default_factory=Ground, description="the level ground")
    walls: Annotated[tuple[Wall, ...], Field(max_length=16)] = Field((), description="vertical walls")
    tilt: Tilt = default("0 deg", "how far the whole scene is tilted")


# --- when: the steps of building --------------------------------------------------------------------------------------

UNTIL_COLLAPSE: Final = 100  # levels, or bricks; plank stacks that are made to fall do so long before


class Step(Timed):
    """One step of building, less the layouts, which `BuildStep` adds from their registry."""

    bricks: Annotated[tuple[PlacedBrick, ...], Field(min_length=1, max_length=MAX_BRICKS)] | None = Field(
        None, description="bricks in any pose, one by one"
    )
    name: t.BrickName | None = Field(None, description="goes before the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="what this step is built of; default: the scenario's brick")
    every: t.PositiveDuration | None = Field(None, description="time for each brick; default: all at one time")
    until: Literal["collapse"] | None = Field(None, description="goes on until the structure falls")

    one_of: ClassVar[tuple[str, ...]] = (*LAYOUTS, "bricks")

    @property
    def layout(self) -> tuple[str, LayoutParams] | None:
        """Name and parameters of the layout, unless the step lists its bricks."""
        written = ((name, getattr(self, name)) for name in LAYOUTS)
        return next(((name, params) for name, params in written if params is not None), None)

    @model_validator(mode="before")
    @classmethod
    def _go_on(cls, written: object) -> object:
        """Fill in how much is built at most, where that is left to the collapse."""
        if not isinstance(written, dict) or "until" not in written:
            return written
        layouts = {name: written[name] for name in LAYOUTS if isinstance(written.get(name), dict)}
        return written | {name: {LAYOUTS[name].params.count: UNTIL_COLLAPSE} | layouts[name] for name in layouts}

    @model_validator(mode="after")
    def _fall_on_the_way(self) -> Self:
        if self.until is None:
            return self
        if self.layout is None:
            raise MistakeError("SD108", "`until: collapse` goes on with a layout, and this step has none", "write one")
        if self.every is None:
            message = "`until: collapse` needs `every`: all at once, nothing is left to add when it falls"
            raise MistakeError("SD102", message, "add such as every: 1 s")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> t.JsonSchema:
        schema = super().__get_pydantic_json_schema__(core, handler)
        counts = {name: {"required": [layout.params.count]} for name, layout in LAYOUTS.items()}
        handler.resolve_ref_schema(schema).update(
            {"if": {"not": {"required": ["until"]}}, "then": {"properties": counts}}
        )
        return schema


if TYPE_CHECKING:
    BuildStep: TypeAlias = Step  # a type that is made while running cannot be checked
else:
    BuildStep = create_model(
        "BuildStep",
        __base__=Step,
        __doc__="One step of building: one layout, or bricks one by one.",
        **{name: (layout.params | None, Field(None, description=layout.summary)) for name, layout in LAYOUTS.items()},
    )


# --- the whole --------------------------------------------------------------------------------------------------------

_VALUE = {"type": ["number", "string"]}


class Scenario(AuthorModel):
    """What is built, and what must come of it."""

    scenario: t.Slug = Field(description="its name, and that of its files")
    description: t.Text | None = Field(None, description="what it shows, in a sentence")
    tags: Annotated[tuple[t.Slug, ...], Field(max_length=32)] = Field((), description="words to select scenarios by")
    brick: BrickKind = default("kapla", "what is built with")
    friction: t.Friction = Field(0.5, description="Coulomb coefficient of brick on brick")
    world: World = Field(default_factory=World, description="gravity, ground, walls, tilt")
    # Judged by `variants.expand`, which has filled them in before.
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
    impacts: Annotated[tuple[Impact, ...], Field(max_length=1000)] = Field((), description="what is done to it")
    systems: t.Systems = Field(("exact",), description="what the scenario is played on")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field((), description="what must come of it")
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field((), description="what is known from outside")
