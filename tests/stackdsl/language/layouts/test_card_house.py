"""The card house: contacts, invalid parameters, and the least friction with which it stands."""

from collections.abc import Sequence
from itertools import combinations
from math import cos, pi, sin, tan

import pytest

from stability.problem import Stability
from stackdsl.language.layouts.card_house import CardHouseParams, card_house
from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.quantities import InputError
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, LENGTH, THICKNESS, by_level, gap, standing


def house(levels: int, **more: object) -> list[list[BrickSpec]]:
    return by_level(card_house(CardHouseParams.model_validate({"levels": levels, **more}), KAPLA))


def in_touch(specs: Sequence[BrickSpec]) -> set[tuple[int, int]]:
    """The pairs, by number, that are no farther apart than rounding."""
    pairs = combinations(enumerate(specs), 2)
    return {(i, j) for (i, one), (j, other) in pairs if abs(gap(one, other)) < 1e-12}


def test_the_planks_of_a_v_meet_along_the_upper_edges_of_their_inner_faces() -> None:
    #    /\      the inner edge of each top is over the middle, at L sin a; the foot is L cos a beside it, on the ground
    #   /  \
    (left, right), a = house(1, angle="70 deg")[0], pi * 70 / 180
    for spec, side in ((left, -1), (right, 1)):
        along, inwards = (-side * cos(a), sin(a)), (-side * sin(a), -cos(a))  # in x and z
        top, foot = (
            [
                spec.position[axis] + end * LENGTH / 2 * along[i] + THICKNESS / 2 * inwards[i]
                for i, axis in ((0, 0), (1, 2))
            ]
            for end in (1, -1)
        )
        assert top == pytest.approx([0.0, LENGTH * sin(a)], abs=1e-12)
        assert foot == pytest.approx([side * LENGTH * cos(a), 0.0], abs=1e-12)
    assert gap(left, right) == pytest.approx(0.0, abs=1e-12)
    assert (left.together, right.together) == (False, True)


@pytest.mark.parametrize("levels", [1, 2, 3, 4])
def test_a_card_house_of_n_has_n_vs_then_one_flat_plank_and_one_v_less_each_time(levels: int) -> None:
    counts = [len(level) for level in house(levels)]
    vs, flats = [2 * n for n in range(levels, 0, -1)], list(range(levels - 1, 0, -1))
    assert (counts[::2], counts[1::2]) == (vs, flats)
    assert all((spec.lean != 0.0) is (spec.level % 2 == 1) for level in house(levels) for spec in level)


@pytest.mark.parametrize("angle", [61, 65, 70, 75, 86])
def test_contacts_of_a_card_house_are_peaks_and_feet_alone(angle: float) -> None:
    #       /\
    #    ___________
    #    /\       /\      bricks 0 1 and 2 3, flat 4, and 5 6 on it
    specs = [spec for level in house(2, angle=f"{angle} deg") for spec in level]
    assert in_touch(specs) == {(0, 1), (2, 3), (5, 6), (1, 4), (2, 4), (4, 5), (4, 6)}
    assert min(gap(one, other) for one, other in combinations(specs, 2)) > -1e-12
    assert [spec.position[0] for spec in specs] == pytest.approx(
        [-spec.position[0] for spec in mirrored(specs)], abs=1e-12
    )


def mirrored(specs: list[BrickSpec]) -> list[BrickSpec]:
    return [spec for level in by_level(specs) for spec in reversed(level)]


@pytest.mark.parametrize("spacing", ["118 mm", "125 mm", "132 mm"])
def test_flat_planks_lie_on_the_near_edges_of_two_peaks_and_are_free_of_each_other(spacing: str) -> None:
    #  ________  ________      the edge of a peak is t sin a = 7.33 mm from the middle of its V, so up to 132.3 mm
    #  /\      /\      /\
    specs = [spec for level in house(3, spacing=spacing)[:2] for spec in level]
    assert in_touch(specs) == {(0, 1), (2, 3), (4, 5), (1, 6), (2, 6), (3, 7), (4, 7)}


def test_by_default_vs_are_a_quarter_of_the_way_from_the_least_spacing_to_the_largest() -> None:
    for angle in (65, 70, 80):
        c, s = cos(pi * angle / 180), sin(pi * angle / 180)
        least, most = max(LENGTH, 2 * LENGTH * c + 2 * THICKNESS * s), LENGTH + 2 * THICKNESS * s
        xs = [spec.position[0] for spec in house(3, angle=f"{angle} deg")[1]]
        assert xs == pytest.approx([-(3 * least + most) / 8, (3 * least + most) / 8], abs=1e-12)


@pytest.mark.parametrize(
    ("written", "message", "hint"),
    [
        ({"spacing": "117 mm"}, "overlap each other", "at least 117.6 mm, and less than 132.3 mm"),
        ({"spacing": "133 mm"}, "too far apart for flat planks", "less than 132.3 mm"),
        ({"angle": "62 deg", "spacing": "124 mm"}, "overlap each other", "at least 124.2 mm"),
        ({"angle": "60 deg"}, "too wide for flat planks", "greater than 60 deg"),
        ({"angle": "0 deg"}, "do not lean", "70 deg"),
        ({"angle": "86.3 deg"}, "do not lean", "70 deg"),  # past the slope of its diagonal, a plank falls outwards
    ],
)
def test_a_card_house_that_cannot_be_is_refused(written: dict[str, object], message: str, hint: str) -> None:
    with pytest.raises(InputError, match=message) as mistake:
        house(2, **written)
    assert hint in mistake.value.hint


def test_a_single_v_may_stand_wide() -> None:
    assert len(house(1, angle="45 deg", spacing="10 mm")[0]) == 2


@pytest.mark.parametrize("angle", [45, 65, 70, 75])
def test_a_v_stands_from_half_the_cotangent_less_its_slenderness(angle: float) -> None:
    #  By moments about a foot, the planks press on each other with W (cot a - t / L) / 2, which the feet must hold.
    limit = (1 / tan(pi * angle / 180) - THICKNESS / LENGTH) / 2
    (specs,) = house(1, angle=f"{angle} deg")
    assert standing(limit * (1 + 1e-6), specs).verdict().stability is Stability.STABLE
    assert standing(limit * (1 - 1e-6), specs).verdict().stability is Stability.UNSTABLE


@pytest.mark.parametrize("levels", [1, 2, 3, 4])
@pytest.mark.parametrize("angle", [65, 70, 75])
def test_a_card_house_stands_at_a_friction_of_a_half_while_it_is_built(levels: int, angle: float) -> None:
    specs = [spec for level in house(levels, angle=f"{angle} deg") for spec in level]
    assembly = standing(0.5, specs)
    assert (assembly.verdict().stability, len(assembly.bricks)) == (Stability.STABLE, len(specs))
