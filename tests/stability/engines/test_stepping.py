"""Sub-steps follow from the awake bricks; a quiet scene of equal bricks has none."""

from dataclasses import replace
from math import ceil, inf

import pytest

from stability.engines.pybullet.settings import PyBulletSettings
from stability.engines.pybullet.stepping import AwakeBodies, Stepping, stepping
from stackdsl.simulation.systems import HELD, MOVING, STOCK, TUNED

QUIET = AwakeBodies(fastest=0.1, mass_ratio=1.0)


@pytest.mark.parametrize("settings", [STOCK, HELD, TUNED, MOVING])
def test_quiet_bricks_of_equal_mass_are_stepped_whole(settings: PyBulletSettings) -> None:
    assert stepping(settings, QUIET) == Stepping(1, settings.iterations, lively=False)


@pytest.mark.parametrize(("ratio", "parts"), [(16.0, 1), (17.0, 2), (64.0, 2), (300.0, 5), (1000.0, 8)])
def test_the_square_of_the_step_falls_as_the_ratio_of_masses_grows(ratio: float, parts: int) -> None:
    assert stepping(TUNED, replace(QUIET, mass_ratio=ratio)).parts == parts


def test_no_ratio_of_masses_splits_a_step_without_end() -> None:
    assert stepping(TUNED, replace(QUIET, mass_ratio=1e12)).parts == TUNED.most_parts


@pytest.mark.parametrize("speed", [1.0, 4.0, 16.0])
def test_no_body_gets_further_in_a_part_than_the_settings_allow(speed: float) -> None:
    assert TUNED.most_travel is not None
    parts = stepping(TUNED, replace(QUIET, fastest=speed)).parts
    assert parts == ceil(speed * TUNED.time_step / TUNED.most_travel)
    assert speed * TUNED.time_step / parts <= TUNED.most_travel


def test_what_moves_fast_is_lively_and_gets_the_iterations_of_an_impact() -> None:
    assert stepping(TUNED, replace(QUIET, fastest=0.31)) == Stepping(1, TUNED.lively_iterations, lively=True)
    assert not stepping(TUNED, replace(QUIET, fastest=0.29)).lively


def test_the_most_demanding_reason_decides() -> None:
    assert stepping(MOVING, replace(QUIET, begins=True)).parts == MOVING.first_parts
    assert stepping(MOVING, replace(QUIET, begins=True, mass_ratio=16.0 * 12**2)).parts == 12


def test_a_hit_that_is_about_to_come_is_stepped_finely_and_solved_well() -> None:
    assert MOVING.first_travel is not None
    hit = stepping(MOVING, replace(QUIET, begins=True, fastest=4.0))
    assert hit.parts == ceil(4.0 * MOVING.time_step / MOVING.first_travel) > MOVING.first_parts
    assert hit.iterations == MOVING.first_iterations > MOVING.lively_iterations
    assert hit.may_hit
    assert stepping(MOVING, replace(QUIET, begins=True)).iterations == MOVING.iterations, "what is slow hits nothing"
    assert stepping(MOVING, replace(QUIET, fastest=4.0)).iterations == MOVING.lively_iterations


def test_settings_that_ask_for_nothing_heed_nothing() -> None:
    assert stepping(STOCK, AwakeBodies(fastest=inf, mass_ratio=inf)) == Stepping(1, STOCK.iterations, lively=False)
