"""A body that turns about a fixed axis: energy, and the times of closed forms."""

from math import cosh, pi, radians, sqrt

import pytest

from stability.dynamics.pendulum import Pendulum

STEP = 1e-3  # [s]


def time_until(pendulum: Pendulum, angle: float) -> float:
    now, speed, steps = 0.0, 0.0, 0
    while True:
        further, faster = pendulum.after(now, speed, STEP)
        if further > angle:
            return STEP * (steps + (angle - now) / (further - now))
        now, speed, steps = further, faster, steps + 1


def test_speed_in_time_is_that_of_the_height_lost() -> None:
    pendulum = Pendulum(inertia=5e-4, torque=2e-3, torque_across=4.6e-2)
    angle, speed = 0.0, 0.0
    while angle < radians(60.0):
        angle, speed = pendulum.after(angle, speed, STEP)
        assert speed == pytest.approx(pendulum.speed_at(angle), rel=1e-9)


def test_a_rod_let_go_level_swings_down_in_the_time_of_a_quarter_of_a_large_swing() -> None:
    # With the arithmetic-geometric mean: T = 2 pi sqrt(I / m g c) / agm(1, cos(amplitude / 2)); amplitude 90 deg.
    inertia, pull = 3e-3, 0.2
    a, b = 1.0, sqrt(0.5)
    for _ in range(8):
        a, b = 0.5 * (a + b), sqrt(a * b)
    quarter = 0.25 * 2.0 * pi * sqrt(inertia / pull) / a
    assert time_until(Pendulum(inertia, pull, 0.0), radians(90.0)) == pytest.approx(quarter, abs=1e-6)


@pytest.mark.parametrize("lean", [1e-3, 1e-2])
def test_time_to_topple_grows_with_the_logarithm_of_a_small_overhang(lean: float) -> None:
    # Near the upright the angle from it grows as lean cosh(k t) with k^2 = m g c / I.
    inertia, pull = 5e-4, 4.6e-2
    k = sqrt(pull / inertia)
    angle = lean * (cosh(2.0) - 1.0)
    pendulum = Pendulum(inertia, pull * lean, pull * sqrt(1.0 - lean * lean))
    assert time_until(pendulum, angle) == pytest.approx(2.0 / k, rel=1e-3)
