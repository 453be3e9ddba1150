"""One hull, exact or to rounding."""

import pytest

from stability.geometry.polygons import Point2, convex_hull, hull

SQUARE: tuple[Point2, ...] = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


@pytest.mark.parametrize("out", [1e-15, 1e-9])
def test_the_exact_hull_keeps_a_corner_however_little_it_sticks_out(out: float) -> None:
    assert (0.5, -out) in convex_hull([*SQUARE, (0.5, -out)])


@pytest.mark.parametrize(("out", "kept"), [(1e-15, False), (1e-9, True)])
def test_the_rounded_hull_drops_corners_that_are_rounding(out: float, kept: bool) -> None:
    assert ((0.5, -out) in hull([*SQUARE, (0.5, -out)])) is kept


def test_on_a_line_the_exact_hull_has_its_ends_and_the_other_nothing() -> None:
    line = [(0.1 * number, 0.1 * number) for number in range(5)]
    assert set(convex_hull(line)) == {line[0], line[-1]}
    assert hull(line) == ()


def test_corners_run_counter_clockwise_and_inner_points_are_none() -> None:
    assert hull([*SQUARE, (0.5, 0.5)]) == convex_hull([*SQUARE, (0.5, 0.5)]) == SQUARE
