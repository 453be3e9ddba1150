"""Random boxes on random edges of fixed planes, against an enumeration of all modes of contact in the plane."""

from math import radians, tan
from random import Random

import pytest

from stability import outcome
from stability.statics.assembly import Assembly
from tests.stability.analysis.leaning_scenes import aslant_between_walls, pile_on_a_slope, wedged_between_steep_planes
from tests.stability.analysis.planar_modes import STICKS, starts
from tests.stability.analysis.random_leaning import on_each_other, on_planes, that_need_friction


def told(made: Assembly) -> str:
    """Whether it can only rest, could let go, or neither is known, or whether modes in the plane contradict it."""
    problem = made.problem()
    found = outcome(problem, made.forces())
    if found.guaranteed:
        return "contradicted" if any(starts(problem)) else "rests"
    return "lets go" if found.start is not None else "undecided"


def test_all_modes_of_a_slope_are_at_rest_below_the_friction_angle_alone() -> None:
    assert not list(starts(pile_on_a_slope(1, 20.0, 1.01 * tan(radians(20.0))).problem()))


def test_free_fall_between_walls_is_among_all_modes() -> None:
    modes = list(starts(aslant_between_walls(20.0, 0.6, 0.1).problem()))
    assert modes
    assert not any(STICKS in each for each in modes)


def test_a_wedged_box_that_no_motion_in_the_plane_frees_can_tip_over_one_corner() -> None:
    # It turns about a diagonal, and one end of the edge on the left plane slides 46 times as fast as the other.
    made = wedged_between_steep_planes()
    assert not any(starts(made.problem()))
    assert outcome(made.problem(), made.forces()).lets_go == "box tips over right and slides on left"


def test_random_boxes_on_random_planes_are_decided_and_no_mode_contradicts_it() -> None:
    assert {told(made) for made in that_need_friction(Random(11), on_planes, 7)} == {"rests", "lets go"}


@pytest.mark.slow
def test_many_random_boxes_on_random_planes_are_decided_and_no_mode_contradicts_it() -> None:
    assert {told(made) for made in that_need_friction(Random(8), on_planes, 150)} == {"rests", "lets go"}


@pytest.mark.slow
def test_no_mode_contradicts_what_is_guaranteed_of_two_random_boxes() -> None:
    assert "contradicted" not in {told(made) for made in that_need_friction(Random(9), on_each_other, 20, 5)}
