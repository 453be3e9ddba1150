"""Dominoes: planks on end in a row."""

from math import pi
from typing import ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, layout
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import Levels, PositiveLength
from stackdsl.wording import mm


class DominoesParams(LayoutParams):
    """Planks on end in a row."""

    bricks: Levels = Field(description="number of planks")
    spacing: PositiveLength = Field(description="distance between the centres of neighbouring planks")

    count: ClassVar[str] = "bricks"

    @property
    def bricks_at_most(self) -> int:
        return self.bricks


@layout("dominoes", DominoesParams)
def dominoes(params: DominoesParams, size: Vec3) -> Specs:
    """Planks on end in a row along x, their flat sides to each other; the first stands at the origin.

    A plank of length L and thickness t tips over its edge from a lean of atan(t / L), and hits the next one, a spacing
    s away, at a lean of asin((s - t) / L). So it reaches the next one only for s < L + t, and falls on it by itself if
    sin(atan(t / L)) < (s - t) / L.
    """
    length, _, thickness = size
    if params.bricks > 1 and params.spacing <= thickness:
        message = f"at a spacing of {mm(params.spacing)}, planks with a thickness of {mm(thickness)} overlap"
        raise InputError("SD104", message, "write a spacing greater than the thickness, the third value of `size`")
    return tuple(
        BrickSpec(1, (number * params.spacing, 0.0, 0.5 * length), lean=0.5 * pi) for number in range(params.bricks)
    )
