"""What may be done to a structure, step by step, while it is built or after."""

import re
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final

from pydantic import Field

from stability.model import BodyId
from stackdsl.language import author_types as t
from stackdsl.language.anchors import Timed
from stackdsl.language.author_models import AuthorModel, Choice, default
from stackdsl.language.bricks import BrickKind, SetBrick
from stackdsl.language.claims import BodyNames
from stackdsl.language.mistakes import MistakeError, shown


class Remove(Choice):
    """Bricks pulled out, all at once."""

    brick: t.BodyName | None = Field(None, description="the brick")
    bricks: BodyNames | None = Field(None, description="the bricks")

    one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks")

    @property
    def names(self) -> tuple[BodyId, ...]:
        """The bricks, in the author's order."""
        return self.bricks or ((self.brick,) if self.brick is not None else ())


class Insert(SetBrick):
    """A brick slid into what stands by then."""


@dataclass(frozen=True, slots=True)
class Aim:
    """What a hit is aimed at: one brick, or the middle of a level."""

    brick: BodyId | None = None
    level: int | None = None  # if no brick is meant


_LEVEL: Final = r"level\s+([1-9][0-9]{0,5})"


def _read_aim(written: object) -> Aim:
    text = written.strip() if isinstance(written, str) else ""
    if level := re.fullmatch(_LEVEL, text):
        return Aim(level=int(level[1]))
    if re.fullmatch(t.NAME, text):
        return Aim(brick=text)
    raise MistakeError("SD104", f"{shown(written)} is nothing to aim at", "write a level, such as level 3, or a brick")


AimText = Annotated[
    Aim, t.Reads(_read_aim, t.text_schema(rf"{_LEVEL}|{t.NAME}", "a level, or the name of a brick", "level 3"))
]


class Start(AuthorModel):
    """Where a thrown brick comes from."""

    bearing: t.Angle = Field(description="where it comes from, seen from the aim: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = default("10 mm", "between its nose and the first brick on its way")


class Throw(AuthorModel):
    """A brick that flies, end-on unless turned, at what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: thrown-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is thrown; default: the scenario's brick")
    at: AimText = Field(description="the aim: the middle of a level, or of a brick")
    from_: Start = Field(alias="from", description="where it comes from")
    speed: t.Speed = Field(description="how fast it comes along the ground")
    turn: t.Angle = default("0 deg", "about its upright axis, from end-on; at 90 deg it comes broadside")


class Push(AuthorModel):
    """An impulse on one brick."""

    brick: t.BodyName = Field(description="the brick")
    impulse: tuple[t.Impulse, t.Impulse, t.Impulse] = Field(description="[x, y, z] in the axes of the scene")
    point: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "where it is pushed, from its centre, in the axes of the scene"
    )


class Drop(AuthorModel):
    """A brick let go above what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: dropped-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is dropped; default: the scenario's brick")
    onto: AimText = Field(description="the aim: the middle of a level, or of a brick")
    height: t.PositiveLength = Field(description="how far it falls until it meets what it is dropped onto")
    rotate: tuple[t.Angle, t.Angle, t.Angle] | None = Field(
        None, description="turn about x, then y, then z, the axes of the scene; default: flat, along what it falls onto"
    )


class Impact(Timed):
    """One thing done to the structure. Another kind is another key here, and another action of the timeline."""

    remove: Remove | None = Field(None, description="pull bricks out")
    insert: Insert | None = Field(None, description="slide a brick in")
    throw: Throw | None = Field(None, description="throw a brick at it")
    push: Push | None = Field(None, description="give a brick an impulse")
    drop: Drop | None = Field(None, description="drop a brick onto it")

    one_of: ClassVar[tuple[str, ...]] = ("remove", "insert", "throw", "push", "drop")
