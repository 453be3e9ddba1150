"""Impacts in YAML: drop, throw, push, remove, insert, hold, move."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Self, TypeVar, cast

from pydantic import Field, model_validator

from stability.dynamics.ground_motion import HandCourse
from stability.model import BodyId
from stackdsl.language import value_types as t
from stackdsl.language.bricks import BrickKind, SetBrick
from stackdsl.language.hands import Places, SomeWay
from stackdsl.language.model_base import AuthorModel, ExactlyOneKey, Kinds, Timed, default
from stackdsl.language.quantities import MistakeError, shown
from stackdsl.language.value_types import NameReference, NamesBody, PositiveDuration, named_in

# What a kind of impact answers for itself, and all the kinds there are.
#
# A kind is one module beside this one, a class that is read from YAML, and one in `compiling/impacts`, which says what
# it comes to in the scene. What it names is known from the types of its values (`BodyName` and the like).


@dataclass(frozen=True, slots=True)
class Missile:
    """A brick that comes from outside, and is no part of the structure."""

    name: BodyId | None  # None for such as `thrown-1`
    brick: BrickKind | None  # None for the scenario's
    how: str  # it comes: `thrown`


class ImpactKind(AuthorModel):
    """One thing done to the structure. A kind that says nothing else answers as it stands here."""

    @property
    def slid_in(self) -> SetBrick | None:
        """The brick that becomes part of the structure."""
        return None

    @property
    def missile(self) -> Missile | None:
        """The brick that comes from outside."""
        return None

    @property
    def pulled_out(self) -> Iterable[NameReference]:
        """The bricks that are taken away."""
        return ()

    @property
    def lasts(self) -> float:
        """How long it goes on, so that what comes after it has to wait [s]."""
        return 0.0

    @property
    def struck(self) -> Iterable[BodyId]:
        """The bricks whose own way ends with it, so that from then on only a run can tell where they are."""
        return ()


@dataclass(frozen=True, slots=True)
class KindOfImpact:
    """A kind, as `Impact` has it: the class that is read, and a phrase for editors."""

    model: type[ImpactKind]
    summary: str


IMPACTS: Final = Kinds[KindOfImpact]("impact")

Model = TypeVar("Model", bound=ImpactKind)


def impact(key: str, summary: str) -> Callable[[type[Model]], type[Model]]:
    """Register the class below as what an author writes under a key."""

    def register(model: type[Model]) -> type[Model]:
        IMPACTS.register(key, KindOfImpact(model, summary))
        return model

    return register


# What a hit is aimed at: one brick, or the middle of a level.


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


def _brick_of(aim: object) -> BodyId | None:
    return aim.brick if isinstance(aim, Aim) else None


AimText = Annotated[
    Aim,
    t.Reads(_read_aim, t.text_schema(rf"{_LEVEL}|{t.NAME}", "a level, or the name of a brick", "level 3")),
    NamesBody(read=_brick_of),
]


# Bricks pulled out, all at once.


@impact("remove", "pull bricks out")
class Remove(ExactlyOneKey, ImpactKind):
    """Bricks pulled out, all at once."""

    brick: t.BodyName | None = Field(None, description="the brick")
    bricks: t.BodyNames | None = Field(None, description="the bricks")

    one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks")

    @property
    def pulled_out(self) -> Iterable[NameReference]:
        return named_in(self)

    @property
    def struck(self) -> Iterable[BodyId]:
        return (named.name for named in self.pulled_out)


# A brick slid into what stands by then.


@impact("insert", "slide a brick in")
class Insert(SetBrick, ImpactKind):
    """A brick slid into what stands by then."""

    @property
    def slid_in(self) -> SetBrick:
        return self


# A brick that flies at what stands by then.


class ThrowOrigin(AuthorModel):
    """Where a thrown brick comes from."""

    bearing: t.Angle = Field(description="where it comes from, seen from the aim: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = default("10 mm", "between its nose and the first brick on its way")


@impact("throw", "throw a brick at it")
class Throw(ImpactKind):
    """A brick that flies, end-on unless turned, at what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: thrown-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is thrown; default: the scenario's brick")
    at: AimText = Field(description="the aim: the middle of a level, or of a brick")
    from_: ThrowOrigin = Field(alias="from", description="where it comes from")
    speed: t.Speed = Field(description="how fast it comes along the ground")
    turn: t.Angle = default("0 deg", "about its upright axis, from end-on; at 90 deg it comes broadside")

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "thrown")


