"""PyBullet adapter against closed forms, in scene units, at any scale."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import cos, radians, sin

import pybullet
import pytest

from stability import UnknownShapeWarning
from stability.engines.pybullet import PyBulletBodies, PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.model import GROUND, BodyState, Brick, Plane, Pose
from stability.stabilizers.published.stabilizer import StackStability

SIZE = (0.1176, 0.0234, 0.0078)
SETTINGS = PyBulletSettings(time_step=1.0 / 960.0, iterations=50, contact_erp=0.2, breaking_threshold=0.001)
SCALES = pytest.mark.parametrize("scale", [1.0, 100.0])


@contextmanager
def world(scale: float = 1.0, friction: float = 0.5, tilt: float = 0.0) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(replace(SETTINGS, scale=scale), gravity=9.81, friction=friction)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (sin(tilt), 0.0, cos(tilt)), friction))
        yield opened
    finally:
        opened.close()


def plank(name: str = "plank") -> Brick:
    return Brick(name, Box(SIZE), 0.012)


@SCALES
def test_free_fall_covers_half_g_t_squared(scale: float) -> None:
    with world(scale) as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0)))
        for _ in range(96):
            engine.step()
        state = engine.states(["plank"])["plank"]
        # The engine's semi-implicit Euler step falls g t dt / 2 further than the parabola.
        t, dt = 0.1, SETTINGS.time_step
        assert 1.0 - state.pose.position_W[2] == pytest.approx(9.81 * t * (t + dt) / 2.0, rel=1e-6)
        assert state.velocity_W[2] == pytest.approx(-0.981, rel=1e-6)


@SCALES
def test_a_plank_set_down_flush_touches_with_its_four_corners_and_presses_with_its_weight(scale: float) -> None:
    with world(scale) as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, SIZE[2] / 2.0)))
        for _ in range(20):
            engine.step()
        points = engine.contacts("plank")
        corners = {(round(p.position_W[0], 4), round(p.position_W[1], 4)) for p in points}
        assert corners == {(x, y) for x in (-0.0588, 0.0588) for y in (-0.0117, 0.0117)}
        assert all(p.normal_BA_W[2] * (1.0 if p.a == "plank" else -1.0) > 0.999 for p in points)
        assert sum(p.normal_force for p in points) == pytest.approx(0.012 * 9.81, rel=0.01)


@SCALES
@pytest.mark.parametrize(("angle", "slides"), [(24.0, False), (29.0, True)])
def test_a_plank_slides_on_a_slope_steeper_than_the_angle_of_friction(scale: float, angle: float, slides: bool) -> None:
    #   atan(0.5) = 26.57 deg: pair friction is the requested one, not its square
    tilt = radians(angle)
    with world(scale, friction=0.5, tilt=tilt) as engine:
        engine.add_brick(
            plank(), Pose((0.0039 * sin(tilt), 0.0, 0.0039 * cos(tilt)), (0.0, sin(tilt / 2), 0.0, cos(tilt / 2)))
        )
        for _ in range(480):
            engine.step()
        speed = engine.states(["plank"])["plank"].velocity_W[0]
        assert (speed > 0.05) is slides


@SCALES
@pytest.mark.parametrize("order", [("lower", "upper"), ("upper", "lower")])
@pytest.mark.parametrize("asked", ["lower", "upper"])
def test_friction_of_a_sliding_brick_opposes_its_motion_from_both_bodies(
    scale: float, order: tuple[str, str], asked: str
) -> None:
    with world(scale) as engine:
        for name in order:
            engine.add_brick(plank(name), Pose((0.0, 0.0, SIZE[2] * (0.5 if name == "lower" else 1.5))))
        engine.freeze("lower")
        for _ in range(20):
            engine.step()
        pose = engine.states(["upper"])["upper"].pose
        engine.set_state("upper", BodyState(pose, (0.2, 0.0, 0.0)))
        for _ in range(5):
            engine.step()
        between = [p for p in engine.contacts(asked) if {p.a, p.b} == {"lower", "upper"}]
        on_upper = sum((1.0 if p.a == "upper" else -1.0) * p.friction_W[0] for p in between)
        assert on_upper == pytest.approx(-0.5 * 0.012 * 9.81, rel=0.1)


def test_a_frozen_brick_stays_exactly_where_it_is_and_a_woken_one_falls_with_its_mass() -> None:
    with world() as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0)))
        for _ in range(50):
            engine.step()
        engine.freeze("plank")
        before = engine.states(["plank"])["plank"]
        for _ in range(50):
            engine.step()
        assert engine.states(["plank"])["plank"] == before
        assert before.velocity_W == (0.0, 0.0, 0.0)
        engine.wake("plank")
        engine.step()
        assert engine.states(["plank"])["plank"].velocity_W[2] == pytest.approx(-9.81 * SETTINGS.time_step)
        assert pybullet.getDynamicsInfo(engine.bodies.numbers["plank"], -1, engine.bodies.client)[0] == pytest.approx(
            0.012
        )


def test_what_stood_on_a_brick_that_is_taken_out_falls_to_the_ground() -> None:
    with world() as engine:
        for level, name in enumerate(["lower", "upper"]):
            engine.add_brick(plank(name), Pose((0.0, 0.0, (level + 0.5) * SIZE[2])))
        engine.freeze("lower")
        engine.remove_brick("lower")
        for _ in range(240):
            engine.step()
        assert set(engine.masses()) == {"upper"}
        assert engine.states(["upper"])["upper"].pose.position_W[2] == pytest.approx(0.5 * SIZE[2], abs=1e-4)


def test_a_brick_of_the_same_name_as_one_that_was_taken_out_is_another_one() -> None:
    with world() as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 0.5 * SIZE[2])))
        assert dict(engine.masses()) == {"plank": pytest.approx(0.012)}
        engine.remove_brick("plank")
        engine.add_brick(Brick("plank", Box((0.05, 0.05, 0.05)), 1.0), Pose((0.0, 0.0, 0.025)))
        assert dict(engine.masses()) == {"plank": pytest.approx(1.0)}
        shape = engine.shape("plank")
        assert isinstance(shape, Box)
        assert shape.size == pytest.approx((0.05, 0.05, 0.05))


def test_no_setting_leaks_from_one_world_to_the_next() -> None:
    def settled(before: PyBulletSettings | None) -> tuple[float, ...]:
        if before is not None:
            PyBulletWorld.opened(before, gravity=1.0, friction=0.1).close()
        with world() as engine:
            for level in range(4):
                engine.add_brick(plank(f"{level}"), Pose((0.02 * level, 0.0, SIZE[2] * (level + 0.5))))
            for _ in range(200):
                engine.step()
            return engine.states(["3"])["3"].pose.position_W

    wild = replace(
        SETTINGS, breaking_threshold=0.05, iterations=2, contact_erp=0.9, time_step=0.1, friction_anchor=True
    )
    assert settled(before=wild) == settled(before=None)


@contextmanager
def client_of_somebody() -> Iterator[int]:
    """A PyBullet client with a box for a table, number 0, its top at z = 0."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, client)
        table = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[1, 1, 1], physicsClientId=client)
        pybullet.createMultiBody(0.0, table, basePosition=[0, 0, -1], physicsClientId=client)
        yield client
    finally:
        pybullet.disconnect(client)


