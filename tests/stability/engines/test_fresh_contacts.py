"""Contacts of turning and sliding bricks have the normals of the current pose at every step."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path

import pytest

from stability.engines.edge_normals import BoxPair, true_normals, wrong_normals
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.contacts import find_all_points, refresh_contacts
from stability.geometry.box import Box
from stability.geometry.box_distance import block
from stability.geometry.vectors import about, multiply
from stability.model import AT_REST, GROUND, Brick, Plane, Pose
from stackdsl.checking.cases import cases_of, gather
from stackdsl.language.yaml.source import parse
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, SYSTEMS

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)
MASS, GRAVITY = 0.012, 9.81


@contextmanager
def world(friction: float) -> Iterator[PyBulletWorld]:
    opened = PyBulletWorld.opened(MOVING, GRAVITY, friction, heaviest=MASS)
    try:
        opened.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction))
        yield opened
    finally:
        opened.close()


def worst_normal(engine: PyBulletWorld, seconds: float, fastest: float) -> float:
    """The largest angle by which a normal was wrong while time passed [rad]; 0 if none was."""
    engine.set_max_speed(fastest)
    worst = 0.0
    for _ in range(round(seconds / MOVING.time_step)):
        engine.step()
        wrong = wrong_normals(engine, engine.states(engine.masses()), GRAVITY)
        worst = max([worst, *(each.angle for each in wrong)])
    return worst


@pytest.mark.parametrize("times_as_heavy", [1.0, 30.0])
def test_a_plank_that_tips_over_the_edge_of_a_block_is_pushed_across_itself_all_the_way(times_as_heavy: float) -> None:
    high = 0.08
    with world(friction=1.5) as engine:
        engine.add_brick(Brick("block", Box((0.05, 0.05, high)), times_as_heavy * MASS), Pose((0.0, 0.0, high / 2.0)))
        centre = (0.025 + 0.03 * LENGTH, 0.0, high + THICKNESS / 2.0)  # beyond the edge
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose(centre))
        assert worst_normal(engine, 0.5, fastest=0.1) == 0.0
        assert engine.states(["plank"])["plank"].pose.position_W[2] < high  # it has tipped


def test_edges_that_slide_down_each_other_in_a_card_house_are_pushed_as_they_lie() -> None:
    cases = gather([Path("scenarios/leaning.yaml")]).cases
    case = next(case for case in cases if (case.scenario_name, case.system) == ("leaning-card-house-slippery", "exact"))
    trace = play(case.timeline, SYSTEMS["exact"])
    assert trace.collapse is not None
    assert trace.wrong_edges is None


def test_edges_that_are_pushed_off_each_other_within_two_steps_are_pushed_as_they_lie() -> None:
    #  The lower Vs spread under the house, the uppermost two shut, and their edges slide at 20 mm/s a step later.
    layout = "{levels: 3, angle: 66.749 deg}"
    text = f"scenario: house\nbrick: kapla\nfriction: 0.0855\nbuild:\n  - card_house: {layout}\n"
    cases, _ = cases_of(parse(text, "house.yaml"))
    trace = play(replace(cases[0].timeline, aftermath=False), SYSTEMS["exact"])
    assert trace.collapse is not None
    assert trace.wrong_edges is None


@pytest.mark.parametrize("speed", [0.15, 0.2])
def test_an_edge_that_comes_down_along_another_while_it_slides_is_pushed_as_it_lies(speed: float) -> None:
    #  \/ ->   cubes whose edges are rounded by 1.3 mm: while the gap closes the normal turns by 30 deg, and the point
    #  /\      that the engine finds first, at one end of the edge, keeps that of before
    side, before, gap, askew = 0.1, 0.0005, 0.0003, 0.002
    apart = 2.0 * MOVING.edge_rounding * side + gap  # edges without their rounding
    inside = 2.0**0.5 * (0.5 - MOVING.edge_rounding) * side  # from the middle of a cube to these
    on_edge = about((0.0, 1.0, 0.0), 0.25 * pi)
    with world(friction=0.4) as engine:
        lower = Brick("lower", Box((side, side, side)), 0.6)
        engine.add_brick(lower, Pose((0.0, 0.0, 1.0), on_edge))
        engine.freeze("lower")
        centre = (-before, 0.0, 1.0 + 2.0 * inside + (apart**2 - before**2) ** 0.5)
        turned = multiply(about((0.0, 0.0, 1.0), askew), on_edge)
        engine.add_brick(replace(lower, id="upper"), Pose(centre, turned), (speed, 0.0, 0.0))
        assert worst_normal(engine, 0.04, fastest=1.2 * speed) == 0.0
        assert engine.states(["upper"])["upper"].angular_velocity_W != AT_REST  # they have met


@pytest.mark.parametrize(
    ("impulse", "low", "out"), [((0.008, 0.0, 0.0), 0.015, 0.001), ((0.004, 0.0, 0.001), 0.002, 0.001)]
)
def test_what_lay_still_until_it_was_hit_is_pushed_as_it_lies(
    impulse: tuple[float, float, float], low: float, out: float
) -> None:
    #   |  |       It lies out over the rim, almost by half of its length; struck behind, it tips over that.
    #  ->  |___    Bricks that lie flat and still were looked at every 20 ms only.
    side, edge = 0.02, 0.05
    with world(friction=0.5) as engine:
        engine.add_brick(Brick("lower", Box((2.0 * edge, 0.1, side)), 1.0), Pose((0.0, 0.0, 0.5 * side)))
        engine.freeze("lower")
        upper = Brick("upper", Box((side, 0.03, 0.03)), 0.01)
        engine.add_brick(upper, Pose((edge - out, 0.0, side + 0.015)))
        assert worst_normal(engine, 0.022, fastest=0.1) == 0.0
        engine.push("upper", impulse, (edge - out - 0.5 * side, 0.0, side + low))
        assert worst_normal(engine, 0.02, fastest=1.0) == 0.0


def test_a_plank_that_slides_off_broadside_stands_on_no_point_behind_it() -> None:
    #   ->  it is 23 mm broad, and points were kept until they had drifted by 6 mm
    high, edge, speed = 0.08, 0.03, 1.0
    with world(friction=0.2) as engine:
        engine.add_brick(Brick("block", Box((2.0 * edge, 0.2, high)), 1.0), Pose((0.0, 0.0, high / 2.0)))
        centre = (edge - WIDTH / 2.0 - 0.003, 0.0, high + THICKNESS / 2.0)
        engine.add_brick(Brick("plank", Box((WIDTH, LENGTH, THICKNESS)), MASS), Pose(centre), (speed, 0.0, 0.0))
        engine.set_max_speed(1.2 * speed)
        while (place := engine.states(["plank"])["plank"].pose.position_W)[2] > high:
            engine.step()
            behind = place[0] - WIDTH / 2.0
            pressed = [point.position_W[0] for point in engine.contacts("plank") if point.normal_force > 0.0]
            assert min(pressed, default=behind) > behind - 0.0003


def test_a_contact_tells_how_much_its_edges_are_rounded() -> None:
    #   Each as much as its thickness asks for; boxes that are set down square are sharp against each other.
    with world(friction=0.5) as engine:
        thick, share = 0.04, MOVING.edge_rounding
        engine.add_brick(Brick("block", Box((0.1, 0.1, thick)), 1.0), Pose((0.0, 0.0, thick / 2.0)))
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, thick + THICKNESS / 2.0)))
        engine.step()
        assert {point.rounded for point in engine.contacts("plank")} == {(0.0, 0.0)}
        engine.bricks.swap("plank")
        engine.step()
        told = {frozenset(zip((point.a, point.b), point.rounded, strict=True)) for point in engine.contacts("plank")}
        (pair,) = told
        assert dict(pair) == pytest.approx({"plank": share * THICKNESS, "block": share * thick})


def test_a_hull_that_comes_to_lie_on_a_face_touches_with_all_its_corners_at_once() -> None:
    with world(friction=0.5) as engine:
        turned = about((0.0, 0.0, 1.0), 0.1 * pi)
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS / 2.0), turned))
        engine.step()
        before = engine.states(["plank"])["plank"]
        engine.bricks.swap("plank")
        find_all_points(engine.bricks, ["plank"])
        assert len(engine.contacts("plank")) == 4
        after = engine.states(["plank"])["plank"]
        assert (after.pose.position_W, after.velocity_W) == (before.pose.position_W, before.velocity_W)


def test_what_is_found_anew_of_a_box_loses_nothing_but_its_forces() -> None:
    with world(friction=0.5) as engine:
        engine.add_brick(Brick("plank", Box(SIZE), MASS), Pose((0.0, 0.0, THICKNESS / 2.0)))
        for _ in range(3):
            engine.step()
        refresh_contacts(engine.bricks, ["plank"])
        assert engine.contacts("plank") == []
        engine.step()
        assert sum(point.normal_force for point in engine.contacts("plank")) == pytest.approx(MASS * GRAVITY, rel=0.01)


def spin_after_sliding_over_an_edge(speed: float, friction: float) -> float:
    """Return the spin of a plank when it leaves an edge that it slid over [rad/s], by its equations of motion.

    At the speed it has got so far that the torque of gravity about the edge overcomes that of friction. It leaves when
    its end has passed the edge, or when nothing presses any more. Steps of two microseconds.
    """
    own_inertia, step = (WIDTH**2 + THICKNESS**2) / 12.0, 2e-6  # of unit mass; [s]
    beyond, turn, slip, spin = -0.5 * friction * THICKNESS, 0.0, speed, 0.0  # of the centre, along the plank [m], [m/s]
    while beyond < 0.5 * WIDTH:
        lever = (beyond + 0.5 * friction * THICKNESS) / own_inertia
        pressed = GRAVITY * cos(turn) - (2.0 * slip + 0.5 * THICKNESS * spin) * spin
        pressed /= 1.0 + beyond * lever
        if pressed <= 0.0:
            break
        along = -friction * pressed + GRAVITY * sin(turn) + beyond * spin**2 - 0.5 * THICKNESS * pressed * lever
        slip, spin = slip + along * step, spin + pressed * lever * step
        beyond, turn = beyond + slip * step, turn + spin * step
    return spin


@pytest.mark.parametrize("speed", [0.4, 0.5, 0.6, 0.8, 1.0])
def test_a_plank_that_slides_over_an_edge_tips_as_fast_as_its_equations_of_motion_say(speed: float) -> None:
    #  <- _____      the block pushes where its edge is, and not at the point of the plank that was there before
    #        |block
    high, friction = 0.06, 0.5
    with world(friction) as engine:
        engine.add_brick(Brick("block", Box((0.2, 0.2, high)), 1.0), Pose((0.0, 0.1, 0.5 * high)))
        engine.freeze("block")
        start = Pose((0.0, 0.5 * friction * THICKNESS, high + 0.5 * THICKNESS))
        engine.add_brick(Brick("plank", Box(SIZE), MASS), start, (0.0, -speed, 0.0))
        engine.set_max_speed(speed)
        spin = 0.0
        for _ in range(round(0.08 / MOVING.time_step)):
            engine.step()
            spin = max(spin, engine.states(["plank"])["plank"].angular_velocity_W[0])
    assert spin == pytest.approx(spin_after_sliding_over_an_edge(speed, friction), rel=0.05)


def test_contact_points_without_friction_equal_the_full_ones() -> None:
    with world(friction=0.5) as engine:
        engine.add_brick(Brick("below", Box(SIZE), MASS), Pose((0.0, 0.0, 0.5 * THICKNESS)))
        engine.add_brick(Brick("above", Box(SIZE), MASS), Pose((0.02, 0.0, 1.5 * THICKNESS)), (0.3, 0.1, 0.0))
        for _ in range(20):
            engine.step()
        told = engine.contacts("above")
        assert any(point.friction_W != AT_REST for point in told)
        assert engine.groups.touching("above", engine.time()) == [replace(each, friction_W=AT_REST) for each in told]


def test_cached_pairs_of_boxes_give_the_same_normals() -> None:
    leaning = Pose((0.0, 0.0, 0.03), about((0.0, 1.0, 0.0), 0.7))
    one, other = block(SIZE, leaning), block(SIZE, Pose((0.02, 0.001, -0.0151), about((1.0, 0.0, 0.0), 0.02)))
    pair, radii = BoxPair(one, other), (1e-4, 1e-4)
    points = [(x, y, -0.0112) for x in (0.03, 0.045, 0.06) for y in (-0.011, 0.0, 0.011)]
    for point in points + points[::-1]:
        assert list(pair.true_normals(point, radii)) == list(true_normals(one, other, point, radii))
