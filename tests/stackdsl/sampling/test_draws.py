"""The random numbers of a sample depend only on their purpose."""

import numpy as np
import pytest

from stackdsl.sampling.samples import Draws


def test_a_sample_is_the_same_whichever_others_are_drawn_with_it() -> None:
    together = Draws(7, "tower", 0, 100).uniform("L3.1")
    np.testing.assert_array_equal(together[:, 60:65], Draws(7, "tower", 60, 5).uniform("L3.1"))


@pytest.mark.parametrize(
    "other",
    [
        Draws(8, "tower", 0, 50).uniform("L3.1"),
        Draws(7, "towers", 0, 50).uniform("L3.1"),
        Draws(7, "tower", 0, 50).uniform("L3.2"),
        Draws(7, "tower", 0, 50).uniform("L3.1", attempt=1),
    ],
    ids=["seed", "scenario", "brick", "attempt"],
)
def test_another_subject_has_other_numbers(other: np.ndarray) -> None:
    assert not np.isin(other, Draws(7, "tower", 0, 50).uniform("L3.1")).any()


def test_numbers_are_those_of_philox_on_every_machine() -> None:
    drawn = Draws(1, "tower", 0, 2).uniform("L1.1")
    assert drawn.shape == (4, 2)
    assert [float(number).hex() for number in drawn[:, 0]] == [
        "0x1.b5c56655158e1p-2",
        "0x1.5e3529068c4cap-3",
        "0x1.c071b7805ad01p-2",
        "0x1.3b7c6ca3ab682p-3",
    ]


def test_numbers_are_spread_evenly_between_zero_and_one() -> None:
    drawn = Draws(3, "tower", 0, 25_000).uniform("L1.1").ravel()
    assert 0.0 < drawn.min() < 1e-4
    assert 1.0 - 1e-4 < drawn.max() < 1.0
    assert drawn.mean() == pytest.approx(0.5, abs=4.0 / np.sqrt(12.0 * drawn.size))
