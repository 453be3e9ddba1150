"""How the ground is shaken: as a sine, or as a table says."""

from collections.abc import Sequence
from itertools import pairwise
from math import pi
from typing import Annotated, ClassVar, Self, TypeAlias

from pydantic import AfterValidator, Field, model_validator

from stability.mechanics.ground_motion import Course, Recorded, Sine
from stackdsl.language import author_types as t
from stackdsl.language.anchors import AnchorText, Timed
from stackdsl.language.author_models import default
from stackdsl.language.mistakes import MistakeError

Row: TypeAlias = tuple[t.Duration, t.SignedAcceleration]


def _in_order(rows: Sequence[Row]) -> Sequence[Row]:
    for number, (before, after) in enumerate(pairwise(rows), start=2):
        if after[0] < before[0]:
            message = f"row {number} of the table is of {after[0]:g} s, and the one before it of {before[0]:g} s"
            raise MistakeError("SD104", message, "write the rows in order of time; twice the same time is a jump")
    if rows[-1][0] == rows[0][0]:
        raise MistakeError("SD104", "the table takes no time", "write a later row")
    return rows


Table = Annotated[tuple[Row, ...], Field(min_length=2, max_length=100_000), AfterValidator(_in_order)]


class Shake(Timed):
    """The ground moves to and fro, level, along one line."""

    at: t.Duration | None = Field(None, description="when it begins; default: when all is built")
    after: AnchorText | None = Field(None, description="the event that it begins after")
    bearing: t.Angle = default("0 deg", "which way it accelerates first: 0 deg = +x, 90 deg = +y")
    acceleration: t.ShakeAcceleration | None = Field(None, description="the most, of a sine")
    amplitude: t.PositiveLength | None = Field(None, description="to either side, of a sine; or else its acceleration")
    frequency: t.ShakeFrequency | None = Field(None, description="of the sine")
    for_: t.PositiveDuration | None = Field(None, alias="for", description="how long the sine goes on")
    table: Table | None = Field(
        None, description="rows of [time, acceleration] along the bearing, straight between; one time twice is a jump"
    )

    one_of: ClassVar[tuple[str, ...]] = ("acceleration", "amplitude", "table")
    of_a_sine: ClassVar[tuple[str, ...]] = ("frequency", "for_")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        written = [key for key in self.of_a_sine if getattr(self, key) is not None]
        if self.table is not None:
            if written:
                message = f"a table says all, and there is no sine to have a `{self._spelling(written[0])}`"
                raise MistakeError("SD108", message, "leave it out, or the table")
        elif len(written) < len(self.of_a_sine):
            missing = next(key for key in self.of_a_sine if key not in written)
            example = {"frequency": "frequency: 2 Hz", "for_": "for: 2 s"}[missing]
            raise MistakeError("SD102", f"`{self._spelling(missing)}` is missing", f"add such as {example}")
        elif self._most > t.MOST_SHAKEN:
            message = (
                f"the ground would accelerate by up to {self._most:.4g} m/s2, and {t.MOST_SHAKEN:g} m/s2 is the most"
            )
            raise MistakeError("SD104", message, "write a lesser amplitude or frequency")
        return self

    @property
    def _most(self) -> float:
        """Of a sine [m/s2]."""
        return self.acceleration or (self.amplitude or 0.0) * (2.0 * pi * (self.frequency or 0.0)) ** 2

    @property
    def course(self) -> Course:
        """The acceleration along the bearing."""
        if self.table is None:
            return Sine(self._most, self.frequency or 0.0, self.for_ or 0.0)
        start = self.table[0][0]
        return Recorded(tuple((time - start, acceleration) for time, acceleration in self.table))

    @property
    def delay(self) -> float:
        """From when it begins until the ground first moves [s]."""
        return self.table[0][0] if self.table is not None else 0.0
