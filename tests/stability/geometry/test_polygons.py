"""Convex polygons in plan, without rounding corners away."""

from math import cos, hypot, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.polygons import Point2, Polygon, barycentric, clip, depth, extent, hull, inset

SQUARE: Polygon = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def area(polygon: Polygon) -> float:
    return 0.5 * sum(ax * by - ay * bx for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1], strict=True))


def moved(polygon: Polygon, x: float, y: float, angle: float = 0.0) -> Polygon:
    c, s = cos(angle), sin(angle)
    return tuple((x + c * px - s * py, y + s * px + c * py) for px, py in polygon)


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.999999999])
def test_two_squares_overlap_in_a_rectangle(shift: float) -> None:
    assert area(clip(SQUARE, moved(SQUARE, shift, 0.0))) == pytest.approx(1.0 - shift, rel=1e-6)


def test_a_square_and_the_same_turned_by_45_degrees_overlap_in_an_octagon() -> None:
    centred = moved(SQUARE, -0.5, -0.5)
    # regular octagon of inradius 1/2: 8 r^2 tan(pi / 8)
    assert area(clip(centred, moved(centred, 0.0, 0.0, 0.0))) == pytest.approx(1.0)
    turned = moved(moved(SQUARE, -0.5, -0.5), 0.0, 0.0, pi / 4)
    assert area(clip(centred, turned)) == pytest.approx(2.0 * 0.41421356237309503, rel=1e-12)


def test_touching_polygons_do_not_overlap() -> None:
    assert clip(SQUARE, moved(SQUARE, 1.0, 0.0)) == ()
    assert clip(SQUARE, moved(SQUARE, 1.0, 1.0)) == ()
    assert clip(SQUARE, ()) == ()


def test_a_sliver_keeps_its_corners() -> None:
    sliver = clip(SQUARE, moved(SQUARE, 1.0 - 1e-9, 0.0))
    assert len(sliver) == 4
    assert area(sliver) == pytest.approx(1e-9, rel=1e-5)


def test_clipping_by_the_same_polygon_again_and_again_changes_nothing() -> None:
    window = moved(SQUARE, 0.3, 0.1, 0.7)
    once = clip(SQUARE, window)
    again = once
    for _ in range(100):
        again = clip(clip(again, window), SQUARE)
    assert again == once


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 2 * pi))
def test_clipping_does_not_ask_which_polygon_comes_first(x: float, y: float, angle: float) -> None:
    other = moved(moved(SQUARE, -0.5, -0.5), x + 0.5, y + 0.5, angle)
    one, two = clip(SQUARE, other), clip(other, SQUARE)
    assert (area(one) if one else 0.0) == pytest.approx(area(two) if two else 0.0, abs=1e-11)


@pytest.mark.parametrize(("point", "expected"), [((0.2, 0.5), 0.2), ((0.0, 0.5), 0.0), ((-0.3, 0.5), -0.3)])
def test_depth_is_the_distance_to_the_nearest_side(point: Point2, expected: float) -> None:
    assert depth(point, SQUARE) == pytest.approx(expected)


@pytest.mark.parametrize("distance", [0.0, 0.1, 0.49])
def test_an_inset_square_loses_the_distance_on_each_side(distance: float) -> None:
    assert area(inset(SQUARE, distance)) == pytest.approx((1.0 - 2.0 * distance) ** 2)


def test_a_square_has_no_part_deeper_than_half_its_side() -> None:
    assert inset(SQUARE, 0.51) == ()


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 2 * pi))
def test_corner_weights_have_the_point_as_their_mean(u: float, v: float, angle: float) -> None:
    polygon = moved(SQUARE, 3.0, -2.0, angle)
    point = moved(((u, v),), 3.0, -2.0, angle)[0]
    weights = barycentric(point, polygon)
    assert min(weights) >= 0.0
    assert sum(weights) == pytest.approx(1.0)
    mean = (
        sum(weight * x for weight, (x, _) in zip(weights, polygon, strict=True)),
        sum(weight * y for weight, (_, y) in zip(weights, polygon, strict=True)),
    )
    assert hypot(mean[0] - point[0], mean[1] - point[1]) < 1e-12


def test_points_on_a_line_have_no_hull() -> None:
    assert hull([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]) == ()
    assert extent(hull([(0.0, 0.0), (2.0, 0.0), (1.0, 1.0)])) == 2.0


def test_a_corner_that_is_there_twice_changes_no_depth() -> None:
    square = ((0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
    assert depth((1.5, 1.0), square) == 0.5
