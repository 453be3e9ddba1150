"""A world without an engine until something moves."""

import subprocess
import sys
from dataclasses import dataclass, field

import pytest

from stability.engines.lazy_world import EngineFactory, RestingWorld
from stability.engines.protocol import EngineSettings, World
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.model import GROUND, BodyState, Brick, HalfSpace, Plane, Pose
from tests.paths import ROOT

SETTINGS = PyBulletSettings(time_step=1.0 / 960.0, iterations=50, contact_erp=0.4, breaking_threshold=0.1, scale=100.0)
SIZE = (0.12, 0.024, 0.008)


@dataclass
class Opened:
    """A resting world, and the engines that it opened."""

    engines: list[World] = field(default_factory=list)

    def world(self) -> RestingWorld:
        world = RestingWorld(EngineFactory(SETTINGS, lambda _: SETTINGS, self._open))
        world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
        return world

    def _open(self, settings: EngineSettings, heaviest: float) -> World:
        assert isinstance(settings, PyBulletSettings)
        self.engines.append(PyBulletWorld.opened(settings, gravity=9.81, friction=0.5, heaviest=heaviest))
        return self.engines[-1]


def test_nothing_is_opened_while_nothing_is_stepped() -> None:
    opened = Opened()
    world = opened.world()
    world.add_brick(Brick("a", Box(SIZE), 0.012), Pose((0.0, 0.0, 0.004)))
    world.freeze("a")
    world.skip(3.0)
    world.set_max_speed(5.0)
    assert world.time() == 3.0
    assert dict(world.masses()) == {"a": 0.012}
    assert world.fixed() == {GROUND}
    assert (world.shape("a"), world.shape(GROUND)) == (Box(SIZE), HalfSpace((0.0, 0.0, 1.0)))
    assert world.states(["a"])["a"].pose == Pose((0.0, 0.0, 0.004))
    assert world.holds("a")
    assert not world.contacts("a")
    world.close()
    assert opened.engines == []


