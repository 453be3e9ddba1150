"""Bricks that ride along as one rigid body, until it has moved too far."""

from collections.abc import Iterator
from math import cos, radians, sin

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.model import BodyId, BodyState, Pose, Vec3
from stability.stabilizers.exact.woken_region import RigidGroups
from stackdsl.simulation.systems import MOVING
from tests.planks import GRAVITY, MASS, THICKNESS, WOOD, column, plank

TOWER = column(4)


TOUCHING = {name: [other for other in TOWER if other != name] for name in TOWER}


@pytest.fixture
def world() -> Iterator[PyBulletWorld]:
    """Four planks in the air, all frozen."""
    opened = PyBulletWorld.opened(MOVING, GRAVITY, WOOD, heaviest=MASS)
    try:
        for name, pose in TOWER.items():
            opened.add_brick(plank(name), pose)
            opened.freeze(name)
        yield opened
    finally:
        opened.close()


@pytest.fixture
def rigid_groups(world: PyBulletWorld) -> RigidGroups:
    riding = RigidGroups(world)
    riding.weld({name: TOWER[name] for name in ("L4", "L3", "L2")}, TOUCHING, THICKNESS)
    return riding


def at(brick: BodyId, shift: Vec3 = (0.0, 0.0, 0.0), turn: float = 0.0) -> dict[BodyId, BodyState]:
    x, y, z = TOWER[brick].position_W
    a, b, c = shift
    return {brick: BodyState(Pose((x + a, y + b, z + c), (0.0, 0.0, sin(turn / 2), cos(turn / 2))))}


def test_a_group_is_looked_at_through_its_lowest_brick(rigid_groups: RigidGroups) -> None:
    assert rigid_groups.watched(TOWER) == ["L1", "L2"]
    assert rigid_groups.members("L2") == ("L2", "L3", "L4")
    assert rigid_groups.members("L1") == ("L1",)
    assert rigid_groups.bricks == {"L2", "L3", "L4"}


@pytest.mark.parametrize(("shift", "turn", "strays"), [
    (0.0019, 0.0, False), (0.0020, 0.0, True), (0.0, 0.99, False), (0.0, 1.01, True),
])  # fmt: skip
def test_a_rigid_group_strays_beyond_two_millimetres_or_one_degree(
    rigid_groups: RigidGroups, shift: float, turn: float, strays: bool
) -> None:
    state = at("L2", (0.0, -shift, 0.0), radians(turn))
    assert rigid_groups.moved_too_far(state) == (["L2"] if strays else [])


def test_a_group_that_moves_two_millimetres_is_taken_apart_with_its_motion(
    world: PyBulletWorld, rigid_groups: RigidGroups
) -> None:
    #   Without the plank below them: free fall by 2 mm takes sqrt(2 s / g) = 20 ms, and they fall on at g t each.
    world.remove_brick("L1")
    while not (moved_too_far := rigid_groups.moved_too_far(world.states(["L2"]))):
        world.step()
        assert world.time() < 0.1
    assert world.time() == pytest.approx((2.0 * 0.25 * THICKNESS / GRAVITY) ** 0.5, abs=MOVING.time_step)
    before = world.states(["L2", "L3", "L4"])
    assert rigid_groups.unweld(moved_too_far[0]) == ("L2", "L3", "L4")
    after = world.states(["L2", "L3", "L4"])
    for name, state in after.items():
        assert state.velocity_W == pytest.approx((0.0, 0.0, -GRAVITY * world.time()), rel=1e-6, abs=1e-9)
        assert state.pose.position_W == pytest.approx(before[name].pose.position_W, abs=1e-12)
    assert rigid_groups.bricks == frozenset()


def test_a_brick_parted_by_the_engine_leaves_its_rigid_group(world: PyBulletWorld, rigid_groups: RigidGroups) -> None:
    world.remove_brick("L3")
    rigid_groups.removed(["L3"])
    assert rigid_groups.bricks == frozenset()
    assert rigid_groups.watched(["L2", "L4"]) == ["L2", "L4"]


def test_no_group_rides_in_an_engine_that_cannot_weld() -> None:
    with pytest.raises(TypeError, match="cannot weld bricks"):
        RigidGroups(None).weld(TOWER, TOUCHING, THICKNESS)


def test_a_brick_that_is_hit_leaves_with_its_neighbours_and_the_rest_rides_on(world: PyBulletWorld) -> None:
    #   Of seven planks in a row the third and those that touch it move one by one, and the last three ride on.
    riding = RigidGroups(world)
    column = {f"C{number}": Pose((1.0, 0.0, number * THICKNESS)) for number in range(1, 8)}
    for name, pose in column.items():
        world.add_brick(plank(name), pose)
        world.freeze(name)
    touching = {f"C{number}": [f"C{number - 1}", f"C{number + 1}"] for number in range(1, 8)}
    riding.weld(column, touching, THICKNESS)
    world.step()
    riding.release("C3")
    assert riding.bricks == {"C5", "C6", "C7"}
    for state in world.states(sorted(column)).values():
        assert state.velocity_W[2] == pytest.approx(-GRAVITY * world.time(), rel=1e-6)
