"""Steps of the rigid-body engine that are recorded for joined bricks: their mean loads, and how they are taken back."""

import pytest

from stability.engines.rigid.settings import RigidSettings
from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.simulation.systems import SYSTEMS

G = 9.81  # [m/s2]
BLOCK = Box((0.1, 0.1, 0.1))


def recorded_world(**places: tuple[float, float, float]) -> RigidWorld:
    settings = SYSTEMS["exact"].engine
    assert isinstance(settings, RigidSettings)
    world = RigidWorld.opened(settings, G, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    for name, place in places.items():
        world.add_brick(Brick(name, BLOCK, 1.0), Pose(place))
    world.record_steps()
    return world


def test_mean_loads_are_the_contact_forces_on_each_brick_of_a_group() -> None:
    # A pair at rest on one of its bricks: the ground bears both weights there, at half a width from the centre.
    world = recorded_world(low=(0.0, 0.0, 0.05), upper=(0.0, 0.0, 0.15), frozen=(0.3, 0.0, 0.05))
    world.weld(["low", "upper"])
    world.freeze("frozen")
    for _ in range(20):
        world.step()
    (low, loads) = next(iter(world.mean_loads().items()))
    assert (low, len(world.mean_loads())) == ("low", 1)
    assert loads == pytest.approx((0.0, 0.0, 2.0 * G, 0.0, 0.0, 0.0), abs=1e-6)


def test_a_step_that_is_taken_back_is_repeated_bit_for_bit() -> None:
    world = recorded_world(low=(0.0, 0.0, 0.05), upper=(0.02, 0.03, 0.15))
    world.push("upper", (0.3, 0.1, 0.0), (0.02, 0.03, 0.2))
    for _ in range(30):
        world.step()
        states, loads, time = world.states(["low", "upper"]), world.mean_loads(), world.time()
        world.undo_step()
        assert world.states(["low", "upper"]) != states
        world.step()
        assert (world.states(["low", "upper"]), world.mean_loads(), world.time()) == (states, loads, time)


def test_a_push_moves_a_welded_group_as_a_whole() -> None:
    world = recorded_world(a=(0.0, 0.0, 1.0), b=(0.1, 0.0, 1.0))
    world.weld(["a", "b"])
    world.push("a", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    about_middle = 2.0 * (0.1**2 / 6.0 + 0.05**2)
    for name, arm in (("a", -0.05), ("b", 0.05)):
        state = world.states([name])[name]
        assert state.angular_velocity_W == pytest.approx((0.0, 0.0, -0.05 / about_middle))
        assert state.velocity_W == pytest.approx((0.0, 0.5 - 0.05 / about_middle * arm, 0.0))
