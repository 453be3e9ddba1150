"""Solids that are no boxes in every engine: they spin as their inertia says, rest where they are put."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import World
from stability.geometry.box import OffCentreBox
from stability.geometry.placed_shape import inertia_times
from stability.geometry.solid_making import prism, solid_of_corners
from stability.geometry.vectors import about, multiply, norm, scale, turn_between
from stability.model import AT_REST, GROUND, IDENTITY, BodyState, Brick, ConvexShape, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.known_systems import system_named
from tests.engines_at_hand import WITH_RIGID

MASS = 0.2
TETRAHEDRON = solid_of_corners([(0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.01, 0.04, 0.0), (0.02, 0.01, 0.03)])
CARTON = OffCentreBox((0.1, 0.06, 0.03), (0.01, -0.01, 0.004))
ROOF = prism([(0.0, 0.0), (0.1, 0.0), (0.0, 0.05)], 0.06)
Opened = Callable[[float], World]


@pytest.fixture(params=["stock", "tuned", "exact", *WITH_RIGID])
def opened(request: pytest.FixtureRequest) -> Iterator[Opened]:
    """Empty worlds with gravity, of each engine that is installed."""
    worlds: list[World] = []

    def world(gravity: float) -> World:
        system = system_named(request.param)
        if not system.engine.package.installed:
            pytest.skip(f"{system.engine.package.name} is not installed")
        worlds.append(stepped_world(system.engine, gravity, 0.5, heaviest=MASS))
        return worlds[-1]

    yield world
    for each in worlds:
        each.close()


def turned_freely(shape: ConvexShape, angular_velocity: Vec3, duration: float) -> Quaternion:
    """Where a free body has turned to: its angular momentum stays. By the midpoint rule, in small steps."""
    brick, turn, steps = Brick("b", shape, MASS), IDENTITY, 4000
    momentum = np.array(inertia_times(brick, turn, angular_velocity))

    def spin(now: Quaternion) -> Vec3:
        axes: list[Vec3] = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
        x, y, z = np.linalg.solve(np.array([inertia_times(brick, now, axis) for axis in axes]), momentum).tolist()
        return (x, y, z)

    def after(start: Quaternion, velocity: Vec3, time: float) -> Quaternion:
        return multiply(about(scale(1.0 / norm(velocity), velocity), norm(velocity) * time), start)

    for _ in range(steps):
        middle = after(turn, spin(turn), 0.5 * duration / steps)
        turn = after(turn, spin(middle), duration / steps)
    return turn


# `stock` damps spins, and follows wobbling less accurately.
@pytest.mark.parametrize("opened", ["tuned", "exact", *WITH_RIGID], indirect=True)
@pytest.mark.parametrize("shape", [TETRAHEDRON.shape, CARTON], ids=["tetrahedron", "carton"])
def test_a_solid_that_spins_freely_wobbles_as_its_moments_say(shape: ConvexShape, opened: Opened) -> None:
    world, spin, duration = opened(0.0), (3.0, 1.0, -1.5), 0.5
    world.add_brick(Brick("b", shape, MASS), Pose((0.0, 0.0, 1.0)))
    world.set_state("b", BodyState(Pose((0.0, 0.0, 1.0)), AT_REST, spin))
    while world.time() < duration - 1e-9:
        world.step()
    end = world.states(["b"])["b"].pose
    assert norm((end.position_W[0], end.position_W[1], end.position_W[2] - 1.0)) < 1e-6
    wanted = Pose(end.position_W, turned_freely(shape, spin, duration))
    assert turn_between(wanted, Pose(end.position_W)) > 1.0
    assert turn_between(wanted, end) < 0.01 * turn_between(wanted, Pose(end.position_W))


def test_a_solid_stays_where_it_is_set_down(opened: Opened) -> None:
    world = opened(9.81)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    places = {"tetrahedron": (TETRAHEDRON, 0.0), "roof": (ROOF, 0.3)}
    for name, (made, x) in places.items():
        a, b, c = made.centre_of_mass
        world.add_brick(Brick(name, made.shape, MASS), Pose((x + a, b, c)))
    while world.time() < 0.5:
        world.step()
    for name, (made, x) in places.items():
        a, b, c = made.centre_of_mass
        end = world.states([name])[name].pose
        assert end.position_W == pytest.approx((x + a, b, c), abs=1e-3)
        assert turn_between(end, Pose(end.position_W)) < 0.03


def test_the_shape_and_the_neighbours_of_a_solid_are_known(opened: Opened) -> None:
    world = opened(9.81)
    world.add_brick(Brick("roof", ROOF.shape, MASS), Pose((0.0, 0.0, 1.0)))
    world.add_brick(Brick("near", CARTON, MASS), Pose((0.0, 0.09, 1.0)))
    world.add_brick(Brick("far", CARTON, MASS), Pose((0.0, 0.5, 1.0)))
    assert world.shape("roof") == ROOF.shape
    assert list(world.neighbours("roof", 0.045)) == ["near"]


@pytest.mark.parametrize("name", ["exact", "mujoco"])
def test_joined_solids_fall_as_one(name: str) -> None:
    system = system_named(name)
    if not system.engine.package.installed:
        pytest.skip(f"{system.engine.package.name} is not installed")
    world = stepped_world(system.engine, 9.81, 0.5, heaviest=MASS)
    a, b, c = ROOF.centre_of_mass
    world.add_brick(Brick("roof", ROOF.shape, MASS), Pose((a, b, 1.0 + c)))
    world.add_brick(Brick("carton", CARTON, MASS), Pose((0.06, 0.0, 0.98)))
    world.weld(["roof", "carton"])
    starts = {"roof": (a, b, 1.0 + c), "carton": (0.06, 0.0, 0.98)}
    before = world.states(["roof", "carton"])
    for brick, state in before.items():
        assert state.pose.position_W == pytest.approx(starts[brick], abs=1e-6)
    while world.time() < 0.2:
        world.step()
    after = world.states(["roof", "carton"])
    for brick, state in after.items():
        assert before[brick].pose.position_W[2] - state.pose.position_W[2] == pytest.approx(0.5 * 9.81 * 0.04, rel=0.03)
        assert turn_between(before[brick].pose, state.pose) < 1e-3
    world.close()
