"""Rotations about axes, their inverses, and body axes."""

from math import pi, sqrt

import pytest

from stability.geometry.vectors import about, body_axes, inverse, rotate

UP = (0.0, 0.0, 1.0)


def test_a_quarter_turn_about_the_vertical_takes_x_to_y() -> None:
    assert rotate(about(UP, 0.5 * pi), (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0), abs=1e-15)


def test_a_turn_and_its_inverse_leave_all_as_it_was() -> None:
    turn = about((0.6, 0.0, 0.8), 1.234)
    assert rotate(inverse(turn), rotate(turn, (1.0, 2.0, 3.0))) == pytest.approx((1.0, 2.0, 3.0))


def test_body_axes_are_the_rotated_axes_of_the_world() -> None:
    turn = about((0.6, 0.0, 0.8), 1.234)
    for axis, along in zip(body_axes(turn), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), UP), strict=True):
        assert axis == pytest.approx(rotate(turn, along))


def test_axes_are_of_unit_length_though_an_author_wrote_few_digits() -> None:
    for axis in body_axes((0.0, 0.0, 0.38, 0.92)):
        assert sqrt(sum(part * part for part in axis)) == pytest.approx(1.0, abs=1e-15)