def box(client: int, *position: float) -> int:
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.3, 0.1, 0.05], physicsClientId=client)
    return int(pybullet.createMultiBody(1.0, shape, basePosition=position, physicsClientId=client))


def stacked(client: int) -> tuple[PyBulletBodies, StackStability]:
    """Three boxes on the table, set down one by one, each noticed by itself."""
    bodies = PyBulletBodies(client)
    stability = StackStability(bodies)
    for level in range(3):
        box(client, 0.0, 0.0, 0.05 + 0.1 * level)
        played(bodies, stability, 60)
    assert stability.awake() == []
    return bodies, stability


def played(bodies: PyBulletBodies, stability: StackStability, steps: int) -> list[str]:
    woken: list[str] = []
    for _ in range(steps):
        bodies.step()
        woken += stability.update().woken
    return woken


def test_the_stabilizer_freezes_bricks_of_a_foreign_client() -> None:
    with client_of_somebody() as client:
        _, stability = stacked(client)
        assert sorted(stability.stack) == ["1", "2", "3"]
        assert stability.least_margin() == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize("body", [0, 1])
def test_bricks_fall_when_their_support_is_removed(body: int) -> None:
    with client_of_somebody() as client:
        bodies, stability = stacked(client)
        pybullet.removeBody(body, client)
        played(bodies, stability, 60)
        assert bodies.states(["3"])["3"].pose.position_W[2] < 0.24


def test_a_frozen_brick_that_is_given_a_velocity_flies_off_with_it() -> None:
    with client_of_somebody() as client:
        bodies, stability = stacked(client)
        pybullet.resetBaseVelocity(3, [0, 2, 0], physicsClientId=client)
        assert played(bodies, stability, 60) == ["3"]
        assert bodies.states(["3"])["3"].pose.position_W[1] > 0.2


def test_a_robot_is_neither_frozen_nor_stood_upon() -> None:
    with client_of_somebody() as client:
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.3, 0.3, 0.05], physicsClientId=client)
        robot = pybullet.createMultiBody(
            5.0,
            shape,
            basePosition=[0, 0, 0.05],
            linkMasses=[1.0],
            linkCollisionShapeIndices=[shape],
            linkVisualShapeIndices=[-1],
            linkPositions=[[0, 0, 0.1]],
            linkOrientations=[[0, 0, 0, 1]],
            linkInertialFramePositions=[[0, 0, 0]],
            linkInertialFrameOrientations=[[0, 0, 0, 1]],
            linkParentIndices=[0],
            linkJointTypes=[pybullet.JOINT_FIXED],
            linkJointAxis=[[0, 0, 1]],
            physicsClientId=client,
        )
        box(client, 0.0, 0.0, 0.25)
        bodies = PyBulletBodies(client)
        stability = StackStability(bodies)
        played(bodies, stability, 240)
        assert stability.stack == {}
        assert pybullet.getDynamicsInfo(robot, -1, client)[0] == 5.0


