"""Named structures: their shape, and the statics that the shape is for."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations, pairwise
from math import cos, hypot, inf, pi, sin, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.model import Brick, Plane, Vec3
from stability.separation import block, boxes_apart
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability
from stackdsl.compiling.written import pose_of
from stackdsl.language.card_house import CardHouseParams, card_house
from stackdsl.language.catalogue import CATALOGUE
from stackdsl.language.layouts import (
    LAYOUTS,
    MAX_BRICKS,
    BrickSpec,
    ColumnParams,
    FourStackParams,
    HarmonicParams,
    LayoutParams,
    TowerParams,
    WallParams,
    column,
    four_stack,
    harmonic,
    place,
    tower,
    wall,
)
from stackdsl.language.leaning_structure import LeaningStructureParams, leaning_structure
from stackdsl.language.mistakes import MistakeError

KAPLA = CATALOGUE["kapla"].size
LENGTH, WIDTH, THICKNESS = KAPLA


def extent(spec: BrickSpec, axis: int) -> tuple[float, float]:
    """From where to where a brick that is turned by 0 or 90 deg reaches along x (0) or y (1) [m]."""
    length, width, _ = spec.size or KAPLA
    along = (length, width)[axis] if spec.yaw == 0 else (width, length)[axis]
    return spec.position[axis] - along / 2, spec.position[axis] + along / 2


def by_level(specs: Sequence[BrickSpec]) -> list[list[BrickSpec]]:
    levels = defaultdict(list)
    for spec in specs:
        levels[spec.level].append(spec)
    return [levels[level] for level in sorted(levels)]


def reach(specs: Sequence[BrickSpec], axis: int) -> tuple[float, float]:
    return min(extent(spec, axis)[0] for spec in specs), max(extent(spec, axis)[1] for spec in specs)


def lowest(spec: BrickSpec) -> float:
    """The height of the lowest point of a brick [m]."""
    made = block(spec.size or KAPLA, pose_of(spec))
    return made.p_WC[2] - made.reach[2]


EXAMPLES: dict[str, tuple[dict[str, object], int]] = {  # parameters, and how many bricks they make
    "four_stack": ({"levels": 5, "step": "11 mm"}, 10),
    "column": ({"levels": 5, "step": "11 mm"}, 5),
    "wall": ({"levels": 3, "bricks": 4}, 13),
    "harmonic": ({"bricks": 5}, 5),
    "tower": ({"levels": 4, "bricks": 7}, 28),
    "leaning_structure": ({"levels": 5}, 10),
    "card_house": ({"levels": 3}, 15),
}


def example_of(name: str, **more: object) -> tuple[BrickSpec, ...]:
    params = LAYOUTS[name].params.model_validate({**EXAMPLES[name][0], **more})
    return place(name, params, KAPLA)


def test_every_layout_has_an_example() -> None:
    assert set(LAYOUTS) == set(EXAMPLES)


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_layout_has_the_bricks_it_says(name: str) -> None:
    parameters, count = EXAMPLES[name]
    specs = example_of(name)
    assert len(specs) == count <= LAYOUTS[name].params.model_validate(parameters).bricks_at_most


@pytest.mark.parametrize("name", EXAMPLES)
def test_levels_are_built_upwards_and_the_first_rests_on_the_ground(name: str) -> None:
    specs = example_of(name)
    assert [spec.level for spec in specs] == sorted(spec.level for spec in specs)
    assert {spec.level for spec in specs} == set(range(1, specs[-1].level + 1))
    assert min(lowest(spec) for spec in specs if spec.level == 1) == pytest.approx(0.0, abs=1e-12)
    if not any(spec.lean for spec in specs):
        heights = [spec.position[2] for spec in specs]
        assert heights == pytest.approx([(spec.level - 0.5) * THICKNESS for spec in specs], rel=1e-12)


@pytest.mark.parametrize("name", EXAMPLES)
@given(heading=st.floats(-360, 360), x=st.floats(-1, 1), y=st.floats(-1, 1), z=st.floats(-1, 1))
def test_origin_and_heading_move_a_layout_as_a_whole(name: str, heading: float, x: float, y: float, z: float) -> None:
    here, there = example_of(name), example_of(name, heading=f"{heading} deg", origin=[f"{x} m", f"{y} m", f"{z} m"])
    for a, b in zip(here, there, strict=True):
        assert hypot(b.position[0] - x, b.position[1] - y) == pytest.approx(hypot(*a.position[:2]), abs=1e-12)
        assert b.position[2] - a.position[2] == pytest.approx(z, abs=1e-12)
        assert b.yaw - a.yaw == pytest.approx(heading * pi / 180, abs=1e-12)
        assert (b.level, b.lean, b.size, b.together) == (a.level, a.lean, a.size, a.together)


def test_a_heading_turns_x_towards_y() -> None:
    top = example_of("column", heading="90 deg", origin=["1 m", "2 m", "3 m"])[-1]
    assert top.position == pytest.approx((1.0, 2.0 + 4 * 0.011, 3.0 + 4.5 * THICKNESS), abs=1e-12)


def test_a_column_steps_along_its_length() -> None:
    specs = column(ColumnParams.model_validate({"levels": 9, "step": "13.5 mm"}), KAPLA)
    for lower, upper in pairwise(specs):
        assert upper.position[0] - lower.position[0] == pytest.approx(0.0135, abs=1e-15)
        assert upper.position[1] == lower.position[1] == 0.0
        assert upper.yaw == lower.yaw == 0.0


def test_a_four_stack_fills_a_square_with_flush_ends() -> None:
    # |==============|     each level reaches from -L/2 to L/2 both ways
    # ||            ||
    for level in by_level(four_stack(FourStackParams.model_validate({"levels": 4}), KAPLA)):
        for axis in (0, 1):
            assert reach(level, axis) == pytest.approx((-LENGTH / 2, LENGTH / 2), abs=1e-15)


def test_a_four_stack_turns_each_level_and_begins_on_the_negative_side() -> None:
    specs = four_stack(FourStackParams.model_validate({"levels": 2, "spacing": "40 mm", "step": "5 mm"}), KAPLA)
    assert [spec.position[:2] for spec in specs] == [(0.0, -0.02), (0.0, 0.02), (-0.015, 0.0), (0.025, 0.0)]
    assert [spec.yaw for spec in specs] == [0.0, 0.0, pi / 2, pi / 2]


@given(st.integers(2, 60), st.floats(-30, 30))
def test_every_level_of_a_slant_tower_is_shifted_by_the_step(levels: int, step: float) -> None:
    specs = four_stack(FourStackParams.model_validate({"levels": levels, "step": f"{step} mm"}), KAPLA)
    middles = [sum(spec.position[0] for spec in level) / 2 for level in by_level(specs)]
    assert middles == pytest.approx([index * step / 1000 for index in range(levels)], abs=1e-12)


@pytest.mark.parametrize("bricks", [1, 2, 5])
def test_all_levels_of_a_wall_are_equally_long_and_closed(bricks: int) -> None:
    levels = by_level(wall(WallParams.model_validate({"levels": 4, "bricks": bricks, "gap": "1 mm"}), KAPLA))
    half = (bricks * LENGTH + (bricks - 1) * 0.001) / 2
    for level in levels:
        assert reach(level, axis=0) == pytest.approx((-half, half), abs=1e-12)


@given(st.integers(1, 30), st.floats(0.01, 100))
def test_neighbours_in_a_wall_are_a_gap_apart(bricks: int, gap: float) -> None:
    for level in by_level(wall(WallParams.model_validate({"levels": 2, "bricks": bricks, "gap": f"{gap} mm"}), KAPLA)):
        for left, right in pairwise(level):
            assert extent(right, 0)[0] - extent(left, 0)[1] == pytest.approx(gap / 1000, abs=1e-12)


def test_every_plank_of_a_wall_lies_on_two_or_wholly_on_one() -> None:
    # |_|___|___|_|     the half planks at the ends lie on one, all others straddle a joint in their middle
    # |___|___|___|
    for below, level in pairwise(by_level(wall(WallParams.model_validate({"levels": 5, "bricks": 4}), KAPLA))):
        for spec in level:
            start, end = extent(spec, 0)
            lengths = [max(0.0, min(end, extent(low, 0)[1]) - max(start, extent(low, 0)[0])) for low in below]
            carried = [length for length in lengths if length > 1e-9]
            assert len(carried) in (1, 2)
            assert carried == pytest.approx(carried[::-1], abs=1e-12)  # evenly
            assert sum(carried) == pytest.approx(end - start, abs=0.0002 + 1e-12)


def test_a_gap_longer_than_a_plank_is_refused() -> None:
    with pytest.raises(MistakeError, match=r"longer than a plank of 117\.6 mm"):
        wall(WallParams.model_validate({"levels": 2, "bricks": 2, "gap": "118 mm"}), KAPLA)


def test_a_harmonic_stack_of_ten_planks_leans_out_by_1464484_lengths() -> None:
    # Ten planks over the edge of an eleventh: L/2 * H_10.
    specs = harmonic(HarmonicParams(bricks=11), KAPLA)
    assert specs[0].position[0] == 0.0
    assert specs[-1].position[0] / LENGTH == pytest.approx(1.464484, abs=5e-7)


@pytest.mark.parametrize("written", [0.95, "95 %", "0.95"])
def test_the_share_of_a_harmonic_stack_is_a_number_or_a_percentage(written: object) -> None:
    assert HarmonicParams.model_validate({"bricks": 3, "share": written}).share == 0.95


def test_a_harmonic_stack_leans_out_by_a_half_then_a_quarter_then_a_sixth() -> None:
    specs = harmonic(HarmonicParams(bricks=4), (1.0, 0.2, 0.1))
    overhangs = [upper.position[0] - lower.position[0] for lower, upper in pairwise(specs)]
    assert overhangs[::-1] == pytest.approx([1 / 2, 1 / 4, 1 / 6], rel=1e-12)


@given(st.integers(2, 50), st.floats(0, 2))
def test_the_planks_above_a_joint_balance_at_the_share_of_the_limit(bricks: int, share: float) -> None:
    xs = [spec.position[0] for spec in harmonic(HarmonicParams(bricks=bricks, share=share), KAPLA)]
    # By moments: with share 1, the mean of all above is half a length from the middle of the plank below.
    for joint in range(1, bricks):
        above = xs[joint:]
        assert sum(above) / len(above) - xs[joint - 1] == pytest.approx(share * LENGTH / 2, abs=1e-9)


# --- the round tower --------------------------------------------------------------------------------------------------

RINGS = [(3, 0.2), (5, 0.5), (7, 0.4), (16, 0.4), (40, 0.05), (400, 0.45)]  # planks a ring, and their overlap


def rings(bricks: int, overlap: float, levels: int = 3) -> list[list[BrickSpec]]:
    return by_level(tower(TowerParams(levels=levels, bricks=bricks, overlap=overlap), KAPLA))


def seen_from(spec: BrickSpec, x: float, y: float) -> tuple[float, float]:
    """A point in plan, along the length and the width of a plank from its middle [m]."""
    dx, dy = x - spec.position[0], y - spec.position[1]
    return dx * cos(spec.yaw) + dy * sin(spec.yaw), -dx * sin(spec.yaw) + dy * cos(spec.yaw)


def gap(one: BrickSpec, other: BrickSpec) -> float:
    return boxes_apart(KAPLA, pose_of(one), KAPLA, pose_of(other)).gap


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_a_plank_of_a_tower_lies_with_its_overlap_on_each_of_two_below(bricks: int, overlap: float) -> None:
    # ===|===|===     the middle line of a plank leaves the end face of one below at its overlap from its own end
    #  |===|===|
    for below, ring in pairwise(rings(bricks, overlap)):
        for spec in ring:
            for side in (-1.0, 1.0):
                along = side * (0.5 - overlap) * LENGTH
                x, y = spec.position[0] + along * cos(spec.yaw), spec.position[1] + along * sin(spec.yaw)
                ends = [abs(abs(seen_from(low, x, y)[0]) - LENGTH / 2) for low in below]
                assert min(ends) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_two_equal_forces_inside_both_contacts_hold_each_plank_of_a_tower(bricks: int, overlap: float) -> None:
    #        o          Middle lines of a plank and of two below cross at x, within all three, at equal distances. Half
    #  --x-------x--    of the load at each x balances the plank, and presses on those below at such points of theirs.
    for below, ring in pairwise(rings(bricks, overlap, levels=4)):
        for spec in ring:
            carrying = [low for low in below if abs(crossing(spec, low)) < LENGTH / 2]
            one, other = (crossing(spec, low) for low in carrying)
            assert one == pytest.approx(-other, abs=1e-12)
            for low in carrying:
                assert abs(crossing(low, spec)) == pytest.approx(abs(one), abs=1e-12)
                assert gap(spec, low) == pytest.approx(0.0, abs=1e-12)


def crossing(spec: BrickSpec, low: BrickSpec) -> float:
    """Where the middle line of another plank crosses that of the first, along it from its middle [m]."""
    away, turn = seen_from(low, *spec.position[:2])[1], sin(spec.yaw - low.yaw)
    return -away / turn if abs(turn) > 1e-12 else inf


@pytest.mark.parametrize(("bricks", "overlap"), RINGS)
def test_planks_of_a_ring_are_free_of_each_other(bricks: int, overlap: float) -> None:
    ring = rings(bricks, overlap)[0]
    assert min(gap(one, other) for one, other in pairwise([*ring, ring[0]])) > 0.0


@pytest.mark.parametrize("bricks", [3, 5, 16, 400])
def test_a_ring_closes_at_its_largest_overlap(bricks: int) -> None:
    half_pitch = pi / bricks
    most = (1 / cos(half_pitch) - WIDTH / LENGTH * tan(half_pitch)) / 2
    ring = rings(bricks, most * (1 - 1e-9))[0]
    assert gap(ring[0], ring[1]) == pytest.approx(0.0, abs=1e-9)
    for overlap in (most * (1 + 1e-9), 0.0):
        with pytest.raises(MistakeError, match=rf"{bricks} planks a ring") as mistake:
            rings(bricks, overlap)
        assert mistake.value.hint == f"write an overlap of more than 0 % and less than {100 * most:.3g} %"


# --- the card house ---------------------------------------------------------------------------------------------------


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
def test_what_touches_in_a_card_house_is_vs_peaks_and_feet_and_nothing_else(angle: float) -> None:
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
        ({"spacing": "117 mm"}, "run into each other", "at least 117.6 mm, and less than 132.3 mm"),
        ({"spacing": "133 mm"}, "too far apart for flat planks", "less than 132.3 mm"),
        ({"angle": "62 deg", "spacing": "124 mm"}, "run into each other", "at least 124.2 mm"),
        ({"angle": "60 deg"}, "feet are too far apart for flat planks", "more than 60 deg"),
        ({"angle": "0 deg"}, "do not lean", "70 deg"),
        ({"angle": "86.3 deg"}, "do not lean", "70 deg"),  # past the slope of its diagonal, a plank falls outwards
    ],
)
def test_a_card_house_that_cannot_be_is_refused(written: dict[str, object], message: str, hint: str) -> None:
    with pytest.raises(MistakeError, match=message) as mistake:
        house(2, **written)
    assert hint in mistake.value.hint


def test_a_single_v_may_stand_wide() -> None:
    assert len(house(1, angle="45 deg", spacing="10 mm")[0]) == 2


def standing(friction: float, specs: Sequence[BrickSpec]) -> Assembly:
    """An empty assembly with this friction throughout, and the bricks of a layout set down in it moment by moment."""
    assembly = Assembly([Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)], friction)
    moments: list[list[Placed]] = []
    for number, spec in enumerate(specs):
        placed = Placed(Brick(f"{number:03}", KAPLA, 0.0119), pose_of(spec))
        moments = [*moments[:-1], [*moments[-1], placed]] if spec.together else [*moments, [placed]]
    for moment in moments:
        if assembly.add_all(moment).stability is not Stability.STABLE:
            break
    return assembly


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


# --- the leaning structure --------------------------------------------------------------------------------------------


def leaning(**written: object) -> tuple[BrickSpec, ...]:
    return leaning_structure(LeaningStructureParams.model_validate({"levels": 14, **written}), KAPLA)


def test_the_leaning_structure_is_a_four_stack_that_steps_by_11_per_cent_of_its_length() -> None:
    stack = FourStackParams.model_validate({"levels": 14, "step": f"{110 * LENGTH} mm", "spacing": "78.4 mm"})
    for one, other in zip(leaning(), four_stack(stack, KAPLA), strict=True):
        assert one.position == pytest.approx(other.position, abs=1e-12)
        assert (one.level, one.yaw) == (other.level, other.yaw)


@pytest.mark.parametrize(("step", "spacing"), [(0.11 * LENGTH, LENGTH * 2 / 3), (0.0121, 0.0784), (0.0105, 0.080)])
def test_the_leaning_structure_falls_at_the_level_that_moments_give(step: float, spacing: float) -> None:
    #  The leading plank of level 2 and all above turn about the end of level 1, once their centre is beyond it.
    xs = [(level - 1) * step for level in range(3, 15) for _ in range(2)]  # plank by plank, from level 3
    beyond = [(step + spacing / 2 + sum(xs[:count])) / (count + 1) > LENGTH / 2 for count in range(1, len(xs) + 1)]
    falls_with = 4 + beyond.index(True) + 1  # so many planks
    assembly = standing(0.5, leaning(step=f"{step} m", spacing=f"{spacing} m"))
    assert assembly.verdict().stability is Stability.UNSTABLE
    assert len(assembly.bricks) == falls_with


def test_by_default_the_leaning_structure_falls_with_the_first_plank_of_level_9() -> None:
    assert len(standing(0.5, leaning()).bricks) == 2 * 8 + 1


@pytest.mark.parametrize(
    ("params", "size"),
    [
        (FourStackParams, {"levels": 10_000}),
        (WallParams, {"levels": 10, "bricks": MAX_BRICKS // 10 - 1}),
        (TowerParams, {"levels": 1250, "bricks": 16}),
    ],
)
def test_a_layout_may_be_large(params: type[LayoutParams], size: dict[str, int]) -> None:
    assert params.model_validate(size).bricks_at_most == MAX_BRICKS


@pytest.mark.parametrize(
    ("params", "size"),
    [
        (WallParams, {"levels": 10, "bricks": MAX_BRICKS // 10}),
        (WallParams, {"levels": 10_000, "bricks": 10_000}),
        (FourStackParams, {"levels": 10_001}),
        (HarmonicParams, {"bricks": 10_001}),
        (TowerParams, {"levels": 10_000, "bricks": 3}),
        (TowerParams, {"levels": 1, "bricks": 2}),
        (CardHouseParams, {"levels": 116}),
        (ColumnParams, {"levels": 0}),
        (ColumnParams, {"levels": True}),
    ],
)
def test_a_typo_does_not_eat_the_machine(params: type[LayoutParams], size: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"bricks|less than or equal|greater than|valid integer"):
        params.model_validate(size)


@pytest.mark.parametrize("size", [brick.size for brick in CATALOGUE.values()], ids=CATALOGUE)
def test_catalogue_bricks_are_given_as_length_width_thickness(size: Vec3) -> None:
    assert sorted(size, reverse=True) == list(size)


def test_the_ideal_plank_has_sides_of_1_3_15_and_the_real_one_11_9_grams() -> None:
    length, width, thickness = CATALOGUE["kapla-ideal"].size
    assert (length / thickness, width / thickness) == pytest.approx((15, 3))
    assert CATALOGUE["kapla"].density * LENGTH * WIDTH * THICKNESS == pytest.approx(0.0119, abs=0.0001)
