"""What an author may write: the models of one scenario, and the description of every key."""

from typing import TYPE_CHECKING, Annotated, ClassVar, Self, TypeAlias

from pydantic import Field, WithJsonSchema, create_model, model_validator

from stability.model import Vec3
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import author_types as t
from stackdsl.language.anchors import AnchorText
from stackdsl.language.author_models import AuthorModel, Choice, Shorthand, default
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.claims import Expectation, Truth
from stackdsl.language.layouts import LAYOUTS, MAX_BRICKS, LayoutParams, Levels
from stackdsl.language.mistakes import MistakeError, shown

# --- given: bricks and world ------------------------------------------------------------------------------------------


class BrickKind(Shorthand, Choice):
    """A brick from the catalogue, or one of its own."""

    size: tuple[t.PositiveLength, t.PositiveLength, t.PositiveLength] = Field(description="length, width, thickness")
    density: t.Density | None = Field(None, description="density; or else give the mass")
    mass: t.Mass | None = Field(None, description="mass of a whole brick; or else give the density")

    one_of: ClassVar[tuple[str, ...]] = ("density", "mass")

    @classmethod
    def spelt_out(cls, scalar: object) -> object:
        if not isinstance(scalar, str) or scalar not in CATALOGUE:
            hint = did_you_mean(str(scalar), tuple(CATALOGUE))
            raise MistakeError("SD104", f"the catalogue has no brick {shown(scalar)}", hint)
        known = CATALOGUE[scalar]
        return cls.model_construct(size=known.size, density=known.density)

    @classmethod
    def scalar_schema(cls, _properties: dict[str, t.JsonSchema]) -> t.JsonSchema:
        return {"type": "string", "anyOf": [{"enum": list(CATALOGUE)}, {"pattern": t.EXPRESSION_PATTERN}]}

    def mass_of(self, size: Vec3) -> float:
        """Mass of a piece of this size, of the same material [kg]."""
        if self.mass is None:
            return (self.density or 0.0) * size[0] * size[1] * size[2]
        return self.mass * (size[0] * size[1] * size[2]) / (self.size[0] * self.size[1] * self.size[2])


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


class PlacedBrick(AuthorModel):
    """One brick in any pose."""

    name: t.BrickName | None = Field(None, description="its name; default: by place, such as L3.2")
    at: tuple[t.Length, t.Length, t.Length] = Field(description="[x, y, z] of its centre")
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
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
    name: t.BrickName | None = Field(None, description="goes before the names of the bricks of this step")
    brick: BrickKind | None = Field(None, description="what this step is built of; default: the scenario's brick")
    every: t.PositiveDuration | None = Field(None, description="time for each brick; default: all at one time")
    at: t.Duration | None = Field(None, description="when the step begins; default: after the previous step")
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
    systems: t.Systems = Field(("exact",), description="what the scenario is played on")
    expect: Annotated[tuple[Expectation, ...], Field(max_length=1000)] = Field((), description="what must come of it")
    truth: Annotated[tuple[Truth, ...], Field(max_length=1000)] = Field((), description="what is known from outside")