def test_only_the_named_bodies_are_bricks() -> None:
    with client_of_somebody() as client:
        one, other = box(client, 0.0, 0.0, 0.05), box(client, 0.0, 0.5, 0.05)
        bodies = PyBulletBodies(client, only={one})
        stability = StackStability(bodies)
        played(bodies, stability, 60)
        assert list(stability.stack) == [str(one)]
        assert pybullet.getDynamicsInfo(other, -1, client)[0] == 1.0


def test_another_body_under_the_number_of_a_frozen_one_is_not_taken_for_it() -> None:
    with client_of_somebody() as client:
        bodies, stability = stacked(client)
        pybullet.removeBody(3, client)
        assert box(client, 0.0, 0.0, 1.0) == 3  # PyBullet gives the number again
        played(bodies, stability, 10)
        assert "3" not in stability.stack
        assert bodies.states(["3"])["3"].velocity_W[2] < 0.0
        played(bodies, stability, 240)
        assert "3" in stability.stack


def test_taking_a_counterweight_away_wakes_the_beam_that_it_held() -> None:
    with client_of_somebody() as client:
        bodies = PyBulletBodies(client)
        stability = StackStability(bodies)
        cube = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.05] * 3, physicsClientId=client)
        pybullet.createMultiBody(1.0, cube, basePosition=[0, 0, 0.05], physicsClientId=client)
        box(client, 0.0, 0.0, 0.15)
        weight = pybullet.createMultiBody(1.0, cube, basePosition=[-0.08, 0, 0.25], physicsClientId=client)
        played(bodies, stability, 60)
        pybullet.createMultiBody(1.0, cube, basePosition=[0.2, 0, 0.25], physicsClientId=client)
        played(bodies, stability, 60)
        assert stability.awake() == []
        pybullet.removeBody(weight, client)
        assert played(bodies, stability, 1) == ["1", "2", "4"]  # the post under it would tip as well


def test_a_stack_on_a_plane_without_end_stands_on_its_whole_under_side() -> None:
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        pybullet.createMultiBody(0.0, plane, physicsClientId=client)
        _, stability = stacked(client)
        assert stability.least_margin() == pytest.approx(0.1, abs=1e-4)
    finally:
        pybullet.disconnect(client)


def test_a_box_turned_within_its_body_is_left_to_the_engines_contact_points() -> None:
    with client_of_somebody() as client:
        turned = pybullet.createCollisionShape(
            pybullet.GEOM_BOX,
            halfExtents=[0.3, 0.1, 0.05],
            collisionFrameOrientation=[0, 0, 0.7071067811865476, 0.7071067811865476],
            physicsClientId=client,
        )
        pybullet.createMultiBody(0.0, turned, basePosition=[0, 0, 0.05], physicsClientId=client)
        box(client, 0.2, 0.0, 0.15)  # its centre is 0.1 m beyond the support, which reaches to x = 0.1 m
        bodies = PyBulletBodies(client)
        stability = StackStability(bodies)
        with pytest.warns(UnknownShapeWarning, match="fixed body '1': a GEOM_BOX rotated"):
            played(bodies, stability, 60)
        assert stability.stack == {} or bodies.states(["2"])["2"].pose.position_W[2] < 0.14


@SCALES
@pytest.mark.parametrize("mass", [1e-6, 0.012, 1e9])
def test_bricks_of_any_mass_stand_on_the_ground(scale: float, mass: float) -> None:
    settings = replace(SETTINGS, scale=scale)
    engine = PyBulletWorld.opened(settings, gravity=9.81, friction=0.5, heaviest=mass)
    try:
        engine.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
        engine.add_brick(Brick("brick", Box(SIZE), mass), Pose((0.0, 0.0, SIZE[2] / 2.0)))
        for _ in range(200):
            engine.step()
        assert engine.states(["brick"])["brick"].pose.position_W[2] == pytest.approx(SIZE[2] / 2.0, abs=1e-4)
        assert engine.masses()["brick"] == pytest.approx(mass)
    finally:
        engine.close()


@SCALES
def test_a_plank_held_out_too_far_tips_over_the_edge_of_its_support(scale: float) -> None:
    #   Centre 21.2 mm beyond the edge: it starts to turn with alpha = g e / (L^2 / 12 + t^2 / 3 + e^2), no slip yet.
    with world(scale) as engine:
        engine.add_brick(plank("low"), Pose((0.0, 0.0, SIZE[2] / 2.0)))
        engine.add_brick(plank("high"), Pose((0.08, 0.0, SIZE[2] * 1.5)))
        for _ in range(20):
            engine.step()
        beyond, length, thickness = 0.08 - SIZE[0] / 2.0, SIZE[0], SIZE[2]
        alpha = 9.81 * beyond / (length**2 / 12.0 + thickness**2 / 3.0 + beyond**2)
        turning = engine.states(["high"])["high"].angular_velocity_W[1]
        assert turning == pytest.approx(alpha * 20 * SETTINGS.time_step, rel=0.05)
