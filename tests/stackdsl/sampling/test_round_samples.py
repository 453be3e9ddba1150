"""Samples of round bricks, against closed forms of each sample."""

import numpy as np
import pytest

from stability.geometry.placed_shape import apart
from stackdsl.sampling.placement_errors import FORGIVEN, PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, sample_outcomes_of
from stackdsl.studies.fragility_intensity import capacities_of
from tests.stackdsl.sampling.samples import designed, some

RADIUS, HEIGHT = 0.03, 0.1
CAN = "brick: {cylinder: {diameter: 60 mm, height: 100 mm}, mass: 1 kg}"


def off(hands: PlacementSampler, lower: int, upper: list[int]) -> np.ndarray:
    """By how much the common centre of some bricks is off that of another one, by sample [m]."""
    x, y = (rows[upper].mean(axis=0) - rows[lower] for rows in (hands.x, hands.y))
    return np.hypot(x, y)  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    "brick", ["cylinder: {diameter: 60 mm, height: 100 mm}", "pipe: {diameter: 60 mm, wall: 4 mm, height: 100 mm}"]
)
def test_a_can_falls_off_another_where_its_centre_is_beyond_the_rim(brick: str) -> None:
    design = designed(
        "- column: {levels: 2}\n  every: 1 s\n  jitter: {position: 20 mm, yaw: 3 deg}",
        f"brick: {{{brick}, mass: 1 kg}}",
    )
    hands = PlacementSampler(design, some(100)).build()
    aside = off(hands, 0, [1])
    falls = (aside > RADIUS) & (aside < 2.0 * RADIUS)  # farther off it stands beside the other
    assert 0.1 < falls.mean() < 0.6
    np.testing.assert_array_equal(sample_outcomes_of(design, some(100)).values, np.where(falls, 2, 0))


def test_a_column_of_cans_falls_where_a_common_centre_is_beyond_a_rim() -> None:
    design = designed("- column: {levels: 4}\n  every: 1 s\n  jitter: {position: 12 mm}", CAN)
    hands, fell = PlacementSampler(design, some(60)).build(), np.zeros(60, dtype=int)
    for top in range(1, 4):
        for lower in range(top):
            upper = list(range(lower + 1, top + 1))
            beyond = (off(hands, lower, upper) > RADIUS) | (off(hands, lower + 1, upper) > RADIUS)
            fell[(fell == 0) & beyond] = top + 1
    assert len(set(fell.tolist())) > 2
    np.testing.assert_array_equal(sample_outcomes_of(design, some(60)).values, fell)


def test_a_can_falls_off_a_block_where_its_centre_is_beyond_an_edge() -> None:
    design = designed(
        """
        - bricks: [{name: block, brick: {size: [80 mm, 50 mm, 40 mm], mass: 1 kg}, on: ground}]
        - bricks: [{name: can, on: block}]
          jitter: {position: 20 mm, yaw: 10 deg}
        """,
        CAN,
    )
    hands = PlacementSampler(design, some(60)).build()
    falls = (np.abs(hands.x[1]) > 0.04) | (np.abs(hands.y[1]) > 0.025)
    assert 0.1 < falls.mean() < 0.9
    values = sample_outcomes_of(design, some(60)).values
    np.testing.assert_array_equal(values == SampleOutcome.STANDS, ~falls)


def test_a_can_that_misses_the_one_below_stands_on_the_ground() -> None:
    design = designed("- column: {levels: 2}\n  every: 1 s\n  jitter: {position: 60 mm}", CAN)
    hands = PlacementSampler(design, some(60)).build()
    misses = off(hands, 0, [1]) > 2.0 * RADIUS
    assert misses.any()
    np.testing.assert_allclose(hands.lift[1], np.where(misses, -HEIGHT, 0.0), atol=1e-12)


def test_cans_side_by_side_never_enter_each_other() -> None:
    places = ", ".join(f"{{name: c{x}{y}, at: [{62 * x} mm, {62 * y} mm, 50 mm]}}" for x in (0, 1) for y in (0, 1))
    design = designed(f"- bricks: [{places}]\n  jitter: {{position: 3 mm}}", CAN)
    hands = PlacementSampler(design, some(80)).build()
    apart_by = [off(hands, one, [other])[hands.fits] for one in range(4) for other in range(one)]
    assert hands.fits.mean() > 0.9
    assert np.min(apart_by) > 2.0 * RADIUS - 1.01 * FORGIVEN
    assert np.min(apart_by) < 2.0 * RADIUS + 1e-3


@pytest.mark.parametrize("brick", ["cone: {bottom: 60 mm, top: 40 mm, height: 100 mm}", "sphere: {diameter: 60 mm}"])
def test_a_round_brick_is_lowered_until_it_touches(brick: str) -> None:
    design = designed(
        "- column: {levels: 2}\n  every: 1 s\n  jitter: {position: 8 mm}", f"brick: {{{brick}, mass: 1 kg}}"
    )
    hands = PlacementSampler(design, some(12)).build()
    for sample in range(12):
        low, high = hands.placed(sample)
        assert apart(high.brick.shape, high.pose, low.brick.shape, low.pose).gap == pytest.approx(0.0, abs=1e-9)


def test_a_log_on_level_ground_is_undecided_in_every_sample() -> None:
    log = "{name: log, at: [0 m, 0 m, 30 mm], rotate: [90 deg, 0 deg, 0 deg]}"
    build = f"- bricks: [{log}]\n  jitter: {{position: 5 mm, yaw: 5 deg}}"
    values = sample_outcomes_of(designed(build, CAN), some(10)).values
    assert set(values.tolist()) == {int(SampleOutcome.UNDECIDED)}


def test_two_cans_survive_the_acceleration_that_tips_one_or_both() -> None:
    """The upper one turns about the rim of the lower one, both about the rim on the ground."""
    design = designed("- column: {levels: 2}\n  every: 1 s\n  jitter: {position: 5 mm}", f"{CAN}\nfriction: 3")
    aside = off(PlacementSampler(design, some(2)).build(), 0, [1])
    expected = np.minimum((RADIUS - 0.5 * aside) / HEIGHT, (RADIUS - aside) / (0.5 * HEIGHT))
    survived = np.array([each.survived for each in capacities_of(design, some(2), None)[0]])
    assert (survived <= expected).all()
    np.testing.assert_allclose(survived, expected, rtol=5e-4)  # the apothem of 128 sides


def test_the_outcomes_are_those_of_a_scene_ten_times_as_large() -> None:
    build = "- column: {{levels: 3}}\n  every: 1 s\n  jitter: {{position: {}}}"
    small = sample_outcomes_of(designed(build.format("14 mm"), CAN), some(40)).values
    large = CAN.replace("60 mm, height: 100 mm", "600 mm, height: 1 m")
    np.testing.assert_array_equal(sample_outcomes_of(designed(build.format("140 mm"), large), some(40)).values, small)
