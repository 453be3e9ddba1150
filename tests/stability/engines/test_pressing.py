"""A brick under a load that is no body: it slides, stops and stays as if a body of that weight lay on it."""

from collections.abc import Iterator
from math import hypot

import pytest

from stability.dynamics.rigid_body import AppliedForce
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import World
from stability.engines.rigid.world import RigidWorld
from stability.engines.scene_scale import SceneScale
from stability.model import BodyId, Pose
from stackdsl.simulation.systems import MOVING, MOVING_ON_MUJOCO, RIGID
from tests.planks import FLOOR, GRAVITY, LENGTH, MASS, THICKNESS, WIDTH, WOOD, lying, plank

LOAD = 10.0 * MASS * GRAVITY  # [N]


@pytest.fixture(params=[MOVING, MOVING_ON_MUJOCO, RIGID], ids=["pybullet", "mujoco", "rigid"])
def world(request: pytest.FixtureRequest) -> Iterator[World]:
    if not request.param.package.installed:
        pytest.skip("the engine is not installed")
    settings = request.param.scaled(SceneScale.of([plank("a")], GRAVITY))
    world = stepped_world(settings, GRAVITY, WOOD, MASS)
    world.add_plane(FLOOR)
    world.add_brick(plank("a"), lying(1))
    world.substep_next_contact()
    yield world
    world.close()


def pressed(friction: float, x: float = 0.0, load: float = LOAD) -> list[AppliedForce]:
    """A load [N], spread over the top of a plank, or over one end of it."""
    half = 0.5 * LENGTH - abs(x)
    places = [(x + along, across, THICKNESS) for along in (-half, half) for across in (-0.5 * WIDTH, 0.5 * WIDTH)]
    return [AppliedForce((0.0, 0.0, -0.25 * load), place, friction) for place in places]


def slid(world: World, friction: float, speed: float, brick: BodyId = "a") -> float:
    """How far a loaded plank slides that was pushed [m]."""
    for _ in range(20):
        world.apply_forces(brick, pressed(friction))
        world.step()
    world.push(brick, (0.0, speed * MASS, 0.0), world.states([brick])[brick].pose.position_W)
    start = world.states([brick])[brick].pose.position_W[1]
    for _ in range(round(0.1 / world.settings.time_step)):
        world.step()
    return world.states([brick])[brick].pose.position_W[1] - start


@pytest.mark.parametrize("friction", [0.0, 0.3, 0.5])
def test_a_loaded_plank_slides_against_the_friction_below_and_that_of_its_load(world: World, friction: float) -> None:
    speed = 1.0
    slowing = (WOOD * (LOAD + MASS * GRAVITY) + friction * LOAD) / MASS
    # Foreign engines move bodies on by the speed that they will have, ours by the mean speed.
    late = 0.0 if isinstance(world, RigidWorld) else 0.5 * speed * world.settings.time_step
    assert slid(world, friction, speed) == pytest.approx(speed**2 / (2.0 * slowing) - late, rel=0.02)


@pytest.mark.parametrize("gap", [0.001, 0.0013, 0.0015, 0.0018])
def test_the_load_of_a_plank_that_is_hit_slows_it_from_the_moment_of_the_hit(gap: float) -> None:
    speed = 4.0
    world = RigidWorld.opened(RIGID, GRAVITY, WOOD)
    world.add_plane(FLOOR)
    world.add_brick(plank("a"), lying(1))
    for _ in range(20):
        world.apply_forces("a", pressed(WOOD, load=5.0 * LOAD))
        world.step()
    x, y, z = lying(1).position_W
    world.add_brick(plank("hitting"), Pose((x, y - WIDTH - gap, z)), (0.0, speed, 0.5 * GRAVITY * gap / speed))
    for _ in range(100):
        world.step()
    slowing = (WOOD * (10.0 * LOAD + 2.0 * MASS * GRAVITY)) / (2.0 * MASS)
    way = world.states(["a"])["a"].pose.position_W[1] - y
    world.close()
    # Friction acts during the whole sub-step of the hit, of 0.2 ms, in which the speed decreases by 2.5 %.
    assert 0.94 < way / ((0.5 * speed) ** 2 / (2.0 * slowing)) < 1.01


def test_a_load_presses_until_it_is_taken_off(world: World) -> None:
    world.apply_forces("a", pressed(WOOD))
    for _ in range(40):
        world.step()
    assert sum(point.normal_force for point in world.contacts("a")) == pytest.approx(11.0 * MASS * GRAVITY, rel=0.05)
    world.apply_forces("a", ())
    for _ in range(40):
        world.step()
    assert sum(point.normal_force for point in world.contacts("a")) == pytest.approx(MASS * GRAVITY, rel=0.05)


def test_a_plank_that_is_pressed_on_one_half_stays_where_it_is(world: World) -> None:
    for _ in range(200):
        world.apply_forces("a", pressed(WOOD, x=0.25 * LENGTH))
        world.step()
    x, y, _ = world.states(["a"])["a"].pose.position_W
    assert hypot(x, y) < 0.05 * THICKNESS
