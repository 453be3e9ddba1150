"""What an author says of how exactly hands set bricks down."""

from dataclasses import replace
from typing import Annotated, ClassVar, Final

from pydantic import Field

from stackdsl.language import author_types as t
from stackdsl.language.author_models import Asking, Choice, Shorthand
from stackdsl.language.quantities import SLOPE
from stackdsl.timeline import Jitter, Spread

PositiveSlope = Annotated[float, t.quantity(replace(SLOPE, positive=True))]  # [rad]
ONE_OF: Final = ("normal", "uniform")


class _Error(Shorthand, Choice):
    """An error about zero; by itself a quantity is the standard deviation of a normal one."""

    one_of: ClassVar[tuple[str, ...]] = ONE_OF
    scalar_key: ClassVar[str] = "normal"

    @property
    def spread(self) -> Spread:
        """The same as the hands take it."""
        return Spread("normal" if self.kind == "normal" else "uniform", getattr(self, self.kind))


class PositionError(_Error):
    """How far off a brick is, along each of two level axes."""

    normal: t.PositiveLength | None = Field(None, description="normal, with this standard deviation")
    uniform: t.PositiveLength | None = Field(None, description="up to so far to either side, all alike likely")


class YawError(_Error):
    """How far off a brick is turned about the upright."""

    normal: PositiveSlope | None = Field(None, description="normal, with this standard deviation")
    uniform: PositiveSlope | None = Field(None, description="up to so far to either side, all alike likely")


class HandErrors(Asking):
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
