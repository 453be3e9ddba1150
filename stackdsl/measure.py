"""A number that was measured, beside what was expected of it, for programs to go on with."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Measure:
    """One number, in its unit, and between which it was to be; None where there is no such limit."""

    value: float
    least: float | None
    most: float | None
    unit: str  # as people are told: mm, deg, %, s; `levels` and `bricks` of counts
