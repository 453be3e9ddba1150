"""The acceleration that is survived by bearing: against closed forms, and nothing that does not touch changes it."""

from math import cos, inf, pi, radians, sin
from random import Random

import pytest

from stability.analysis.acceleration_cut import shaken
from stability.analysis.bearings import Survived, along_bearing, by_bearing
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.proof import check_motion

TALL = (0.3, 0.2, 0.5)  # [m]


def box(name: str, size: Vec3, *at: float, yaw: float = 0.0) -> Placed:
    return Placed(Brick(name, Box(size), 1.0), Pose((at[0], at[1], at[2]), (0.0, 0.0, sin(yaw / 2.0), cos(yaw / 2.0))))


def survived(boxes: list[Placed], friction: float, count: int = 24, tolerance: float = 1e-4) -> tuple[Survived, ...]:
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction),), friction)
    assembly.add_all(boxes)
    found = by_bearing(assembly.problem(), count, tolerance)
    assert found is not None
    return found


def borne(size: Vec3, friction: float, bearing: float) -> float:
    """Of a box on level ground [g]: it slides at mu, and tips at the way to a side over half of its height."""
    ways = [abs(cos(bearing)) * size[2] / size[0], abs(sin(bearing)) * size[2] / size[1]]
    return min([friction, *(1.0 / way for way in ways if way > 1e-9)])


@pytest.mark.parametrize("friction", [0.1, 0.45, 2.0])
@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_a_box_slides_at_its_friction_and_tips_over_its_sides(friction: float, yaw: float) -> None:
    for each in survived([box("one", TALL, 0.0, 0.0, 0.25, yaw=yaw)], friction):
        truth = borne(TALL, friction, each.bearing - yaw)
        assert each.value <= truth * (1.0 + 1e-9)
        assert each.value == pytest.approx(truth, rel=2e-4)
        assert each.upper == pytest.approx(truth, rel=1e-3)


def test_the_margin_of_a_top_at_the_point_of_tipping_is_zero_one_way_and_friction_the_other_ways() -> None:
    #     |  top  |      its centre is right above the end of the base
    #  | base |
    boxes = [box("base", (0.2, 0.2, 0.1), 0.0, 0.0, 0.05), box("top", (0.2, 0.2, 0.02), 0.1, 0.0, 0.11)]
    for each in survived(boxes, 0.5, count=8):
        assert each.value == pytest.approx(0.5 if cos(each.bearing) < 0.5 else 0.0, abs=1e-4)


def test_the_margin_of_separate_parts_is_that_of_the_weakest() -> None:
    flat = (0.3, 0.3, 0.1)
    boxes = [box("tall", TALL, 0.0, 0.0, 0.25), box("flat", flat, 2.0, 0.0, 0.05)]
    for each in survived(boxes, 0.55):
        assert each.value == pytest.approx(min(borne(TALL, 0.55, each.bearing), 0.55), rel=2e-4)
        assert each.motion is not None
        if borne(TALL, 0.55, each.bearing) < 0.54:
            assert set(each.motion.velocity) == {"tall"}


@pytest.mark.parametrize("yaw", [0.0, 0.7])
@pytest.mark.parametrize("levels", [4, 6, 9])
def test_a_tower_that_stands_flush_holds_another_by_the_friction_between_them_alone(levels: int, yaw: float) -> None:
    # Both tip over their lower edges on one side. With mu the friction, n what one presses the other with over what it
    # weighs, and a the acceleration: a N - 1 = mu n, as their sides slide, and n (1 - mu^2) = mu - a, as the second is
    # about to slide on the ground. What is across from a cube, and touches it along an edge, takes no part.
    friction, side = 0.4, 0.1
    cubes = [
        box(f"{k}.{i}", (side, side, side), i * side * cos(yaw), i * side * sin(yaw), (k + 0.5) * side, yaw=yaw)
        for k in range(levels)
        for i in range(2)
    ]
    share = friction / (1.0 - friction * friction)
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction),), friction)
    assembly.add_all(cubes)
    found = along_bearing(assembly.problem(), yaw)
    assert found is not None
    assert found.value == pytest.approx((1.0 + friction * share) / (levels + share), rel=1e-7)
    assert found.upper == pytest.approx(found.value, rel=1e-7)


