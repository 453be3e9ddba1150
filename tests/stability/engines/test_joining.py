"""Bricks that move as one rigid body: their mass, inertia, weight and motion are those of the bricks."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from math import atan, cos, radians, sin

import pytest

from stability.dynamics.rigid_group import grouped, member_state, surfaces
from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.geometry.vectors import add, cross, dot, norm, rotate, scale, subtract
from stability.model import GROUND, BodyId, BodyState, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.systems import MOVING

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS = 0.012
CROSSED: Quaternion = (0.0, 0.0, 0.5**0.5, 0.5**0.5)
AWRY: Quaternion = (0.1, 0.5, -0.1, 0.73**0.5)


@contextmanager
def world(tilt: float = 0.0, friction: float = 0.5) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(MOVING, 9.81, friction, heaviest=MASS)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (sin(tilt), 0.0, cos(tilt)), friction))
        yield opened
    finally:
        opened.close()


def put(engine: PyBulletWorld, poses: Mapping[BodyId, Pose], size: Vec3 = SIZE) -> None:
    """Put up planks, all frozen."""
    for name, pose in poses.items():
        engine.add_brick(Brick(name, Box(size), MASS), pose)
        engine.freeze(name)


def stepped(engine: PyBulletWorld, steps: int) -> None:
    for _ in range(steps):
        engine.step()


def four_stack(levels: Iterable[int]) -> dict[BodyId, Pose]:
    aside = (LENGTH - WIDTH) / 2.0
    return {
        f"L{level:02}.{number}": Pose((x, y, THICKNESS * (level - 0.5)), CROSSED if level % 2 == 0 else (0, 0, 0, 1))
        for level in levels
        for number, side in enumerate((-aside, aside), 1)
        for x, y in [(side, 0.0) if level % 2 == 0 else (0.0, side)]
    }


def spin(state: BodyState, size: Vec3, mass: float) -> Vec3:
    """Angular momentum of a brick about its centre, in W."""
    x, y, z, w = state.pose.orientation
    turning = rotate((-x, -y, -z, w), state.angular_velocity_W)
    a, b, c = (moment * rate for moment, rate in zip(Box(size).moments(mass), turning, strict=True))
    return rotate(state.pose.orientation, (a, b, c))


def energy(states: Iterable[BodyState]) -> float:
    """Kinetic energy of planks [J]."""
    return sum(
        0.5 * MASS * dot(state.velocity_W, state.velocity_W)
        + 0.5 * dot(state.angular_velocity_W, spin(state, SIZE, MASS))
        for state in states
    )


def test_a_group_has_the_mass_the_centre_and_the_inertia_of_its_bricks() -> None:
    #   Two blocks of a x a x a, one on the other, are one of a x a x 2a, whichever way the pair is turned.
    a, half = 0.02, rotate(AWRY, (0.0, 0.0, 0.01))
    group = grouped(
        [
            (Brick("low", Box((a, a, a)), 1.0), Pose(scale(-1, half), AWRY)),
            (Brick("top", Box((a, a, a)), 1.0), Pose(half, AWRY)),
        ]
    )
    assert group.mass == 2.0
    assert group.pose.position_W == pytest.approx((0.0, 0.0, 0.0), abs=1e-15)
    assert group.moments == pytest.approx(sorted(Box((a, a, 2 * a)).moments(2.0)), rel=1e-12)
    back = member_state(BodyState(group.pose), group.places_G["top"]).pose
    assert back.position_W == pytest.approx(half, abs=1e-15)
    assert rotate(back.orientation, (1.0, 2.0, 3.0)) == pytest.approx(rotate(AWRY, (1.0, 2.0, 3.0)), abs=1e-14)


def test_unlike_bricks_balance_about_their_common_centre_of_mass() -> None:
    bricks = [
        (Brick("heavy", Box((1.0, 1.0, 1.0)), 3.0), Pose((0.0, 0.0, 0.0))),
        (Brick("light", Box((1.0, 1.0, 1.0)), 1.0), Pose((4.0, 0.0, 0.0))),
    ]
    group = grouped(bricks)
    assert group.pose.position_W == pytest.approx((1.0, 0.0, 0.0))
    assert group.moments == pytest.approx((4.0 / 6.0, 4.0 / 6.0 + 12.0, 4.0 / 6.0 + 12.0))  # 3 m 1^2 + 1 m 3^2
    assert surfaces(group).brick_at(group.places_G["light"].position_W) == "light"


@pytest.mark.parametrize("joined", [True, False])
def test_a_joined_pair_slides_like_one_brick_of_twice_the_mass(joined: bool) -> None:
    #   30 deg against an angle of friction of 26.6 deg: g (sin a - mu cos a), of which 3 % are 0.5 % of the friction
    tilt, seconds = radians(30.0), 0.5
    turn = (0.0, sin(tilt / 2.0), 0.0, cos(tilt / 2.0))
    size = SIZE if joined else (LENGTH, WIDTH, 2.0 * THICKNESS)
    heights = {"low": 0.5 * THICKNESS, "top": 1.5 * THICKNESS} if joined else {"low": THICKNESS}
    with world(tilt) as engine:
        put(engine, {n: Pose((h * sin(tilt), 0.0, h * cos(tilt)), turn) for n, h in heights.items()}, size)
        if joined:
            engine.weld(["low", "top"])
        else:
            engine.wake("low")
        stepped(engine, round(seconds / MOVING.time_step))
        speeds = [norm(state.velocity_W) for state in engine.states(heights).values()]
    assert speeds == pytest.approx([9.81 * (sin(tilt) - 0.5 * cos(tilt)) * seconds] * len(heights), rel=0.03)


@pytest.mark.parametrize(("beyond", "tips"), [(-1.0, False), (1.0, True)])
def test_a_joined_column_tips_as_one_where_its_centre_passes_its_edge(beyond: float, tips: bool) -> None:
    #   Four planks across a rough slope: together they tip at tan a = 23.4 / 31.2, each alone at three times the slope.
    tilt = atan(WIDTH / (4.0 * THICKNESS)) + radians(beyond)
    with world(tilt, friction=2.0) as engine:
        lean = (0.0, sin(tilt / 2.0), 0.0, cos(tilt / 2.0))
        size = (WIDTH, LENGTH, THICKNESS)
        heights = [THICKNESS * (level + 0.5) for level in range(4)]
        put(engine, {f"{h:.4f}": Pose((h * sin(tilt), 0.0, h * cos(tilt)), lean) for h in heights}, size)
        names = list(engine.masses())
        engine.weld(names)
        stepped(engine, 480)
        states = engine.states(names)
        turning = {state.angular_velocity_W for state in states.values()}
        assert len(turning) == 1
        assert (norm(turning.pop()) > 0.5) is tips


def test_parting_keeps_momentum_angular_momentum_and_energy() -> None:
    names = ["a", "b", "c"]
    poses = {
        name: Pose((0.01 * i, 0.0, 1.0 + THICKNESS * i), CROSSED if i % 2 else (0, 0, 0, 1))
        for i, name in enumerate(names)
    }
    with world() as engine:
        put(engine, poses)
        engine.weld(names)
        joined = engine.groups.by_brick["a"]
        engine.bodies.set_motion(joined.name, (0.3, -0.2, 0.5), (4.0, 5.0, -6.0))
        before = engine.states(names)
        whole = engine.states([joined.name])[joined.name]
        assert engine.unweld("b") == ("a", "b", "c")
        after = engine.states(names)
    for name in names:
        assert after[name].velocity_W == pytest.approx(before[name].velocity_W, rel=1e-9)
        assert after[name].pose.position_W == pytest.approx(before[name].pose.position_W, rel=1e-9)
    momentum, about = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for state in after.values():
        momentum = add(momentum, scale(MASS, state.velocity_W))
        arm = subtract(state.pose.position_W, whole.pose.position_W)
        about = add(about, add(cross(arm, scale(MASS, state.velocity_W)), spin(state, SIZE, MASS)))
    x, y, z, w = whole.pose.orientation
    a, b, c = (
        m * r for m, r in zip(joined.group.moments, rotate((-x, -y, -z, w), whole.angular_velocity_W), strict=True)
    )
    assert momentum == pytest.approx(scale(3.0 * MASS, whole.velocity_W), rel=1e-9)
    assert about == pytest.approx(rotate(whole.pose.orientation, (a, b, c)), rel=1e-9)
    rigid = 1.5 * MASS * dot(whole.velocity_W, whole.velocity_W) + 0.5 * dot(whole.angular_velocity_W, about)
    assert energy(after.values()) == pytest.approx(rigid, rel=1e-9)


def test_parted_bricks_fall_and_collide_each_by_itself() -> None:
    with world() as engine:
        put(engine, {"low": Pose((0.0, 0.0, 0.1)), "top": Pose((0.3, 0.0, 0.1))})
        engine.weld(["low", "top"])
        engine.unweld("top")
        engine.freeze("low")
        stepped(engine, 480)
        states = engine.states(["low", "top"])
    assert states["low"].pose.position_W == pytest.approx((0.0, 0.0, 0.1), abs=1e-12)
    assert states["top"].pose.position_W == pytest.approx((0.3, 0.0, THICKNESS / 2.0), abs=1e-4)


@pytest.mark.parametrize("levels", [11, 101])
def test_a_joined_tower_presses_on_an_awake_level_with_its_weight(levels: int) -> None:
    carried, awake = four_stack(range(2, levels + 1)), four_stack([1])
    with world() as engine:
        put(engine, awake | carried)
        engine.weld(list(carried))
        for name in awake:
            engine.wake(name)
        stepped(engine, 240)
        pressed = [point for name in awake for point in engine.contacts(name) if GROUND not in (point.a, point.b)]
        assert {name for point in pressed for name in (point.a, point.b)} == {*awake, "L02.1", "L02.2"}
        weight = 9.81 * MASS * len(carried)
        assert sum(point.normal_force for point in pressed) == pytest.approx(weight, rel=0.01)
        assert engine.neighbours("L01.1", 5e-4) == ["L02.1", "L02.2", GROUND]
        assert engine.neighbours("L02.1", 5e-4) == ["L01.1", "L01.2"]
        for name, state in engine.states(carried).items():
            assert state.pose.position_W == pytest.approx(carried[name].position_W, abs=1e-4)


def test_a_hit_turns_a_joined_tower_as_its_inertia_says() -> None:
    #   It is hollow, so unlike its bounding box. A plank hits the long side of its top level: what it loses in angular
    #   momentum about where the centre of the tower was, the tower turns with.
    carried, speed, height = four_stack(range(1, 14)), 2.0, 12.5 * THICKNESS
    opened = PyBulletWorld.opened(MOVING, 0.0, 0.5, heaviest=MASS)
    put(opened, carried)
    opened.weld(list(carried))
    group, name = opened.groups.by_brick["L01.1"].group, opened.groups.by_brick["L01.1"].name
    opened.add_brick(Brick("shot", Box(SIZE), MASS), Pose((0.0, LENGTH + 0.003, height), CROSSED), (0.0, -speed, 0.0))
    stepped(opened, 48)
    shot, tower = opened.states(["shot", name]).values()
    opened.close()
    centre = group.pose.position_W
    turning = add(_orbital(shot, MASS, centre), add(spin(shot, SIZE, MASS), _orbital(tower, group.mass, centre)))
    lost = MASS * speed * (height - centre[2]) - turning[0]
    about_x = sum(_about_x(brick, carried[member], group.pose) for member, brick in group.bricks.items())
    assert tower.angular_velocity_W[0] == pytest.approx(lost / about_x, rel=0.01)


def _orbital(state: BodyState, mass: float, about: Vec3) -> Vec3:
    """Angular momentum of a body's centre about a point."""
    return cross(subtract(state.pose.position_W, about), scale(mass, state.velocity_W))


