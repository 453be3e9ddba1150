"""What an author may say of a brick: what it is, and where it is put."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from stability.model import GROUND, Vec3
from stability.statics.admission import LIGHTEST
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import author_types as t
from stackdsl.language.author_models import Choice, Shorthand, default
from stackdsl.language.author_types import Levels
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.mistakes import EchoError, MistakeError, shown

MAX_TYPES: Final = 1000


class BrickKind(Shorthand, Choice):
    """A brick from the catalogue, or one of its own."""

    size: tuple[t.Side, t.Side, t.Side] = Field(description="length, width, thickness")
    density: t.Density | None = Field(None, description="density; or else give the mass")
    mass: t.Mass | None = Field(None, description="mass of a whole brick; or else give the density")

    one_of: ClassVar[tuple[str, ...]] = ("density", "mass")

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        name = scalar if isinstance(scalar, str) else ""
        if name in known:
            if known[name] is None:
                raise EchoError
            return known[name]
        if name in CATALOGUE:
            return cls.model_construct(size=CATALOGUE[name].size, density=CATALOGUE[name].density)
        message = f"there is no brick {shown(scalar)} in the catalogue, nor under `brick_types`"
        raise MistakeError("SD104", message, did_you_mean(str(scalar), (*known, *CATALOGUE)))

    @classmethod
    def scalar_schema(cls, _properties: dict[str, t.JsonSchema]) -> t.JsonSchema:
        return {
            "type": "string",
            "anyOf": [{"enum": list(CATALOGUE)}, {"pattern": f"^{t.NAME}$|{t.EXPRESSION_PATTERN}"}],
        }

    @field_validator("density", "mass")
    @classmethod
    def _outweighs_nothing(cls, written: float, info: ValidationInfo) -> float:
        """What statics cannot tell from nothing is no brick."""
        size = info.data.get("size")
        if size is None:  # it is told by itself
            return written
        mass = written * size[0] * size[1] * size[2] if info.field_name == "density" else written
        if mass < LIGHTEST:
            message = f"a brick of {mass:.3g} kg is lighter than any that can be weighed"
            hint = f"write a {info.field_name} that makes it at least {LIGHTEST:g} kg"
            raise MistakeError("SD104", message, hint)
        return written

    def mass_of(self, size: Vec3) -> float:
        """Mass of a piece of this size, of the same material [kg]."""
        if self.mass is None:
            return (self.density or 0.0) * size[0] * size[1] * size[2]
        return self.mass * (size[0] * size[1] * size[2]) / (self.size[0] * self.size[1] * self.size[2])


def _of_its_own(name: str) -> str:
    if name in CATALOGUE:
        raise MistakeError("SD104", f"'{name}' is a brick of the catalogue", "take another name")
    return name


BrickTypes = Annotated[
    dict[Annotated[str, t.TYPE_NAME, AfterValidator(_of_its_own)], BrickKind], Field(max_length=MAX_TYPES)
]


def brick_types_of(written: object) -> Mapping[str, BrickKind | None]:
    """The bricks that a scenario names, by name; None where its own lines are mistaken, which is told of these."""
    return {name: _kind(kind) for name, kind in written.items()} if isinstance(written, dict) else {}


def _kind(written: object) -> BrickKind | None:
    try:
        return BrickKind.model_validate(written)
    except ValidationError:
        return None


class SetBrick(Choice):
    """One brick set down in any pose."""

    name: t.BrickName | None = Field(None, description="its name; default: by place, such as L3.2")
    at: tuple[t.Length, t.Length, t.Length] | None = Field(None, description="[x, y, z] of its centre")
    on: Annotated[t.Supports, BeforeValidator(t.listed), WithJsonSchema(t.SUPPORTS)] | None = Field(
        None, description="the brick, or bricks, on whose top it lies, in the middle of their centres; or the ground"
    )
    beside: t.BodyName | None = Field(None, description="the brick that it stands beside, touching it, as low as that")
    towards: t.Angle = default("0 deg", "where it stands, seen from what it is beside: 0 deg = +x, 90 deg = +y")
    offset: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "shifts it from there by [x, y, z], in the axes of the scene"
    )
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "turn about x, then y, then z, the axes of the scene"
    )
    brick: BrickKind | None = Field(None, description="default: the brick of the step, or else of the scenario")
    level: Levels | None = Field(None, description="its level; default: judged by its height")

    one_of: ClassVar[tuple[str, ...]] = ("at", "on", "beside")

    @model_validator(mode="after")
    def _shift_from_something(self) -> Self:
        written = self.model_fields_set
        if self.at is not None and "offset" in written:
            raise MistakeError(
                "SD108", "`offset` is from another brick, and this one has its place `at`", "add them up"
            )
        if self.beside is None and "towards" in written:
            raise MistakeError("SD108", "`towards` is of what stands `beside` another brick", "say beside which")
        if GROUND in (self.on or ()) and len(self.on or ()) > 1:
            raise MistakeError("SD104", "a brick lies on others or on the ground, not on both", "leave the ground out")
        return self


class PlacedBrick(SetBrick):
    """One brick in any pose, set down or let go."""

    drop: Annotated[bool, Field(strict=True)] = Field(False, description="let go in the air, rather than set down")
    repeat: t.REPEAT = Field(None, description="variables that each repetition has its own values of")
