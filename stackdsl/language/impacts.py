"""Impacts in YAML: drop, throw, push, remove, insert, hold, move, glue, cut."""

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
from stackdsl.language.joints import JoinedBodies, JointKind
from stackdsl.language.model_base import AuthorModel, ExactlyOneKey, Kinds, Timed, default
from stackdsl.language.quantities import InputError, shown
from stackdsl.language.value_types import NameReference, NamesBody, named_in

# Base class and registry of impacts.
#
# A kind of impact is a class here, which is read from YAML, and one in `compiler.impacts`, which compiles it to
# actions. The bricks that it names follow from the types of its values (`BodyName` and others).


@dataclass(frozen=True, slots=True)
class Missile:
    """A brick from outside that hits the structure and does not become part of it."""

    name: BodyId | None  # None for a default name such as `thrown-1`
    brick: BrickKind | None  # None for the brick of the scenario
    how: str  # first part of the default name: `thrown`


class ImpactKind(AuthorModel):
    """An action on the structure. Kinds override the defaults here."""

    @property
    def slid_in(self) -> SetBrick | None:
        """Return the brick that becomes part of the structure."""
        return None

    @property
    def missile(self) -> Missile | None:
        """Return the brick that comes from outside."""
        return None

    @property
    def pulled_out(self) -> Iterable[NameReference]:
        """Return the bricks that are removed."""
        return ()

    @property
    def lasts(self) -> float:
        """Return the duration, for which the next step waits [s]."""
        return 0.0

    @property
    def struck(self) -> Iterable[BodyId]:
        """Return the bricks whose poses after the impact are known from a simulation only."""
        return ()


@dataclass(frozen=True, slots=True)
class KindOfImpact:
    """A registered kind of impact: its model, and its description for editors."""

    model: type[ImpactKind]
    summary: str


IMPACTS: Final = Kinds[KindOfImpact](
    "impact", "remove", "insert", "throw", "push", "drop", "move", "hold", "glue", "cut"
)

Model = TypeVar("Model", bound=ImpactKind)


def impact(key: str, summary: str) -> Callable[[type[Model]], type[Model]]:
    """Return a decorator that registers the model of the key `key`."""

    def register(model: type[Model]) -> type[Model]:
        IMPACTS.register(key, KindOfImpact(model, summary))
        return model

    return register


# Targets of hits.


@dataclass(frozen=True, slots=True)
class Aim:
    """The target of a hit: one brick, or the middle of a level."""

    brick: BodyId | None = None
    level: int | None = None  # None if the target is a brick


_LEVEL: Final = r"level\s+([1-9][0-9]{0,5})"


def _read_aim(written: object) -> Aim:
    text = written.strip() if isinstance(written, str) else ""
    if level := re.fullmatch(_LEVEL, text):
        return Aim(level=int(level[1]))
    if re.fullmatch(t.NAME, text):
        return Aim(brick=text)
    raise InputError(
        "SD104", f"{shown(written)} is not a target", "write a level, such as level 3, or the name of a brick"
    )


def _brick_of(aim: object) -> BodyId | None:
    return aim.brick if isinstance(aim, Aim) else None


AimText = Annotated[
    Aim,
    t.Reads(_read_aim, t.text_schema(rf"{_LEVEL}|{t.NAME}", "a level, or the name of a brick", "level 3")),
    NamesBody(read=_brick_of),
]


# The kinds of impacts.


@impact("remove", "pull bricks out")
class Remove(ExactlyOneKey, ImpactKind):
    """Bricks pulled out, all at once."""

    brick: t.BodyName | None = Field(None, description="name of the brick")
    bricks: t.BodyNames | None = Field(None, description="names of the bricks")

    one_of: ClassVar[tuple[str, ...]] = ("brick", "bricks")

    @property
    def pulled_out(self) -> Iterable[NameReference]:
        return named_in(self)

    @property
    def struck(self) -> Iterable[BodyId]:
        return (named.name for named in self.pulled_out)


@impact("insert", "slide a brick in")
class Insert(SetBrick, ImpactKind):
    """A brick slid into the structure."""

    @property
    def slid_in(self) -> SetBrick:
        return self


class ThrowOrigin(AuthorModel):
    """Start of the flight of a thrown brick."""

    bearing: t.Angle = Field(description="direction from the target to the start: 0 deg = +x, 90 deg = +y")
    distance: t.NonNegativeLength = default(
        "10 mm", "distance from the front of the thrown brick to the first brick on its path"
    )


