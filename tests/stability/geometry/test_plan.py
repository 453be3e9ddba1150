"""Polygons in plan and turns in space."""

from math import cos, pi, sin, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.polygons import Point2, centroid, convex_hull, signed_distance, straightened
from stability.geometry.vectors import lean_between, multiply, rotate, turn_between
from stability.model import Pose

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
coordinates = st.floats(-1.0, 1.0).map(lambda x: round(x, 4))
point_sets = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=12)


def about_z(angle: float) -> tuple[float, float, float, float]:
    return (0.0, 0.0, sin(angle / 2.0), cos(angle / 2.0))


def test_a_quarter_turn_about_z_takes_x_to_y() -> None:
    assert rotate(about_z(pi / 2.0), (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))


@given(st.floats(-pi, pi), st.floats(-pi, pi))
def test_two_turns_compose_to_the_turn_by_the_sum(first: float, second: float) -> None:
    once = rotate(about_z(first + second), (1.0, 2.0, 3.0))
    twice = rotate(multiply(about_z(second), about_z(first)), (1.0, 2.0, 3.0))
    assert twice == pytest.approx(once, abs=1e-12)


def test_the_hull_of_a_square_with_points_inside_and_on_its_edges_is_the_square() -> None:
    inner = [(1.0, 1.0), (1.0, 0.0), (2.0, 1.0), (0.3, 1.9)]
    assert convex_hull([*inner, *SQUARE]) == SQUARE


@given(st.lists(st.tuples(*[st.floats(-1e-15, 1e-15)] * 2), min_size=8, max_size=8))
def test_rounding_never_costs_a_hull_its_extreme_corners(noise: list[Point2]) -> None:
    #   A rectangle whose left side carries two points more: sorting them by x is sorting noise.
    places = [(-0.0354, y) for y in (-0.0588, -0.0354, 0.0354, 0.0588)] + [(0.05, y) for y in (-0.0588, 0.0588)] * 2
    points = [(x + dx, y + dy) for (x, y), (dx, dy) in zip(places, noise, strict=True)]
    assert len(straightened(convex_hull(points))) == 4


def test_a_polygon_no_wider_than_noise_is_none() -> None:
    assert straightened(((0.0, 0.0), (1.0, 0.0), (1.0, 1e-6), (0.0, 1e-6))) == ()
    assert straightened(()) == ()


@pytest.mark.parametrize(
    ("points", "hull"),
    [
        ([(1.0, 1.0), (1.0, 1.0)], ((1.0, 1.0),)),
        ([(0.0, 0.0), (1.0, 1.0), (3.0, 3.0)], ((0.0, 0.0), (3.0, 3.0))),
    ],
)
def test_points_on_a_line_have_a_hull_without_area(points: list[Point2], hull: tuple[Point2, ...]) -> None:
    assert convex_hull(points) == hull


@given(point_sets)
def test_every_point_lies_in_the_hull_of_all(points: list[Point2]) -> None:
    hull = convex_hull(points)
    assert all(signed_distance(point, hull) >= -1e-6 for point in points)


@given(point_sets)
def test_the_hull_does_not_depend_on_the_order(points: list[Point2]) -> None:
    assert convex_hull(points) == convex_hull(points[::-1])


@pytest.mark.parametrize(
    ("point", "distance"),
    [((1.0, 1.0), 1.0), ((0.25, 1.0), 0.25), ((2.0, 1.0), 0.0), ((3.0, 1.0), -1.0), ((3.0, 3.0), -sqrt(2.0))],
)
def test_distance_to_a_square_is_positive_inside_and_negative_outside(point: Point2, distance: float) -> None:
    assert signed_distance(point, SQUARE) == pytest.approx(distance)


def test_nothing_is_inside_a_line_or_a_point() -> None:
    assert signed_distance((0.5, 0.0), ((0.0, 0.0), (1.0, 0.0))) == 0.0
    assert signed_distance((0.0, 2.0), ((0.0, 0.0), (1.0, 0.0))) == -2.0
    assert signed_distance((3.0, 4.0), ((0.0, 0.0),)) == -5.0


def test_the_centroid_of_a_triangle_is_the_mean_of_its_corners() -> None:
    assert centroid(((0.0, 0.0), (3.0, 0.0), (0.0, 3.0))) == pytest.approx((1.0, 1.0))
    assert centroid(SQUARE) == pytest.approx((1.0, 1.0))
    assert centroid(((0.0, 0.0), (2.0, 0.0))) == pytest.approx((1.0, 0.0))


def test_a_turn_about_the_vertical_is_no_lean() -> None:
    lying = Pose((0.0, 0.0, 0.0), (sin(0.2), 0.0, 0.0, cos(0.2)))
    yawed = Pose((0.0, 0.0, 0.0), multiply((0.0, 0.0, sin(0.4), cos(0.4)), lying.orientation))
    rolled = Pose((0.0, 0.0, 0.0), multiply((sin(0.1), 0.0, 0.0, cos(0.1)), lying.orientation))
    assert turn_between(lying, yawed) == pytest.approx(0.8)
    assert lean_between(lying, yawed) == pytest.approx(0.0, abs=1e-12)
    assert lean_between(lying, rolled) == pytest.approx(0.2)
