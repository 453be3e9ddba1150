"""Adapters of peers against closed forms, for each engine that is installed."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from math import cos, radians, sin
from typing import TypeAlias

import pytest

from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import World
from stability.engines.rigid.settings import RigidSettings
from stability.geometry.box import Box
from stability.geometry.vectors import add, cross, subtract
from stability.model import GROUND, Brick, HalfSpace, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.known_systems import missing, system_named
from tests.engines_at_hand import WITH_RIGID

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS = 0.012
WEIGHT = 9.81 * MASS
MANY = 200
CROSSED: Quaternion = (0.0, 0.0, 0.5**0.5, 0.5**0.5)
BARE = ["mujoco-stiff", *WITH_RIGID]
# Other engines need not join bricks, nor tell of friction.
MUJOCO_ALONE = pytest.mark.parametrize("opened", ["mujoco", "mujoco-stiff"], indirect=True)
Opened: TypeAlias = Callable[..., AbstractContextManager[World]]


@pytest.fixture(params=BARE)
def opened(request: pytest.FixtureRequest) -> Opened:
    """A way to open worlds of a peer, with a ground at z = 0 that may be tilted."""
    for _, package in missing([request.param]):
        pytest.skip(f"{package.name} is not installed")

    @contextmanager
    def world(
        gravity: float = 9.81, friction: float = 0.5, of_ground: float | None = None, tilt: float = 0.0
    ) -> Iterator[World]:
        engine = stepped_world(system_named(request.param).engine, gravity, friction, heaviest=MASS)
        of_ground = friction if of_ground is None else of_ground
        try:
            engine.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (sin(tilt), 0.0, cos(tilt)), of_ground))
            yield engine
        finally:
            engine.close()

    return world


def plank(name: str = "plank") -> Brick:
    return Brick(name, Box(SIZE), MASS)


def play(engine: World, duration: float) -> int:
    """Let time pass; returns in how many steps."""
    steps = round(duration / engine.settings.time_step)
    for _ in range(steps):
        engine.step()
    return steps


def column(engine: World, *names: str) -> None:
    for level, name in enumerate(names):
        engine.add_brick(plank(name), Pose((0.0, 0.0, THICKNESS * (level + 0.5))))


def position(engine: World, brick: str) -> Vec3:
    return engine.states([brick])[brick].pose.position_W


def force_on(engine: World, brick: str) -> Vec3:
    """All that contacts do to a brick [N]."""
    x, y, z = 0.0, 0.0, 0.0
    for point in engine.contacts(brick):
        sign = 1.0 if point.a == brick else -1.0
        normal, friction = point.normal_BA_W, point.friction_W
        x += sign * (point.normal_force * normal[0] + friction[0])
        y += sign * (point.normal_force * normal[1] + friction[1])
        z += sign * (point.normal_force * normal[2] + friction[2])
    return (x, y, z)


def test_free_fall_covers_half_g_t_squared(opened: Opened) -> None:
    with opened() as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0)))
        t = play(engine, 0.1) * engine.settings.time_step
        # A semi-implicit Euler step falls g t dt / 2 further than the parabola; `rigid` follows the parabola.
        further = 0.0 if isinstance(engine.settings, RigidSettings) else engine.settings.time_step
        fallen = 1.0 - position(engine, "plank")[2]
        assert fallen == pytest.approx(9.81 * t * (t + further) / 2.0, rel=1e-5)
        assert engine.time() == pytest.approx(t)


def test_fast_bodies_split_steps_to_limit_their_travel(opened: Opened) -> None:
    #   Split in two, a step of dt falls g t dt / 4 further than the parabola, not g t dt / 2.
    with opened() as engine:
        settings = engine.settings
        if isinstance(settings, RigidSettings):
            pytest.skip("it looks ahead instead")
        assert settings.most_travel is not None
        engine.set_max_speed(1.5 * settings.most_travel / settings.time_step)
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0)))
        t = play(engine, 0.1) * settings.time_step
        fallen = 1.0 - position(engine, "plank")[2]
        assert fallen == pytest.approx(9.81 * t * (t + settings.time_step / 2.0) / 2.0, rel=1e-5)


def test_a_turning_brick_keeps_turning_about_its_long_axis_in_w(opened: Opened) -> None:
    with opened(gravity=0.0) as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0), CROSSED))  # its long axis is the y axis of W
        lever, impulse = THICKNESS / 2.0, 1e-5
        engine.push("plank", (impulse, 0.0, 0.0), (0.0, 0.0, 1.0 + lever))
        play(engine, 0.1)
        state = engine.states(["plank"])["plank"]
        moment = MASS * (WIDTH**2 + THICKNESS**2) / 12.0
        assert state.velocity_W == pytest.approx((impulse / MASS, 0.0, 0.0), rel=1e-5, abs=1e-9)
        assert state.angular_velocity_W == pytest.approx((0.0, impulse * lever / moment, 0.0), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(("friction", "of_ground"), [(0.5, 0.5), (0.5, 0.3), (0.2, 0.8)])
@pytest.mark.parametrize("turn", [0.0, 20.0, 45.0, 90.0])
def test_a_thrown_plank_slides_v_squared_by_two_mu_g(
    opened: Opened, friction: float, of_ground: float, turn: float
) -> None:
    #   The friction of the pair is that of the plane, less or more than that of bricks, in all directions.
    speed, angle = 1.0, radians(turn)
    with opened(friction=friction, of_ground=of_ground) as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, THICKNESS / 2.0)), (speed * cos(angle), speed * sin(angle), 0.0))
        play(engine, 1.2 * speed / (of_ground * 9.81))
        x, y, _ = position(engine, "plank")
        assert x * cos(angle) + y * sin(angle) == pytest.approx(speed**2 / (2.0 * of_ground * 9.81), rel=0.03)


def test_a_plank_slides_on_another_with_the_friction_of_bricks(opened: Opened) -> None:
    #   |--high--| ->      after t = 0.1 s it is v - mu g t fast, whatever the ground is made of
    # |----low-----|
    with opened(friction=0.3, of_ground=0.9) as engine:
        column(engine, "low")
        engine.freeze("low")
        engine.add_brick(plank("high"), Pose((0.0, 0.0, 1.5 * THICKNESS)), (0.5, 0.0, 0.0))
        t = play(engine, 0.1) * engine.settings.time_step
        assert engine.states(["high"])["high"].velocity_W[0] == pytest.approx(0.5 - 0.3 * 9.81 * t, abs=0.02)


@pytest.mark.parametrize(("angle", "slides"), [(25.5, False), (27.6, True)])
def test_a_plank_slides_on_a_slope_steeper_than_the_angle_of_friction(
    opened: Opened, angle: float, slides: bool
) -> None:
    #   atan(0.5) = 26.57 deg
    tilt, half = radians(angle), THICKNESS / 2.0
    with opened(tilt=tilt) as engine:
        pose = Pose((half * sin(tilt), 0.0, half * cos(tilt)), (0.0, sin(tilt / 2), 0.0, cos(tilt / 2)))
        engine.add_brick(plank(), pose)
        play(engine, 0.5)
        assert (engine.states(["plank"])["plank"].velocity_W[0] > 0.02) is slides


def test_two_planks_that_meet_end_to_end_keep_their_momentum_and_part_slowly(opened: Opened) -> None:
    #   |--a--| ->  |--b--|
    # Restitution is 0, but MuJoCo's critically damped springs return a sixth of the speed.
    with opened(gravity=0.0) as engine:
        engine.add_brick(plank("a"), Pose((0.0, 0.0, 1.0)), (0.5, 0.0, 0.0))
        engine.add_brick(plank("b"), Pose((LENGTH + 0.002, 0.0, 1.0)))
        play(engine, 0.1)
        a, b = (engine.states([name])[name].velocity_W[0] for name in "ab")
        assert a + b == pytest.approx(0.5, rel=1e-5)
        assert 0.0 <= b - a < 0.5 / 5.0


def test_contacts_carry_the_weight_and_push_each_brick_away_from_the_other(opened: Opened) -> None:
    with opened() as engine:
        column(engine, "low", "mid", "top")
        play(engine, 0.5)
        # The mean over some steps, as in single precision the forces of one tremble by a third.
        sums = dict.fromkeys(("low", "mid", "top"), 0.0)
        on_ground = []
        for _ in range(MANY):
            engine.step()
            for brick in sums:
                x, y, z = force_on(engine, brick)
                sums[brick] += z / MANY
                assert (x, y) == pytest.approx((0.0, 0.0), abs=0.01 * WEIGHT)
            on_ground += [point for point in engine.contacts("low") if GROUND in (point.a, point.b)]
        assert sums == pytest.approx(dict.fromkeys(sums, WEIGHT), rel=0.01)
        assert sum(point.normal_force for point in on_ground) / MANY == pytest.approx(3.0 * WEIGHT, rel=0.01)
        for point in on_ground:
            up = point.normal_BA_W[2] if point.a == "low" else -point.normal_BA_W[2]
            assert up == pytest.approx(1.0, abs=1e-3)
            assert abs(point.position_W[0]) == pytest.approx(LENGTH / 2.0, abs=1e-4)
            assert abs(point.gap) < 1e-4


@MUJOCO_ALONE
@pytest.mark.parametrize("angle", [0.0, 0.6, -2.0])
def test_friction_on_a_sliding_brick_is_against_its_motion_and_mu_times_the_press(opened: Opened, angle: float) -> None:
    ahead = (cos(angle), sin(angle), 0.0)
    with opened(friction=0.4) as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, THICKNESS / 2.0)), ahead)
        for _ in range(20):
            engine.step()
            x, y, z = force_on(engine, "plank")
            assert (x, y) == pytest.approx((-0.4 * z * ahead[0], -0.4 * z * ahead[1]), rel=0.02, abs=1e-3 * WEIGHT)


@MUJOCO_ALONE
def test_joined_bricks_stand_with_the_weight_of_all_and_are_no_neighbours(opened: Opened) -> None:
    with opened() as engine:
        column(engine, "a", "b", "c")
        for brick in ("b", "c"):
            engine.freeze(brick)
        engine.weld(["b", "c"])
        play(engine, 0.3)
        assert list(engine.neighbours("b", 5e-4)) == ["a"]
        assert not engine.holds("b")
        forces = [point.normal_force for point in engine.contacts("b") if "a" in (point.a, point.b)]
        assert sum(forces) == pytest.approx(2.0 * WEIGHT, rel=0.01)


@MUJOCO_ALONE
def test_parted_bricks_go_on_with_the_motion_that_they_had(opened: Opened) -> None:
    #   |------|------|      over an edge, they turn as one body, and continue to turn when unwelded
    #   |held|
    with opened() as engine:
        engine.add_brick(Brick("held", Box((WIDTH, WIDTH, WIDTH)), MASS), Pose((0.0, 0.0, 0.3)))
        engine.freeze("held")
        for number, brick in enumerate(("near", "far")):
            engine.add_brick(plank(brick), Pose((number * LENGTH, 0.0, 0.3 + (WIDTH + THICKNESS) / 2.0)))
            engine.freeze(brick)
        engine.weld(["near", "far"])
        play(engine, 0.15)
        before = engine.states(["near", "far"])
        turning = before["near"].angular_velocity_W
        arm = subtract(before["far"].pose.position_W, before["near"].pose.position_W)
        assert turning[1] > 1.0
        assert before["far"].velocity_W == pytest.approx(add(before["near"].velocity_W, cross(turning, arm)), rel=1e-9)
        assert engine.unweld("far") == ("near", "far")
        after = engine.states(["near", "far"])
        for brick, state in before.items():
            assert after[brick].pose.position_W == pytest.approx(state.pose.position_W, abs=1e-12)
            assert after[brick].velocity_W == pytest.approx(state.velocity_W, rel=1e-9, abs=1e-12)
            assert after[brick].angular_velocity_W == pytest.approx(turning, rel=1e-9, abs=1e-12)


def test_a_frozen_brick_is_exactly_where_it_was_whatever_hits_it(opened: Opened) -> None:
    with opened() as engine:
        engine.add_brick(plank("held"), Pose((0.0, 0.0, 0.5), (0.0, sin(0.4), 0.0, cos(0.4))))  # steeper than friction
        engine.freeze("held")
        before = engine.states(["held"])
        engine.add_brick(plank("hits"), Pose((0.0, 0.0, 0.6)), (0.0, 0.0, -3.0))
        engine.set_max_speed(4.0)
        play(engine, 0.2)
        assert engine.holds("held")
        assert engine.states(["held"]) == before
        assert position(engine, "hits")[2] < 0.5  # it hit, and slid off


def test_a_woken_brick_has_its_mass_again_and_starts_at_rest(opened: Opened) -> None:
    with opened() as engine:
        engine.add_brick(plank(), Pose((0.0, 0.0, 1.0)), (1.0, 0.0, -2.0))
        engine.freeze("plank")
        play(engine, 0.1)
        engine.wake("plank")
        assert not engine.holds("plank")
        engine.step()
        dt = engine.settings.time_step
        assert engine.states(["plank"])["plank"].velocity_W == pytest.approx((0.0, 0.0, -9.81 * dt), rel=1e-4)
        engine.push("plank", (MASS, 0.0, 0.0), position(engine, "plank"))
        assert engine.states(["plank"])["plank"].velocity_W[0] == pytest.approx(1.0, rel=1e-5)
        assert engine.masses()["plank"] == MASS


def test_a_frozen_brick_can_be_put_elsewhere_and_carries_there(opened: Opened) -> None:
    with opened() as engine:
        column(engine, "held")
        engine.freeze("held")
        there = Pose((0.3, 0.0, 0.2))
        engine.put_at("held", there)
        engine.add_brick(plank("on it"), Pose((0.3, 0.0, 0.2 + THICKNESS)))
        play(engine, 0.2)
        assert engine.states(["held"])["held"].pose.position_W == pytest.approx(there.position_W, abs=1e-7)
        assert position(engine, "on it") == pytest.approx((0.3, 0.0, 0.2 + THICKNESS), abs=2e-4)


def test_what_stood_on_a_brick_that_is_taken_out_falls_and_the_name_is_free(opened: Opened) -> None:
    with opened() as engine:
        column(engine, "low", "top")
        play(engine, 0.05)
        engine.remove_brick("low")
        play(engine, 0.3)
        assert dict(engine.masses()) == {"top": MASS}
        assert position(engine, "top")[2] == pytest.approx(0.5 * THICKNESS, abs=2e-4)
        engine.add_brick(Brick("low", Box((0.05, 0.05, 0.05)), 1.0), Pose((0.5, 0.0, 0.025)))
        assert engine.shape("low") == Box((0.05, 0.05, 0.05))
        assert engine.masses()["low"] == 1.0


def test_bricks_that_come_leave_the_motion_of_the_others_as_it_is(opened: Opened) -> None:
    def fallen(disturbed: bool) -> Vec3:
        with opened() as engine:
            engine.add_brick(plank(), Pose((0.0, 0.0, 1.0), CROSSED), (0.1, 0.2, 0.3))
            engine.push("plank", (1e-3, 0.0, 0.0), (0.0, 0.01, 1.0))
            play(engine, 0.1)
            if disturbed:
                engine.add_brick(plank("other"), Pose((2.0, 0.0, THICKNESS / 2.0)))
                engine.freeze("other")
                engine.wake("other")
            play(engine, 0.1)
            return position(engine, "plank")

    assert fallen(disturbed=True) == pytest.approx(
        fallen(disturbed=False), abs=5e-6
    )  # an engine may be of single precision


def test_near_are_the_bodies_whose_bounding_boxes_come_close(opened: Opened) -> None:
    with opened() as engine:
        column(engine, "a", "b", "c")
        engine.add_brick(plank("far"), Pose((0.5, 0.0, THICKNESS / 2.0)))
        assert list(engine.neighbours("a", 5e-4)) == ["b", GROUND]
        assert list(engine.neighbours("b", 5e-4)) == ["a", "c"]
        assert list(engine.neighbours("far", within=0.4)) == ["a", "b", "c", GROUND]
        assert engine.shape(GROUND) == HalfSpace((0.0, 0.0, 1.0))
        assert engine.fixed() == {GROUND}


def test_a_fast_plank_does_not_pass_through_another(opened: Opened) -> None:
    with opened(gravity=0.0) as engine:
        engine.add_brick(plank("wall"), Pose((0.2, 0.0, 1.0), (0.0, 0.5**0.5, 0.0, 0.5**0.5)))
        engine.freeze("wall")
        engine.add_brick(plank("shot"), Pose((0.0, 0.0, 1.0)), (8.0, 0.0, 0.0))
        engine.set_max_speed(8.0)
        play(engine, 0.05)
        assert position(engine, "shot")[0] < 0.2


def test_a_run_repeats_bit_for_bit_after_other_runs(opened: Opened) -> None:
    def fallen() -> list[Vec3]:
        with opened() as engine:
            for level in range(6):
                engine.add_brick(plank(f"{level}"), Pose((0.03 * level, 0.001 * level, THICKNESS * (level + 0.5))))
                play(engine, 0.1)
            return [position(engine, f"{level}") for level in range(6)]

    first = fallen()
    with opened(gravity=1.0, friction=0.1) as other:
        column(other, "a", "b")
        play(other, 0.1)
    assert fallen() == first
