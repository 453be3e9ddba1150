"""Bricks of several parts on the rigid-body engine: closed forms of free, sliding and toppling bodies."""

import numpy as np
import pytest

from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.geometry.compound_making import FramedCompound
from stability.geometry.vectors import add, body_axes, norm
from stability.model import AT_REST, GROUND, BodyState, Brick, Plane, Pose, Vec3
from stackdsl.simulation.systems import RIGID
from tests.stability.statics.compounds import boxes
from tests.stability.statics.test_compounds import ANGLE, HOLLOW, SADDLE, TABLE

GRAVITY = 9.81


def world_with(made: FramedCompound, origin: Vec3, friction: float = 0.5, velocity: Vec3 = AT_REST) -> RigidWorld:
    world = RigidWorld.opened(RIGID, GRAVITY, friction)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction))
    world.add_brick(Brick("body", made.shape, 1.0), Pose(add(origin, made.centre_of_mass)), velocity)
    return world


def body(world: RigidWorld) -> BodyState:
    return world.states(["body"])["body"]


@pytest.mark.parametrize("made", [HOLLOW, TABLE, SADDLE])
def test_a_body_of_several_parts_slides_as_far_as_its_friction_lets_it(made: FramedCompound) -> None:
    low = -min(corner[2] for corner in made.shape.corners) - made.centre_of_mass[2]
    world = world_with(made, (0.0, 0.0, low), 0.2, (0.0, 0.5, 0.0))
    for _ in range(300):
        world.step()
    way = body(world).pose.position_W[1] - made.centre_of_mass[1]
    assert way == pytest.approx(0.5**2 / (2.0 * 0.2 * GRAVITY), rel=0.02)
    assert norm(body(world).velocity_W) < 1e-3


def test_an_angle_in_free_flight_keeps_its_angular_momentum() -> None:
    spin: Vec3 = (3.0, 2.0, 1.0)
    world = world_with(ANGLE, (0.0, 0.0, 5.0))
    place = body(world).pose
    world.set_state("body", BodyState(place, AT_REST, spin))
    inertia = np.diag(ANGLE.shape.moments(1.0))
    axes = np.array(body_axes(ANGLE.shape.principal_axes)).T

    def momentum() -> list[float]:
        state = body(world)
        turn = np.array(body_axes(state.pose.orientation)).T @ axes
        return (turn @ inertia @ turn.T @ np.array(state.angular_velocity_W)).tolist()  # type: ignore[no-any-return]

    before = momentum()
    for _ in range(200):
        world.step()
    assert momentum() == pytest.approx(before, rel=0.01)
    assert body(world).pose.position_W[2] == pytest.approx(place.position_W[2] - 0.5 * GRAVITY * 0.2**2, rel=1e-3)


def test_a_box_cut_in_two_slides_and_tips_as_the_whole_box() -> None:
    size = (0.06, 0.05, 0.12)
    halves = boxes(((0.03, 0.05, 0.12), (-0.015, 0.0, 0.0)), ((0.03, 0.05, 0.12), (0.015, 0.0, 0.0)))
    ends = []
    for shape in (halves.shape, Box(size)):
        world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
        world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.9))
        world.add_brick(Brick("body", shape, 1.0), Pose((0.0, 0.0, 0.06)))
        world.push("body", (0.4, 0.0, 0.0), (0.0, 0.0, 0.1))
        for _ in range(150):
            world.step()
        ends.append(body(world).pose.position_W)
    assert ends[0] == pytest.approx(ends[1], abs=2e-4)


def test_a_bar_lies_across_the_walls_of_a_hollow_block_and_is_held_at_both() -> None:
    world = world_with(HOLLOW, (0.0, 0.0, 0.0))
    world.add_brick(Brick("bar", Box((0.05, 0.3, 0.02)), 0.2), Pose((0.09, 0.0, 0.21)))
    for _ in range(100):
        world.step()
    assert world.states(["bar"])["bar"].pose.position_W == pytest.approx((0.09, 0.0, 0.21), abs=1e-4)
    assert {point.a if point.b == "bar" else point.b for point in world.contacts("bar")} == {"body"}
    assert set(world.neighbours("bar", 0.001)) == {"body"}
