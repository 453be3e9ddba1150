"""Prescribed motion: shaking ground, and the path of a hand."""

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, pairwise
from math import ceil, cos, dist, hypot, inf, pi, sin, sqrt
from typing import NamedTuple, Protocol

from stability.geometry.vectors import add, add_scaled, scale, subtract
from stability.model import AT_REST, Vec3

# Motion of the ground: along a horizontal line, or the sum of motions along several lines.
#
# States are relative to the ground. There each body feels, besides its weight, its mass times the opposite acceleration
# of the ground (d'Alembert). An engine step uses the mean acceleration over the step, so that the total change of
# velocity does not depend on the step, and a jump need not be at the end of a step.


HALVINGS_OF_A_ROW = 10  # bisection steps between two rows of tables, each of which may need a proof
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

    def extremes(self, since: float) -> tuple[float, float]:
        """Return the least and the largest acceleration from a time on, including 0 after the end [m/s2]."""


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

    def extremes(self, since: float) -> tuple[float, float]:
        ends = [self.acceleration(time) for stretch in _stretches(self.turns, since) for time in stretch]
        return min(0.0, *ends, 0.0), max(0.0, *ends, 0.0)


@dataclass(frozen=True, slots=True)
class TabulatedCourse:
    """Linear interpolation of a table, whose times begin at 0 and do not decrease; two equal times are a jump."""

    points: tuple[tuple[float, float], ...]  # time [s] and acceleration [m/s2]
    _gained: tuple[float, ...] = field(init=False)  # change of speed until each point [m/s]
    _between: tuple[float, ...] = field(init=False, repr=False, compare=False)  # times of all but the first and last
    # Least and largest acceleration from each point on, including 0.
    _later: tuple[tuple[float, float], ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_between", tuple(time for time, _ in self.points[1:-1]))
        later = accumulate(
            (acceleration for _, acceleration in reversed(self.points)),
            lambda ends, acceleration: (min(ends[0], acceleration), max(ends[1], acceleration)),
            initial=(0.0, 0.0),
        )
        object.__setattr__(self, "_later", tuple(later)[::-1])
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

    def extremes(self, since: float) -> tuple[float, float]:
        if since >= self.duration:
            return 0.0, 0.0
        least, most = self._later[self._stretch(since, before=False) + 1]
        now = self.acceleration(max(since, 0.0))
        return min(least, now), max(most, now)

    def _stretch(self, time: float, before: bool) -> int:
        """Return the index of the interval of a time; at a point, of the interval before or after it."""
        return (bisect_left if before else bisect_right)(self._between, time)


class Component(NamedTuple):
    """Acceleration of the ground along a line."""

    course: Course
    direction_W: Vec3  # unit: positive direction of the acceleration


@dataclass(frozen=True, slots=True)
class GroundMotion:
    """Acceleration of the ground from a start time: along a horizontal line, and along others if there are `beside`."""

    course: Course
    direction_W: Vec3  # unit, horizontal: positive direction of the acceleration
    begins: float  # [s]
    beside: tuple[Component, ...] = ()  # along other lines; then all courses are tables

    @property
    def components(self) -> tuple[Component, ...]:
        """All components, that along `direction_W` first."""
        return (Component(self.course, self.direction_W), *self.beside)

    @property
    def ends(self) -> float:
        """Time after which the ground is at rest or moves uniformly [s]."""
        return self.begins + self.duration

    @property
    def duration(self) -> float:
        """Time from the beginning of the first to the end of the last component [s]."""
        return max(course.duration for course, _ in self.components)

    @property
    def is_horizontal(self) -> bool:
        """True if no component has a vertical part."""
        return all(direction_W[2] == 0.0 for _, direction_W in self.components)

    def means(self, start: float, duration: float) -> Sequence[float]:
        """Return the mean acceleration of each component over a positive duration [m/s2]."""
        ends = start, start + duration
        gained = ([self._gained(course, time) for time in ends] for course, _ in self.components)
        return [(after - before) / duration for before, after in gained]

    def mean_W(self, start: float, duration: float) -> Vec3:
        """Return the mean acceleration over a positive duration as a vector [m/s2]."""
        return self._sum(self.means(start, duration))

    def at(self, time: float) -> Vec3:
        """Return the acceleration at a time from the beginning on [m/s2]; 0 after the end of each course."""
        return self._since(max(0.0, time - self.begins), before=False)

    def _since(self, time: float, before: bool) -> Vec3:
        """Return the acceleration at a time after the beginning, so that jumps are exact."""
        return self._sum([_within(course, time, before) for course, _ in self.components])

    def _sum(self, along: Sequence[float]) -> Vec3:
        if not self.beside:
            return scale(along[0], self.direction_W)
        total = AT_REST
        for value, (_, direction_W) in zip(along, self.components, strict=True):
            total = add_scaled(total, value, direction_W)
        return total

    @property
    def peaks(self) -> Sequence[float]:
        """Largest absolute acceleration of each component [m/s2]."""
        return [max(map(abs, course.extremes(0.0))) for course, _ in self.components]

    def most_pull(self, gravity: float, since: float) -> float:
        """Return an upper bound of the acceleration of a free body relative to the ground, from a time on [m/s2]."""
        level: list[float] = []
        upright = gravity
        for course, direction_W in self.components:
            ends = course.extremes(since - self.begins)
            level += [] if direction_W[2] else ends
            upright += max(ends) if direction_W[2] else 0.0
        return hypot(upright, *level)

    def leaves(self, least: float, most: float, since: float) -> float:
        """Return the first time from `since` at which the acceleration leaves a range around 0 [s]; inf if never.

        Only for a motion along one line.
        """
        for start, end in _stretches(self.course.turns, since - self.begins):
            if not least <= self.course.acceleration(start) <= most:
                return self.begins + start
            if not least <= self.course.acceleration(end, before=True) <= most:
                return self.begins + self._passed(start, end, least, most)
        return inf

    def _passed(self, start: float, end: float, least: float, most: float) -> float:
        for _ in range(HALVINGS):
            middle = 0.5 * (start + end)
            within = least <= self.course.acceleration(middle) <= most
            start, end = (middle, end) if within else (start, middle)
        return start

    def leaves_set(self, holds: Callable[[Vec3], bool], since: float) -> float:
        """Return the first time from `since` at which the acceleration leaves a convex set around 0 [s]; inf if never.

        `holds` tells if an acceleration [m/s2] is in the set. The time is early by at most a thousandth of the time
        between two rows of the tables.
        """
        turns = sorted({time for course, _ in self.components for time in course.turns})
        for start, end in _stretches(turns, since - self.begins):
            if not holds(self._since(start, before=False)):
                return self.begins + start
            if not holds(self._since(end, before=True)):
                inside, outside = start, end
                for _ in range(HALVINGS_OF_A_ROW):
                    middle = 0.5 * (inside + outside)
                    within = holds(self._since(middle, before=False))
                    inside, outside = (middle, outside) if within else (inside, middle)
                return self.begins + inside
        return inf

    def _gained(self, course: Course, time: float) -> float:
        return course.gained(min(max(time - self.begins, 0.0), course.duration))


def _stretches(turns: Iterable[float], since: float) -> Iterator[tuple[float, float]]:
    """Return the monotonic intervals from a time on, in the time of the course, so that jumps are exact [s]."""
    later = (max(since, turn) for turn in turns)  # lazily, as a long course has millions
    return ((start, end) for start, end in pairwise(later) if end > start)


def _within(course: Course, time: float, before: bool) -> float:
    """Return the acceleration of a course at a time, or just before it; 0 outside of the course [m/s2]."""
    if before:
        return course.acceleration(time, before=True) if 0.0 < time <= course.duration else 0.0
    return course.acceleration(time) if 0.0 <= time < course.duration else 0.0


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