def test_how_fast_bodies_will_be_is_passed_on_to_an_engine_that_is_opened_later(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told: list[float] = []
    monkeypatch.setattr(PyBulletWorld, "set_max_speed", lambda _, fastest: told.append(fastest))
    world = Opened().world()
    world.set_max_speed(20.0)
    assert told == []
    world.step()
    assert told == [20.0]
    world.close()


def test_velocities_set_before_the_engine_starts_are_kept_in_it() -> None:
    opened = Opened()
    world = opened.world()
    world.add_brick(Brick("a", Box(SIZE), 0.012), Pose((0.0, 0.0, 1.0)))
    state = BodyState(Pose((0.1, 0.2, 1.5)), (1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    world.set_state("a", state)
    assert (world.states(["a"])["a"], opened.engines) == (state, [])
    world.step()
    after = world.states(["a"])["a"]
    assert after.pose.position_W[:2] == pytest.approx((0.1 + 1.0 / 960.0, 0.2), abs=1e-9)
    assert after.angular_velocity_W == pytest.approx((0.0, 0.0, 2.0))
    world.close()


def test_another_object_tells_of_masses_when_a_brick_has_come() -> None:
    world = Opened().world()
    before = world.masses()
    assert world.masses() is before
    world.add_brick(Brick("a", Box(SIZE), 0.012), Pose((0.0, 0.0, 0.004)))
    assert world.masses() is not before


def test_a_brick_that_was_taken_out_does_not_come_into_the_engine_that_is_opened() -> None:
    opened = Opened()
    world = opened.world()
    for level, name in enumerate("abc"):
        world.add_brick(Brick(name, Box(SIZE), 0.012), Pose((0.0, 0.0, 0.004 + 0.008 * level)))
        world.freeze(name)
    before = world.masses()
    world.remove_brick("c")
    assert world.masses() is not before
    world.wake("a")
    world.step()
    assert set(opened.engines[0].masses()) == {"a", "b"}
    world.remove_brick("b")
    assert set(world.masses()) == set(opened.engines[0].masses()) == {"a"}
    world.close()


def test_the_first_step_opens_an_engine_in_which_only_awake_bricks_fall() -> None:
    opened = Opened()
    world = opened.world()
    for name, height in (("held", 1.0), ("loose", 2.0), ("woken", 3.0)):
        world.add_brick(Brick(name, Box(SIZE), 0.012), Pose((0.0, 0.0, height)))
    world.freeze("held")
    world.freeze("woken")
    world.wake("woken")
    world.skip(1.0)
    for _ in range(96):
        world.step()
    world.add_brick(Brick("late", Box(SIZE), 0.012), Pose((0.0, 0.0, 4.0)))
    world.freeze("late")
    for _ in range(96):
        world.step()
    heights = {name: state.pose.position_W[2] for name, state in world.states(world.masses()).items()}
    world.close()
    assert len(opened.engines) == 1
    assert world.time() == pytest.approx(1.2)
    fall = 0.5 * 9.81 * 0.2**2
    assert heights == pytest.approx({"held": 1.0, "loose": 2.0 - fall, "woken": 3.0 - fall, "late": 4.0}, abs=0.002)


def test_a_brick_that_is_frozen_when_the_engine_opens_has_its_mass_when_it_is_woken() -> None:
    world = Opened().world()
    world.add_brick(Brick("a", Box(SIZE), 0.012), Pose((0.0, 0.0, 1.0)))
    world.freeze("a")
    world.step()
    world.wake("a")
    for _ in range(96):
        world.step()
    assert world.states(["a"])["a"].velocity_W[2] == pytest.approx(-0.981, rel=1e-3)
    assert world.contacts("a") == []
    assert world.neighbours("a", 5e-4) == []
    world.close()


def test_joined_bricks_fall_as_one_and_may_be_frozen_again_when_they_are_parted() -> None:
    world = Opened().world()
    for name, height in (("low", 1.0), ("top", 1.008)):
        world.add_brick(Brick(name, Box(SIZE), 0.012), Pose((0.0, 0.0, height)))
        world.freeze(name)
    world.weld(["low", "top"])
    assert not world.holds("low")
    for _ in range(96):
        world.step()
    assert world.unweld("top") == ("low", "top")
    heights = {name: state.pose.position_W[2] for name, state in world.states(["low", "top"]).items()}
    world.freeze("low")
    assert world.holds("low")
    for _ in range(96):
        world.step()
    states = world.states(["low", "top"])
    world.close()
    fall = 0.5 * 9.81 * 0.1**2
    assert heights == pytest.approx({"low": 1.0 - fall, "top": 1.008 - fall}, abs=0.001)
    assert states["low"].pose.position_W[2] == pytest.approx(heights["low"], abs=1e-9)
    assert states["top"].velocity_W[2] == pytest.approx(0.0, abs=0.1)  # it lies on the other


def test_a_world_absorbs_moving_and_frozen_bricks_of_another() -> None:
    opened = Opened()
    one, other = opened.world(), opened.world()
    for world, x in ((one, 0.0), (other, 0.5)):
        world.add_brick(Brick(f"stands at {x}", Box(SIZE), 0.012), Pose((x, 0.0, 0.004)))
        world.freeze(f"stands at {x}")
        world.add_brick(Brick(f"falls at {x}", Box(SIZE), 0.012), Pose((x, 0.2, 1.0)), (0.3, 0.0, 0.0))
    for name, height in (("low", 1.0), ("top", 1.008)):
        other.add_brick(Brick(name, Box(SIZE), 0.012), Pose((0.5, 0.4, height)))
        other.freeze(name)
    other.weld(["low", "top"])
    for _ in range(96):
        one.step()
        other.step()
    one.engine.absorb(other.engine)
    assert len(opened.engines) == 2
    for _ in range(96):
        one.step()
    states = one.states(one.masses())
    fall = 0.5 * 9.81 * 0.2 * (0.2 + 1.0 / 960.0)  # by Euler's steps
    assert one.holds("stands at 0.5")
    assert states["stands at 0.5"].pose.position_W == (0.5, 0.0, 0.004)
    for x in (0.0, 0.5):
        assert states[f"falls at {x}"].pose.position_W == pytest.approx((x + 0.06, 0.2, 1.0 - fall), abs=1e-6)
        assert states[f"falls at {x}"].velocity_W == pytest.approx((0.3, 0.0, -1.962), abs=1e-6)
    assert states["top"].pose.position_W[2] - states["low"].pose.position_W[2] == pytest.approx(0.008, abs=1e-9)
    assert one.unweld("top") == ("low", "top")
    assert one.time() == pytest.approx(0.2)
    one.close()


def test_a_world_that_gives_its_engine_back_opens_another_when_something_moves_again() -> None:
    opened = Opened()
    world = opened.world()
    world.engine.close_engine()  # there is none
    for name, x in (("a", 0.0), ("b", 0.5), ("falls on", 1.0)):
        world.add_brick(Brick(name, Box(SIZE), 0.012), Pose((x, 0.0, 1.0)))
    for _ in range(96):
        world.step()
    world.freeze("a")
    world.freeze("b")
    before = world.states(["a", "b", "falls on"])
    world.engine.close_engine()
    assert world.states(before) == before
    assert world.time() == pytest.approx(0.1)
    assert not world.contacts("a")
    world.wake("a")
    world.step()
    assert len(opened.engines) == 2
    assert set(opened.engines[1].masses()) == {"a", "falls on"}
    speeds = [world.states(before)[name].velocity_W[2] for name in before]
    assert speeds == pytest.approx([-9.81 / 960.0, 0.0, -9.81 * (0.1 + 1.0 / 960.0)], abs=1e-9)
    assert world.time() == pytest.approx(0.1 + 1.0 / 960.0)
    world.close()


def test_exact_imports_no_engine_while_all_is_proven() -> None:
    code = """
import sys
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from tests.scenes import timeline_of
trace = play(timeline_of("- four_stack: {levels: 5}\\n  every: 1 s"), SYSTEMS["exact"])
assert trace.cost.steps == 0
sys.exit("pybullet" in sys.modules)
"""
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0
