"""Contact areas from contact points (stack-stability thesis, 3.3.3)."""

import pytest

from stability.geometry.polygons import signed_distance
from stability.stabilizers.published.support import WIDENING, contact_area, main_contact, plan_hull


def test_four_corner_points_give_their_quad_whatever_their_order_and_height() -> None:
    points = [(0.0, 0.0, 1.0), (2.0, 1.0, 1.1), (2.0, 0.0, 0.9), (0.0, 1.0, 1.0)]
    area = contact_area("below", points)
    assert area.polygon == ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0))
    assert area.centre == pytest.approx((1.0, 0.5))


def test_two_points_become_a_thin_quad_along_their_line() -> None:
    quad = plan_hull([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    assert signed_distance((0.5, 0.0), quad) == pytest.approx(WIDENING)
    assert signed_distance((0.5, 2.0 * WIDENING), quad) == pytest.approx(-WIDENING)
    assert signed_distance((1.1, 0.0), quad) == pytest.approx(-0.1)


def test_the_contact_area_of_one_point_is_a_small_diamond() -> None:
    diamond = plan_hull([(3.0, 4.0, 0.0)])
    assert len(diamond) == 4
    assert signed_distance((3.0, 4.0), diamond) > 0.0
    assert signed_distance((3.0 + WIDENING, 4.0), diamond) == pytest.approx(0.0, abs=1e-12)


def test_the_main_contact_spans_the_gap_between_two_supports() -> None:
    left = contact_area("left", [(x, y, 0.0) for x in (0.0, 1.0) for y in (0.0, 1.0)])
    right = contact_area("right", [(x, y, 0.0) for x in (5.0, 6.0) for y in (0.0, 1.0)])
    assert main_contact([left, right]) == ((0.0, 0.0), (6.0, 0.0), (6.0, 1.0), (0.0, 1.0))
