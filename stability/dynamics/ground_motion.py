"""Prescribed motion: horizontally shaking ground, and the path of a hand."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, pairwise
from math import ceil, cos, dist, inf, pi, sin, sqrt
from typing import Protocol

from stability.geometry.vectors import add, scale, subtract
from stability.model import Vec3

# Motion of the ground: horizontal, along one line.
#
# States are relative to the ground. There each body feels, besides its weight, its mass times the opposite acceleration
# of the ground (d'Alembert). An engine step uses the mean acceleration over the step, so that the total change of
# velocity does not depend on the step, and a jump need not be at the end of a step.


HALVINGS = 60  # bisection steps for the time at which an acceleration is reached, to the last digit


class Course(Protocol):
    """Acceleration along a line over time, from its beginning."""

    @property
    def duration(self) -> float:
        """The duration [s]."""

    @property
    def turns(self) -> Iterable[float]:
        """Times from 0 to the end between which the acceleration is monotonic [s]; a jump is listed twice."""

    def acceleration(self, time: float, before: bool = False) -> float:
        """Return the acceleration at a time from 0 to the end [m/s2]; at a jump the value after or `before` it."""

    def gained(self, time: float) -> float:
        """Return the change of speed until a time from 0 to the end [m/s]."""


@dataclass(frozen=True, slots=True)
class SineCourse:
    """Sine that begins at 0."""

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
class TabulatedCourse:
    """Linear interpolation of a table, whose times begin at 0 and do not decrease; two equal times are a jump."""

    points: tuple[tuple[float, float], ...]  # time [s] and acceleration [m/s2]
    _gained: tuple[float, ...] = field(init=False)  # change of speed until each point [m/s]

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
        """Return the index of the interval of a time; at a point, of the interval before or after it."""
        ends = (end < time or (end == time and not before) for end, _ in self.points[1:-1])
        return sum(ends)


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """Acceleration along a horizontal line, from a start time."""

    course: Course
    direction_W: Vec3  # unit, horizontal: positive direction of the acceleration
    begins: float  # [s]

    @property
    def ends(self) -> float:
        """Time after which the ground is at rest or moves uniformly [s]."""
        return self.begins + self.course.duration

    def mean(self, start: float, duration: float) -> float:
        """Return the mean acceleration over a positive duration [m/s2]."""
        return (self._gained(start + duration) - self._gained(start)) / duration

    def mean_W(self, start: float, duration: float) -> Vec3:
        """Return the mean acceleration over a positive duration as a vector [m/s2]."""
        return scale(self.mean(start, duration), self.direction_W)

    def extremes(self, since: float) -> tuple[float, float]:
        """Return the least and the largest acceleration from a time on, including 0 after the end [m/s2]."""
        least = most = 0.0
        for start, end in self._stretches(since):
            ends = self.course.acceleration(start), self.course.acceleration(end, before=True)
            least, most = min(least, *ends), max(most, *ends)
        return least, most

    def leaves(self, least: float, most: float, since: float) -> float:
        """Return the first time from `since` at which the acceleration leaves a range around 0 [s]; inf if never."""
        for start, end in self._stretches(since):
            if not least <= self.course.acceleration(start) <= most:
                return self.begins + start
            if not least <= self.course.acceleration(end, before=True) <= most:
                return self.begins + self._passed(start, end, least, most)
        return inf

    def _stretches(self, since: float) -> Iterator[tuple[float, float]]:
        """Return the monotonic intervals from a time on, in the time of the course, so that jumps are exact [s]."""
        turns = (max(since - self.begins, turn) for turn in self.course.turns)  # lazily, as a long course has millions
        return ((start, end) for start, end in pairwise(turns) if end > start)

    def _passed(self, start: float, end: float, least: float, most: float) -> float:
        for _ in range(HALVINGS):
            middle = 0.5 * (start + end)
            within = least <= self.course.acceleration(middle) <= most
            start, end = (middle, end) if within else (start, middle)
        return start

    def _gained(self, time: float) -> float:
        return self.course.gained(min(max(time - self.begins, 0.0), self.course.duration))


# Path of a hand: minimum jerk from point to point, at rest at each.
#
# Source: T. Flash, N. Hogan, "The coordination of arm movements", Journal of Neuroscience 5 (1985): the motion between
# two points of rest has the least jerk. Over a distance d in a time T it is d (10 s^3 - 15 s^4 + 6 s^5), s = t / T,
# with a largest speed of 15/8 d / T and a largest acceleration of 10 / sqrt(3) d / T^2. As it is smooth, bricks on a
# hand stay on it, and a pushed brick stays in contact, as long as friction withstands the acceleration.


START: Vec3 = (0.0, 0.0, 0.0)
PEAK = 15.0 / 8.0  # ratio of the largest to the mean speed
SHARPEST = 10.0 / sqrt(3.0)  # largest acceleration in units of d / T^2


@dataclass(frozen=True, slots=True)
class HandCourse:
    """Path through points, relative to its start [m, axes of W]; a path without points is at rest."""

    places_W: tuple[Vec3, ...]
    speed: float  # largest speed on each straight part [m/s]

    @property
    def duration(self) -> float:
        """The duration [s]."""
        return sum(PEAK * length / self.speed for length in self._lengths)

    @property
    def length(self) -> float:
        """The length of the path [m]."""
        return sum(self._lengths)

    @property
    def end_W(self) -> Vec3:
        """The end, relative to the start [m]."""
        return self.places_W[-1] if self.places_W else START

    @property
    def most_acceleration(self) -> float:
        """The largest acceleration [m/s2]."""
        return max((SHARPEST * self.speed**2 / (PEAK**2 * length) for length in self._lengths if length), default=0.0)

    @property
    def _lengths(self) -> Sequence[float]:
        return [dist(before, after) for before, after in pairwise((START, *self.places_W))]

    def at(self, time: float) -> Vec3:
        """Return the position after a time [s], relative to the start [m]."""
        remaining = time
        for before, after in pairwise((START, *self.places_W)):
            part_duration = PEAK * dist(before, after) / self.speed
            if remaining < part_duration:
                share = max(0.0, remaining / part_duration)
                fraction = share**3 * (10.0 - 15.0 * share + 6.0 * share * share)
                return add(before, scale(fraction, subtract(after, before)))
            remaining -= part_duration
        return self.end_W
