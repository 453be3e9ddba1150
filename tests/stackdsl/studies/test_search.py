"""The search for a limit, with verdicts given by a rule."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

import pytest

from stackdsl.studies.limit_search import (
    EVERYWHERE,
    Range,
    SearchResult,
    SearchStart,
    SearchTarget,
    TrialVerdict,
    Tried,
    VerdictCache,
    search,
)


@dataclass
class DisplayedResult(VerdictCache):
    """Answers by rule instead of by statics."""

    rule: Callable[[float], TrialVerdict] = lambda _: TrialVerdict.STANDS

    def _try(self, value: float) -> Tried:
        return Tried(value, self.rule(value))


def asked(
    rule: Callable[[float], bool | TrialVerdict],
    number: float,
    upwards: bool,
    within: Range = EVERYWHERE,
    **more: float,
) -> tuple[SearchResult, DisplayedResult]:
    def answer(value: float) -> TrialVerdict:
        given = rule(value)
        return given if isinstance(given, TrialVerdict) else (TrialVerdict.STANDS if given else TrialVerdict.FALLS)

    asking = DisplayedResult(lambda _: (None, ()), rule=answer)
    whole = bool(more.pop("whole", 0.0))
    return search(
        asking, SearchStart(number, 1.0, whole), SearchTarget(upwards, 1e-7, within, more.get("guess"))
    ), asking


def sides(found: SearchResult) -> tuple[float, float]:
    assert found.stands is not None
    assert found.beyond is not None
    return found.stands.value, found.beyond.value


@pytest.mark.parametrize("written", [0.5, 8.39, 10.0, 14.0, 80.0])
def test_the_largest_is_found_from_either_side(written: float) -> None:
    found, _ = asked(lambda value: value <= 8.4, written, upwards=True)
    stands, falls = sides(found)
    assert stands <= 8.4 < falls <= stands * (1.0 + 1.1e-7)
    assert not found.contradicting


@pytest.mark.parametrize("written", [0.05, 0.3, 0.5, 4.0])
def test_the_least_is_found_from_either_side(written: float) -> None:
    stands, falls = sides(asked(lambda value: value >= 0.3, written, upwards=False)[0])
    assert falls < 0.3 <= stands <= falls * (1.0 + 1.1e-7)


def test_of_whole_numbers_the_last_that_stands_and_the_next() -> None:
    found, asking = asked(lambda value: value <= 9, 14.0, upwards=True, whole=1.0)
    assert sides(found) == (9.0, 10.0)
    assert all(value == int(value) for value in asking.tried)


def test_what_somebody_knows_is_asked_on_both_sides_and_nowhere_else_but_beside() -> None:
    found, asking = asked(lambda value: value >= 0.3, 0.5, upwards=False, guess=0.3)
    assert found.guessed
    assert len(asking.tried) == 8  # two sides, and three beside each


def test_a_wrong_guess_leads_nowhere() -> None:
    found, _ = asked(lambda value: value >= 0.3, 0.5, upwards=False, guess=0.2)
    assert not found.guessed
    assert sides(found)[0] == pytest.approx(0.3, rel=1e-7)


def test_nothing_is_asked_outside_of_the_range() -> None:
    found, asking = asked(lambda value: value <= 8.4, 20.0, True, Range(2.0, 9.0, given=True))
    assert sides(found)[0] == pytest.approx(8.4, rel=1e-7)
    assert min(asking.tried) >= 2.0
    assert max(asking.tried) <= 9.0


def test_without_a_limit_in_the_range_it_stands_to_the_end() -> None:
    found, _ = asked(lambda value: value <= 8.4, 3.0, True, Range(2.0, 5.0, given=True))
    assert found.stands is not None
    assert (found.stands.value, found.beyond) == (5.0, None)


def test_a_search_without_a_stand_finds_no_limit() -> None:
    assert asked(lambda value: False, 3.0, upwards=True)[0] == SearchResult(None)
    assert asked(lambda value: TrialVerdict.OPEN, 3.0, upwards=True)[0] == SearchResult(None)


def test_a_window_is_told_as_no_only_limit() -> None:
    #   It stands from 2 to 5; the largest is 5, and below 2 it falls also.
    found, _ = asked(lambda value: 2.0 <= value <= 5.0, 4.0, upwards=True)
    assert sides(found)[0] == pytest.approx(5.0, rel=1e-7)
    assert {each.answer for each in found.contradicting} == {TrialVerdict.FALLS}
    assert all(each.value < 2.0 for each in found.contradicting)


def test_a_search_reports_a_second_range_that_stands() -> None:
    found, _ = asked(lambda value: value <= 5.0 or value >= 7.0, 4.0, upwards=True)
    assert sides(found)[0] == pytest.approx(5.0, rel=1e-7)
    assert [each.answer for each in found.contradicting] == [TrialVerdict.STANDS] * len(found.contradicting)
    assert found.contradicting


def test_a_limit_may_be_the_last_valid_value_of_a_scenario() -> None:
    found, asking = asked(lambda value: value <= 9.0 or TrialVerdict.NO_SCENARIO, 4.0, upwards=True)
    stands, none = sides(found)
    assert stands <= 9.0 < none <= stands * (1.0 + 1.1e-7)
    assert asking(none).answer is TrialVerdict.NO_SCENARIO


def test_a_limit_may_lie_just_before_invalid_values() -> None:
    found, asking = asked(
        lambda v: v <= 8.8 or (TrialVerdict.FALLS if v <= 9.0 else TrialVerdict.NO_SCENARIO), 4.0, upwards=True
    )
    stands, falls = sides(found)
    assert asking(falls).answer is TrialVerdict.FALLS
    assert stands == pytest.approx(8.8, rel=1e-7)


def test_a_search_tries_one_scene_that_is_too_large() -> None:
    found, asking = asked(lambda value: value <= 900 or TrialVerdict.TOO_LARGE, 20.0, upwards=True, whole=1.0)
    assert found.beyond is not None
    assert found.beyond.answer is TrialVerdict.TOO_LARGE
    assert sum(value > 900 for value in asking.tried) == 1


def test_a_number_that_is_zero_is_left_in_steps_of_its_usual_size() -> None:
    stands, falls = sides(asked(lambda value: value <= 2.5, 0.0, upwards=True)[0])
    assert stands == pytest.approx(2.5, rel=1e-7)
    assert falls < inf
