"""Region of a hit: bricks that move one by one, bricks that ride as a rigid group, and bricks that stay."""

from math import atan, cos, sin

import pytest

from stability.geometry.vectors import scale
from stability.model import GROUND, BodyId, Plane, Pose, Vec3
from stability.stabilizers.exact.woken_region import FEWEST, Region, region
from stability.statics.assembly import Assembly
from tests.planks import LENGTH, WOOD, column, four_stack, lying, standing

FROM_BEHIND: Vec3 = (0.0, -1.0, 0.0)
ALONG_X: Vec3 = (1.0, 0.0, 0.0)


def hit(assembly: Assembly, brick: BodyId, along_W: Vec3 = FROM_BEHIND, ride: bool = True) -> Region:
    return region(assembly, {brick: along_W}, ride)


def names(*levels: int) -> list[BodyId]:
    """Upwards; on a level, by x and y."""
    stack = four_stack(levels)
    return sorted(stack, key=lambda name: (stack[name].position_W[2], stack[name].position_W))


def test_a_hit_at_level_3_moves_levels_2_to_4_one_by_one_and_all_above_as_one() -> None:
    reached = hit(standing(four_stack(range(1, 14))), "L3.2")
    assert list(reached.one_by_one) == names(2, 3, 4)
    assert [list(group) for group in reached.riding] == [names(*range(5, 14))]


def test_a_brick_between_moving_bricks_is_stepped_one_by_one() -> None:
    #   L3.1 is not touched by L3.2, but lies on level 2 and under level 4, which are.
    reached = hit(standing(four_stack(range(1, 14))), "L3.2")
    assert "L3.1" in reached.one_by_one


def test_where_nothing_may_ride_all_moves_one_by_one() -> None:
    reached = hit(standing(four_stack(range(1, 14))), "L3.2", ride=False)
    assert list(reached.one_by_one) == names(*range(2, 14))
    assert reached.riding == ()


def test_a_hit_at_the_top_leaves_all_but_the_two_uppermost_levels() -> None:
    reached = hit(standing(four_stack(range(1, 14))), "L13.2")
    assert reached == Region(tuple(names(12, 13)), (), ("L13.2",), in_wall=False)


@pytest.mark.parametrize(("levels", "riding"), [(FEWEST + 1, 0), (FEWEST + 2, FEWEST)])
def test_a_group_rides_from_three_bricks_on(levels: int, riding: int) -> None:
    #   Of a column hit at the bottom, all but the two lowest would ride.
    reached = hit(standing(column(levels)), "L1")
    assert sum(map(len, reached.riding)) == riding
    assert len(reached.one_by_one) == levels - riding


def test_bricks_apart_are_not_in_the_region() -> None:
    apart = {f"b{name}": pose for name, pose in four_stack(range(1, 7), x=0.2).items()}
    reached = hit(standing({**four_stack(range(1, 7)), **apart}), "L3.2")
    assert not [name for name in (*reached.one_by_one, *sum(reached.riding, ())) if name.startswith("b")]


@pytest.mark.parametrize(
    ("along_W", "reached"), [(ALONG_X, "abcde"), (scale(-1.0, ALONG_X), "abcde"), (FROM_BEHIND, "ab")]
)
def test_planks_end_to_end_in_line_with_a_hit_wake_with_it(along_W: Vec3, reached: str) -> None:
    #   ==> |-a-|-b-|-c-|-d-|-e-|      across the line only bricks that touch a wake
    row = standing({name: lying(1, x=LENGTH * place) for place, name in enumerate("abcde")})
    assert "".join(hit(row, "a", along_W).one_by_one) == reached


@pytest.mark.parametrize(("gap", "reached"), [(0.2e-3, "abc"), (0.9e-3, "abc"), (1.1e-3, "a")])
def test_a_gap_that_a_hit_closes_within_a_step_does_not_end_the_line(gap: float, reached: str) -> None:
    #   ==> |-a-| |-b-| |-c-|      a wall has gaps of 0.2 mm, in which no contact is
    row = standing({name: lying(1, x=(LENGTH + gap) * place) for place, name in enumerate("abc")})
    assert "".join(hit(row, "a", ALONG_X).one_by_one) == reached


def test_two_hits_are_one_region() -> None:
    both = region(standing(four_stack(range(1, 14))), {"L3.2": FROM_BEHIND, "L8.1": ALONG_X}, ride=True)
    assert list(both.one_by_one) == names(*range(2, 10))
    assert [list(group) for group in both.riding] == [names(*range(10, 14))]


def test_on_a_slope_nothing_rides() -> None:
    #   Gravity pulls a group down the slope, so its support carries more than its weight.
    tilt = atan(0.1)
    turn = (0.0, sin(tilt / 2), 0.0, cos(tilt / 2))
    up = (sin(tilt), 0.0, cos(tilt))
    slope = Plane(GROUND, (0.0, 0.0, 0.0), up, WOOD)
    stack = {name: Pose(scale(pose.position_W[2], up), turn) for name, pose in column(6).items()}
    assert hit(standing(stack, slope), "L1").riding == ()
    assert hit(standing(column(6)), "L1").riding != ()


def test_no_group_rides_in_a_wall_where_it_would_span_a_yielding_support() -> None:
    #        |--|--|           the two planks of a level above lie on different ones of the level below
    #       |--|--|--|
    #      |--|--|--|--|
    rows = range(1, 7)
    poses = {
        f"L{level}.{place}": lying(level, (LENGTH + 0.2e-3) * (place + 0.5 * level))
        for level in rows
        for place in range(8 - level)
    }
    reached = hit(standing(poses), "L1.3")
    assert reached.riding == ()
    assert reached.in_wall
    assert {"L6.0", "L6.1"} <= set(reached.one_by_one)


def test_a_region_does_not_depend_on_the_order_of_the_bricks() -> None:
    stack = four_stack(range(1, 14))
    backwards = dict(reversed(stack.items()))
    assert hit(standing(stack), "L3.2") == hit(standing(backwards), "L3.2")


def test_a_bridge_wakes_with_the_tower_that_is_hit_and_the_other_one_stays() -> None:
    #   |---c---|
    #  a2     b2
    #  a1     b1
    poses = {f"{name}{level}": lying(level, x) for level in (1, 2) for name, x in (("a", 0.0), ("b", 0.15))}
    assert hit(standing({**poses, "c": lying(3, 0.075)}), "a1") == Region(("a1", "a2", "c"), (), ("a1",), in_wall=False)
