"""The engine contains only moving bricks and their neighbourhood, and its settings follow these bricks."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import pytest

from stability.engines.lazy_world import EngineFactory, RestingWorld
from stability.engines.protocol import EngineSettings, World
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose

SETTINGS = PyBulletSettings(
    time_step=1.0 / 960.0, iterations=50, contact_erp=0.4, breaking_threshold=0.1, scale=100.0, most_travel=0.001
)
CUBE = 0.05


def cube(name: str, side: float = CUBE) -> Brick:
    return Brick(name, Box((side, side, side)), 700.0 * side**3)


@dataclass
class Opened:
    """A world above no ground, and the engines that it opened; of thinner bricks, bodies get less far in a step."""

    engines: list[World] = field(default_factory=list)

    def world(self) -> RestingWorld:
        return RestingWorld(EngineFactory(SETTINGS, self._settings_for, self._open))

    def _settings_for(self, bricks: Collection[Brick]) -> EngineSettings:
        return replace(SETTINGS, most_travel=0.02 * min(brick.shape.least_thickness for brick in bricks))

    def _open(self, settings: EngineSettings, heaviest: float) -> World:
        assert isinstance(settings, PyBulletSettings)
        self.engines.append(PyBulletWorld.opened(settings, gravity=0.0, friction=0.0, heaviest=heaviest))
        return self.engines[-1]


def row(world: RestingWorld, count: int) -> None:
    """Cubes in a row along x, half a metre apart, all held."""
    for number in range(count):
        world.add_brick(cube(f"{number}"), Pose((0.5 * number, 0.0, 0.0)))
        world.freeze(f"{number}")


def go(world: RestingWorld, seconds: float, fastest: float) -> None:
    """Let time pass; how fast all is, is said a hundred times a second."""
    for step in range(round(960 * seconds)):
        if step % 10 == 0:
            world.set_max_speed(fastest)
        world.step()


def test_bricks_far_from_any_motion_are_not_in_the_engine() -> None:
    opened = Opened()
    world = opened.world()
    row(world, 1000)
    world.wake("500")
    go(world, 0.02, fastest=0.0)
    assert set(opened.engines[0].masses()) == {"500"}
    assert len(world.masses()) == 1000
    assert world.states(["7"])["7"].pose.position_W == (3.5, 0.0, 0.0)
    world.close()


def test_a_flying_brick_hits_distant_standing_bricks() -> None:
    opened = Opened()
    world = opened.world()
    row(world, 4)
    for name in ("0", "1"):
        world.remove_brick(name)
    world.add_brick(cube("flying"), Pose((0.1, 0.0, 0.0)), (4.0, 0.0, 0.0))
    go(world, 0.1, fastest=4.0)
    assert set(opened.engines[0].masses()) == {"flying"}
    go(world, 0.15, fastest=4.0)
    assert set(opened.engines[0].masses()) == {"2", "flying"}
    assert 0.5 < world.states(["flying"])["flying"].pose.position_W[0] <= 1.0 - CUBE + 1e-4
    world.close()


def test_neighbours_are_found_up_to_the_requested_distance() -> None:
    world = Opened().world()
    row(world, 9)
    world.wake("4")
    assert world.neighbours("4", 0.01) == []
    assert world.neighbours("4", 0.6) == ["3", "5"]
    assert world.neighbours("4", 1.2) == ["2", "3", "5", "6"]
    world.close()


def test_a_thin_brick_far_away_changes_no_settings_and_near_it_does_while_all_goes_on() -> None:
    opened = Opened()
    world = opened.world()
    sheet = Brick("sheet", Box((0.001, CUBE, CUBE)), 0.001)
    world.add_brick(sheet, Pose((2.0, 0.0, 0.0)))
    world.freeze("sheet")
    for name, y in (("a", 0.0), ("b", 0.06)):
        world.add_brick(cube(name), Pose((0.0, y, 0.0)), (2.0, 0.0, 0.0))
    world.weld(["a", "b"])
    go(world, 0.5, fastest=2.0)
    assert world.settings == replace(SETTINGS, most_travel=0.02 * CUBE)
    before = world.states(["a", "b"])
    go(world, 0.45, fastest=2.0)
    after = world.states(["a", "b"])
    assert world.settings == replace(SETTINGS, most_travel=0.02 * 0.001)
    assert len(opened.engines) == 2
    assert world.time() == pytest.approx(0.95)
    for name in ("a", "b"):
        way = after[name].pose.position_W[0] - before[name].pose.position_W[0]
        assert way == pytest.approx(0.45 * before[name].velocity_W[0], rel=1e-6)
    assert set(world.unweld("a")) == {"a", "b"}
    world.close()


def test_bricks_placed_during_a_motion_enter_the_near_engine() -> None:
    opened = Opened()
    world = opened.world()
    world.add_plane(Plane(GROUND, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), 0.5))
    world.add_brick(cube("flying"), Pose((0.0, 0.0, 0.0)), (2.0, 0.0, 0.0))
    go(world, 0.05, fastest=2.0)
    world.add_brick(cube("late"), Pose((0.5, 0.0, 0.0)))
    world.freeze("late")
    assert set(opened.engines[0].masses()) == {"flying"}
    go(world, 0.5, fastest=2.0)
    assert world.states(["flying"])["flying"].pose.position_W[0] <= 0.5 - CUBE + 1e-4
    world.close()


def test_a_group_is_unwelded_in_a_reopened_engine() -> None:
    world = Opened().world()
    for name, y in (("a", 0.0), ("b", 0.06)):
        world.add_brick(cube(name), Pose((0.0, y, 0.0)), (1.0, 0.0, 0.0))
    world.weld(["a", "b"])
    go(world, 0.01, fastest=1.0)
    world.add_brick(Brick("chip", Box((0.0005, 0.004, 0.004)), 1e-5), Pose((5.0, 0.0, 0.0)), (0.1, 0.0, 0.0))
    assert set(world.unweld("a")) == {"a", "b"}
    go(world, 0.01, fastest=1.0)
    for name in ("a", "b"):
        assert world.states([name])[name].pose.position_W[0] == pytest.approx(world.time(), rel=1e-6)
    world.close()


def test_bricks_frozen_elsewhere_before_a_step_never_enter_the_near_engine() -> None:
    opened = Opened()
    world = opened.world()
    world.add_brick(cube("moving"), Pose((0.0, 0.0, 0.0)), (1.0, 0.0, 0.0))
    go(world, 0.01, fastest=1.0)
    world.add_brick(Brick("sheet", Box((0.0005, CUBE, CUBE)), 1e-3), Pose((5.0, 0.0, 0.0)))
    assert world.neighbours("moving", 0.1) == []
    world.freeze("sheet")
    go(world, 0.01, fastest=1.0)
    assert set(opened.engines[0].masses()) == {"moving"}
    assert len(opened.engines) == 1
    world.close()
