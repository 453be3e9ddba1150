"""Jenga towers, pyramids, corbels, dominoes and rings, each on both sides of the closed form that it is judged by."""

from collections.abc import Collection
from dataclasses import replace
from itertools import combinations, pairwise
from math import asin, atan, pi

import pytest

from stability.problem import Stability
from stackdsl.language.layouts.registry import LAYOUTS, BrickSpec, place
from stackdsl.language.quantities import InputError
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, LENGTH, THICKNESS, WIDTH, by_level, gap, standing


def made(name: str, **keys: object) -> tuple[BrickSpec, ...]:
    return place(name, LAYOUTS[name].params.model_validate(keys), KAPLA)


def stands(specs: Collection[BrickSpec]) -> bool:
    """Set down at one moment, as scenarios do unless they say `every`."""
    stability = (
        standing(0.5, [replace(spec, together=number > 0) for number, spec in enumerate(specs)]).verdict().stability
    )
    assert stability is not Stability.UNDECIDED
    return stability is Stability.STABLE


# --- jenga ------------------------------------------------------------------------------------------------------------

POWER_SET = [left for count in (1, 2, 3) for left in combinations(range(4), count)]


@pytest.mark.parametrize("left", POWER_SET)
def test_a_level_of_a_jenga_tower_carries_the_rest_if_the_axis_is_within_what_is_left(
    left: tuple[int, ...],
) -> None:
    specs = made("jenga", levels=5, bricks=4)
    kept = [spec for number, spec in enumerate(specs) if not 4 <= number < 8 or number - 4 in left]
    sides = [(number - 1.5) * LENGTH / 4 for number in left]
    assert stands(kept) == (min(sides) - WIDTH / 2 < 0.0 < max(sides) + WIDTH / 2)


def test_each_level_of_a_jenga_tower_crosses_the_one_below() -> None:
    turns = [[spec.yaw for spec in level] for level in by_level(made("jenga", levels=3))]
    assert turns == [[0.0] * 3, [pi / 2] * 3, [0.0] * 3]


def test_planks_of_a_level_do_not_run_into_each_other() -> None:
    with pytest.raises(InputError, match="overlap at"):
        made("jenga", levels=2, bricks=6)
    assert gap(*made("jenga", levels=1, bricks=2, spacing="23.5 mm")) == pytest.approx(0.0001)


def test_planks_a_third_as_wide_as_long_stand_side_by_side_without_a_gap() -> None:
    of_the_game = (0.075, 0.025, 0.015)
    specs = place("jenga", LAYOUTS["jenga"].params.model_validate({"levels": 1}), of_the_game)
    assert [spec.position[1] for spec in specs] == pytest.approx([-0.025, 0.0, 0.025])


# --- pyramid ----------------------------------------------------------------------------------------------------------


def test_a_pyramid_gives_half_of_its_top_to_either_plank_below() -> None:
    specs = made("pyramid", levels=4)
    assert list(standing(0.5, specs).shares("009").values()) == pytest.approx([0.5, 0.5])
    assert specs[-1].position[:2] == (0.0, 0.0)


@pytest.mark.parametrize(("levels", "holds"), [(2, False), (3, True)])
def test_a_row_that_lost_a_plank_below_wants_a_counterweight(levels: int, holds: bool) -> None:
    assert stands(made("pyramid", levels=levels, omit=["L1.1"])) is holds


# --- corbel -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("share", "holds"), [(1.0 - 1e-6, True), (1.0 + 1e-6, False)])
@pytest.mark.parametrize("levels", [2, 5, 12])
def test_a_corbel_stands_up_to_the_harmonic_overhangs(levels: int, share: float, holds: bool) -> None:
    assert stands(made("corbel", levels=levels, share=share)) is holds


def test_a_corbel_spans_the_harmonic_sum_of_lengths() -> None:
    lowest = by_level(made("corbel", levels=5, share=0.9, gap="10 mm"))[0]
    width = lowest[1].position[0] - lowest[0].position[0] - LENGTH
    assert width == pytest.approx(0.01 + 0.9 * LENGTH * (1 + 1 / 2 + 1 / 3 + 1 / 4))


# --- dominoes ---------------------------------------------------------------------------------------------------------


def test_dominoes_stand_on_end_as_far_apart_as_written() -> None:
    specs = made("dominoes", bricks=4, spacing="30 mm")
    assert [gap(*pair) for pair in pairwise(specs)] == pytest.approx([0.03 - THICKNESS] * 3)
    assert [spec.position[2] for spec in specs] == pytest.approx([LENGTH / 2] * 4)
    assert stands(specs)
    assert asin((0.03 - THICKNESS) / LENGTH) > atan(THICKNESS / LENGTH)  # as the scenario counts on


def test_dominoes_do_not_stand_in_each_other() -> None:
    with pytest.raises(InputError, match="overlap"):
        made("dominoes", bricks=2, spacing="7.8 mm")


# --- ring -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("posts", [6, 7, 9, 24, 61])
@pytest.mark.parametrize("overlap", ["5 %", "80 %", "99 %"])
def test_a_ring_stands_with_half_of_each_lintel_on_either_post(posts: int, overlap: str) -> None:
    specs = made("ring", posts=posts, overlap=overlap)
    assembly = standing(0.5, specs)
    assert assembly.verdict().stability is Stability.STABLE
    assert assembly.shares(f"{posts:03}") == pytest.approx({"000": 0.5, "001": 0.5})
    lintels = specs[posts:]
    assert min(gap(*pair) for pair in pairwise(lintels)) > 0.0


def test_without_a_post_a_ring_loses_two_lintels() -> None:
    assert not stands(made("ring", posts=9, omit=["L1.3"]))
    assert stands(made("ring", posts=9, omit=["L1.3", "L2.2", "L2.3"]))


@pytest.mark.parametrize("overlap", ["0 %", "100 %"])
def test_lintels_lie_on_posts_and_not_in_each_other(overlap: str) -> None:
    with pytest.raises(InputError, match="every lintel"):
        made("ring", posts=9, overlap=overlap)


def test_few_posts_leave_no_room_for_lintels_of_planks() -> None:
    with pytest.raises(InputError, match="with 5 posts"):
        made("ring", posts=5)
    cubes = LAYOUTS["ring"].params.model_validate({"posts": 5})
    assert len(place("ring", cubes, (0.1, 0.02, 0.02))) == 10


# --- omitted bricks ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("levels", "holds"), [(3, False), (4, True)])
def test_a_wall_over_an_opening_wants_a_level_on_its_edges(levels: int, holds: bool) -> None:
    assert stands(made("wall", levels=levels, bricks=5, gap="2 mm", omit=["L2.3"])) is holds


def test_omitted_bricks_count_in_the_names_of_others() -> None:
    left = made("wall", levels=2, bricks=3, omit=["L1.2", "L2.1", "L2.2"])
    assert [(spec.level, spec.passed) for spec in left] == [(1, 0), (1, 1), (2, 2), (2, 0)]


def test_the_second_of_two_that_come_together_comes_alone_without_the_first() -> None:
    left = made("card_house", levels=2, omit=["L1.1"])
    assert [spec.together for spec in left[:3]] == [False, False, True]


@pytest.mark.parametrize("place_", ["L3.1", "L1.9"])
def test_omitted_brick_must_exist(place_: str) -> None:
    with pytest.raises(InputError, match=f"the layout has no {place_}"):
        made("column", levels=2, omit=[place_])
    with pytest.raises(InputError, match="all bricks"):
        made("column", levels=1, omit=["L1.1"])
