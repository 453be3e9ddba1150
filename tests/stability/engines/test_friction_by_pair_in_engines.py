"""Slip sheets in engines: an engine has the requested friction of each pair, or records the error."""

from collections.abc import Mapping
from math import atan, cos, radians, sin

import numpy as np
import pytest

from stability.contact_law import Friction, Rule
from stability.engines.lazy_world import stepped_world
from stability.engines.mujoco.pair_frictions import GeomFriction, pair_frictions
from stability.engines.protocol import World
from stability.engines.scene_scale import SceneScale
from stability.geometry.box import Box
from stability.geometry.vectors import rotate
from stability.model import GROUND, BodyId, Brick, Plane, Pose
from stackdsl.simulation.known_systems import system_named
from tests.engines_at_hand import WITH_RIGID

SLOPE, GRAVITY, TIME, ROUGH = radians(15.0), 9.81, 0.2, 0.6
TURN = (0.0, sin(0.5 * SLOPE), 0.0, cos(0.5 * SLOPE))
DOWNHILL = (cos(SLOPE), 0.0, -sin(SLOPE))
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (sin(SLOPE), 0.0, cos(SLOPE)), ROUGH)
ENGINES = pytest.mark.parametrize("system", ["stock", "tuned", *WITH_RIGID])


def stacked(system: str, friction: Friction, names: Mapping[BodyId, float]) -> World:
    """Square bricks on a slope, one on the other from the ground on, each so thick [m]."""
    bricks = [Brick(name, Box((0.16, 0.16, thickness)), 0.1) for name, thickness in names.items()]
    settings = system_named(system).engine.scaled(SceneScale.of(bricks, GRAVITY))
    world, height = stepped_world(settings, GRAVITY, friction, 0.1), 0.0
    world.add_plane(FLOOR)
    for brick in bricks:
        thickness = names[brick.id]
        world.add_brick(brick, Pose(rotate(TURN, (0.0, 0.0, height + 0.5 * thickness)), TURN))
        height += thickness
    return world


def slid(system: str, friction: Friction, names: Mapping[BodyId, float]) -> dict[BodyId, float]:
    """How far each has come downhill after TIME [m]."""
    world = stacked(system, friction, names)
    before = world.states(names)
    while world.time() < TIME - 1e-9:
        world.step()
    after = world.states(names)
    assert world.wrong_friction() is None
    world.close()
    return {
        name: float(np.dot(np.subtract(after[name].pose.position_W, before[name].pose.position_W), DOWNHILL))
        for name in names
    }


def way(friction: float) -> float:
    """Return the slide by gravity minus friction in TIME from rest [m]."""
    return 0.5 * GRAVITY * (sin(SLOPE) - friction * cos(SLOPE)) * TIME**2


STACK = {"sheet": 0.02, "low": 0.02, "high": 0.02}
SLIPS = {
    "of its own": Friction(0.5, own={"sheet": 0.1}, between={("sheet", GROUND): ROUGH}),
    "of the pair": Friction(0.5, between={("low", "sheet"): 0.1}),
    "of the kinds": Friction(0.5, between={("foil", "box"): 0.1}, kinds={"sheet": "foil", "low": "box"}),
    "by another rule": Friction(0.04, own={"sheet": 0.25, "high": 0.9, GROUND: 1.0}, rule=Rule.GEOMETRIC),
}


@ENGINES
@pytest.mark.parametrize("case", SLIPS)
def test_a_brick_on_a_sheet_slides_by_the_friction_of_that_pair(system: str, case: str) -> None:
    if case == "by another rule":  # the root of 0.25 and 0.04 is 0.1, and of 0.04 and 0.9 is 0.19
        gone = slid(system, SLIPS[case], {"sheet": 0.02, "low": 0.02})
        high = 0.0
    else:
        gone = slid(system, SLIPS[case], STACK)
        high = gone["high"] - gone["low"]
    assert gone["sheet"] == pytest.approx(0.0, abs=1e-4)
    assert gone["low"] == pytest.approx(way(0.1), rel=0.02)
    assert high == pytest.approx(0.0, abs=5e-4)


@ENGINES
def test_a_sheet_that_is_smooth_on_both_sides_takes_all_on_it_along(system: str) -> None:
    gone = slid(system, Friction(0.5, own={"sheet": 0.1}), STACK)
    assert gone["low"] == pytest.approx(way(0.1), rel=0.03)


