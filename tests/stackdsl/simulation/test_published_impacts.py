"""Planks that hit a tower of 13 levels under the published method: when it reacts, and with what.

The limits of speed are worked out by hand in tests/stability/stabilizers/published/test_impacts.py: 2.1295 m/s at
level 3, 0.2766 m/s at the top.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import dist, hypot, sqrt

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.model import AT_REST, BodyId, Brick, Plane, Pose, Vec3
from stability.stabilizers.protocol import Update
from stability.stabilizers.published.stabilizer import StackStability
from stability.stabilizers.published.support import AS_READ, Readings, SecondObjects
from stackdsl.simulation.systems import HELD

PLANK: Vec3 = (0.1176, 0.0234, 0.0078)  # [m]
LENGTH, WIDTH, THICKNESS = PLANK
MASS = 557.0 * LENGTH * WIDTH * THICKNESS  # [kg]
GROUND = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
ALONG_Y = (0.0, 0.0, sqrt(0.5), sqrt(0.5))
OUT = (LENGTH - WIDTH) / 2.0
LEVELS = 13
GAP = 0.01  # [m] from the nose of a thrown plank to what it hits


@dataclass
class Tower:
    """Two flush planks a level; odd levels lie along x, and number 1 is the one towards -y or -x."""

    world: PyBulletWorld
    stability: StackStability

    def put(self, name: BodyId, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        self.world.add_brick(Brick(name, Box(PLANK), MASS), pose, velocity_W)

    def throw_at_level(self, level: int, speed: float) -> Update:
        """A plank end-on along y, at the middle of the plank of an odd level that it meets first."""
        assert level % 2 == 1
        z = (level - 0.5) * THICKNESS
        upward = 0.5 * 9.81 * GAP / speed  # it arrives at the height that it was thrown from
        self.put("shot", Pose((0.0, -LENGTH - GAP, z), ALONG_Y), (0.0, speed, upward))
        return self.stability.update()

    def watch(self, seconds: float) -> list[Update]:
        """All that the method does while time passes."""
        updates = []
        end = self.world.time() + seconds
        while self.world.time() < end and self.stability.awake():
            states = self.world.states(self.stability.awake()).values()
            self.world.set_max_speed(max(hypot(*state.velocity_W) for state in states) + 0.1)
            self.world.step()
            updates.append(self.stability.update())
        return updates

    def places(self) -> dict[BodyId, Vec3]:
        names = [name for name in self.world.masses() if name.startswith("L")]
        return {name: state.pose.position_W for name, state in self.world.states(names).items()}


def woken(updates: list[Update]) -> set[BodyId]:
    return {brick for update in updates for brick in update.woken}


def reasons(updates: list[Update]) -> list[str]:
    return [update.reason for update in updates if update.woken]


@pytest.fixture
def readings() -> Readings:
    return AS_READ


@pytest.fixture
def tower(readings: Readings) -> Iterator[Tower]:
    world = PyBulletWorld.opened(HELD, 9.81, friction=0.5, heaviest=MASS)
    world.add_plane(GROUND)
    built = Tower(world, StackStability(world, planes=[GROUND], readings=readings))
    for level in range(1, LEVELS + 1):
        z = (level - 0.5) * THICKNESS
        for number, side in ((1, -OUT), (2, OUT)):
            pose = Pose((0.0, side, z)) if level % 2 else Pose((side, 0.0, z), ALONG_Y)
            built.put(f"L{level}.{number}", pose)
            built.stability.set_down([f"L{level}.{number}"])
            assert built.stability.update().frozen
    yield built
    world.close()


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0, 2.12])
def test_a_hit_at_level_3_below_the_limit_moves_nothing(tower: Tower, speed: float) -> None:
    before = tower.places()
    updates = [tower.throw_at_level(3, speed), *tower.watch(1.0)]
    assert woken(updates) == set()
    assert tower.places() == before
    # The plank loses its speed, and falls down next to the tower.
    _, y, z = tower.world.states(["shot"])["shot"].pose.position_W
    assert y < -LENGTH
    assert z == pytest.approx(THICKNESS / 2.0, abs=1e-4)
    assert tower.stability.is_frozen("shot")


def test_a_faster_one_wakes_the_hit_brick_and_all_above_it_at_once(tower: Tower) -> None:
    updates = [tower.throw_at_level(3, 2.14), *tower.watch(0.05)]
    above = {f"L{level}.{number}" for level in range(4, LEVELS + 1) for number in (1, 2)}
    assert woken(updates) == {"L3.1"} | above
    assert reasons(updates) == ["shot would hit L3.1: kinetic energy 27.4 mJ, potential energy 27.1 mJ"]
    # Its momentum is not lost: the brick was woken before the hit.
    assert tower.world.states(["L3.1"])["L3.1"].pose.position_W[1] > -OUT + 0.001


@pytest.mark.parametrize(("speed", "reacts"), [(0.27, False), (0.30, True), (1.0, True)])
def test_at_the_top_it_loses_the_hit_brick_alone(tower: Tower, speed: float, reacts: bool) -> None:
    before = tower.places()
    # Straight in front of it, for the fall through a longer way would add to so low a speed.
    tower.put("shot", Pose((0.0, -LENGTH - 0.0005, 12.5 * THICKNESS), ALONG_Y), (0.0, speed, 0.0))
    updates = [tower.stability.update(), *tower.watch(0.5)]
    assert woken(updates) == ({"L13.1"} if reacts else set())
    after = tower.places()
    assert {name for name in before if dist(before[name], after[name]) > 0.001} == ({"L13.1"} if reacts else set())


@pytest.mark.parametrize(("speed", "gives"), [(2.12, False), (2.14, True)])
def test_a_push_is_tested_like_a_hit_by_a_plank_of_that_momentum(tower: Tower, speed: float, gives: bool) -> None:
    update = tower.stability.struck("L3.1", (0.0, MASS * speed, 0.0))
    assert ("L3.1" in update.woken) is gives
    assert tower.stability.is_frozen("L3.1") is not gives
    assert update.reason == f"L3.1 pushed: kinetic energy {0.5e3 * MASS * speed**2:.3g} mJ, potential energy 27.1 mJ"


def test_a_push_on_a_brick_that_is_awake_is_left_to_the_engine(tower: Tower) -> None:
    tower.stability.wake(["L13.1"])
    assert tower.stability.struck("L13.1", (0.0, 1.0, 0.0)) == Update()


def test_what_has_been_part_of_the_stack_disturbs_nothing_that_it_hits(tower: Tower) -> None:
    #   L13.1 slides over level 12, square on L13.2 which lies 70.8 mm away
    tower.stability.wake(["L13.1"])
    assert tower.stability.struck("L13.1", (0.0, MASS * 2.0, 0.0)) == Update()
    tower.world.push("L13.1", (0.0, MASS * 2.0, 0.0), tower.places()["L13.1"])
    before = tower.places()["L13.2"]
    furthest = 0.0
    for _ in range(20):
        assert woken(tower.watch(0.005)) == set()
        furthest = max(furthest, tower.places()["L13.1"][1])
    assert furthest == pytest.approx(OUT - WIDTH, abs=0.002)
    assert tower.places()["L13.2"] == before


@pytest.mark.parametrize("readings", [Readings(second_objects=SecondObjects.NONE)])
def test_read_so_that_all_that_moves_hits_it_wakes_what_it_slides_against(tower: Tower) -> None:
    #   The same slide: 0.5 m v^2 of what is left of 2 m/s after 70.8 mm is far above the 0.457 mJ that hold L13.2.
    tower.stability.wake(["L13.1"])
    tower.world.push("L13.1", (0.0, MASS * 2.0, 0.0), tower.places()["L13.1"])
    updates = tower.watch(0.1)
    assert woken(updates) == {"L13.2"}
    assert reasons(updates)[0].startswith("L13.1 would hit L13.2: ")


def test_a_stranger_that_slides_the_same_way_does(tower: Tower) -> None:
    place = tower.places()["L13.1"]
    tower.world.remove_brick("L13.1")
    tower.stability.taken_out(["L13.1"])
    tower.put("shot", Pose(place), (0.0, 2.0, 0.0))
    assert "L13.2" in woken(tower.watch(0.5))


def test_of_two_bricks_hit_at_once_each_is_tested_by_itself(tower: Tower) -> None:
    #   flat on both planks of the top level, from 30 mm above
    tower.put("shot", Pose((0.0, 0.0, 13.5 * THICKNESS + 0.03), ALONG_Y))
    updates = tower.watch(0.5)
    # Each of the two is held by 0.457 mJ; m g 30 mm is 3.52 mJ, less what the last two steps bring.
    (reason,) = reasons(updates)
    assert woken(updates) == {"L13.1", "L13.2"}
    assert "shot would hit L13.1" in reason
    assert "shot would hit L13.2" in reason
    assert len(tower.stability.stack) == 2 * LEVELS + 1
