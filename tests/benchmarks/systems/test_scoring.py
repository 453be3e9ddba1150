"""How far a run is from what is known: creep, levels, times and lengths, against truth or converged runs."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from benchmarks.systems.answers import Source
from benchmarks.systems.run_record import Record, TruthHeld
from benchmarks.systems.scoring import LOOKS_APART, numerical_reason, reference_of, scores_of
from tests.benchmarks.systems.runs import FELL, SHOULD_FALL, SHOULD_STAND, STOOD, run


def test_creep_is_the_largest_shift_of_what_should_stand_whether_it_falls_or_not() -> None:
    stood, fell = scores_of([run(), run(FELL, factor=2.0)], {"tower": SHOULD_STAND})
    assert (stood.wrong, stood.creep, stood.levels, stood.energy) == (False, 0.25, 0.0, 0.5)
    assert (fell.wrong, fell.creep, fell.levels) == (True, 200.0, 3.0)


def test_creep_of_what_should_fall_is_what_moved_before_the_brick_came_with_which_it_does() -> None:
    known = replace(SHOULD_FALL, undisturbed=True)
    assert scores_of([run(FELL, shift_before=0.125)], {"tower": known})[0].creep == 0.125
    assert scores_of([run(FELL)], {"tower": SHOULD_FALL})[0].creep is None  # it was hit


def test_what_falls_before_it_should_is_wrong_though_it_should_fall() -> None:
    early = replace(run(FELL), numerical="statics prove that it stands")
    assert [score.wrong for score in scores_of([run(FELL), early], {"tower": SHOULD_FALL})] == [False, True]


def test_truths_tell_lengths_of_runs_with_the_right_verdict_alone() -> None:
    truths = (TruthHeld("height", "mm", 0.5), TruthHeld("rests_on", "", None))
    right, wrong = (replace(run(seen), truths=truths) for seen in (STOOD, FELL))
    assert scores_of([right], {"tower": SHOULD_STAND})[0].mm == 0.5
    assert scores_of([wrong], {"tower": SHOULD_STAND})[0].mm is None


def test_the_converged_reference_is_what_the_two_finest_runs_of_a_bare_engine_agree_on() -> None:
    finest, finer = run(FELL, factor=0.25), run(FELL, factor=0.5, collapse_time=2.11, reach=120.0)
    reference = reference_of([run(FELL, factor=1.0, collapse_level=5.0), finer, finest], SHOULD_FALL)
    assert reference is not None
    assert (reference.system, reference.factor) == ("tuned", 0.25)
    assert reference.observations["collapse time"] == 2.1
    assert "reach" not in reference.observations  # 80 mm and 120 mm do not agree


@pytest.mark.parametrize(
    "records",
    [
        [run(FELL, factor=0.25), run(STOOD, factor=0.5)],  # they do not agree
        [run(FELL, factor=0.25)],  # there is one only
        [run(STOOD, factor=0.25), run(STOOD, factor=0.5)],  # they agree on what is not true
        [run(FELL, system="exact", factor=0.25), run(FELL, system="exact", factor=0.5)],  # no bare engine
        [run(FELL, factor=0.25), replace(run(factor=0.5), observations=None)],  # one is not done
    ],
)
def test_there_is_no_reference_without_convergence(records: Sequence[Record]) -> None:
    assert reference_of(records, SHOULD_FALL) is None


def test_the_moving_part_is_held_against_the_reference() -> None:
    fine = [run(FELL, factor=0.25), run(FELL, factor=0.5)]
    own = run(FELL, system="exact", collapse_time=2.13, reach=76.0, bearing=-178.0)
    score = scores_of([*fine, own], {"tower": SHOULD_FALL})[2]
    assert score.seconds == pytest.approx(0.03 - LOOKS_APART)
    assert score.mm == pytest.approx(4.0)
    assert score.deg == pytest.approx(3.0)  # across the half turn
    assert scores_of(fine, {"tower": SHOULD_FALL})[0].mm is None  # the reference has no distance from itself


def test_a_time_that_is_known_is_better_than_that_of_a_reference() -> None:
    known = replace(SHOULD_FALL, earliest=2.5, latest=2.6)
    records = [run(FELL, factor=0.5), run(FELL, factor=0.25), run(FELL, "exact", collapse_time=2.55)]
    seconds = [score.seconds for score in scores_of(records, {"tower": known})]
    assert seconds == [pytest.approx(0.4), pytest.approx(0.4), 0.0]


def test_runs_that_see_a_fall_at_times_more_than_a_look_apart_have_not_converged() -> None:
    fine, coarse, own = run(FELL, factor=0.25), run(FELL, factor=0.5, collapse_time=2.08), run(FELL, "exact")
    assert scores_of([fine, coarse, own], {"tower": SHOULD_FALL})[2].seconds is None
    coarse = run(FELL, factor=0.5, collapse_time=2.09)
    assert scores_of([fine, coarse, own], {"tower": SHOULD_FALL})[2].seconds == 0.0


def test_what_nobody_knows_is_known_from_converged_runs() -> None:
    fine = [run(factor=0.25), run(factor=0.5), run(system="exact", height=41.0), run(FELL, system="stock")]
    scores = scores_of(fine, {"tower": None})
    assert [score.known for score in scores] == [Source.CONVERGED] * 4
    assert [score.wrong for score in scores] == [False, False, False, True]
    assert scores[2].mm == pytest.approx(2.0)
    assert scores[2].creep is None  # a shift is none of creep where something lands


def test_nothing_is_right_or_wrong_where_nothing_is_known() -> None:
    assert scores_of([run()], {"tower": None})[0].wrong is None


def test_a_collapse_that_the_next_finer_step_lets_stand_is_numerical() -> None:
    coarse, fine = scores_of([run(FELL, factor=2.0), run(factor=1.0)], {"tower": None})
    assert (coarse.verdict, fine.verdict) == ("numerical-collapse", "stands")
    assert "finer time step than step x 2" in numerical_reason(coarse)


def test_a_collapse_that_is_true_is_not_numerical_however_wrong_a_finer_run_is() -> None:
    coarse, fine = scores_of([run(FELL, factor=2.0), run(factor=1.0)], {"tower": SHOULD_FALL})
    assert (coarse.verdict, coarse.wrong, fine.wrong) == ("collapses", False, True)


def test_how_far_something_goes_is_creep_where_nothing_moves_it_and_a_length_where_it_is_hit() -> None:
    truths = (TruthHeld("drift", "mm", 0.75), TruthHeld("stands", "mm", 3.0))
    for undisturbed, length in ((True, None), (False, 0.75)):
        answer = replace(SHOULD_STAND, undisturbed=undisturbed)
        (score,) = scores_of([replace(run(), truths=truths)], {"tower": answer})
        assert score.mm == length
        assert (score.creep is None) is not undisturbed
