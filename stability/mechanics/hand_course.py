"""How a hand moves what it holds: from place to place, at rest in each, as smoothly as people do.

Source: T. Flash, N. Hogan, "The coordination of arm movements", Journal of Neuroscience 5 (1985): on the way from one
place at rest to another the jerk is least. Over a way d in a time T that is d (10 s^3 - 15 s^4 + 6 s^5), s = t / T, at
most 15/8 d / T fast, with accelerations of at most 10 / sqrt(3) d / T^2. Being smooth it throws nothing: what lies on a
hand goes with it, and what is pushed stays at it, as long as the acceleration is less than friction bears.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import dist, sqrt

from stability.geometry.vectors import add, scale, subtract
from stability.model import Vec3

START: Vec3 = (0.0, 0.0, 0.0)
PEAK = 15.0 / 8.0  # of the mean speed
SHARPEST = 10.0 / sqrt(3.0)  # the most acceleration, in times of d / T^2


@dataclass(frozen=True, slots=True)
class HandCourse:
    """A way from place to place, each told from where it begins [m, axes of W]; one without places is at rest."""

    places_W: tuple[Vec3, ...]
    speed: float  # the most, on each straight part [m/s]

    @property
    def duration(self) -> float:
        """How long it takes [s]."""
        return sum(PEAK * length / self.speed for length in self._lengths)

    @property
    def length(self) -> float:
        """How far it goes [m]."""
        return sum(self._lengths)

    @property
    def end_W(self) -> Vec3:
        """Where it ends, from where it begins [m]."""
        return self.places_W[-1] if self.places_W else START

    @property
    def most_acceleration(self) -> float:
        """The most at any time [m/s2]."""
        return max((SHARPEST * self.speed**2 / (PEAK**2 * length) for length in self._lengths if length), default=0.0)

    @property
    def _lengths(self) -> Sequence[float]:
        return [dist(before, after) for before, after in pairwise((START, *self.places_W))]

    def at(self, time: float) -> Vec3:
        """How far from its beginning it is after a time [s, m]."""
        left = time
        for before, after in pairwise((START, *self.places_W)):
            takes = PEAK * dist(before, after) / self.speed
            if left < takes:
                share = max(0.0, left / takes)
                gone = share**3 * (10.0 - 15.0 * share + 6.0 * share * share)
                return add(before, scale(gone, subtract(after, before)))
            left -= takes
        return self.end_W
