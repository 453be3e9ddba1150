"""Prescribed motion: the level ground that shakes, and the path of a hand."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, pairwise
from math import ceil, cos, dist, inf, pi, sin, sqrt
from typing import Protocol

from stability.geometry.vectors import add, scale, subtract
from stability.model import Vec3

# Motion of the ground: horizontal, along one line.
#
# Bodies are told as seen from the ground. There each feels, besides its weight, its mass times the acceleration of the
# ground, the other way (d'Alembert). What an engine takes in a step is the mean over that step, so that what the ground
# gives in all is right whatever the step, and a jump need not fall on its end.


HALVINGS = 60  # of a stretch in which an acceleration is passed: down to the last digit of a time


class Course(Protocol):
    """An acceleration along a line, from when it begins."""

    @property
    def duration(self) -> float:
        """How long it goes on [s]."""

    @property
    def turns(self) -> Iterable[float]:
        """Times from 0 to its end between any two of which it never turns round [s]; twice the same for a jump."""

    def acceleration(self, time: float, before: bool = False) -> float:
        """The acceleration at a time from 0 to its end [m/s2]; at a jump that after it, or that `before` it."""

    def gained(self, time: float) -> float:
        """The speed that it gives until a time from 0 to its end [m/s]."""


@dataclass(frozen=True, slots=True)
class Sine:
    """As a sine, which begins at none."""

    most: float  # [m/s2]
    frequency: float  # [Hz]
    duration: float  # [s]

    @property
    def turns(self) -> Iterable[float]:
        quarter = 0.25 / self.frequency
        between = (quarter * number for number in range(1, 2 * ceil(2.0 * self.frequency * self.duration) + 1, 2))
        return chain((0.0,), (time for time in between if time < self.duration), (self.duration,))

    def acceleration(self, time: float, before: bool = False) -> float:
        return self.most * sin(2.0 * pi * self.frequency * time)

    def gained(self, time: float) -> float:
        rate = 2.0 * pi * self.frequency
        return self.most / rate * (1.0 - cos(rate * time))


@dataclass(frozen=True, slots=True)
class Recorded:
    """Straight between the points of a table, whose times begin with 0 and never fall; twice the same is a jump."""

    points: tuple[tuple[float, float], ...]  # time [s] and acceleration [m/s2]
    _gained: tuple[float, ...] = field(init=False)  # by each point [m/s]

    def __post_init__(self) -> None:
        areas = (0.5 * (a + b) * (end - start) for (start, a), (end, b) in pairwise(self.points))
        object.__setattr__(self, "_gained", tuple(accumulate(areas, initial=0.0)))

    @property
    def duration(self) -> float:
        return self.points[-1][0]

    @property
    def turns(self) -> Iterable[float]:
        return [time for time, _ in self.points]

    def acceleration(self, time: float, before: bool = False) -> float:
        (start, a), (end, b) = self.points[(number := self._stretch(time, before))], self.points[number + 1]
        return a + (b - a) * (time - start) / (end - start) if end > start else a

    def gained(self, time: float) -> float:
        number = self._stretch(time, before=True)
        start, a = self.points[number]
        return self._gained[number] + 0.5 * (a + self.acceleration(time, before=True)) * (time - start)

    def _stretch(self, time: float, before: bool) -> int:
        """The number of the stretch of the table that a time is in; at a point, of the one before it or after it."""
        ends = (end < time or (end == time and not before) for end, _ in self.points[1:-1])
        return sum(ends)


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """A course along a level line, in time."""

    course: Course
    direction_W: Vec3  # unit, level: which way the acceleration is counted
    begins: float  # [s]

    @property
    def ends(self) -> float:
        """From when on the ground is at rest, or moves evenly [s]."""
        return self.begins + self.course.duration

    def mean(self, start: float, duration: float) -> float:
        """The mean acceleration over a time that is more than zero [m/s2]."""
        return (self._gained(start + duration) - self._gained(start)) / duration

    def mean_W(self, start: float, duration: float) -> Vec3:
        """The same as a vector."""
        return scale(self.mean(start, duration), self.direction_W)

    def extremes(self, since: float) -> tuple[float, float]:
        """The least and the most that the acceleration will be from a time on, none at its end included [m/s2]."""
        least = most = 0.0
        for start, end in self._stretches(since):
            ends = self.course.acceleration(start), self.course.acceleration(end, before=True)
            least, most = min(least, *ends), max(most, *ends)
        return least, most

    def leaves(self, least: float, most: float, since: float) -> float:
        """When the acceleration is first beyond two bounds, one on each side of 0, from a time on [s]; inf if never."""
        for start, end in self._stretches(since):
            if not least <= self.course.acceleration(start) <= most:
                return self.begins + start
            if not least <= self.course.acceleration(end, before=True) <= most:
                return self.begins + self._passed(start, end, least, most)
        return inf

    def _stretches(self, since: float) -> Iterator[tuple[float, float]]:
        """From a time on, from turn to turn, in the time of the course: only so a jump is where it is [s]."""
        turns = (max(since - self.begins, turn) for turn in self.course.turns)  # of a long course there are millions
        return ((start, end) for start, end in pairwise(turns) if end > start)

    def _passed(self, start: float, end: float, least: float, most: float) -> float:
        for _ in range(HALVINGS):
            middle = 0.5 * (start + end)
            within = least <= self.course.acceleration(middle) <= most
            start, end = (middle, end) if within else (start, middle)
        return start

    def _gained(self, time: float) -> float:
        return self.course.gained(min(max(time - self.begins, 0.0), self.course.duration))


# Path of a hand: minimum jerk from point to point, at rest in each.
#
# Source: T. Flash, N. Hogan, "The coordination of arm movements", Journal of Neuroscience 5 (1985): on the way from one
# place at rest to another the jerk is least. Over a way d in a time T that is d (10 s^3 - 15 s^4 + 6 s^5), s = t / T,
# at most 15/8 d / T fast, with accelerations of at most 10 / sqrt(3) d / T^2. Being smooth it throws nothing: what lies
# on a hand goes with it, and what is pushed stays at it, as long as the acceleration is less than friction bears.


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