@pytest.mark.parametrize("off", [1e-9, 1e-6, 1e-5])
def test_cubes_that_are_off_by_a_hair_survive_no_more_than_flush_ones(off: float) -> None:
    # Each its own way, so that some come to lie on the next tower: a sliver, which carries the whole of one.
    draws, side = Random(1), 0.1
    cubes = [
        box(
            f"{k}.{i}",
            (side, side, side),
            i * side + draws.uniform(-off, off),
            draws.uniform(-off, off),
            (k + 0.5) * side,
        )
        for k in range(6)
        for i in range(2)
    ]
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.4),), 0.4)
    assembly.add_all(cubes)
    found = along_bearing(assembly.problem(), 0.0)
    assert found is not None
    assert found.value == pytest.approx(0.18382353, rel=30.0 * off / side + 1e-7)


def test_a_far_brick_turning_and_size_change_nothing() -> None:
    alone = survived([box("one", TALL, 0.0, 0.0, 0.25)], 0.8)
    for times in (0.01, 100.0):
        a, b, c = (times * side for side in TALL)
        beside = box("far", (a, a, 0.001 * a), 50.0 * a, 0.0, 0.0005 * a)
        for one, other in zip(alone, survived([box("one", (a, b, c), 0.0, 0.0, 0.5 * c), beside], 0.8), strict=True):
            assert other.value == pytest.approx(one.value, rel=3e-4)


def test_the_motion_lowers_what_is_pulled_a_little_harder() -> None:
    boxes = [box("low", (0.3, 0.2, 0.1), 0.0, 0.0, 0.05), box("high", (0.2, 0.1, 0.2), 0.02, 0.0, 0.2)]
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.7),), 0.7)
    assembly.add_all(boxes)
    problem = assembly.problem()
    found, case = by_bearing(problem, 12), shaken(problem, None, Tolerances())
    assert found is not None
    assert case is not None
    for each in found:
        assert 0.0 < each.value <= each.upper <= each.value / 0.98
        assert each.motion is not None
        harder = case.loaded(*(1.0001 * each.upper * part for part in (cos(each.bearing), sin(each.bearing))))
        assert check_motion(harder, each.motion, Tolerances()).holds


def test_the_margin_of_a_brick_held_on_all_sides_is_infinite() -> None:
    walls = [
        Plane(
            f"wall {k}",
            (0.1 * cos(k * pi / 2.0), 0.1 * sin(k * pi / 2.0), 0.0),
            (-cos(k * pi / 2.0), -sin(k * pi / 2.0), 0.0),
            0.0,
        )
        for k in range(4)
    ]
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5), *walls), 0.5)
    assembly.add_all([box("one", (0.2, 0.2, 0.1), 0.0, 0.0, 0.05)])
    found = by_bearing(assembly.problem(), 8)
    assert found is not None
    assert [each.value for each in found] == [inf] * 8


def test_a_falling_structure_has_no_margin_at_any_bearing() -> None:
    assembly = Assembly((Plane(GROUND, (0.0, 0.0, 0.0), (0.0, sin(radians(40.0)), cos(radians(40.0))), 0.5),), 0.5)
    turned = Pose(
        (0.0, 0.05 * sin(radians(40.0)), 0.05 * cos(radians(40.0))), (-sin(radians(20.0)), 0.0, 0.0, cos(radians(20.0)))
    )
    assembly.add(Brick("one", Box((0.2, 0.2, 0.1)), 1.0), turned)
    assert by_bearing(assembly.problem(), 8) is None
