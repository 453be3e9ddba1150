"""Columns, four-stacks, walls and harmonic stacks: their shape, and the statics that the shape is for."""

from collections.abc import Sequence
from itertools import pairwise
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stackdsl.language.layouts.column import ColumnParams, column
from stackdsl.language.layouts.four_stack import FourStackParams, four_stack
from stackdsl.language.layouts.harmonic import HarmonicParams, harmonic
from stackdsl.language.layouts.registry import BrickSpec
from stackdsl.language.layouts.wall import WallParams, wall
from stackdsl.language.quantities import InputError
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, LENGTH, by_level


def extent(spec: BrickSpec, axis: int) -> tuple[float, float]:
    """From where to where a brick that is turned by 0 or 90 deg reaches along x (0) or y (1) [m]."""
    length, width, _ = spec.size or KAPLA
    along = (length, width)[axis] if spec.yaw == 0 else (width, length)[axis]
    return spec.position[axis] - along / 2, spec.position[axis] + along / 2


def reach(specs: Sequence[BrickSpec], axis: int) -> tuple[float, float]:
    return min(extent(spec, axis)[0] for spec in specs), max(extent(spec, axis)[1] for spec in specs)


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
    with pytest.raises(InputError, match=r"shorter than a plank of 117\.6 mm"):
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
