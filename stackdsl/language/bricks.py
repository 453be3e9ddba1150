"""What an author may say of a brick: what it is, and where it is put."""

from typing import Annotated, ClassVar

from pydantic import Field, ValidationInfo, field_validator

from stability.model import Vec3
from stability.statics.admission import LIGHTEST
from stackdsl.diagnostics import did_you_mean
from stackdsl.language import author_types as t
from stackdsl.language.author_models import AuthorModel, Choice, Shorthand, default
from stackdsl.language.author_types import Levels
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.mistakes import MistakeError, shown


class BrickKind(Shorthand, Choice):
    """A brick from the catalogue, or one of its own."""

    size: tuple[t.Side, t.Side, t.Side] = Field(description="length, width, thickness")
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


class SetBrick(AuthorModel):
    """One brick set down in any pose."""

    name: t.BrickName | None = Field(None, description="its name; default: by place, such as L3.2")
    at: tuple[t.Length, t.Length, t.Length] = Field(description="[x, y, z] of its centre")
    rotate: tuple[t.Angle, t.Angle, t.Angle] = default(
        ["0 deg", "0 deg", "0 deg"], "turn about x, then y, then z, the axes of the scene"
    )
    brick: BrickKind | None = Field(None, description="default: the brick of the step, or else of the scenario")
    level: Levels | None = Field(None, description="its level; default: judged by its height")


class PlacedBrick(SetBrick):
    """One brick in any pose, set down or let go."""

    drop: Annotated[bool, Field(strict=True)] = Field(False, description="let go in the air, rather than set down")
    repeat: t.REPEAT = Field(None, description="variables that each repetition has its own values of")
