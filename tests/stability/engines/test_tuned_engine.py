"""Motion in the engine of `tuned` and of the moving part of `exact`, against closed forms."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import atan, cos, hypot, pi, radians, sin, sqrt

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.geometry.vectors import body_axes, dot
from stability.model import GROUND, BodyState, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.systems import MOVING, TUNED

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS, GRAVITY, FRICTION = 0.012, 9.81, 0.5
BOTH = pytest.mark.parametrize("settings", [TUNED, MOVING], ids=["tuned", "exact"])
ALONG: Quaternion = (0.0, 0.0, 0.0, 1.0)
ACROSS: Quaternion = (0.0, 0.0, sqrt(0.5), sqrt(0.5))  # turned by 90 deg about z
FLAT_ON: Quaternion = (0.0, sqrt(0.5), 0.0, sqrt(0.5))  # about y


@contextmanager
def world(settings: PyBulletSettings, heaviest: float = MASS) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(settings, GRAVITY, FRICTION, heaviest)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION))
        yield opened
    finally:
        opened.close()


def played(engine: PyBulletWorld, seconds: float, fastest: float = 0.0) -> Mapping[str, BodyState]:
    engine.set_max_speed(fastest)
    for _ in range(round(seconds / engine.settings.time_step)):
        engine.step()
    return engine.states(engine.masses())


@BOTH
@pytest.mark.parametrize("bearing", [0.0, 20.0, 45.0])
def test_a_plank_slides_as_far_in_every_direction(settings: PyBulletSettings, bearing: float) -> None:
    speed, way = 2.0, radians(bearing)
    with world(settings) as engine:
        velocity_W = (speed * cos(way), speed * sin(way), 0.0)
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS / 2.0)), velocity_W)
        x, y, _ = played(engine, 0.5, speed)["plank"].pose.position_W
    assert hypot(x, y) == pytest.approx(speed**2 / (2.0 * FRICTION * GRAVITY), rel=0.01)


@pytest.mark.parametrize("settings", [TUNED, pytest.param(MOVING, marks=pytest.mark.slow)], ids=["tuned", "exact"])
@pytest.mark.parametrize("speed", [10.0, pytest.param(15.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("start", [pytest.param((0.0, 0.0), marks=pytest.mark.slow), (-1000.0, 300.0)])
def test_the_ground_goes_on_where_a_plank_slides_to(
    settings: PyBulletSettings, start: tuple[float, float], speed: float
) -> None:
    #   It stops after v^2 / (2 mu g) = 10 m or 23 m; the box that stands for the ground reaches 5 m at first.
    with world(settings) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((*start, THICKNESS / 2.0)), (speed, 0.0, 0.0))
        x, _, z = played(engine, 1.1 * speed / (FRICTION * GRAVITY), speed)["plank"].pose.position_W
    assert x - start[0] == pytest.approx(speed**2 / (2.0 * FRICTION * GRAVITY), rel=0.01)
    assert z == pytest.approx(THICKNESS / 2.0, abs=1e-4)


@BOTH
@pytest.mark.parametrize("seconds", [0.1, 0.25, 1.0])
def test_way_and_speed_of_a_fall_are_exact(settings: PyBulletSettings, seconds: float) -> None:
    with world(settings) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, 50.0)))
        state = played(engine, seconds)["plank"]
        seconds = engine.time()
    assert 50.0 - state.pose.position_W[2] == pytest.approx(GRAVITY * seconds**2 / 2.0, rel=1e-6)
    assert -state.velocity_W[2] == pytest.approx(GRAVITY * seconds, rel=1e-6)


def test_a_fall_stays_exact_when_steps_are_split_on_the_way() -> None:
    with world(TUNED) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, 50.0)))
        played(engine, 0.3)
        played(engine, 0.3, fastest=20.0)
        state = played(engine, 0.3)["plank"]
        seconds = engine.time()
    assert 50.0 - state.pose.position_W[2] == pytest.approx(GRAVITY * seconds**2 / 2.0, rel=1e-6)


@BOTH
@pytest.mark.parametrize("gap", [0.0100, 0.0103, 0.0105, 0.0107])  # the step in which they meet begins anywhere
@pytest.mark.parametrize(("turn", "side"), [(ALONG, LENGTH), (ACROSS, WIDTH), (FLAT_ON, THICKNESS)])
def test_a_plank_that_hits_another_squarely_shares_its_speed(
    settings: PyBulletSettings, turn: Quaternion, side: float, gap: float
) -> None:
    #   |--a--| ->  |--b--|    restitution 0: both go on with half the speed
    speed = 2.0
    with world(settings) as engine:
        engine.add_brick(Brick("a", Box(SIZE), MASS), Pose((-side - gap, 0.0, 5.0), turn), (speed, 0.0, 0.0))
        engine.add_brick(Brick("b", Box(SIZE), MASS), Pose((0.0, 0.0, 5.0), turn))
        after = played(engine, 0.02, speed)
    assert [state.velocity_W[0] for state in after.values()] == pytest.approx([speed / 2.0] * 2, rel=1e-3)


def energy_of_turning(state: BodyState) -> float:
    turning = (dot(state.angular_velocity_W, axis_W) for axis_W in body_axes(state.pose.orientation))
    return 0.5 * sum(moment * rate**2 for moment, rate in zip(Box(SIZE).moments(MASS), turning, strict=True))


@BOTH
def test_a_plank_that_tumbles_gains_no_energy_and_loses_little(settings: PyBulletSettings) -> None:
    rate = 10.0 / sqrt(3.0)  # [rad/s] about each axis
    with world(settings) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, 50.0)))
        engine.bodies.set_motion("plank", (0.0, 0.0, 0.0), (rate, rate, rate))
        before = energy_of_turning(engine.states(["plank"])["plank"])
        after = energy_of_turning(played(engine, 1.0)["plank"])
    assert 0.97 * before < after <= before * (1.0 + 1e-9)


@BOTH
def test_five_planks_hold_one_of_a_thousand_times_their_mass(settings: PyBulletSettings) -> None:
    with world(settings, heaviest=1000.0 * MASS) as engine:
        for level in range(5):
            engine.add_brick(Brick(f"light {level}", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS * (level + 0.5))))
        engine.add_brick(Brick("heavy", Box(SIZE), 1000.0 * MASS), Pose((0.0, 0.0, 5.5 * THICKNESS)))
        after = played(engine, 0.5)["heavy"].pose.position_W
    assert after == pytest.approx((0.0, 0.0, 5.5 * THICKNESS), abs=0.03 * THICKNESS)


@pytest.mark.parametrize(("share", "holds"), [(0.98, True), (1.05, False)])
@pytest.mark.parametrize("bearing", [0.0, 30.0, 45.0])
def test_anchors_hold_no_plank_on_a_slope_that_is_too_steep(share: float, holds: bool, bearing: float) -> None:
    slope, way = atan(share * FRICTION), radians(bearing)
    normal_W: Vec3 = (sin(slope) * cos(way), sin(slope) * sin(way), cos(slope))
    opened = PyBulletWorld.opened(TUNED, GRAVITY, FRICTION, MASS)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), normal_W, FRICTION))
        half = (slope / 2.0, way)
        turn = (-sin(half[0]) * sin(way), sin(half[0]) * cos(way), 0.0, cos(half[0]))
        x, y, z = (THICKNESS / 2.0 * part for part in normal_W)
        opened.add_brick(Brick("plank", Box(SIZE), MASS), Pose((x, y, z), turn))
        moved_to = played(opened, 1.0)["plank"].pose.position_W
    finally:
        opened.close()
    due = 0.5 * GRAVITY * (sin(slope) - FRICTION * cos(slope))
    gone = hypot(moved_to[0] - x, moved_to[1] - y, moved_to[2] - z)
    assert gone < 1e-4 if holds else gone == pytest.approx(due, rel=0.15)


def test_a_tower_of_ten_levels_creeps_by_less_than_a_twentieth_of_a_millimetre() -> None:
    offset = (LENGTH - WIDTH) / 2.0
    with world(TUNED) as engine:
        for index in range(20):
            level, side = index // 2, offset if index % 2 else -offset
            height = THICKNESS * (level + 0.5)
            pose = Pose((side, 0.0, height), ACROSS) if level % 2 else Pose((0.0, side, height))
            engine.add_brick(Brick(f"{index:02}", Box(SIZE), MASS), pose)
        before = engine.states(engine.masses())
        after = played(engine, 1.0)
    shifts = [
        hypot(*(a - b for a, b in zip(after[n].pose.position_W[:2], before[n].pose.position_W[:2], strict=True)))
        for n in before
    ]
    assert max(shifts) < 5e-5


@BOTH
def test_a_frozen_brick_gets_its_mass_and_moments_back(settings: PyBulletSettings) -> None:
    with world(settings) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, 1.0), (0.0, sin(pi / 12), 0.0, cos(pi / 12))))
        engine.freeze("plank")
        engine.wake("plank")
        engine.push("plank", (0.0, 0.0, 0.001), (LENGTH / 2.0, 0.0, 1.0))
        state = engine.states(["plank"])["plank"]
        after = played(engine, 0.1)["plank"]
    assert state.velocity_W[2] == pytest.approx(0.001 / MASS)
    assert energy_of_turning(after) == pytest.approx(energy_of_turning(state), rel=0.01)
