"""Release of bricks by a hit: in a wall only the struck brick, elsewhere its whole region."""

import pytest

from stability.model import BodyId, Pose
from stability.stabilizers.exact.woken_region import FEW, ReleasedBricks, region, wake
from stability.statics.assembly import Assembly
from tests.planks import GRAVITY, LENGTH, MASS, column, four_stack, lying, standing

PITCH = LENGTH + 0.2e-3


def pyramid(base: int, levels: int) -> dict[BodyId, Pose]:
    """Every plank on two of the level below, each level by one shorter."""
    return {
        f"L{level}.{place}": lying(level, PITCH * (place + 0.5 * level))
        for level in range(1, levels + 1)
        for place in range(base + 1 - level)
    }


def woken(assembly: Assembly, brick: BodyId, presses: bool = True) -> ReleasedBricks:
    return wake(assembly, region(assembly, {brick: (0.0, -1.0, 0.0)}, ride=True), presses)


def test_in_a_wall_the_brick_that_is_struck_is_woken_alone() -> None:
    assembly = standing(pyramid(14, 10))
    found = woken(assembly, "L3.5")
    assert list(found.placed) == ["L3.5"]
    assert found.riding == ()
    assert "L3.5" not in assembly.bricks
    assert len(assembly.bricks) == len(pyramid(14, 10)) - 1


def test_its_load_is_that_of_the_proof_before_it_was_woken() -> None:
    #   Of a plank on two, each takes half: inside, a plank of level 4 - n carries n weights and passes n + 1 on.
    assembly = standing(pyramid(14, 4))
    found = woken(assembly, "L1.5")
    assert found.forces is not None
    loads = [sum(force[2] for at in forces for force in at) for _, forces in found.forces.onto("L1.5")]
    assert loads == pytest.approx([1.5 * MASS * GRAVITY] * 2)


def test_without_an_engine_that_can_be_pressed_on_all_that_lies_above_is_woken() -> None:
    found = woken(standing(pyramid(14, 10)), "L3.5", presses=False)
    assert "L10.0" in found.placed
    assert found.forces is None


def test_where_something_falls_without_it_a_small_region_is_woken_whole() -> None:
    #   The uppermost plank lies on two, and falls without one of them; with it go those that these touch.
    assembly = standing(pyramid(5, 5))
    found = woken(assembly, "L4.0")
    assert {"L4.0", "L5.0"} < set(found.placed)
    assert len(found.placed) <= FEW
    assert found.forces is None


def test_in_a_tower_the_bricks_above_ride() -> None:
    assembly = standing(four_stack(range(1, 14)))
    found = woken(assembly, "L3.2")
    assert [len(group) for group in found.riding] == [18]
    assert found.forces is None


def test_a_column_is_no_wall() -> None:
    found = woken(standing(column(60)), "L1")
    assert [len(group) for group in found.riding] == [58]
    assert set(found.touched) == set(found.riding[0])
