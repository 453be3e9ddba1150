"""Outcomes of samples, against closed forms and against full statics of each sample."""

from collections import Counter

import numpy as np
import pytest
from scipy.special import betaincinv

from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, Way, judge_sample, sample_outcomes_of
from stackdsl.sampling.samples import BuildPlan
from tests.stackdsl.sampling.samples import designed, some

HALF_LENGTH, HALF_WIDTH = 0.0588, 0.0117


def closed_form(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The level at which columns of planks that are not turned fall, 0 where they stand; (levels, samples) [m].

    Plank k holds what lies on it while the common centre of that lies above k.
    """
    fell = np.zeros(x.shape[1], dtype=int)
    for top in range(1, len(x)):
        for k in range(top):
            over = [np.abs(row[k + 1 : top + 1].mean(axis=0) - row[k]) for row in (x, y)]
            falls = (over[0] > HALF_LENGTH) | (over[1] > HALF_WIDTH)
            fell[(fell == 0) & falls] = top + 1
    return fell


@pytest.mark.parametrize("step", ["0 mm", "10 mm"])
def test_a_stepped_column_falls_in_the_samples_in_which_its_closed_form_does(step: str) -> None:
    design = designed(f"- column: {{levels: 11, step: {step}}}\n  every: 1 s\n  jitter: {{position: 4 mm}}")
    hands = PlacementSampler(design, some(1000)).build()
    expected = closed_form(hands.x, hands.y)
    assert 0.02 < (expected > 0).mean() < 0.98
    np.testing.assert_array_equal(sample_outcomes_of(design, some(1000)).values, expected)


# Standard deviations with which about so many per cent of columns of ten planks stand.
SPREADS = {99: 2.24, 95: 2.78, 90: 3.13, 75: 3.86, 60: 4.45, 45: 5.06, 30: 5.79, 20: 6.44, 8: 7.8, 1: 10.8}


@pytest.mark.parametrize(
    "share", [pytest.param(share, marks=[] if share in (95, 45, 8) else [pytest.mark.slow]) for share in SPREADS]
)
def test_the_share_of_stepped_columns_that_stand_is_that_of_their_closed_form(share: int) -> None:
    """Held against 200,000 samples of numpy's own; both are as sure as 99.9 %."""
    spread, step, count = SPREADS[share] * 1e-3, 7e-3, 1000
    design = designed(f"- column: {{levels: 10, step: 7 mm}}\n  every: 1 s\n  jitter: {{position: {spread} m}}")
    stood = int((sample_outcomes_of(design, some(count)).values == SampleOutcome.STANDS).sum())
    generator, many = np.random.default_rng(5), 200_000
    x = np.cumsum(step + spread * generator.standard_normal((10, many)), axis=0)
    y = np.cumsum(spread * generator.standard_normal((10, many)), axis=0)
    truly = float((closed_form(x, y) == 0).mean())
    assert truly == pytest.approx(share / 100.0, abs=0.01)
    low = betaincinv(stood, count - stood + 1, 0.0005)
    high = betaincinv(stood + 1, count - stood, 0.9995)
    assert low <= truly <= high


TOWERS = {
    "column": "- column: {levels: 40}\n  every: 1 s\n  jitter: {position: 1.5 mm, yaw: 2 deg}",
    "four-stack": "- four_stack: {levels: 8}\n  every: 1 s\n  jitter: {position: 6 mm, yaw: 6 deg}",
    "stepped": "- four_stack: {levels: 9, step: 10 mm}\n  every: 1 s\n  jitter: {position: 4 mm, yaw: 4 deg}",
    "wall": "- wall: {levels: 4, bricks: 3, gap: 6 mm}\n  every: 1 s\n  jitter: {position: 2 mm, yaw: 1 deg}",
    "at one moment": "- harmonic: {bricks: 6, share: 90 %}\n  jitter: {position: 2 mm, yaw: 2 deg}",
    "misses": "- column: {levels: 3}\n  every: 1 s\n  jitter: {position: 20 mm, yaw: 40 deg}",
}
COSTLY = ("column", "four-stack")


def cold(design: BuildPlan, sample: int) -> int:
    """The fate of a sample by all of statics."""
    hands = PlacementSampler(design, some(1, first=sample)).build()
    return judge_sample(design, hands.placed(0)) if hands.fits[0] else SampleOutcome.UNFIT


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in COSTLY else []) for name in TOWERS]
)
def test_no_verdict_differs_when_a_sample_is_asked_cold(name: str) -> None:
    design = designed(TOWERS[name])
    found = sample_outcomes_of(design, some(60))
    assert found.values.tolist() == [cold(design, sample) for sample in range(60)]
    assert (Way.FORCES in found.ways) or name == "stepped"


def test_a_column_is_decided_by_forces_and_falls_that_are_passed_on() -> None:
    found = sample_outcomes_of(designed(TOWERS["column"]), some(200))
    assert set(found.ways) == {Way.FORCES, Way.FALL}
    assert Counter(found.ways)[Way.FALL] == (found.values > 0).sum()


@pytest.mark.parametrize(
    "build",
    [
        "- card_house: {levels: 2}\n  every: 1 s\n  jitter: {position: 1 mm, yaw: 1 deg}",
        "- bricks: [{on: ground, rotate: [0, 20 deg, 0]}]\n  jitter: {position: 1 mm}",
    ],
)
def test_leaning_samples_are_judged_anew(build: str) -> None:
    found = sample_outcomes_of(designed(build), some(3))
    assert set(found.ways) == {Way.ANEW}
    assert SampleOutcome.UNFIT not in found.values


def test_sliding_bricks_fall_in_every_sample() -> None:
    design = designed(
        "- column: {levels: 2}\n  jitter: {position: 0.1 mm}", "friction: 0.3\nworld: {tilt: 17 deg}"
    )  # whose tangent is 0.306
    assert (sample_outcomes_of(design, some(5)).values > 0).all()


def test_samples_are_the_same_in_whatever_parts_they_are_judged() -> None:
    design = designed(TOWERS["four-stack"])
    parts = [sample_outcomes_of(design, some(20, first)).values for first in (0, 20, 40)]
    np.testing.assert_array_equal(sample_outcomes_of(design, some(60)).values, np.concatenate(parts))
