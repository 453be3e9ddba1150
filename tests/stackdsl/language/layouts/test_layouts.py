"""Every named structure: its bricks, levels, origin and heading, and how large it may be."""

from math import hypot, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stability.geometry.box_distance import block
from stackdsl.compiler.bricks import pose_of
from stackdsl.language.layouts.arch import ArchParams
from stackdsl.language.layouts.card_house import CardHouseParams
from stackdsl.language.layouts.column import ColumnParams
from stackdsl.language.layouts.flat_arch import FlatArchParams
from stackdsl.language.layouts.four_stack import FourStackParams
from stackdsl.language.layouts.harmonic import HarmonicParams
from stackdsl.language.layouts.registry import LAYOUTS, BrickSpec, LayoutParams, place
from stackdsl.language.layouts.tower import TowerParams
from stackdsl.language.layouts.wall import WallParams
from stackdsl.language.value_types import MAX_BRICKS
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, THICKNESS


def lowest(spec: BrickSpec) -> float:
    """The height of the lowest point of a brick [m]."""
    if spec.outline is not None:
        return spec.position[2] + min(z for _, z in spec.outline)
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
    "arch": ({"span": "1 m", "thickness": "60 mm", "voussoirs": 9, "rise": "200 mm", "abutment": "300 mm"}, 11),
    "flat_arch": (
        {"span": "1 m", "height": "500 mm", "thickness": "200 mm", "voussoirs": 7, "abutment": "300 mm"},
        9,
    ),
    "jenga": ({"levels": 4}, 12),
    "pyramid": ({"levels": 4}, 10),
    "corbel": ({"levels": 4}, 8),
    "dominoes": ({"bricks": 5, "spacing": "30 mm"}, 5),
    "ring": ({"posts": 10}, 20),
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


@pytest.mark.parametrize("name", ["column", "four_stack", "harmonic"])
def test_small_ones_may_be_many_since_no_more_is_counted_than_is_built(name: str) -> None:
    parameters, count = EXAMPLES[name]
    assert LAYOUTS[name].params.model_validate(parameters).bricks_at_most == count


@pytest.mark.parametrize("name", EXAMPLES)
def test_levels_are_built_upwards_and_the_first_rests_on_the_ground(name: str) -> None:
    specs = example_of(name)
    assert [spec.level for spec in specs] == sorted(spec.level for spec in specs)
    assert {spec.level for spec in specs} == set(range(1, specs[-1].level + 1))
    assert min(lowest(spec) for spec in specs if spec.level == 1) == pytest.approx(0.0, abs=1e-12)
    if not any(spec.lean or spec.outline for spec in specs):
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
        assert (b.level, b.lean, b.size, b.outline, b.together) == (a.level, a.lean, a.size, a.outline, a.together)


def test_a_heading_turns_x_towards_y() -> None:
    top = example_of("column", heading="90 deg", origin=["1 m", "2 m", "3 m"])[-1]
    assert top.position == pytest.approx((1.0, 2.0 + 4 * 0.011, 3.0 + 4.5 * THICKNESS), abs=1e-12)


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
        (ArchParams, {"span": "1 m", "thickness": "0.1 m", "voussoirs": 201}),
        (FlatArchParams, {"span": "1 m", "height": "1 m", "thickness": "0.1 m", "abutment": "1 m", "voussoirs": 201}),
        (ColumnParams, {"levels": 0}),
        (ColumnParams, {"levels": True}),
    ],
)
def test_a_typo_does_not_eat_the_machine(params: type[LayoutParams], size: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"bricks|less than or equal|greater than|valid integer"):
        params.model_validate(size)