# An impulse on one brick.


@impact("push", "give a brick an impulse")
class Push(ImpactKind):
    """An impulse on one brick."""

    brick: t.BodyName = Field(description="the brick")
    impulse: tuple[t.Impulse, t.Impulse, t.Impulse] = Field(description="[x, y, z] in the axes of the scene")
    point: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"], "where it is pushed, from its centre, in the axes of the scene"
    )

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


# A brick let go above what stands by then.


@impact("drop", "drop a brick onto it")
class Drop(ImpactKind):
    """A brick let go above what stands by then."""

    name: t.BrickName | None = Field(None, description="its name; default: dropped-1 if it is the first impact")
    brick: BrickKind | None = Field(None, description="what is dropped; default: the scenario's brick")
    onto: AimText = Field(description="the aim: the middle of a level, or of a brick")
    height: t.PositiveLength = Field(description="how far it falls until it meets what it is dropped onto")
    rotate: tuple[t.Angle, t.Angle, t.Angle] | None = Field(
        None, description="turn about x, then y, then z, the axes of the scene; default: flat, along what it falls onto"
    )

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "dropped")


# A brick that a hand moves along a path, with all that is in its way.


@impact("move", "move a brick by hand")
class Move(ExactlyOneKey, ImpactKind):
    """A brick that a hand moves along a path, with all that is in its way, and lets go."""

    brick: t.BodyName = Field(description="the brick")
    by: SomeWay | None = Field(None, description="how far, straight, as [x, y, z] in the axes of the scene")
    path: Places | None = Field(
        None, description="the places it goes to, one after another, each from where it is at first; it stops in each"
    )
    speed: t.Speed = default("50 mm/s", "the most on the way; it sets out and stops smoothly")
    held: t.Duration = default("0 s", "how long it is held at the end before it is let go")
    slid: t.Flag = Field(False, description="pushed along level rather than carried: it keeps its weight, and may tip")

    one_of: ClassVar[tuple[str, ...]] = ("by", "path")

    @model_validator(mode="after")
    def _slide_level(self) -> Self:
        if self.slid and any(z for _, _, z in self.course.places_W):
            raise MistakeError(
                "SD104", "what is slid goes level, and this way goes up or down", "carry it, or write 0 for z"
            )
        return self

    @property
    def course(self) -> HandCourse:
        """The way, in the axes of the scene."""
        return HandCourse(self.path if self.by is None else (self.by,), self.speed)  # type: ignore[arg-type]  # one is

    @property
    def lasts(self) -> float:
        return self.course.duration + self.held

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


# A brick that a hand holds where it is.


@impact("hold", "hold a brick where it is")
class Hold(ImpactKind):
    """A brick that a hand holds where it is, and lets go."""

    brick: t.BodyName = Field(description="the brick")
    for_: t.PositiveDuration = Field(alias="for", description="how long it is held")

    @property
    def lasts(self) -> float:
        return self.for_

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


# One thing that is done to a structure, while it is built or after.


class Impact(Timed):
    """One thing done to the structure. Another kind is another key here, and another action of the timeline."""

    every: PositiveDuration | None = Field(
        None, description="from one repetition to the next; default: all at one time"
    )

    @property
    def done(self) -> ImpactKind:
        """What is written under its key."""
        return cast("ImpactKind", getattr(self, self.kind))
