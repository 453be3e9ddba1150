"""Cutting polygons, lines and points by half-planes."""

from math import cos, hypot, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.polygons import Point2, Polygon, clip, clip_line, cut, doubled_area, within_rectangle

SQUARE: Polygon = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
PLACE = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))


def depths(corners: Polygon, limit: float) -> list[float]:
    return [limit - x for x, _ in corners]


def turned_rectangle(centre: Point2, turn: float) -> Polygon:
    c, s = cos(turn), sin(turn)
    around = ((-0.6, -0.2), (0.6, -0.2), (0.6, 0.2), (-0.6, 0.2))
    return tuple((centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in around)


def test_a_square_cut_in_half_keeps_the_inner_half() -> None:
    assert set(cut(SQUARE, depths(SQUARE, 0.5))) == {(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)}


@pytest.mark.parametrize(("limit", "kept"), [(1.0, SQUARE), (2.0, SQUARE), (-0.5, ())])
def test_clipping_keeps_or_drops_a_polygon_wholly_on_one_side(limit: float, kept: Polygon) -> None:
    assert tuple(cut(SQUARE, depths(SQUARE, limit))) == kept


def test_a_corner_outside_by_less_than_the_slack_stays_where_it_is() -> None:
    assert tuple(cut(SQUARE, depths(SQUARE, 1.0 - 1e-9), slack=1e-6)) == SQUARE


def test_a_side_is_cut_in_the_same_point_from_either_end() -> None:
    a, b = (0.1, 0.3), (0.7, 0.9 + 1e-7)
    one, other = (a, b, (0.0, 5.0)), (b, a, (5.0, 0.0))  # two polygons that share this side
    crossings = [set(cut(polygon, depths(polygon, 1.0 / 3.0))) for polygon in (one, other)]
    assert len(set.intersection(*crossings) - {a}) == 1


def test_a_line_is_cut_into_a_line() -> None:
    assert set(clip_line(((-1.0, 0.5), (2.0, 0.5)), SQUARE, slack=0.0)) == {(0.0, 0.5), (1.0, 0.5)}
    assert clip_line(((-1.0, 2.0), (2.0, 2.0)), SQUARE, slack=0.0) == ()
    assert clip_line(((0.5, 0.5), (0.6, 0.6)), (), slack=0.0) == ()


def test_points_in_space_keep_their_height_between_them() -> None:
    found = within_rectangle([(-2.0, 0.0, 0.0), (2.0, 0.0, 4.0)], 1.0, 1.0)
    assert set(found) == {(-1.0, 0.0, 1.0), (1.0, 0.0, 3.0)}


@given(PLACE, st.floats(-3.0, 3.0))
def test_a_rectangle_cuts_like_any_polygon(centre: Point2, turn: float) -> None:
    polygon, window = turned_rectangle(centre, turn), ((-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (-0.5, 0.3))
    by_sides, by_polygon = within_rectangle(polygon, 0.5, 0.3), clip(polygon, window)
    areas = [doubled_area(found)[0] if found else 0.0 for found in (by_sides, by_polygon)]
    assert areas[0] == pytest.approx(areas[1], abs=1e-9)


@given(PLACE, st.floats(-3.0, 3.0))
def test_clipped_parts_add_up_to_the_polygon(centre: Point2, turn: float) -> None:
    polygon = turned_rectangle(centre, turn)
    inside = depths(polygon, 0.1)
    parts = [cut(polygon, inside), cut(polygon, [-depth for depth in inside])]
    assert sum(doubled_area(part)[0] for part in parts if part) == pytest.approx(2.0 * 1.2 * 0.4)
    assert all(hypot(x - centre[0], y - centre[1]) <= hypot(0.6, 0.2) + 1e-12 for part in parts for x, y in part)
