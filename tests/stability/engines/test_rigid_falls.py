"""Falls, slips and landings on the rigid-body engine, with every brick awake, against closed forms."""

from collections.abc import Iterable
from dataclasses import replace
from math import cos, radians, sin

import numpy as np
import pytest

from benchmarks.movers import Scene, scenes_of_boxes
from stability.contact_law import Friction, GivenFriction
from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.geometry.vectors import about, norm, rotate
from stability.model import GROUND, Brick, Plane, Pose
from stackdsl.language.layouts.wall import WallParams, wall
from stackdsl.simulation.systems import PEERS, RIGID
from tests.planks import LENGTH, MASS, THICKNESS, WIDTH

GRAVITY = 9.81
TOLERANCES = {"falling columns and towers": 0.025, "slips": 0.01, "rolling, rocking, landing": 0.01}
SLOW = ("tower", "askew", "chain")


def known_scenes() -> Iterable[object]:
    """Yield the scenes with a closed form, or with integrated equations of motion."""
    for scene in scenes_of_boxes():
        if scene.kind in TOLERANCES:
            slow = any(word in scene.name for word in SLOW)
            yield pytest.param(scene, id=scene.name, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize("scene", list(known_scenes()))
def test_bricks_that_fall_slip_rock_or_land_take_the_time_of_their_equations(scene: Scene) -> None:
    truth = scene.known()
    assert scene.measured(PEERS["rigid"]).value == pytest.approx(truth.value, rel=TOLERANCES[scene.kind])


PLANKS = 20  # in each of as many courses


def test_a_wall_comes_to_rest_after_a_tap_on_one_plank() -> None:
    world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    for number, spec in enumerate(wall(WallParams(levels=PLANKS, bricks=PLANKS), (LENGTH, WIDTH, THICKNESS))):
        size = spec.size or (LENGTH, WIDTH, THICKNESS)
        world.add_brick(Brick(f"{number}", Box(size), MASS * size[0] / LENGTH), Pose(spec.position))
    tapped = f"{PLANKS * PLANKS // 2}"
    world.push(tapped, (0.0, 0.05 * MASS, 0.0), world.states([tapped])[tapped].pose.position_W)
    for _ in range(60):
        world.step()
    assert max(norm(state.velocity_W) for state in world.states([*world.own.bricks]).values()) < 0.002


def test_a_light_sheet_bears_a_block_of_a_thousand_times_its_mass() -> None:
    world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    world.add_brick(Brick("sheet", Box((0.1, 0.1, 0.004)), 0.001), Pose((0.0, 0.0, 0.002)))
    world.add_brick(Brick("block", Box((0.08, 0.08, 0.05)), 1.0), Pose((0.0, 0.0, 0.029)), (0.0, 0.0, -0.1))
    for _ in range(500):
        world.step()
    assert world.states(["block"])["block"].pose.position_W[2] == pytest.approx(0.029, abs=7e-5)


SLOPE, STEPS = radians(15.0), 100
TURN = about((0.0, 1.0, 0.0), SLOPE)


def test_a_foil_that_is_jammed_below_a_brick_does_not_throw_it_when_it_is_released() -> None:
    """The springs of the foil pushed ever harder, as neither the fixed brick nor the ground gave way."""
    world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    thick = 7e-5
    world.add_brick(Brick("foil", Box((0.09, 0.02, thick)), 7e-5), Pose((0.0, 0.0, 0.5 * thick)), (0.0, 0.0, -0.1))
    world.add_brick(Brick("brick", Box((0.02, 0.02, 0.02)), 0.008), Pose((0.0, 0.0, 0.01)))
    world.freeze("brick")
    for _ in range(200):
        world.step()
    world.wake("brick")
    for _ in range(20):
        world.step()
        assert world.states(["brick"])["brick"].pose.position_W[2] < 0.01 + thick


def ways(friction: GivenFriction, thick: float = 0.02) -> dict[str, float]:
    """Return the ways that a sheet on a slope and an equally heavy block on it slide downhill in 0.1 s [m]."""
    world = RigidWorld.opened(RIGID, GRAVITY, friction)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (sin(SLOPE), 0.0, cos(SLOPE)), 0.9))
    starts = {}
    for name, size, height in (
        ("sheet", (0.6, 0.3, thick), 0.5 * thick),
        ("block", (0.1, 0.1, 0.02), thick + 0.01),
    ):
        starts[name] = rotate(TURN, (0.0, 0.0, height))
        world.add_brick(Brick(name, Box(size), 0.5), Pose(starts[name], TURN))
    for _ in range(STEPS):
        world.step()
    states = world.states(list(starts))
    return {name: (states[name].pose.position_W[0] - start[0]) / cos(SLOPE) for name, start in starts.items()}