@impact("throw", "throw a brick at the structure")
class Throw(ImpactKind):
    """A brick that is thrown at the structure, end-on unless turned."""

    name: t.BrickName | None = Field(
        None, description="name of the thrown brick; default: thrown-1 if it is the first impact"
    )
    brick: BrickKind | None = Field(None, description="kind of the thrown brick; default: that of the scenario")
    at: AimText = Field(description="target: the centre of a level or of a brick")
    from_: ThrowOrigin = Field(alias="from", description="start of the flight")
    speed: t.Speed = Field(description="horizontal speed")
    turn: t.Angle = default("0 deg", "rotation about the vertical axis: 0 deg is end-on, 90 deg is broadside")

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "thrown")


@impact("push", "apply an impulse to a brick")
class Push(ImpactKind):
    """An impulse on one brick."""

    brick: t.BodyName = Field(description="name of the brick")
    impulse: tuple[t.Impulse, t.Impulse, t.Impulse] = Field(description="impulse [x, y, z] along the axes of the scene")
    point: tuple[t.Length, t.Length, t.Length] = default(
        ["0 mm", "0 mm", "0 mm"],
        "point of application, relative to the centre of the brick, along the axes of the scene",
    )

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


@impact("drop", "drop a brick onto the structure")
class Drop(ImpactKind):
    """A brick released above the structure."""

    name: t.BrickName | None = Field(
        None, description="name of the dropped brick; default: dropped-1 if it is the first impact"
    )
    brick: BrickKind | None = Field(None, description="kind of the dropped brick; default: that of the scenario")
    onto: AimText = Field(description="target: the centre of a level or of a brick")
    height: t.PositiveLength = Field(description="height of free fall above the target")
    rotate: tuple[t.Angle, t.Angle, t.Angle] | None = Field(
        None,
        description="rotation about the axes of the scene: x, then y, then z; default: aligned with the target",
    )

    @property
    def missile(self) -> Missile:
        return Missile(self.name, self.brick, "dropped")


@impact("move", "move a brick by hand")
class Move(ExactlyOneKey, ImpactKind):
    """A hand moves a brick along a path, pushes all bricks in its way, and releases it."""

    brick: t.BodyName = Field(description="name of the brick")
    by: SomeWay | None = Field(None, description="straight displacement [x, y, z], along the axes of the scene")
    path: Places | None = Field(
        None, description="successive positions relative to the initial one; the brick stops at each"
    )
    speed: t.Speed = default("50 mm/s", "maximum speed on the path; the motion starts and stops smoothly")
    held: t.Duration = default("0 s", "time for which the brick is held at the end before it is released")
    slid: t.Flag = Field(
        False,
        description="whether the brick is pushed horizontally instead of carried; it may then tip",
    )

    one_of: ClassVar[tuple[str, ...]] = ("by", "path")

    @model_validator(mode="after")
    def _slide_level(self) -> Self:
        if self.slid and any(z for _, _, z in self.course.places_W):
            raise InputError(
                "SD104",
                "`slid` needs a horizontal path",
                "remove `slid`, or write 0 mm for z",
            )
        return self

    @property
    def course(self) -> HandCourse:
        """Return the path, in the axes of the scene."""
        return HandCourse(self.path if self.by is None else (self.by,), self.speed)  # type: ignore[arg-type]  # one of

    @property
    def lasts(self) -> float:
        return self.course.duration + self.held

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


@impact("hold", "hold a brick where it is")
class Hold(ImpactKind):
    """A hand holds a brick where it is, and releases it."""

    brick: t.BodyName = Field(description="name of the brick")
    for_: t.PositiveDuration = Field(alias="for", description="time for which the brick is held")

    @property
    def lasts(self) -> float:
        return self.for_

    @property
    def struck(self) -> Iterable[BodyId]:
        return (self.brick,)


@impact("glue", "join bricks")
class Glue(JointKind, ImpactKind):
    """Joints between bodies that are in place."""


@impact("cut", "remove joints")
class Cut(ExactlyOneKey, JoinedBodies, ImpactKind):
    """Joints that are cut; the contacts remain."""

    one_of: ClassVar[tuple[str, ...]] = ("of", "between")
    examples: ClassVar = {"of": "[L1.1, L2.1]"}


# One impact of a scenario.


class Impact(Timed):
    """An action on the structure, during or after its construction."""

    every: t.LongInterval | None = Field(None, description="time between repetitions; default: all at the same time")

    @property
    def content(self) -> ImpactKind:
        """Return the value of the key of its kind."""
        return cast("ImpactKind", getattr(self, self.kind))
