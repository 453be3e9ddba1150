"""Bricks inside one another, and bricks in the air."""

from dataclasses import replace
from math import cos, inf, pi, sin
from random import Random

import pytest

from stability.geometry.box import Box
from stability.geometry.box_distance import reach_between
from stability.geometry.placed_shape import apart
from stability.model import GROUND, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.fit import TimedShape, fits

FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
WALL = Plane("wall 1", (0.3, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.5)
SIZE = (0.1176, 0.0234, 0.0078)


def at(*position: float, time: float = 0.0, size: Vec3 = SIZE) -> TimedShape:
    x, y, z = position
    return TimedShape(time, Box(size), Pose((x, y, z)))


def test_a_column_rests_brick_on_brick() -> None:
    found = fits([at(0.0, 0.0, 0.0078 * (k + 0.5), time=k) for k in range(4)], [FLOOR])
    assert [fit.on_boxes for fit in found] == [(), (0,), (1,), (2,)]
    assert [fit.on_planes for fit in found] == [(0,), (), (), ()]
    assert not any(fit.overlaps or fit.in_the_air for fit in found)


@pytest.mark.parametrize(("raised", "in_the_air"), [(0.0, False), (0.000155, False), (0.000157, True), (0.03, True)])
def test_a_brick_a_fiftieth_of_its_thickness_above_its_support_is_in_the_air(raised: float, in_the_air: bool) -> None:
    fit = fits([at(0.0, 0.0, 0.0039 + raised)], [FLOOR])[0]
    assert fit.in_the_air is in_the_air
    assert fit.clearance == pytest.approx(raised, abs=1e-12)


def test_of_two_bricks_that_overlap_the_later_one_is_blamed() -> None:
    one, other = fits([at(0.0, 0.0, 0.0039), at(0.01, 0.0, 0.0039)], [FLOOR])
    assert not one.overlaps
    assert other.overlaps_box == 0
    assert other.depth == pytest.approx(0.0078)


def test_bricks_side_by_side_do_not_carry_each_other() -> None:
    raised = fits([at(0.0, 0.0, 0.0039), at(0.0, 0.0234, 0.0060, time=1.0)], [FLOOR])[1]
    assert raised.in_the_air


def test_a_brick_may_not_stick_in_the_ground_or_in_a_wall() -> None:
    assert fits([at(0.0, 0.0, 0.002)], [FLOOR])[0].overlaps_plane == 0
    assert fits([at(0.28, 0.0, 0.0039)], [FLOOR, WALL])[0].overlaps_plane == 1


def test_a_brick_does_not_rest_on_what_comes_later_but_may_on_what_comes_with_it() -> None:
    upper, lower = at(0.0, 0.0, 0.0117), at(0.0, 0.0, 0.0039)
    together = fits([upper, lower], [FLOOR])
    assert not together[0].in_the_air
    later = fits([upper, TimedShape(1.0, lower.shape, lower.pose)], [FLOOR])
    assert later[0].in_the_air


def test_a_brick_makes_room_when_it_is_taken_away_for_what_is_put_then() -> None:
    first = TimedShape(0.0, Box(SIZE), Pose((0.0, 0.0, 0.0039)), until=2.0)
    for time, overlaps in ((1.0, 0), (2.0, None), (3.0, None)):
        assert fits([first, replace(first, time=time, until=inf)], [FLOOR])[1].overlaps_box == overlaps


def test_bricks_of_very_different_sizes_find_each_other() -> None:
    slab = TimedShape(0.0, Box((2.0, 2.0, 0.1)), Pose((0.0, 0.0, 0.05)))
    found = fits([slab, at(0.9, 0.9, 0.1039, time=1.0), at(0.9, 0.9, 0.1117, time=2.0)], [FLOOR])
    assert found[1].on_boxes == (0,)
    assert found[2].on_boxes == (1,)


def test_a_table_much_larger_than_the_bricks_on_it_is_found_by_each_and_finds_each() -> None:
    table = TimedShape(0.0, Box((2.0, 2.0, 0.1)), Pose((0.0, 0.0, 0.05)))
    on_it = [at(0.2 * x, 0.1 * y, 0.1039, time=1.0) for x in range(-4, 5) for y in range(-4, 5)]
    assert all(fit.on_boxes == (0,) for fit in fits([table, *on_it], [FLOOR])[1:])
    late = TimedShape(2.0, table.shape, table.pose)
    assert fits([at(0.0, 0.0, 0.0039), late], [FLOOR])[1].overlaps_box == 0


def test_a_plank_on_end_and_the_flat_ones_beside_it_find_each_other() -> None:
    on_end: Quaternion = (0.0, sin(pi / 4.0), 0.0, cos(pi / 4.0))
    post = TimedShape(0.0, Box(SIZE), Pose((0.0, 0.0, SIZE[0] / 2.0), on_end))
    around = [at(0.2 * x, 0.1, 0.0039 + 0.0078 * level) for x in (-1, 1) for level in range(30)]
    lintel = at(0.0, 0.0, SIZE[0] + SIZE[2] / 2.0, time=1.0)
    assert fits([post, *around, lintel], [FLOOR])[-1].on_boxes == (0,)


def test_a_brick_in_the_air_knows_how_far_below_the_next_one_is() -> None:
    raised = fits([at(0.0, 0.0, 0.0039), at(0.0, 0.0, 0.0117 + 0.04, time=1.0)], [FLOOR])[1]
    assert raised.in_the_air
    assert raised.clearance == pytest.approx(0.04)


@pytest.mark.parametrize("seed", range(5))
def test_fitting_finds_the_supports_and_overlaps_of_a_full_comparison(seed: int) -> None:
    #   The grid only spares comparisons: comparing each with all gives the same.
    boxes = sorted((thrown(Random(1000 * seed + number)) for number in range(80)), key=lambda box: box.time)
    for index, (box, fit) in enumerate(zip(boxes, fits(boxes, [FLOOR]), strict=True)):
        there = [other for other, at in enumerate(boxes) if at.time <= box.time < at.until and other != index]
        between = {n: apart(box.shape, box.pose, boxes[n].shape, boxes[n].pose) for n in there}
        inside = [n for n in there if n < index and between[n].gap < -1e-4]
        reach = {n: reach_between(box.shape.least_thickness, boxes[n].shape.least_thickness) for n in there}
        below = [n for n in there if between[n].gap <= reach[n] and between[n].normal_BA_W[2] > 0.05]
        assert fit.overlaps_box == (inside[0] if inside else None)
        assert fit.on_boxes == (() if inside else tuple(below))


def thrown(random: Random) -> TimedShape:
    """A plank somewhere above the floor, flat or not, long or short."""
    x, y, level = random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.randrange(10)
    yaw, roll = random.uniform(-pi, pi), random.choice([0.0, 0.0, 0.1])
    turn = (sin(roll) * cos(yaw), sin(roll) * sin(yaw), cos(roll) * sin(yaw), cos(roll) * cos(yaw))
    size = random.choice([SIZE, SIZE, (0.03, 0.02, SIZE[2]), (0.5, 0.02, SIZE[2])])
    pose = Pose((x, y, 0.1 + 0.0078 * level), turn)
    return TimedShape(float(random.randrange(4)), Box(size), pose, until=random.choice([inf, inf, 2.0, 3.0]))
