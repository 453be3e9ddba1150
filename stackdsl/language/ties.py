"""Ties: straps, bands and rods around bricks or between them."""

from typing import Annotated, ClassVar, Final, Self

from pydantic import Field, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.model_base import ExactlyOneKey
from stackdsl.language.quantities import InputError

MAX_TIES: Final = 1000
ALL: Final = "all"

Place = tuple[t.Length, t.Length, t.Length]


class Tie(ExactlyOneKey):
    """A strap or a band around bricks, or a rod between two of them."""

    repeat: t.REPEAT = Field(None, description="variables and their values; the item is repeated for each combination")
    around: t.JoinedNames | None = Field(
        None, description="names of bricks, steps or kinds of brick, or `all`: a loop around these bricks"
    )
    between: tuple[t.JoinedName, t.JoinedName] | None = Field(
        None, description="names of two bricks: a straight tie from one to the other"
    )
    name: t.BrickName | None = Field(None, description="name of the tie in reports; default: `tie` and its number")
    along: t.Angle | None = Field(
        None, description="horizontal line of an upright loop, over and under the bricks: 0 deg = x, 90 deg = y"
    )
    height: t.NonNegativeLength | None = Field(
        None, description="height of a level loop around the sides of the bricks"
    )
    offset: t.Length | None = Field(
        None,
        description="distance of an upright loop from the middle of its bricks, to the left of `along`; default: 0",
    )
    anchors: tuple[t.Length, t.Length] | None = Field(
        None,
        description="places on the ground where an upright tie ends, along its line from the middle of its bricks; "
        "default: it is closed below the bricks",
    )
    points: tuple[Place, Place] | None = Field(
        None, description="ends of a straight tie [x, y, z] in the scene; default: the centres of mass of its bricks"
    )
    tension: t.Force | None = Field(None, description="tension with which the tie is put on; default: 0 N")
    strength: t.Force | None = Field(
        None, description="greatest tension that the tie bears; default: it keeps its `tension`"
    )

    one_of: ClassVar[tuple[str, ...]] = ("around", "between")
    examples: ClassVar = {"around": "all"}

    @property
    def least(self) -> float:
        """Return the tension with which it is put on [N]."""
        return self.tension or 0.0

    @property
    def most(self) -> float:
        """Return the greatest tension [N]."""
        return self.least if self.strength is None else self.strength

    @model_validator(mode="after")
    def _keys_of_kind(self) -> Self:
        upright: tuple[str, ...] = ("along", "offset", "anchors")
        level: tuple[str, ...] = ("height",)
        straight: tuple[str, ...] = ("points",)
        if self.around is not None and (self.along is None) == (self.height is None):
            message = "a loop is either upright, along a line, or level, at a height"
            hint = "write `along: 0 deg` for a strap over the bricks, or `height: 300 mm` for a band around their sides"
            raise InputError("SD102" if self.along is None else "SD108", message, hint)
        kind, allowed = "a tie `between` bricks", straight
        if self.around is not None:
            kind, allowed = ("an upright loop", upright) if self.along is not None else ("a level loop", level)
        for key in (*upright, *level, *straight):
            if getattr(self, key) is not None and key not in allowed:
                raise InputError("SD108", f"`{key}` does not apply to {kind}", "remove it")
        return self

    @model_validator(mode="after")
    def _bears_its_tension(self) -> Self:
        if self.tension is None and self.strength is None:
            message = "the tie has neither a `tension` nor a `strength`"
            raise InputError("SD102", message, "add the tension with which it is put on, such as `tension: 500 N`")
        if self.least > self.most:
            message = f"the tie is put on with {self.least:g} N, which is more than its strength of {self.most:g} N"
            raise InputError("SD104", message, "write a `strength` of at least `tension`")
        if self.anchors is not None and self.anchors[0] == self.anchors[1]:
            raise InputError("SD104", "both anchors are one place", "write two places, such as [-500 mm, 500 mm]")
        return self


Ties = Annotated[tuple[Tie, ...], Field(max_length=MAX_TIES)]
