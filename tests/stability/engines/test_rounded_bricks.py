"""Bricks with rounded edges: edge contacts slip, stand, slide and fall as closed forms predict."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import atan, cos, hypot, radians, sin, tan

import pybullet
import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.simulation.systems import MOVING

SIZE = LENGTH, _, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS = 0.012


@contextmanager
def world(friction: float = 0.5, edge_rounding: float = MOVING.edge_rounding) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(replace(MOVING, edge_rounding=edge_rounding), 9.81, friction, heaviest=MASS)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction))
        yield opened
    finally:
        opened.close()


def lean(engine: PyBulletWorld, name: str, angle: float, side: float) -> None:
    """Lean a plank against the plane x = 0, from the left (-1) or the right, its lower edge on the ground."""
    x = (LENGTH * cos(angle) + THICKNESS * sin(angle)) / 2.0
    z = (LENGTH * sin(angle) + THICKNESS * cos(angle)) / 2.0
    turn = (0.0, side * sin(angle / 2.0), 0.0, cos(angle / 2.0))
    engine.add_brick(Brick(name, Box(SIZE), MASS), Pose((side * x, 0.0, z), turn))


def stands(engine: PyBulletWorld, brick: str) -> bool:
    before = engine.states([brick])[brick].pose.position_W[2]
    for _ in range(960):
        engine.step()
        if engine.states([brick])[brick].pose.position_W[2] < before - 0.002:
            return False
    return True


def inverted_v_stands(angle: float, share: float, edge_rounding: float = MOVING.edge_rounding) -> bool:
    """Does it stand with this share of the friction that it needs?"""
    #   /\    mu = (cot a - t / L) / 2
    needed = (1.0 / tan(angle) - THICKNESS / LENGTH) / 2.0
    with world(share * needed, edge_rounding) as engine:
        lean(engine, "left", angle, -1.0)
        lean(engine, "right", angle, 1.0)
        return stands(engine, "left")


@pytest.mark.parametrize("angle", [60.0, 65.0, 70.0, 75.0])
def test_two_planks_that_lean_on_each_other_need_just_the_friction_that_statics_ask_for(angle: float) -> None:
    assert inverted_v_stands(radians(angle), 1.03)
    assert not inverted_v_stands(radians(angle), 0.97)


def test_sharp_edges_would_need_twice_that_friction() -> None:
    assert not inverted_v_stands(radians(70.0), 2.0, edge_rounding=0.0)


@pytest.mark.parametrize(("beyond", "slips"), [(0.5, False), (-0.5, True)])
def test_a_ladder_on_a_smooth_wall_slips_where_statics_say(beyond: float, slips: bool) -> None:
    #   tan a = 1 / (2 mu + t / L), contacts on its lower face; 1 deg about it is 2 % of the friction
    slipping = atan(1.0 / (2.0 * 0.5 + THICKNESS / LENGTH))
    with world() as engine:
        engine.add_plane(Plane("wall", (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.0))
        lean(engine, "ladder", slipping + radians(beyond), -1.0)
        assert stands(engine, "ladder") is not slips


@pytest.mark.parametrize(("bearing", "within"), [(0.0, 0.02), (20.0, 0.02), (45.0, 0.02), (90.0, 0.02)])
def test_a_plank_slides_v_squared_over_two_mu_g(bearing: float, within: float) -> None:
    speed, way = 1.0, radians(bearing)
    with world() as engine:
        velocity_W = (speed * cos(way), speed * sin(way), 0.0)
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS / 2.0)), velocity_W)
        for _ in range(300):
            engine.step()
        x, y, z = engine.states(["plank"])["plank"].pose.position_W
    assert hypot(x, y) == pytest.approx(speed**2 / (2.0 * 0.5 * 9.81), rel=within)
    assert z == pytest.approx(
        THICKNESS / 2.0, abs=2e-6
    )  # the outer size is exact, but for a micrometre of overlap that is let be


@pytest.mark.parametrize("size", [SIZE, (1e-3, 1e-3, 1e-3)])
def test_a_rounded_brick_is_a_box_with_the_inertia_of_one_also_after_it_was_frozen(
    size: tuple[float, float, float],
) -> None:
    with world() as engine:
        engine.add_brick(Brick("brick", Box(size), MASS), Pose((0.0, 0.0, 1.0)))
        body, unit = engine.bodies.numbers["brick"], engine.bodies.mass_unit * engine.bodies.scale**2
        inertia = pytest.approx([unit * moment for moment in Box(size).moments(MASS)])
        assert engine.shape("brick") == Box(size)
        assert pybullet.getDynamicsInfo(body, -1, engine.bodies.client)[2] == inertia
        engine.freeze("brick")
        engine.wake("brick")
        assert pybullet.getDynamicsInfo(body, -1, engine.bodies.client)[2] == inertia


def test_rounded_bricks_stand_at_their_height_and_creep_less_than_a_quarter_of_a_millimetre() -> None:
    #   Ten levels of two planks, awake for a second: boxes with the same settings creep more than twice as far.
    half_turn = 0.5**0.5
    turns = [(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, half_turn, half_turn)]
    offset = (LENGTH - SIZE[1]) / 2.0
    with world() as engine:
        for level in range(10):
            for side in (-offset, offset):
                x, y = (0.0, side) if level % 2 == 0 else (side, 0.0)
                pose = Pose((x, y, THICKNESS * (level + 0.5)), turns[level % 2])
                engine.add_brick(Brick(f"{level} {side}", Box(SIZE), MASS), pose)
        before = engine.states(engine.masses())
        for _ in range(960):
            engine.step()
        for name, state in engine.states(before).items():
            assert state.pose.position_W == pytest.approx(before[name].pose.position_W, abs=2.5e-4)


def test_the_ground_goes_on_under_bricks_far_away() -> None:
    with world() as engine:
        for name, x in (("here", 0.0), ("there", 3000.0)):
            engine.add_brick(Brick(name, Box(SIZE), MASS), Pose((x, 0.0, THICKNESS / 2.0)))
        for _ in range(240):
            engine.step()
        heights = [state.pose.position_W[2] for state in engine.states(["here", "there"]).values()]
        assert heights == pytest.approx([THICKNESS / 2.0] * 2, abs=2e-4)
        assert engine.fixed() == {GROUND}
