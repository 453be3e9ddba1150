"""Size and time scale of a scene, relative to the reference scene of the settings and limits.

Model: gravity and lengths alone set the time scale of stacked bricks, sqrt(length / gravity) (Froude). Masses and
friction have no influence.
"""

from collections.abc import Collection
from dataclasses import astuple, dataclass
from math import floor, log2, sqrt
from typing import Self

from stability.model import Brick

# The reference scene of limits and settings: KAPLA planks on earth.
USUAL_GRAVITY, USUAL_SIDE, USUAL_DIAGONAL = 9.81, 0.0078, 0.1202  # [m/s2], [m], [m]
# Tolerance of the rounding to powers of two, in doublings: a step may be this much longer than the exact scaling.
MOST_LONGER = 0.25
SAMPLING = 0.01  # [s] between checks of all moving bricks; a free fall covers half a millimetre in the first


@dataclass(frozen=True, slots=True)
class SceneScale:
    """Gravity of a scene, and the lengths of its bricks relative to the reference scene."""

    gravity: float  # [m/s2]
    smallest_side: float  # of all bricks
    thickest_side: float  # the largest of the bricks' smallest sides
    longest_diagonal: float
    median_diagonal: float  # the lower median

    @classmethod
    def of(cls, bricks: Collection[Brick], gravity: float) -> Self:
        """Return the scale of a scene with these bricks (at least one) and gravity [m/s2]."""
        sides = [brick.shape.least_thickness / USUAL_SIDE for brick in bricks]
        diagonals = sorted(2.0 * brick.shape.bounding_radius / USUAL_DIAGONAL for brick in bricks)
        return cls(gravity, min(sides), max(sides), diagonals[-1], diagonals[(len(diagonals) - 1) // 2])

    def resized(self, factor: float) -> Self:
        """Return the scale of the same scene with all lengths, and gravity, multiplied by a factor."""
        return type(self)(*(factor * value for value in astuple(self)))

    def times(self, lengths: float) -> float:
        """Return the duration of a motion relative to the reference scene, at a relative length."""
        return sqrt(lengths * USUAL_GRAVITY / self.gravity)

    @property
    def slower(self) -> float:
        """Toppling time of the largest brick, relative to the reference scene."""
        return self.times(self.longest_diagonal)


def power_of_two(factor: float) -> float:
    """Return the largest power of two that exceeds a factor by at most `MOST_LONGER` doublings."""
    return float(2.0 ** floor(log2(factor) + MOST_LONGER))
