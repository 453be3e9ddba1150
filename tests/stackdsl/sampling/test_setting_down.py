"""Placement errors add up, heights follow the supports, and no brick overlaps another."""

from math import degrees

import numpy as np
import pytest

from stackdsl.sampling.placement_errors import PlacementSampler
from tests.stackdsl.sampling.samples import designed, some

MILLIMETRE = 1e-3
THICKNESS = 7.8e-3


def test_errors_add_up_from_brick_to_brick() -> None:
    design = designed("- column: {levels: 25}\n  jitter: {position: 1 mm, yaw: 1 deg}")
    hands = PlacementSampler(design, some(4000)).build()
    for level in (1, 4, 9, 25):
        assert hands.turn[level - 1].std() == pytest.approx(np.radians(1.0) * level**0.5, rel=0.05)
        assert hands.x[level - 1].std() == pytest.approx(MILLIMETRE * level**0.5, rel=0.05)
        assert hands.y[level - 1].std() == pytest.approx(MILLIMETRE * level**0.5, rel=0.05)


def test_a_brick_on_two_belongs_in_the_middle_of_where_each_would_have_it() -> None:
    build = """\
    - bricks: [{name: a, on: ground}, {name: b, on: ground, offset: [0 mm, 80 mm, 0 mm]}]
      jitter: {position: 3 mm, yaw: 2 deg}
    - bricks: [{name: c, on: [a, b], rotate: [0 deg, 0 deg, 90 deg]}]
    """
    hands = PlacementSampler(designed(build), some(50)).build()
    # Each of the lower ones carries the middle along as it turns: 40 mm to its side.
    carried = [
        hands.x[0] - 0.040 * np.sin(hands.turn[0]),
        hands.x[1] + 0.040 * np.sin(hands.turn[1]),
    ]
    np.testing.assert_allclose(hands.x[2], np.mean(carried, axis=0), atol=1e-11)
    np.testing.assert_allclose(hands.turn[2], (hands.turn[0] + hands.turn[1]) / 2.0, atol=1e-11)


def test_uniform_errors_stay_within_their_limits() -> None:
    build = "- column: {levels: 1}\n  jitter: {position: {uniform: 2 mm}, yaw: {uniform: 5 deg}}"
    hands = PlacementSampler(designed(build), some(3000)).build()
    assert 1.99 * MILLIMETRE < np.abs(hands.x).max() <= 2.0 * MILLIMETRE
    assert 4.9 < degrees(float(np.abs(hands.turn).max())) <= 5.0 + 1e-9


def test_a_brick_that_misses_the_one_below_is_let_down_to_what_is_there() -> None:
    build = "- column: {levels: 1}\n- bricks: [{on: L1.1}]\n  jitter: {position: 60 mm}"
    hands = PlacementSampler(designed(build), some(2000)).build()
    misses = (np.abs(hands.x[1]) > 0.1176) | (np.abs(hands.y[1]) > 0.0234)
    assert 0.5 < misses.mean() < 0.95
    np.testing.assert_allclose(hands.lift[1], np.where(misses, -THICKNESS, 0.0), atol=1e-12)


def test_where_it_would_lie_in_its_neighbour_a_brick_is_set_down_anew() -> None:
    build = "- wall: {levels: 1, bricks: 2, gap: 0.2 mm}\n  jitter: {position: 1 mm}"
    hands = PlacementSampler(designed(build), some(500)).build()
    gap = hands.x[1] - hands.x[0] - 0.1176
    np.testing.assert_array_equal(hands.fits, gap >= -1e-4 - 1e-12)
    assert hands.fits.mean() > 0.98  # the errors of the first try alone would be 0.58


def test_a_brick_without_a_free_place_makes_a_sample_unfit() -> None:
    """Between two planks that leave 1 um to spare, errors of 5 mm find no place in 50 attempts."""
    build = """\
    - bricks: [{name: a, on: ground}, {name: b, on: ground, offset: [0 mm, 46.801 mm, 0 mm]}]
    - bricks: [{name: c, on: ground, offset: [0 mm, 23.4005 mm, 0 mm]}]
      jitter: {position: {uniform: 5 mm}, yaw: 20 deg}
    """
    hands = PlacementSampler(designed(build), some(200)).build()
    assert 0 < hands.fits.sum() < 200


def test_two_planks_that_lean_on_each_other_are_set_down_as_one() -> None:
    build = "- card_house: {levels: 1}\n  jitter: {position: 5 mm, yaw: 5 deg}"
    hands = PlacementSampler(designed(build), some(20)).build()
    apart = np.hypot(hands.x[1] - hands.x[0], hands.y[1] - hands.y[0])
    np.testing.assert_allclose(apart, apart[0], atol=1e-11)
    np.testing.assert_allclose(hands.turn[1], hands.turn[0], atol=1e-15)
    np.testing.assert_allclose(hands.lift, 0.0, atol=1e-11)


def test_a_tilted_scene_is_built_in_its_own_plane() -> None:
    build = "- column: {levels: 3}\n  jitter: {position: 1 mm, yaw: 1 deg}"
    level, tilted = designed(build), designed(build, "world: {tilt: 10 deg}")
    flat = PlacementSampler(level, some(3)).build()
    leaning = PlacementSampler(tilted, some(3)).build()
    np.testing.assert_allclose(leaning.x, flat.x, atol=1e-12)
    np.testing.assert_allclose(leaning.lift, flat.lift, atol=1e-12)
    heights = [placed.pose.position_W[2] for placed in leaning.placed(0)]
    assert heights == sorted(heights)
    expected = 0.5 * THICKNESS * np.cos(np.radians(10.0)) - leaning.x[0, 0] * np.sin(np.radians(10.0))
    assert heights[0] == pytest.approx(expected, abs=1e-12)
