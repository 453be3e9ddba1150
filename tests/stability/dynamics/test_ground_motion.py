"""Ground motion: mean over a step, future extremes, and the time at which it leaves a range."""

from math import asin, cos, hypot, inf, pi, sin
from time import process_time

import pytest

from stability.dynamics.ground_motion import Component, Course, GroundMotion, SineCourse, TabulatedCourse

ALONG_X = (1.0, 0.0, 0.0)
PULSE = TabulatedCourse(((0.0, 5.0), (0.2, 5.0), (0.2, -3.0), (0.4, -1.0)))
SINE = SineCourse(4.0, 2.5, 0.7)


def moving(course: Course, begins: float = 1.0) -> GroundMotion:
    return GroundMotion(course, ALONG_X, begins)


@pytest.mark.parametrize("step", [0.4 / 7, 0.013, 0.3])
@pytest.mark.parametrize(("course", "speed"), [(PULSE, 0.2 * 5.0 - 0.2 * 2.0), (SINE, None)])
def test_steps_of_any_length_give_the_speed_of_the_whole(course: Course, speed: float | None, step: float) -> None:
    if speed is None:
        speed = 4.0 / (5.0 * pi) * (1.0 - cos(5.0 * pi * 0.7))
    motion = moving(course)
    given = sum(motion.means(number * step, step)[0] * step for number in range(round(3.0 / step)))
    assert given == pytest.approx(speed)


def test_a_step_within_a_stretch_gets_the_mean_of_its_ends() -> None:
    assert moving(PULSE).means(1.25, 0.1)[0] == pytest.approx(-2.0)
    assert moving(PULSE).mean_W(1.05, 0.1) == pytest.approx((5.0, 0.0, 0.0))


def test_a_ground_that_has_not_begun_or_is_over_accelerates_no_more() -> None:
    for course in (PULSE, SINE):
        assert moving(course).means(0.0, 1.0) == [0.0]
        assert moving(course).means(1.7, 1.0) == pytest.approx([0.0])


def test_future_extremes_include_the_rest_after_the_motion() -> None:
    assert PULSE.extremes(-1.0) == (-3.0, 5.0)
    assert PULSE.extremes(0.3) == pytest.approx((-2.0, 0.0))
    assert PULSE.extremes(0.5) == (0.0, 0.0)
    assert SINE.extremes(-1.0) == pytest.approx((-4.0, 4.0))
    assert SINE.extremes(0.35) == pytest.approx((-4.0, 4.0))  # a quarter of its period before it ends


def test_a_bound_is_passed_where_the_sine_is_as_large() -> None:
    assert moving(SINE).leaves(-inf, 3.0, 0.0) == pytest.approx(1.0 + asin(0.75) / (5.0 * pi))
    assert moving(SINE).leaves(-3.0, inf, 0.0) == pytest.approx(1.2 + asin(0.75) / (5.0 * pi))
    assert moving(SINE).leaves(-4.0001, 4.0001, 0.0) == inf


def test_a_bound_is_passed_at_a_jump_and_on_a_slope() -> None:
    assert moving(PULSE).leaves(-inf, 4.9, 0.0) == 1.0
    assert moving(PULSE).leaves(-2.9, 6.0, 0.0) == 1.2
    assert moving(PULSE).leaves(-2.9, 6.0, 1.3) == inf
    rising = moving(TabulatedCourse(((0.0, 0.0), (2.0, 4.0))))
    assert rising.leaves(-1.0, 3.0, 0.0) == pytest.approx(2.5)


# --- several components -----------------------------------------------------------------------------------------------


def three_ways() -> GroundMotion:
    along = TabulatedCourse(((0.0, 0.0), (1.0, 3.0), (2.0, 0.0)))
    across = TabulatedCourse(((0.0, 0.0), (1.0, 4.0), (3.0, 0.0)))
    up = TabulatedCourse(((0.0, -1.0), (0.5, -1.0)))
    return GroundMotion(along, ALONG_X, 1.0, (Component(across, (0.0, 1.0, 0.0)), Component(up, (0.0, 0.0, 1.0))))


def test_components_add_up_each_for_its_own_duration() -> None:
    motion = three_ways()
    assert motion.ends == 4.0
    assert motion.at(1.25) == pytest.approx((0.75, 1.0, -1.0))
    assert motion.at(3.5) == pytest.approx((0.0, 1.0, 0.0))
    assert motion.mean_W(1.0, 1.0) == pytest.approx((1.5, 2.0, -0.5))
    assert list(motion.peaks) == [3.0, 4.0, 1.0]


def test_a_convex_set_is_left_where_the_path_crosses_its_edge() -> None:
    assert three_ways().leaves_set(lambda a_W: hypot(a_W[0], a_W[1]) <= 2.5, 0.0) == pytest.approx(1.5, abs=2e-3)
    assert three_ways().leaves_set(lambda a_W: hypot(a_W[0], a_W[1]) <= 5.01, 0.0) == inf
    assert three_ways().leaves_set(lambda a_W: a_W[2] >= 0.0, 0.0) == 1.0
    assert three_ways().leaves_set(lambda a_W: a_W[1] <= 1.0, 3.0) == 3.0


def test_a_body_falls_no_faster_against_the_ground_than_gravity_and_ground_together() -> None:
    motion = GroundMotion(PULSE, ALONG_X, 0.0, (Component(PULSE, (0.0, 0.0, 1.0)),))
    assert motion.most_pull(9.81, 0.0) >= hypot(9.81 + 5.0, 5.0)
    assert motion.most_pull(9.81, 0.5) == 9.81


def test_a_long_table_is_read_at_once() -> None:
    rows = tuple((0.005 * number, sin(0.3 * number)) for number in range(50_000))
    course, began = TabulatedCourse(rows), process_time()
    for number in range(20_000):
        course.gained(0.0123 * number)
    assert process_time() - began < 2.0
