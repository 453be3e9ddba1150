"""Shares of samples: exact intervals, looks fixed in advance, and undecided results."""

from math import comb, inf

import numpy as np
import pytest

from stackdsl.judging.statistics import Decision, decided, error_of_a_look, interval, judge_share, looks, samples_needed
from stackdsl.language.claims.collapses import Collapses
from stackdsl.language.claims.stands import Stands
from stackdsl.trace import Ensemble


def ensemble(stood: int, fell: dict[int, int], undecided: int = 0, planned: int = 0) -> Ensemble:
    drawn = stood + sum(fell.values()) + undecided
    return Ensemble(drawn, planned or drawn, 1, stood, fell, undecided)


def at_least(count: int, many: int, share: float) -> float:
    """How likely so many or more of many hold, of which each does so with this probability."""
    return sum(comb(many, k) * share**k * (1.0 - share) ** (many - k) for k in range(count, many + 1))


@pytest.mark.parametrize(("held", "many"), [(0, 30), (1, 30), (17, 30), (30, 30)])
def test_an_interval_is_that_of_clopper_and_pearson(held: int, many: int) -> None:
    """At its lower end so many or more are as unlikely as half of what one may be wrong by, and so at its upper end."""
    found = interval(held, held, many, 0.05)
    if held:
        assert at_least(held, many, found.low) == pytest.approx(0.025, rel=1e-9)
    else:
        assert found.low == 0.0
    if held < many:
        assert 1.0 - at_least(held + 1, many, found.high) == pytest.approx(0.025, rel=1e-9)
    else:
        assert found.high == 1.0


def test_samples_that_may_go_either_way_widen_the_interval_to_both_sides() -> None:
    found = interval(40, 45, 50, 0.05)
    assert found.low == interval(40, 40, 50, 0.05).low
    assert found.high == interval(45, 45, 50, 0.05).high


def test_looks_are_the_plan_and_its_halves() -> None:
    assert looks(1000) == (125, 250, 500, 1000)
    assert looks(199) == (199,)
    assert looks(1) == (1,)
    assert error_of_a_look(1000, 0.96) == pytest.approx(0.01)


def test_looking_again_and_again_is_wrong_no_more_often_than_was_said() -> None:
    """At the very limit of what is wanted, whatever is decided is wrong."""
    planned, runs, generator = 800, 2000, np.random.default_rng(3)
    wanted = Stands(share="50 %").share
    assert wanted is not None
    error = error_of_a_look(planned, 0.9)
    held = np.cumsum(generator.random((runs, planned)) < 0.5 - 1e-9, axis=1)
    wrong = 0
    for run in held:
        outcomes = [decided(wanted, interval(int(run[n - 1]), int(run[n - 1]), n, error)) for n in looks(planned)]
        wrong += Decision.HOLDS in outcomes
    assert wrong / runs <= 0.1
    assert wrong / runs >= 0.01  # they are looked at


@pytest.mark.parametrize(
    ("share", "stood", "decision"),
    [
        (">= 95 %", 990, Decision.HOLDS),
        (">= 95 %", 955, Decision.OPEN),
        (">= 95 %", 900, Decision.FAILS),
        ("95 %", 990, Decision.HOLDS),
        ("< 2 %", 0, Decision.HOLDS),
        ("90 % ± 5 %", 900, Decision.HOLDS),
        ("90 % ± 1 %", 900, Decision.OPEN),
        ("90 % ± 5 %", 700, Decision.FAILS),
        (">= 100 %", 1000, Decision.OPEN),
    ],
)
def test_a_share_holds_or_fails_only_with_its_whole_interval(share: str, stood: int, decision: Decision) -> None:
    finding, found = judge_share(Stands(share=share), ensemble(stood, {3: 1000 - stood} if stood < 1000 else {}), 0.95)
    assert found is decision
    assert finding.passed is (decision is Decision.HOLDS)
    assert finding.measured.startswith("undecided") is (decision is Decision.OPEN)
    assert (finding.margin >= 0.0) is (decision is Decision.HOLDS)


def test_a_collapse_counts_at_the_levels_that_are_meant() -> None:
    many = ensemble(10, {7: 40, 8: 100, 9: 700, 10: 140, 11: 10})
    finding, found = judge_share(Collapses(at="level 9 ± 1", share="90 %"), many, 0.95)
    assert "(940 of 1000 samples)" in finding.measured
    assert found is Decision.HOLDS
    anywhere, _ = judge_share(Collapses(share="90 %"), many, 0.95)
    assert "(990 of 1000 samples)" in anywhere.measured


def test_an_undecided_share_says_how_many_more_samples_it_takes() -> None:
    finding, _ = judge_share(Stands(share=">= 95 %"), ensemble(960, {3: 40}), 0.95)
    assert "more samples would decide it" in finding.measured
    wanted = Stands(share=">= 95 %").share
    assert wanted is not None
    needed = samples_needed(wanted, 0.96, 0.0, 0.0125)
    low, high = (round(0.96 * n) for n in (0.9 * needed, 1.05 * needed))
    assert (
        interval(low, low, round(0.9 * needed), 0.0125).low
        < 0.95
        <= interval(high, high, round(1.05 * needed), 0.0125).low
    )


def test_no_number_of_samples_proves_that_all_stand() -> None:
    finding, found = judge_share(Stands(share=">= 100 %"), ensemble(1000, {}), 0.95)
    assert found is Decision.OPEN
    assert "so close to the limit that no number of samples" in finding.measured
    assert samples_needed(Stands(share=">= 100 %").share, 1.0, 0.0, 0.01) == inf  # type: ignore[arg-type]


def test_samples_of_which_nothing_is_proven_are_counted_for_neither_side() -> None:
    finding, found = judge_share(Stands(share=">= 95 %"), ensemble(960, {}, undecided=40), 0.95)
    assert found is Decision.OPEN
    assert "40 undecided" in finding.measured