def _about_x(brick: Brick, pose: Pose, about: Pose) -> float:
    """The moment of inertia of a level plank about an axis along x, by Steiner."""
    along_x, along_y, _ = brick.shape.moments(brick.mass)
    _, y, z = subtract(pose.position_W, about.position_W)
    return (along_y if pose.orientation == CROSSED else along_x) + brick.mass * (y * y + z * z)


def test_a_plank_that_lands_on_a_group_lies_on_the_brick_under_it() -> None:
    #   Twenty levels are more parts than one call of the engine takes; the uppermost must collide as well.
    carried = four_stack(range(1, 21))
    with world() as engine:
        put(engine, carried)
        engine.weld(list(carried))
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, 20.5 * THICKNESS + 0.001)))
        stepped(engine, 240)
        assert engine.states(["plank"])["plank"].pose.position_W[2] == pytest.approx(20.5 * THICKNESS, abs=2e-4)
        assert {p.b if p.a == "plank" else p.a for p in engine.contacts("plank")} == {"L20.1", "L20.2"}
        assert engine.neighbours("plank", 5e-4) == ["L20.1", "L20.2"]


def test_taking_a_brick_out_of_a_group_lets_the_others_go_on_by_themselves() -> None:
    names = ["a", "b", "c"]
    with world() as engine:
        put(engine, {name: Pose((0.3 * i, 0.0, 0.5)) for i, name in enumerate(names)})
        engine.weld(names)
        stepped(engine, 96)  # a tenth of a second of free fall
        before = engine.states(["a", "c"])
        engine.remove_brick("b")
        assert engine.states(["a", "c"]) == pytest.approx(before)
        assert before["a"].velocity_W[2] == pytest.approx(-0.981, rel=1e-6)
        assert sorted(engine.masses()) == ["a", "c"]
        engine.freeze("a")
        stepped(engine, 480)
        states = engine.states(["a", "c"])
    assert states["a"].velocity_W == (0.0, 0.0, 0.0)
    assert states["c"].pose.position_W[2] == pytest.approx(THICKNESS / 2.0, abs=1e-4)


def test_joining_and_parting_prints_nothing_on_the_terminal(capfd: pytest.CaptureFixture[str]) -> None:
    with world() as engine:
        put(engine, four_stack([1, 2]))
        for _ in range(2):
            engine.weld(list(engine.masses()))
            engine.unweld("L01.1")
            for name in engine.masses():
                engine.freeze(name)
    assert capfd.readouterr() == ("", "")
