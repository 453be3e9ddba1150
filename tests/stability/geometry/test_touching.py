"""Definition of contact: the reach is a share of the thinner body."""

import pytest

from stability.geometry.box_distance import reach_between


def test_the_thinner_of_two_bodies_says_how_far_they_reach() -> None:
    assert reach_between(0.0078, 0.08) == reach_between(0.08, 0.0078) == pytest.approx(0.000156)


def test_to_a_plane_a_body_reaches_farthest() -> None:
    assert reach_between(0.0078) == reach_between(0.0078, 1e9) == pytest.approx(0.000156)


def test_all_of_a_scene_larger_reaches_as_much_farther() -> None:
    assert reach_between(7.8, 80.0) == pytest.approx(1000.0 * reach_between(0.0078, 0.08))
