"""Bisection between a number for which a property holds and one for which it fails."""

import pytest

from stackdsl.judging.remedies import Bracket, BracketTolerance, narrow_bracket

WHOLE = BracketTolerance(1e-7, whole=True)


def test_a_bracket_ends_within_the_requested_share() -> None:
    found = narrow_bracket(1.0, 20.0, BracketTolerance(1e-7), lambda value: value < 11.76)
    assert found.holds < 11.76 <= found.fails
    assert found.width <= 1e-7


def test_of_whole_numbers_both_sides_are_next_to_each_other() -> None:
    assert narrow_bracket(3.0, 14.0, WHOLE, lambda value: value <= 9.0) == Bracket(9.0, 10.0)
    assert narrow_bracket(14.0, 3.0, WHOLE, lambda value: value >= 9.0) == Bracket(9.0, 8.0)


def test_a_limit_at_zero_is_found_to_so_much_as_counts_for_nothing() -> None:
    asked: list[float] = []

    def holds(value: float) -> bool:
        asked.append(value)
        return value > 0.0

    found = narrow_bracket(1.0, -2.0, BracketTolerance(1e-7, nothing=1e-6), holds)
    assert found.fails <= 0.0 < found.holds <= 1e-6
    assert len(asked) < 30


def test_a_bracket_closes_in_from_both_sides() -> None:
    found = narrow_bracket(1.0, 8.0, BracketTolerance(1e-9), lambda value: None if 4.0 <= value <= 5.0 else value < 4.0)
    assert found.is_open
    assert found.holds == pytest.approx(4.0, rel=1e-8)
    assert found.fails == pytest.approx(5.0, rel=1e-8)
    assert found.holds < 4.0
    assert found.fails > 5.0