@ENGINES
def test_friction_differs_between_pairs_of_one_brick(system: str) -> None:
    gone = slid(system, Friction(0.5, between={("low", "high"): 0.0}), STACK)
    assert gone["low"] == pytest.approx(0.0, abs=1e-4)
    assert gone["high"] == pytest.approx(way(0.0), rel=0.02)


@ENGINES
def test_a_new_brick_has_its_friction_where_others_lie_already(system: str) -> None:
    law = Friction(0.5, own={"late": 0.1})
    world = stacked(system, law, {"low": 0.02})
    for _ in range(20):
        world.step()
    world.add_brick(Brick("late", Box((0.16, 0.16, 0.02)), 0.1), Pose(rotate(TURN, (0.0, 0.0, 0.03)), TURN))
    start, began = world.states(["late"])["late"].pose.position_W, world.time()
    while world.time() < began + TIME - 1e-9:
        world.step()
    gone = float(np.dot(np.subtract(world.states(["late"])["late"].pose.position_W, start), DOWNHILL))
    world.close()
    assert gone == pytest.approx(way(0.1), rel=0.03)


def ring(friction: Friction) -> World:
    """Three bricks that lie on each other and on the floor: two side by side, pressed together, and one on both."""
    bricks = [Brick(name, Box((0.1, 0.1, 0.1)), 0.1) for name in ("left", "right", "top")]
    settings = system_named("tuned").engine.scaled(SceneScale.of(bricks, GRAVITY))
    world = stepped_world(settings, GRAVITY, friction, 0.1)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.4))
    world.add_plane(Plane("wall", (0.1, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.4))
    for brick, (x, z) in zip(bricks, ((-0.05, 0.05), (0.05, 0.05), (0.0, 0.15)), strict=True):
        world.add_brick(brick, Pose((x, 0.0, z)))
    return world


def test_where_no_factors_do_for_all_that_touches_pybullet_tells_the_pair_that_is_furthest_off() -> None:
    # A ring of four: ground-left, left-top, top-right, right-ground has factors only if the products of opposite
    # ones are equal.
    world = ring(Friction(0.4, between={("left", "top"): 0.1}))
    for _ in range(20):
        world.step()
    wrong = world.wrong_friction()
    world.close()
    assert wrong is not None
    assert {wrong.first, wrong.second} <= {"left", "right", "top", GROUND}
    assert wrong.actual != pytest.approx(wrong.requested, rel=0.01)


def test_a_ring_with_exact_factors_records_no_friction_error() -> None:
    world = ring(Friction(0.4, between={("left", "top"): 0.1, ("right", "top"): 0.1}))
    for _ in range(20):
        world.step()
    told = world.wrong_friction()
    world.close()
    assert told is None


def test_a_single_friction_coefficient_needs_no_pairs() -> None:
    told = pair_frictions(Friction(0.5), [FLOOR], ["a", "b"])
    assert told.shapes == {GROUND: GeomFriction(ROUGH, 1), "a": GeomFriction(0.5), "b": GeomFriction(0.5)}
    assert told.pairs == ()


def test_the_lower_of_two_is_had_by_priorities_without_naming_a_pair() -> None:
    sheets = {f"s{number}": 0.1 + 0.01 * number for number in range(3)}
    told = pair_frictions(Friction(0.5, own=sheets), [FLOOR], ["c1", "c2", *sheets])
    assert told.pairs == []
    by_priority = sorted(told.shapes, key=lambda name: told.shapes[name].priority)
    assert by_priority == ["c1", "c2", GROUND, "s2", "s1", "s0"]


@pytest.mark.parametrize("rule", list(Rule))
def test_whatever_priorities_do_not_give_is_said_of_the_pair(rule: Rule) -> None:
    names = ["a", "b", "c", "d", "e"]
    law = Friction(
        0.5, {"a": 0.1, "b": 0.7, "d": 0.1}, {("c", "a"): 0.3, ("foil", "foil"): 0.2}, {"d": "foil", "e": "foil"}, rule
    )
    told = pair_frictions(law, [FLOOR], names)
    said = {frozenset((one, other)): friction for one, other, friction in told.pairs}
    for index, one in enumerate(names):
        for other in (*names[index + 1 :], GROUND):
            asked = law.on(one, FLOOR) if other == GROUND else law.of(one, other)
            shapes = sorted((told.shapes[one], told.shapes[other]), key=lambda shape: (shape.priority, shape.friction))
            assert said.get(frozenset((one, other)), shapes[1].friction) == asked


def test_the_slope_of_these_tests_is_steeper_than_the_smooth_sheet_and_flatter_than_all_else() -> None:
    assert atan(0.1) < SLOPE < atan(0.5)
