"""Hands in YAML: how they bring, move and release bricks, and how exactly."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import dist, hypot
from typing import Annotated, ClassVar, Final, TypeAlias

from pydantic import AfterValidator, Field

from stability.dynamics.ground_motion import HandCourse
from stability.model import Vec3
from stackdsl.language import value_types as t
from stackdsl.language.model_base import AtLeastOneKey, ExactlyOneKey, Shorthand, default
from stackdsl.language.quantities import SLOPE, MistakeError
from stackdsl.timeline import ErrorSpread, Jitter

# What an author says of how exactly hands set bricks down.


PositiveSlope = Annotated[float, t.quantity(replace(SLOPE, positive=True))]  # [rad]
ONE_OF: Final = ("normal", "uniform")


class _Error(Shorthand, ExactlyOneKey):
    """An error about zero; by itself a quantity is the standard deviation of a normal one."""

    one_of: ClassVar[tuple[str, ...]] = ONE_OF
    scalar_key: ClassVar[str] = "normal"

    @property
    def spread(self) -> ErrorSpread:
        """The same as the hands take it."""
        return ErrorSpread("normal" if self.kind == "normal" else "uniform", getattr(self, self.kind))


class PositionError(_Error):
    """How far off a brick is, along each of two level axes."""

    normal: t.PositiveLength | None = Field(None, description="normal, with this standard deviation")
    uniform: t.PositiveLength | None = Field(None, description="up to so far to either side, all alike likely")


class YawError(_Error):
    """How far off a brick is turned about the upright."""

    normal: PositiveSlope | None = Field(None, description="normal, with this standard deviation")
    uniform: PositiveSlope | None = Field(None, description="up to so far to either side, all alike likely")


class HandErrors(AtLeastOneKey):
    """How far off bricks are set down, from where they belong on what is there."""

    position: PositionError | None = Field(None, description="along each of two level axes")
    yaw: YawError | None = Field(None, description="about the upright")

    @property
    def jitter(self) -> Jitter:
        """The same as the timeline has it."""
        return Jitter(
            self.position.spread if self.position is not None else None,
            self.yaw.spread if self.yaw is not None else None,
        )


# What an author says of hands: how they bring a brick, and how they move one that is there.


MOST_PLACES = 1000  # of one path
LEAST_WAY = 1e-9  # [m] from place to place; of less, the square may be nothing

Way: TypeAlias = tuple[t.Length, t.Length, t.Length]


def _somewhere(way: Vec3) -> Vec3:
    if hypot(*way) < LEAST_WAY:
        raise MistakeError("SD104", "the hand goes nowhere", "write a way that is longer than zero")
    return way


def _onwards(places: Sequence[Vec3]) -> Sequence[Vec3]:
    for number, (before, after) in enumerate(zip(((0.0, 0.0, 0.0), *places), places, strict=False), start=1):
        if dist(before, after) < LEAST_WAY:
            message = f"place {number} of the path is where the hand is already"
            raise MistakeError("SD104", message, "leave it out; each is told from where the brick is at first")
    return places


SomeWay = Annotated[Way, AfterValidator(_somewhere)]
Places = Annotated[tuple[Way, ...], Field(min_length=1, max_length=MOST_PLACES), AfterValidator(_onwards)]


class ByHand(Shorthand):
    """A hand brings each brick, holds it at rest in its place, lets it go there and withdraws."""

    from_: SomeWay = Field(
        default=["0 mm", "0 mm", "20 mm"],
        alias="from",
        validate_default=True,
        description="where it comes from, straight, as [x, y, z] from its place, in the axes of the scene",
    )
    speed: t.Speed = default("50 mm/s", "the most on the way; it sets out and stops smoothly")
    held: t.Duration = default("0 s", "how long it is held in its place before it is let go")

    scalar_word: ClassVar[str] = "by hand"

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        return {} if scalar == cls.scalar_word else super().spelt_out(scalar, known)

    @property
    def course(self) -> HandCourse:
        """The way to its place, from where it comes, in the axes of the scene."""
        x, y, z = self.from_
        return HandCourse(((-x, -y, -z),), self.speed)

    @property
    def lasts(self) -> float:
        """How long the hand is at it [s]."""
        return self.course.duration + self.held
