"""Hands in YAML: paths, speeds, and placement errors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import dist, hypot
from typing import Annotated, ClassVar, Final, TypeAlias

from pydantic import AfterValidator, Field

from stability.dynamics.ground_motion import HandCourse
from stability.model import Vec3
from stackdsl.language import value_types as t
from stackdsl.language.model_base import AtLeastOneKey, ExactlyOneKey, Shorthand, default
from stackdsl.language.quantities import SLOPE, InputError
from stackdsl.timeline import ErrorSpread, Jitter

# Placement errors: how far off hands set bricks down.


PositiveSlope = Annotated[float, t.quantity(replace(SLOPE, positive=True))]  # [rad]
ONE_OF: Final = ("normal", "uniform")


class _Error(Shorthand, ExactlyOneKey):
    """A random error with mean zero; a quantity alone is the standard deviation of a normal distribution."""

    one_of: ClassVar[tuple[str, ...]] = ONE_OF
    scalar_key: ClassVar[str] = "normal"

    @property
    def spread(self) -> ErrorSpread:
        """Return the error as a value of the timeline."""
        return ErrorSpread("normal" if self.kind == "normal" else "uniform", getattr(self, self.kind))


class PositionError(_Error):
    """Error in the position of a brick, along each of two horizontal axes."""

    normal: t.PositiveLength | None = Field(None, description="standard deviation of a normally distributed error")
    uniform: t.PositiveLength | None = Field(None, description="largest magnitude of a uniformly distributed error")


class YawError(_Error):
    """Error in the rotation of a brick about the vertical axis."""

    normal: PositiveSlope | None = Field(None, description="standard deviation of a normally distributed error")
    uniform: PositiveSlope | None = Field(None, description="largest magnitude of a uniformly distributed error")


class HandErrors(AtLeastOneKey):
    """Errors with which bricks are set down, relative to their places on the bricks below."""

    position: PositionError | None = Field(None, description="error along each of two horizontal axes")
    yaw: YawError | None = Field(None, description="error about the vertical axis")

    @property
    def jitter(self) -> Jitter:
        """Return the errors as a value of the timeline."""
        return Jitter(
            self.position.spread if self.position is not None else None,
            self.yaw.spread if self.yaw is not None else None,
        )


# Paths of hands: how they bring a brick, and how they move one.


MOST_PLACES = 1000  # of one path
LEAST_WAY = 1e-9  # [m] between two places; the square of a shorter distance may underflow

Way: TypeAlias = tuple[t.Length, t.Length, t.Length]


def _somewhere(way: Vec3) -> Vec3:
    if hypot(*way) < LEAST_WAY:
        raise InputError("SD104", "the length of the path of the hand is zero", "write a displacement other than zero")
    return way


def _onwards(places: Sequence[Vec3]) -> Sequence[Vec3]:
    for number, (before, after) in enumerate(zip(((0.0, 0.0, 0.0), *places), places, strict=False), start=1):
        if dist(before, after) < LEAST_WAY:
            message = f"position {number} of the path is the same as the position before it"
            raise InputError(
                "SD104", message, "remove it; all positions are relative to the initial position of the brick"
            )
    return places


SomeWay = Annotated[Way, AfterValidator(_somewhere)]
Places = Annotated[tuple[Way, ...], Field(min_length=1, max_length=MOST_PLACES), AfterValidator(_onwards)]


class ByHand(Shorthand):
    """A hand brings each brick, holds it at rest in its place, releases it and withdraws."""

    from_: SomeWay = Field(
        default=["0 mm", "0 mm", "20 mm"],
        alias="from",
        validate_default=True,
        description="start of the straight path, as [x, y, z] from the final position, along the axes of the scene",
    )
    speed: t.Speed = default("50 mm/s", "maximum speed on the path; the motion starts and stops smoothly")
    held: t.Duration = default("0 s", "time for which the brick is held in its place before it is released")

    scalar_word: ClassVar[str] = "by hand"

    @classmethod
    def spelt_out(cls, scalar: object, known: Mapping[str, object]) -> object:
        return {} if scalar == cls.scalar_word else super().spelt_out(scalar, known)

    @property
    def course(self) -> HandCourse:
        """Return the path to the place of the brick, in the axes of the scene."""
        x, y, z = self.from_
        return HandCourse(((-x, -y, -z),), self.speed)

    @property
    def lasts(self) -> float:
        """Return the duration of the whole motion, with the hold at its end [s]."""
        return self.course.duration + self.held
