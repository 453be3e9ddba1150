"""Steps of the rigid-body engine for joined bricks: their mean loads, how they are taken back, and links."""

import pytest

from stability.contact_law import MohrCoulomb
from stability.engines.protocol import Link
from stability.engines.rigid.settings import RigidSettings
from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.simulation.systems import SYSTEMS

G = 9.81  # [m/s2]
BLOCK = Box((0.1, 0.1, 0.1))


def recorded_world(friction: float = 0.5, **places: tuple[float, float, float]) -> RigidWorld:
    settings = SYSTEMS["exact"].engine
    assert isinstance(settings, RigidSettings)
    world = RigidWorld.opened(settings, G, friction)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction))
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


# Links. Each has a quarter of the strength of a joint, and lies at a corner of the face that it holds.

CORNERS = [(x, y) for x in (-0.05, 0.05) for y in (-0.05, 0.05)]


def hanging_on(law: MohrCoulomb) -> RigidWorld:
    world = recorded_world(top=(0.0, 0.0, 1.1), hanging=(0.0, 0.0, 1.0))
    world.freeze("top")
    world.link([Link("top", "hanging", (x, y, -0.05), (x, y, 0.05), (0.0, 0.0, -1.0), law) for x, y in CORNERS])
    return world


def test_a_block_that_hangs_on_less_than_its_weight_accelerates_with_the_difference() -> None:
    world = hanging_on(MohrCoulomb(0.5, 0.25 * G / 1.2, 100.0))
    for step in range(1, 101):
        world.step()
        assert world.mean_loads()["top"][2] == pytest.approx(-G / 1.2, rel=1e-6), step
    time, acceleration = world.time(), G * (1.0 - 1.0 / 1.2)
    state = world.states(["hanging"])["hanging"]
    assert state.velocity_W == pytest.approx((0.0, 0.0, -acceleration * time), abs=1e-9)
    assert state.pose.position_W == pytest.approx((0.0, 0.0, 1.0 - 0.5 * acceleration * time * time), abs=1e-9)


def test_a_block_that_hangs_on_more_than_its_weight_stays() -> None:
    world = hanging_on(MohrCoulomb(0.5, 0.25 * G * 1.001, 100.0))
    for _ in range(100):
        world.step()
    assert world.states(["hanging"])["hanging"].pose.position_W == pytest.approx((0.0, 0.0, 1.0), abs=1e-7)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_block_that_is_pushed_on_links_is_slowed_by_cohesion_and_friction(friction: float) -> None:
    world = recorded_world(friction=friction, block=(0.0, 0.0, 0.05))
    law = MohrCoulomb(friction, 1.0, 0.5)
    world.link([Link(GROUND, "block", (x, y, 0.0), (x, y, -0.05), (0.0, 0.0, 1.0), law) for x, y in CORNERS])
    world.push("block", (0.5, 0.0, 0.0), (0.0, 0.0, 0.05))
    deceleration = 2.0 + friction * G
    for _ in range(100):
        world.step()
        time = world.time()
        state = world.states(["block"])["block"]
        assert state.velocity_W[0] == pytest.approx(0.5 - deceleration * time, abs=2e-3)
    for _ in range(400):
        world.step()
    # The links hold the foot of the block back, so that it tips a little and comes back.
    assert world.states(["block"])["block"].pose.position_W[0] == pytest.approx(0.5**2 / 2.0 / deceleration, rel=5e-3)


def test_links_pass_on_their_strength_for_a_whole_step_wherever_the_hit_is_in_it() -> None:
    # A shot hits the upper one of two smooth blocks in the air, in different sub-steps.
    law = MohrCoulomb(0.0, 1000.0, 5.0)
    for share in (0.05, 0.5, 0.95):
        world = recorded_world(friction=0.0, upper=(0.0, 0.0, 1.0), low=(0.0, 0.0, 0.9))
        world.link([Link("low", "upper", (x, y, 0.05), (x, y, -0.05), (0.0, 0.0, 1.0), law) for x, y in CORNERS])
        ahead = 0.1 + share * 2.0 * world.hit_duration()
        world.add_brick(Brick("shot", BLOCK, 1.0), Pose((-ahead, 0.0, 1.02)), (2.0, 0.0, 0.0))
        world.set_max_speed(2.0)
        world.step()
        assert world.mean_loads()["low"][0] == pytest.approx(20.0, rel=1e-3)


def test_a_step_with_links_is_repeated_bit_for_bit() -> None:
    world = recorded_world(low=(0.0, 0.0, 0.05), upper=(0.0, 0.0, 0.15))
    law = MohrCoulomb(0.5, 3.0, 2.0)
    world.link([Link("low", "upper", (x, y, 0.05), (x, y, -0.05), (0.0, 0.0, 1.0), law) for x, y in CORNERS])
    world.push("upper", (0.3, 0.1, 0.0), (0.0, 0.0, 0.2))
    for _ in range(20):
        world.step()
        states, loads = world.states(["low", "upper"]), world.mean_loads()
        world.undo_step()
        world.step()
        assert (world.states(["low", "upper"]), world.mean_loads()) == (states, loads)