def way(acceleration: float) -> float:
    """Return the way from rest with an acceleration in units of gravity [m]."""
    return 0.5 * GRAVITY * acceleration * (STEPS * RIGID.time_step) ** 2


def test_a_block_slides_down_its_sheet_by_the_friction_of_the_two() -> None:
    gone = ways(Friction(0.9, between={("sheet", "block"): 0.1}))
    assert gone["block"] == pytest.approx(way(sin(SLOPE) - 0.1 * cos(SLOPE)), rel=1e-4)
    assert gone["sheet"] == pytest.approx(0.0, abs=1e-6)


def test_a_sheet_slides_with_its_load_by_its_friction_on_the_ground() -> None:
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.1}))
    assert gone == pytest.approx(dict.fromkeys(gone, way(sin(SLOPE) - 0.1 * cos(SLOPE))), rel=1e-4)


def test_sheet_and_brick_each_slide_by_their_own_friction_law() -> None:
    # The block, as heavy as the sheet, pulls it downhill by 0.15, and the ground holds both back by 0.2 of both.
    gone = ways(Friction(0.9, between={("sheet", GROUND): 0.2, ("sheet", "block"): 0.15}))
    assert gone["block"] == pytest.approx(way(sin(SLOPE) - 0.15 * cos(SLOPE)), rel=1e-4)
    assert gone["sheet"] == pytest.approx(way(sin(SLOPE) + (0.15 - 2.0 * 0.2) * cos(SLOPE)), rel=1e-4)


@pytest.mark.parametrize("seed", range(20))
def test_a_plank_touches_the_plank_below_only_where_their_faces_overlap(seed: int) -> None:
    """Sides that are flush but for rounding were taken to cross far outside of the common area."""
    rounding = np.random.default_rng(seed).normal(size=(2, 3)) * 2e-9
    world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
    for name, x, z, nudge in (("lower", 0.0, 0.0, rounding[0]), ("upper", 0.026, 0.0078, rounding[1])):
        turn = about((0.0, 0.0, 1.0), nudge[2] / 0.0588)
        world.add_brick(Brick(name, Box((0.1176, 0.0234, 0.0078)), 0.012), Pose((x + nudge[0], nudge[1], z), turn))
    world.freeze("lower")
    world.step()
    points = world.contacts("upper")
    assert len(points) >= 4
    for point in points:
        assert 0.026 - 0.0588 - 1e-6 < point.position_W[0] < 0.0588 + 1e-6
        assert abs(point.position_W[1]) < 0.0117 + 1e-6


def test_two_planks_whose_ends_meet_along_a_line_push_each_other_level() -> None:
    """At 45 deg the end of one lies in the plane of the side of the other, and is no face that carries."""
    world = RigidWorld.opened(RIGID, GRAVITY, 0.5)
    half, thick, lean = 0.0588, 0.0078, radians(45.0)
    for name, side in (("left", -1.0), ("right", 1.0)):
        reach = half * cos(lean) + 0.5 * thick * sin(lean)
        height = half * sin(lean) + 0.5 * thick * cos(lean)
        turn = about((0.0, 1.0, 0.0), side * lean)
        world.add_brick(Brick(name, Box((2.0 * half, 0.0234, thick)), 0.012), Pose((side * reach, 0.0, height), turn))
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.9))
    for _ in range(10):  # the edges are rounded by 0.1 mm, and meet after 3 ms
        world.step()
    pushing = [
        point for point in world.contacts("left") if GROUND not in (point.a, point.b) and point.normal_force > 0.0
    ]
    assert pushing
    assert all(abs(point.normal_BA_W[0]) == pytest.approx(1.0, abs=1e-3) for point in pushing)


def test_a_brick_that_leaves_a_rigid_group_keeps_the_places_of_its_contacts() -> None:
    world = RigidWorld.opened(replace(RIGID), GRAVITY, 0.5)
    world.add_plane(Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5))
    for k in range(3):
        world.add_brick(Brick(f"b{k}", Box((0.02, 0.02, 0.02)), 0.01), Pose((0.0, 0.0, 0.01 + 0.02 * k)))
    world.weld(["b1", "b2"])
    world.step()
    before = sorted(point.position_W for point in world.contacts("b1"))
    world.unweld("b2")
    assert sorted(point.position_W for point in world.contacts("b1")) == before
