"""How a hand goes from place to place: smoothly, at rest in each, and never faster than was said."""

from itertools import pairwise
from math import dist, sqrt

import pytest

from stability.dynamics.ground_motion import HandCourse

STRAIGHT = HandCourse(((0.03, 0.04, 0.0),), speed=0.05)
ROUND = HandCourse(((0.02, 0.0, 0.0), (0.02, 0.01, 0.0), (0.0, 0.0, 0.03)), speed=0.1)


@pytest.mark.parametrize("course", [STRAIGHT, ROUND])
def test_a_hand_course_begins_and_ends_at_rest_in_its_places(course: HandCourse) -> None:
    assert course.at(0.0) == (0.0, 0.0, 0.0)
    assert course.at(course.duration) == pytest.approx(course.places_W[-1], abs=1e-15)
    assert course.at(course.duration + 1.0) == course.at(float("inf")) == course.end_W
    soon = 1e-3 * course.duration
    assert dist(course.at(soon), course.at(0.0)) < 1e-6 * course.length
    assert dist(course.at(course.duration - soon), course.end_W) < 1e-6 * course.length


def test_a_hand_course_takes_15_eighths_of_way_over_speed_and_reaches_its_speed_half_way() -> None:
    assert STRAIGHT.duration == pytest.approx(15.0 / 8.0 * 0.05 / 0.05)
    half, step = 0.5 * STRAIGHT.duration, 1e-6
    assert dist(STRAIGHT.at(half - step), STRAIGHT.at(half + step)) / (2.0 * step) == pytest.approx(0.05, rel=1e-6)
    times = [0.01 * index * STRAIGHT.duration for index in range(101)]
    assert max(dist(STRAIGHT.at(t), STRAIGHT.at(t + step)) / step for t in times) <= 0.05 * (1.0 + 1e-6)


def test_its_most_acceleration_is_that_of_the_least_jerk() -> None:
    step, duration = 1e-4, STRAIGHT.duration
    speeds = [dist(STRAIGHT.at(index * step), STRAIGHT.at((index + 1) * step)) / step for index in range(18_749)]
    most = max(abs(after - before) / step for before, after in pairwise(speeds))
    assert most == pytest.approx(STRAIGHT.most_acceleration, rel=1e-3)
    assert STRAIGHT.most_acceleration == pytest.approx(10.0 / sqrt(3.0) * 0.05 / duration**2)


def test_a_hand_course_passes_through_every_place_of_its_path() -> None:
    first = 15.0 / 8.0 * 0.02 / 0.1
    assert ROUND.at(first) == pytest.approx((0.02, 0.0, 0.0))
    assert ROUND.at(first + 15.0 / 8.0 * 0.01 / 0.1) == pytest.approx((0.02, 0.01, 0.0))
    assert ROUND.length == pytest.approx(0.02 + 0.01 + dist((0.02, 0.01, 0.0), (0.0, 0.0, 0.03)))


def test_a_hand_course_of_no_length_has_no_duration() -> None:
    assert HandCourse((), speed=0.05).duration == 0.0
    assert HandCourse((), speed=0.05).at(1.0) == (0.0, 0.0, 0.0)
