"""Supports that move: the ground below some bricks settles, spreads, tilts or turns."""

from typing import Annotated, ClassVar, Final, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.loads import Towards
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.language.quantities import InputError

MAX_SUPPORTS: Final = 100

Place = tuple[t.Length, t.Length, t.Length]


class Support(AtLeastOneKey):
    """Movement of the ground below some bricks."""

    under: Annotated[t.BodyNames, BeforeValidator(t.listed), WithJsonSchema(t.SUPPORTS)] = Field(
        description="name of the brick, or names of the bricks, below which the ground moves"
    )
    by: Place | None = Field(None, description="shift [x, y, z], along the axes of the scene")
    turn: t.Angle | None = Field(None, description="angle by which the support tilts or turns, by the right-hand rule")
    about: Towards | None = Field(
        None, description="axis of the turn: `up`, `down`, or a horizontal bearing from +x towards +y"
    )
    around: Place | None = Field(
        None, description="point on the axis of the turn; default: the middle of the bricks, on the ground"
    )

    defaults: ClassVar[tuple[str, ...]] = ("under", "about", "around")

    @model_validator(mode="after")
    def _turn_about_an_axis(self) -> Self:
        if self.turn is not None and self.about is None:
            raise InputError("SD102", "the turn has no axis", "add `about: 90 deg` or `about: up`")
        for key in ("about", "around"):
            if getattr(self, key) is not None and self.turn is None:
                raise InputError("SD108", f"`{key}` needs a `turn`", "add `turn`, or remove it")
        if not self.turn and not any(self.by or ()):
            raise InputError("SD104", "the support does not move", "write a shift or an angle other than zero")
        return self


Supports = Annotated[tuple[Support, ...], Field(max_length=MAX_SUPPORTS)]
