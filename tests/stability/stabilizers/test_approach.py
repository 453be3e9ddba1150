"""Prediction of hits."""

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.model import Brick, Pose, Vec3
from stability.stabilizers.approach import HitPredictor, PredictionLimits

PLANK = (0.12, 0.024, 0.008)
STEP = 1.0 / 960.0
SETTINGS = PyBulletSettings(time_step=STEP, iterations=20, contact_erp=0.2, breaking_threshold=0.1, scale=100.0)


def world_with(gap: float, velocity_W: Vec3) -> PyBulletWorld:
    """A frozen plank along x, and one that flies along it, with so much room between their ends [m]."""
    world = PyBulletWorld.opened(SETTINGS, gravity=0.0, friction=0.5, heaviest=0.012)
    world.add_brick(Brick("target", Box(PLANK), 0.012), Pose((0.0, 0.0, 0.004)))
    world.freeze("target")
    world.add_brick(Brick("shot", Box(PLANK), 0.012), Pose((-0.12 - gap, 0.0, 0.004)), velocity_W)
    return world


def hits_of(world: PyBulletWorld, approaches: HitPredictor) -> list[tuple[str, str, float]]:
    found = approaches.hits(world.states(["shot"]), {"target"})
    return [(hit.by, hit.brick, round(hit.speed, 6)) for hit in found]


@pytest.mark.parametrize("speed", [0.1, 1.0, 4.0, 20.0])
def test_a_hit_is_predicted_before_the_engine_removes_the_speed(speed: float) -> None:
    world = world_with(0.05, (speed, 0.0, 0.0))
    approaches = HitPredictor(world, lambda _: PredictionLimits(0.005))
    try:
        while not (found := hits_of(world, approaches)):
            world.set_max_speed(speed)
            world.step()
            assert world.time() < 1.0
        ((by, brick, told),) = found
        assert (by, brick) == ("shot", "target")
        assert told == pytest.approx(speed, rel=1e-3)
        assert world.states(["shot"])["shot"].velocity_W[0] == pytest.approx(speed, rel=1e-3)
    finally:
        world.close()


def test_a_brick_that_flies_away_hits_nothing() -> None:
    world = world_with(0.0005, (-2.0, 0.0, 0.0))
    try:
        assert hits_of(world, HitPredictor(world, lambda _: PredictionLimits(0.005))) == []
    finally:
        world.close()


def test_a_brick_that_slides_along_another_one_does_not_hit_it() -> None:
    world = world_with(0.0005, (0.0, 2.0, 0.0))
    try:
        assert hits_of(world, HitPredictor(world, lambda _: PredictionLimits(0.005))) == []
    finally:
        world.close()


def test_a_brick_that_is_let_go_in_touch_hits() -> None:
    world = world_with(0.0, (2.0, 0.0, 0.0))
    try:
        assert hits_of(world, HitPredictor(world, lambda _: PredictionLimits(0.005))) == [("shot", "target", 2.0)]
    finally:
        world.close()


def test_bricks_in_touch_press_and_do_not_hit() -> None:
    world = world_with(0.0001, (2.0, 0.0, 0.0))
    try:
        approaches = HitPredictor(world, lambda _: PredictionLimits(0.0))
        hits_of(world, approaches)  # which has just come
        assert hits_of(world, approaches) == []
    finally:
        world.close()


def test_time_that_was_skipped_is_no_step() -> None:
    #   a second ahead it would hit, but not in the next step
    world = world_with(0.05, (1.0, 0.0, 0.0))
    try:
        approaches = HitPredictor(world, lambda _: PredictionLimits(0.005))
        approaches.hits({}, {"target"})
        world.skip(1.0)
        assert hits_of(world, approaches) == []
    finally:
        world.close()


@pytest.mark.parametrize("speed", [1.0, 4.0, 20.0])
def test_a_brick_that_misses_another_hits_only_bricks_in_its_path(speed: float) -> None:
    #             |--above--|    its end is as near as that of the target, and a thickness too high
    # |--shot-->
    #             |--target--|  (at the height of the shot)
    world = world_with(0.01, (speed, 0.0, 0.0))
    try:
        world.add_brick(Brick("above", Box(PLANK), 0.012), Pose((0.0, 0.0, 0.004 + 2.0 * PLANK[2])))
        world.freeze("above")
        approaches = HitPredictor(world, lambda _: PredictionLimits(0.005))
        while not (found := approaches.hits(world.states(["shot"]), {"target", "above"})):
            world.set_max_speed(speed)
            world.step()
        assert [hit.brick for hit in found] == ["target"]
    finally:
        world.close()


def test_a_brick_on_its_way_to_an_edge_hits_when_the_last_gap_closes() -> None:
    #   8 mm to go along x at 4 m/s, 2 mm down at 1 m/s: both are over in 2 ms, two steps ahead
    world = world_with(0.008, (4.0, 0.0, -1.0))
    try:
        world.freeze("shot")
        world.put_at("shot", Pose((-0.128, 0.0, 0.004 + PLANK[2] + 0.002)))
        world.wake("shot")
        world.push("shot", (0.048, 0.0, -0.012), (-0.128, 0.0, 0.014))
        assert [brick for _, brick, _ in hits_of(world, HitPredictor(world, lambda _: PredictionLimits(0.005)))] == [
            "target"
        ]
    finally:
        world.close()
