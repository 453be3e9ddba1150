"""How much larger and slower a scene is than the one that settings and limits were chosen for.

Model: what stacks is governed by gravity and lengths alone, so that all times go with sqrt(length / gravity) (Froude).
Masses, and friction, change nothing of it.
"""

from collections.abc import Collection
from dataclasses import astuple, dataclass
from math import floor, log2, sqrt
from typing import Self

from stability.model import Brick

# The scene that limits and settings were chosen for: KAPLA planks on earth.
USUAL_GRAVITY, USUAL_SIDE, USUAL_DIAGONAL = 9.81, 0.0078, 0.1202  # [m/s2], [m], [m]
# Steps are no more than this share of a doubling longer than in the usual scene, or they are halved.
MOST_LONGER = 0.25
SAMPLING = 0.01  # [s] between looks at all that moves; a free fall covers half a millimetre in the first


@dataclass(frozen=True, slots=True)
class SceneScale:
    """Gravity, and the lengths of the bricks of a scene in those of the usual one."""

    gravity: float  # [m/s2]
    smallest_side: float  # of all bricks
    thickest_side: float  # the largest of the smallest sides of the bricks
    longest_diagonal: float
    median_diagonal: float  # the lower of two

    @classmethod
    def of(cls, bricks: Collection[Brick], gravity: float) -> Self:
        """That of a scene with these bricks, of which there is one at least, and with gravity [m/s2]."""
        sides = [brick.shape.least_thickness / USUAL_SIDE for brick in bricks]
        diagonals = sorted(2.0 * brick.shape.bounding_radius / USUAL_DIAGONAL for brick in bricks)
        return cls(gravity, min(sides), max(sides), diagonals[-1], diagonals[(len(diagonals) - 1) // 2])

    def resized(self, factor: float) -> Self:
        """That of the same scene with all lengths, and gravity in the same unit, so many times as large."""
        return type(self)(*(factor * each for each in astuple(self)))

    def times(self, lengths: float) -> float:
        """How many times longer all takes than in the usual scene, where lengths are so many times larger."""
        return sqrt(lengths * USUAL_GRAVITY / self.gravity)

    @property
    def slower(self) -> float:
        """How many times longer the largest brick takes to topple than in the usual scene."""
        return self.times(self.longest_diagonal)


def power_of_two(factor: float) -> float:
    """The largest power of two that is hardly larger."""
    return float(2.0 ** floor(log2(factor) + MOST_LONGER))
