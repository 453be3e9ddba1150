"""Prescribed motion of bricks in every engine: independent of contacts, and free again afterwards."""

import pytest

from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import Guided, PrescribedMotion, World
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stackdsl.simulation.known_systems import system_named
from tests.engines_at_hand import WITH_RIGID

SYSTEMS = ["stock", "tuned", *WITH_RIGID]
CUBE, MASS = Box((0.04, 0.04, 0.04)), 0.03
UP: Vec3 = (0.0, 0.0, 1.0)


def world_of(system: str, *centres: Vec3) -> World:
    world = stepped_world(system_named(system).engine, 9.81, 0.5, MASS)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), UP, 0.5))
    for number, centre in enumerate(centres):
        world.add_brick(Brick(f"b{number}", CUBE, MASS), Pose(centre))
    return world


def passed(world: World, seconds: float, **guided: Guided) -> World:
    for _ in range(round(seconds / world.settings.time_step)):
        world.step(PrescribedMotion(guided=guided))
    return world


def centre(world: World, brick: str) -> Vec3:
    return world.states([brick])[brick].pose.position_W


def in_a_step(world: World) -> float:
    """How far a brick that fell for 0.1 s gets in a step [m]."""
    return 9.81 * 0.1 * world.settings.time_step


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_carried_brick_has_no_weight_and_pushes_others(system: str) -> None:
    world = world_of(system, (0.0, 0.0, 0.03), (0.05, 0.0, 0.02))
    passed(world, 0.5, b0=Guided((0.05, 0.0, 0.0)))
    assert centre(world, "b0") == pytest.approx((0.025, 0.0, 0.03), abs=2e-4)  # in the air, and in no way held up
    assert centre(world, "b1")[0] == pytest.approx(0.065, abs=5e-4)
    world.close()


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_released_guided_brick_falls_freely(system: str) -> None:
    world = world_of(system, (0.0, 0.0, 0.3))
    passed(world, 0.2, b0=Guided((0.0, 0.0, 0.0)))
    assert centre(world, "b0")[2] == pytest.approx(0.3, abs=1e-5)
    passed(world, 0.1)
    assert centre(world, "b0")[2] == pytest.approx(0.3 - 0.5 * 9.81 * 0.1**2, abs=in_a_step(world))
    world.close()


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_released_carried_brick_has_its_own_mass_again(system: str) -> None:
    #   Two cubes of equal mass: after a hit at v both move at v / 2 and slide v^2 / 8 mu g.
    world = world_of(system, (0.0, 0.0, 0.02), (0.0401, 0.0, 0.02))
    passed(world, 0.05, b0=Guided((0.0, 0.0, 0.0)))
    world.push("b0", (MASS * 0.4, 0.0, 0.0), centre(world, "b0"))
    passed(world, 0.5)
    assert centre(world, "b1")[0] - 0.0401 == pytest.approx(0.4**2 / (8.0 * 0.5 * 9.81), rel=0.35)
    world.close()


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_guided_sliding_brick_keeps_its_weight_and_falls_off_an_edge(system: str) -> None:
    world = world_of(system, (0.0, 0.0, 0.3))
    passed(world, 0.1, b0=Guided((0.05, 0.0, 0.0), free_W=UP))
    x, _, z = centre(world, "b0")
    assert x == pytest.approx(0.005, abs=1e-5)
    assert z == pytest.approx(0.3 - 0.5 * 9.81 * 0.1**2, abs=in_a_step(world))
    world.close()


def test_a_slid_brick_keeps_its_motion_along_the_free_direction() -> None:
    world = world_of("tuned", (0.0, 0.0, 0.3))
    passed(world, 0.05)
    own = world.states(["b0"])["b0"]
    velocity_W, angular_velocity_W = Guided((0.1, 0.2, 5.0), free_W=UP).motion(own)
    assert velocity_W == pytest.approx((0.1, 0.2, own.velocity_W[2]))
    assert angular_velocity_W == pytest.approx(own.angular_velocity_W)
    world.close()
