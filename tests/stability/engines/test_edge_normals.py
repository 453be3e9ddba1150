"""Planks that touch edge on edge: the normal that geometry gives them, and the one that an engine does."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import asin, cos, degrees, hypot, pi, radians, sin, sqrt, tan
from pathlib import Path

import pybullet
import pytest

from stability.engines.edge_normals import EDGE_RADIUS, leans, true_normals, wrong_normals
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.geometry.box_distance import block
from stability.geometry.vectors import cross, dot, multiply, unit
from stability.model import GROUND, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.checking.cases import gather
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import HELD, MOVING, STOCK, SYSTEMS, TUNED
from tests.scenes import timeline_of

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS, GRAVITY = 0.012, 9.81
BOTH_ROUNDED = EDGE_RADIUS, EDGE_RADIUS
BOTH = pytest.mark.parametrize("settings", [TUNED, MOVING], ids=["tuned", "exact"])


@contextmanager
def world(settings: PyBulletSettings, friction: float = 0.5, ground: float = 0.0) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(settings, GRAVITY, friction, heaviest=MASS)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, ground), (0.0, 0.0, 1.0), friction))
        yield opened
    finally:
        opened.close()


def about(axis: Vec3, angle: float) -> Quaternion:
    x, y, z = (sin(angle / 2.0) * part for part in axis)
    return (x, y, z, cos(angle / 2.0))


def leaning(angle: float, side: float, height: float = 0.0) -> Pose:
    """Half of an inverted V: against the plane x = 0, from the left (-1) or the right."""
    x = (LENGTH * cos(angle) + THICKNESS * sin(angle)) / 2.0
    z = (LENGTH * sin(angle) + THICKNESS * cos(angle)) / 2.0 + height
    return Pose((side * x, 0.0, z), about((0.0, 1.0, 0.0), side * angle))


def set_down_square_then_put(engine: PyBulletWorld, name: str, pose: Pose) -> None:
    engine.add_brick(Brick(name, Box(SIZE), MASS), Pose((10.0 * pose.position_W[0], 0.0, 1.0)))
    engine.put_at(name, pose)


def put_up_v(engine: PyBulletWorld, angle: float, height: float = 0.0) -> None:
    for name, side in (("left", -1.0), ("right", 1.0)):
        set_down_square_then_put(engine, name, leaning(angle, side, height))


def played(engine: PyBulletWorld, seconds: float, fastest: float = 0.0) -> None:
    engine.set_max_speed(fastest + 0.1)
    for _ in range(round(seconds / engine.settings.time_step)):
        engine.step()


def height_of(engine: PyBulletWorld, brick: str) -> float:
    return engine.states([brick])[brick].pose.position_W[2]


@pytest.mark.parametrize("angle", [50.0, 60.0, 70.0])
def test_two_planks_of_an_inverted_v_push_each_other_sideways(angle: float) -> None:
    #   /\    by symmetry; the faces beside the edges are 90 deg - angle off
    left, right = (block(SIZE, leaning(radians(angle), side)) for side in (-1.0, 1.0))
    touching = (0.0, 0.0, LENGTH * sin(radians(angle)))
    for normal in true_normals(left, right, touching, BOTH_ROUNDED):
        assert normal == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("crossing", [0.1, 1.0, 3.0, 8.0, 20.0, 60.0, 90.0])
def test_edges_that_cross_push_across_both(crossing: float) -> None:
    roll = about((1.0, 0.0, 0.0), radians(30.0))
    turn = multiply(about((0.0, 1.0, 0.0), radians(10.0)), about((0.0, 0.0, 1.0), radians(crossing)))
    along_a, along_b = (cos(radians(crossing)) * cos(radians(10.0)), sin(radians(crossing)), 0.0), (1.0, 0.0, 0.0)
    along_a = (along_a[0], along_a[1], -cos(radians(crossing)) * sin(radians(10.0)))
    up = unit(cross(along_b, along_a))
    lower = lowest_or_highest(Pose((0.0, 0.0, 0.0), roll), up)
    upper = lowest_or_highest(Pose((0.0, 0.0, 0.0), multiply(turn, roll)), (-up[0], -up[1], -up[2]))
    boxes = block(SIZE, upper), block(SIZE, lower)
    for beside in (0.0, 0.2 * LENGTH, -0.4 * LENGTH):  # start of the search
        assert list(true_normals(*boxes, (beside, 0.0, 0.0), BOTH_ROUNDED))[-1] == pytest.approx(up, abs=1e-6)


def lowest_or_highest(pose: Pose, direction: Vec3) -> Pose:
    """The same turn, moved so that the middle of the edge farthest along a direction is at the origin."""
    seen = block(SIZE, pose)
    x = y = z = 0.0
    for half_edge in seen.half_edges_W[1:]:
        sign = 1.0 if dot(half_edge, direction) > 0.0 else -1.0
        x, y, z = x - sign * half_edge[0], y - sign * half_edge[1], z - sign * half_edge[2]
    return Pose((x, y, z), pose.orientation)


def test_an_edge_that_stands_on_a_face_is_pushed_straight_off_it() -> None:
    edge = lowest_or_highest(Pose((0.0, 0.0, 0.0), about((1.0, 0.0, 0.0), radians(40.0))), (0.0, 0.0, -1.0))
    below = Pose((0.01, 0.0, -THICKNESS / 2.0))
    for normal in true_normals(block(SIZE, edge), block(SIZE, below), (0.0, 0.0, 0.0), BOTH_ROUNDED):
        assert normal == pytest.approx((0.0, 0.0, 1.0))


@pytest.mark.parametrize(
    "orientation", [(0.0, 0.0, 0.0, 1.0), about((1.0, 0.0, 0.0), pi / 2.0), about((0.0, 0.0, 1.0), 0.3)]
)
def test_a_plank_that_lies_or_stands_upright_does_not_lean(orientation: Quaternion) -> None:
    assert not leans(Pose((0.0, 0.0, 0.0), orientation))
    tipped = multiply(about(unit((1.0, 2.0, 0.0)), radians(1.2)), orientation)
    assert leans(Pose((0.0, 0.0, 0.0), tipped))


@pytest.mark.parametrize("angle", [60.0, 70.0])
def test_pybullet_as_it_comes_gives_a_v_the_normal_of_a_face_and_is_caught(angle: float) -> None:
    #   in so short a time that they have hardly sunk: where rounded edges touch depends on micrometres
    with world(replaced_step(STOCK, 960), friction=0.7) as engine:
        put_up_v(engine, radians(angle))
        played(engine, 2.0 / 960.0)
        wrong = list(wrong_normals(engine, engine.states(engine.masses()), GRAVITY))
    assert [{one.upper, one.lower} for one in wrong] == [{"left", "right"}]
    assert degrees(wrong[0].angle) == pytest.approx(90.0 - angle, abs=0.1)


@BOTH
@pytest.mark.parametrize("angle", [60.0, 70.0])
def test_rounded_edges_leave_nothing_to_catch_in_a_v_that_stands(settings: PyBulletSettings, angle: float) -> None:
    with world(settings, friction=0.5) as engine:
        put_up_v(engine, radians(angle))
        for _ in range(10):
            played(engine, 0.05)
            assert list(wrong_normals(engine, engine.states(engine.masses()), GRAVITY)) == []


@BOTH
@pytest.mark.parametrize("height", [0.0, pytest.param(0.01, marks=pytest.mark.slow), 0.1])
@pytest.mark.parametrize("rate", [480, pytest.param(960, marks=pytest.mark.slow)])
def test_planks_set_down_square_and_leaned_later_need_the_friction_of_statics_also_when_dropped(
    settings: PyBulletSettings, height: float, rate: int
) -> None:
    #   mu = (cot a - t / L) / 2; the shock of a landing slows all parts alike, as weight pulls them
    angle = radians(70.0)
    needed = (1.0 / tan(angle) - THICKNESS / LENGTH) / 2.0
    speed = sqrt(2.0 * GRAVITY * height)
    for share, stands in ((1.03, True), (0.97, False)):
        with world(replaced_step(settings, rate), friction=share * needed) as engine:
            put_up_v(engine, angle, height)
            played(engine, speed / GRAVITY + 1.0, speed)
            stood = all(
                height_of(engine, name) > leaning(angle, 1.0).position_W[2] - 0.002 for name in ("left", "right")
            )
            assert stood is stands


def replaced_step(settings: PyBulletSettings, rate: int) -> PyBulletSettings:
    return replace(settings, time_step=1.0 / rate)


@BOTH
def test_another_body_with_other_edges_has_place_motion_mass_and_inertia(settings: PyBulletSettings) -> None:
    with world(settings, ground=-10.0) as engine:
        engine.add_brick(Brick("a", Box(SIZE), MASS), Pose((0.1, 0.2, 0.3)))
        engine.add_brick(Brick("b", Box(SIZE), MASS), Pose((1.1, 0.2, 0.3)))
        engine.bodies.set_motion("a", (1.0, -2.0, 0.5), (3.0, 20.0, -4.0))
        masses, order, before = engine.masses(), list(engine.masses()), engine.states(["a"])["a"]
        known = body_facts(engine, "a")
        engine.bricks.swap("a")
        assert engine.states(["a"])["a"] == before
        assert engine.masses() is masses
        assert list(engine.masses()) == order
        assert body_facts(engine, "a") == known
        unit_of_inertia = engine.bodies.mass_unit * engine.bodies.scale**2
        assert known[2] == pytest.approx([unit_of_inertia * moment for moment in Box(SIZE).moments(MASS)])


def body_facts(engine: PyBulletWorld, name: str) -> tuple[object, ...]:
    """Mass, friction, inertia, restitution."""
    facts = pybullet.getDynamicsInfo(engine.bodies.numbers[name], -1, engine.bodies.client)
    return facts[0], facts[1], facts[2], facts[5]


@BOTH
def test_edges_that_change_in_free_flight_change_neither_way_nor_spin(settings: PyBulletSettings) -> None:
    ends = []
    for swaps in (False, True):
        with world(settings, ground=-10.0) as engine:
            engine.add_brick(Brick("a", Box(SIZE), MASS), Pose((0.0, 0.0, 0.0)))
            engine.bodies.set_motion("a", (0.3, 0.0, 0.0), (1.0, 5.0, 0.0))
            played(engine, 0.1)
            if swaps:
                engine.bricks.swap("a")
            played(engine, 0.1)
            ends.append(engine.states(["a"])["a"])
    assert ends[1].pose.position_W == pytest.approx(ends[0].pose.position_W, abs=1e-9)
    assert ends[1].velocity_W == pytest.approx(ends[0].velocity_W, abs=1e-9)
    assert ends[1].angular_velocity_W == pytest.approx(ends[0].angular_velocity_W, rel=1e-6)


def test_a_v_that_gets_rounded_edges_gains_no_energy_and_does_not_jump() -> None:
    with world(MOVING) as engine:
        put_up_v(engine, radians(70.0))
        heights = []
        for _ in range(96):
            engine.step()
            heights.append(height_of(engine, "left"))
            speed = hypot(*engine.states(["left"])["left"].velocity_W)
            assert speed < 0.02  # two steps of free fall
        assert heights[0] - min(heights) < 1e-4
        assert max(heights) - heights[0] < 1e-5


def test_planks_that_tilt_together_face_on_face_keep_their_sharp_edges() -> None:
    #   two planks, one on the other, slide down together
    tilt = about((0.0, 1.0, 0.0), radians(20.0))
    with world(MOVING, ground=-1.0) as engine:
        for name, level in (("low", 0.0), ("high", THICKNESS)):
            aside = (level * sin(radians(20.0)), 0.0, level * cos(radians(20.0)))
            engine.add_brick(Brick(name, Box(SIZE), MASS), Pose((1.0, 0.0, 1.0 + level)))
            engine.put_at(name, Pose(aside, tilt))
        played(engine, 0.2)
        assert engine.bricks.rounded == set()


def test_a_plank_whose_edge_stands_on_the_face_of_another_keeps_its_sharp_edges() -> None:
    edge = lowest_or_highest(Pose((0.0, 0.0, 0.0), about((1.0, 0.0, 0.0), radians(40.0))), (0.0, 0.0, -1.0))
    x, y, z = edge.position_W
    with world(MOVING) as engine:
        engine.add_brick(Brick("below", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS / 2.0)))
        set_down_square_then_put(engine, "edge", Pose((x, y, z + THICKNESS), edge.orientation))
        played(engine, 0.02)
        assert engine.bricks.rounded == set()


@pytest.mark.parametrize("settings", [STOCK, HELD], ids=["stock", "thesis"])
def test_systems_without_rounded_edges_are_left_alone(settings: PyBulletSettings) -> None:
    with world(settings) as engine:
        put_up_v(engine, radians(70.0))
        played(engine, 0.2)
        assert engine.bricks.rounded == set()


def test_a_plank_that_lies_square_again_gets_its_sharp_edges_back() -> None:
    with world(MOVING, friction=0.05) as engine:
        put_up_v(engine, radians(70.0))
        played(engine, 0.05)
        assert engine.bricks.rounded == {"left", "right"}
        for name, x in (("left", -1.0), ("right", 1.0)):
            engine.put_at(name, Pose((x, 0.0, THICKNESS / 2.0)))
            engine.bodies.set_motion(name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        played(engine, 0.1)
        assert engine.bricks.rounded == set()


def test_planks_tipped_against_each_other_end_the_same_in_every_run() -> None:
    assert tipped_together() == tipped_together()


def test_two_upright_planks_tipped_against_each_other_hold_each_other_up() -> None:
    #   | |  ->  /\   needs 0.149 at 70 deg; with sharp edges the same planks fall
    angle = asin(tipped_together()[2] * 2.0 / hypot(LENGTH, THICKNESS)) - asin(THICKNESS / hypot(LENGTH, THICKNESS))
    assert degrees(angle) == pytest.approx(70.0, abs=1.0)


def tipped_together() -> Vec3:
    foot = LENGTH * cos(radians(70.0))
    with world(MOVING, friction=0.3) as engine:
        for name, side in (("left", -1.0), ("right", 1.0)):
            aside = side * THICKNESS / 2.0
            pose = Pose((side * foot + aside, 0.0, LENGTH / 2.0), about((0.0, 1.0, 0.0), side * pi / 2.0))
            engine.add_brick(Brick(name, Box(SIZE), MASS), pose)
            turn = -2.0 * side
            engine.bodies.set_motion(name, (turn * LENGTH / 2.0, 0.0, -turn * aside), (0.0, turn, 0.0))
        played(engine, 1.5, 1.0)
        return engine.states(["left"])["left"].pose.position_W


V = """
    - bricks:
        - {name: left, at: [-23.773 mm, 0 mm, 56.588 mm], rotate: [0 deg, -70 deg, 0 deg]}
        - {name: right, at: [23.773 mm, 0 mm, 56.588 mm], rotate: [0 deg, 70 deg, 0 deg]}
"""


@pytest.mark.parametrize(("system", "caught"), [("stock", True), ("tuned", False), ("exact", False)])
def test_a_run_tells_of_edges_that_were_taken_for_faces(system: str, caught: bool) -> None:
    timeline = timeline_of(V, "friction: 0.3\nbrick: kapla\n")
    wrong = play(timeline, SYSTEMS[system]).wrong_edges
    assert (wrong is not None) is caught
    if wrong is not None:
        assert (wrong.contacts, {wrong.upper, wrong.lower}) == (1, {"left", "right"})


@pytest.mark.parametrize(
    "scenario", ["hard-stepped-column-falls", pytest.param("harmonic-too-far", marks=pytest.mark.slow)]
)
def test_planks_that_topple_together_are_pressed_along_the_normals_that_they_have_by_then(scenario: str) -> None:
    #   They turn by 30 deg and more with faces on faces, which PyBullet takes for no reason to find normals anew.
    root = Path(__file__).parents[3] / "scenarios"
    cases = [case for case in gather([root / "hard", root / "harmonic.yaml"]).cases if case.name.startswith(scenario)]
    for case in cases:
        if case.system == "exact":
            assert play(case.timeline, SYSTEMS["exact"]).wrong_edges is None
