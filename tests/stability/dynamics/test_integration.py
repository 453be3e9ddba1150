"""One step of the classical Runge-Kutta method against closed forms."""

from math import cos, exp, sin

import pytest

from stability.dynamics.pendulum import runge_kutta


def test_constant_acceleration_is_exact() -> None:
    assert runge_kutta(lambda _at, _speed: -9.81, 1.0, 2.0, 0.5) == pytest.approx((1.0 + 1.0 - 9.81 / 8.0, 2.0 - 4.905))


def test_a_spring_swings_as_a_sine_and_half_the_step_errs_a_thirty_second_as_much() -> None:
    errors = [abs(runge_kutta(lambda at, _: -at, 0.0, 1.0, step)[0] - sin(step)) for step in (0.2, 0.1)]
    assert errors[0] / errors[1] == pytest.approx(32.0, rel=0.02)
    assert runge_kutta(lambda at, _: -at, 1.0, 0.0, 0.01)[0] == pytest.approx(cos(0.01), abs=1e-12)


def test_drag_that_goes_with_speed_slows_down_exponentially() -> None:
    assert runge_kutta(lambda _, speed: -speed, 0.0, 1.0, 0.01)[1] == pytest.approx(exp(-0.01), abs=1e-11)
