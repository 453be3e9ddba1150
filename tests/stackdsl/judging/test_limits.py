"""Limits of a number, against the exact limit."""

import pytest

from stackdsl.judging.remedies import NumberLimit, limits

STEPS = (0.1, 1.0, 5.0, 20.0)


def test_the_limit_is_found_below() -> None:
    (found,) = limits(12.0, STEPS, False, lambda value: value <= 11.76)
    assert found.value == 11.76  # in four digits, and it holds
    assert 11.76 < found.beyond <= 11.76 * (1.0 + 1e-6)
    assert not found.least


def test_the_limit_is_found_above() -> None:
    (found,) = limits(0.3, STEPS, False, lambda value: value >= 0.36397023)
    assert (found.value, found.least) == (0.364, True)
    assert found.beyond == pytest.approx(0.36397023, rel=2e-6)


def test_a_limit_on_which_it_does_not_hold_is_told_on_the_side_that_does() -> None:
    (found,) = limits(12.0, STEPS, False, lambda value: value < 11.76)
    assert found.value == 11.75


def test_an_undecided_value_at_the_limit_hides_no_limit() -> None:
    #   Halving 12 - 5 and 12 - 1 asks for 9 first.
    (found,) = limits(12.0, STEPS, False, lambda value: None if value == 9.0 else value < 9.0)
    assert found.value == 8.999  # in four digits, the first that holds
    assert 9.0 < found.beyond < 9.00002


def test_there_are_limits_on_both_sides() -> None:
    found = limits(10.0, STEPS, False, lambda value: not 4.0 < value < 12.5)
    assert [(each.value, each.least) for each in found] == [(4.0, False), (12.5, True)]


def test_of_a_whole_number_whole_ones_are_tried() -> None:
    tried = []

    def holds(value: float) -> bool:
        tried.append(value)
        return value <= 9.0

    assert limits(12.0, (1.0, 2.0, 4.0, 8.0), True, holds) == (NumberLimit(9.0, 10.0, least=False),)
    assert all(value == int(value) for value in tried)


def test_a_claim_that_holds_nowhere_has_no_limit() -> None:
    assert limits(10.0, STEPS, False, lambda value: False) == ()
    assert limits(10.0, STEPS, False, lambda value: None) == ()


def test_a_limit_names_only_tried_values() -> None:
    asked = set()

    def holds(value: float) -> bool:
        asked.add(value)
        return value <= 7.654321

    (found,) = limits(10.0, STEPS, False, holds)
    assert {found.value, found.beyond} <= asked
