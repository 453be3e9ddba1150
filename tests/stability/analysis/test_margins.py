"""By how much assemblies stand, against closed forms. Contacts are written by hand: nothing here detects any."""

from dataclasses import replace
from functools import cache
from math import atan, cos, inf, pi, sin, tan
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stability.analysis.acceleration_cut import shaken
from stability.analysis.acceleration_margin import acceleration, hold_along, tilt
from stability.analysis.margins import Margins, least_friction, margins
from stability.analysis.placement_margin import placement
from stability.contact_law import Coulomb
from stability.model import Vec3
from stability.problem import Contact, PlacementLimit, Problem, Tolerances, Wrench
from stability.statics.equilibrium import balance
from tests.stability.analysis.margin_scenes import (
    LENGTH,
    STEEP,
    THICKNESS,
    WIDTH,
    Upright,
    block,
    changed,
    column,
    four_stack,
    leaning,
    on_incline,
    upright_boxes,
)

LEAST = (1.0 / tan(STEEP) - THICKNESS / LENGTH) / 2.0  # friction of a ladder so steep, and of an inverted V


def accelerated(problem: Problem, tolerance: float = 1e-6) -> float:
    margin = acceleration(problem, tolerance)
    assert margin is not None
    assert margin.value <= margin.upper <= margin.value * (1.0 + 2.0 * tolerance) + 1e-7
    return margin.value


@pytest.mark.parametrize(
    ("size", "friction", "limit"),
    [((0.2, 0.05, 0.2), 0.9, 0.25), ((0.1, 0.1, 0.05), 0.5, 0.5), ((0.2, 0.05, 0.1), 0.51, 0.5)],
    ids=["tips over its long edge", "slides alike in all directions", "tips just before it slides"],
)
def test_a_block_survives_the_lesser_of_its_friction_and_its_slenderness(
    size: Vec3, friction: float, limit: float
) -> None:
    assert accelerated(block(*size, friction)) == pytest.approx(limit, rel=2e-6)


SLIDING = {
    "1 cube": (upright_boxes([("cube", 0.0, 0.0, 0.0, (0.1, 0.1, 0.1))], 0.6), 0.6),
    "1 block that would as soon tip": (block(0.1, 0.1, 0.1 / 0.505, 0.5), 0.5),
    "5 planks": (column(5), 0.5),
    "5 planks, stepped": (column(5, 0.02), 0.5),
    "20 planks": (column(20, friction=0.1), 0.1),
    "20 planks that would as soon tip": (column(20, friction=0.149), 0.149),
    "20 planks crosswise": (upright_boxes(four_stack(10)), 0.5),
    "60 planks crosswise": (upright_boxes(four_stack(30), 0.2), 0.2),
}


@pytest.mark.parametrize("name", SLIDING)
def test_the_acceleration_margin_of_a_low_brick_is_its_friction_in_all_directions(name: str) -> None:
    problem, friction = SLIDING[name]
    margin = acceleration(problem)
    assert margin is not None
    assert margin.upper == pytest.approx(friction, rel=1e-8)
    assert margin.value == pytest.approx(friction, rel=1.001e-6)
    assert margin.headings == 4  # a disc takes hundreds of chords, or forces that hold all along its arcs
    assert margin.motion is not None
    assert set(margin.motion.velocity) == set(problem.bricks)


@pytest.mark.parametrize("name", ["1 cube", "5 planks, stepped", "20 planks crosswise"])
@pytest.mark.parametrize(("size", "weight", "yaw"), [(1e-3, 1e5, 0.3), (1e3, 1e-5, 2.0), (1.0, 1.0, -1.1)])
def test_sliding_does_not_depend_on_size_weight_yaw_or_order(name: str, size: float, weight: float, yaw: float) -> None:
    problem, friction = SLIDING[name]
    margin = acceleration(changed(problem, size, weight, yaw))
    assert margin is not None
    assert margin.value == pytest.approx(friction, rel=1.001e-6)
    assert margin.headings == 4


@pytest.mark.parametrize(
    ("frictions", "moving"),
    [((0.4, 0.3, 0.2), {"b002"}), ((0.4, 0.2, 0.3), {"b001", "b002"}), ((0.2, 0.3, 0.4), {"b000", "b001", "b002"})],
)
def test_a_column_slides_on_its_slickest_joint_with_all_that_is_above(
    frictions: tuple[float, ...], moving: set[str]
) -> None:
    problem = column(3)
    contacts = [replace(one, law=Coulomb(own)) for one, own in zip(problem.contacts, frictions, strict=True)]
    margin = acceleration(replace(problem, contacts=contacts))
    assert margin is not None
    assert margin.value == pytest.approx(0.2, rel=1.001e-6)
    assert margin.upper == pytest.approx(0.2, rel=1e-8)
    assert margin.headings == 4
    assert margin.motion is not None
    assert set(margin.motion.velocity) == moving


def test_a_slick_post_that_bears_too_little_does_not_let_a_plank_slide_earlier_in_all_directions() -> None:
    #   The plank rests on its left post, which is rough, and may rest on its right one, which is slick.
    post, beam = (0.1, 0.1, 0.1), (0.4, 0.1, 0.05)
    problem = upright_boxes(
        [("left", -0.03, 0.0, 0.0, post), ("right", 0.15, 0.0, 0.0, post), ("beam", 0.0, 0.0, 0.1, beam)]
    )
    contacts = [replace(one, law=Coulomb(0.1)) if one.lower == "right" else one for one in problem.contacts]
    assert accelerated(replace(problem, contacts=contacts)) > 0.4


@pytest.mark.parametrize("beyond", [1.0 + 1e-6, 1.1])
def test_no_parallel_forces_hold_more_than_a_block_survives(beyond: float) -> None:
    #   From edge to edge of a square, between a quarter of the directions and the next, they hold all that it survives.
    for problem in (block(0.1, 0.1, 0.2, 0.9), block(0.1, 0.1, 0.15, 0.5)):  # tips; slides
        case = shaken(problem, None, Tolerances())
        assert case is not None
        assert hold_along(case, 0.5 * (1.0 - 1e-6), pi / 4.0, pi / 2.0)
        assert not hold_along(case, 0.5 * beyond, pi / 4.0, pi / 2.0)


def test_whatever_the_parallel_forces_hold_along_an_arc_is_held_by_forces_in_each_of_its_directions() -> None:
    problem = changed(column(5, 0.02), 1.0, 1.0, 0.4)
    case = shaken(problem, None, Tolerances())
    assert case is not None
    held = [bearing for bearing in range(12) if hold_along(case, 0.499, bearing * pi / 6.0, 0.1)]
    assert len(held) == 12
    for bearing in held:
        for aside in (-0.05, 0.0, 0.03):
            assert balance(pulled(problem, 0.499, bearing * pi / 6.0 + aside)).forces is not None


def test_a_block_that_is_pushed_aside_survives_only_what_friction_is_left() -> None:
    problem = block(0.1, 0.1, 0.05, 0.5)
    weight = -problem.loads["block"].force_W[2]
    pushed = replace(problem, loads={"block": Wrench((0.2 * weight, 0.0, -weight))})
    assert accelerated(pushed) == pytest.approx(0.3, rel=2e-6)


def test_the_worst_direction_is_across_the_long_edge_over_which_it_tips() -> None:
    margin = acceleration(changed(block(0.2, 0.05, 0.2, 0.9), 1.0, 1.0, 0.3))
    assert margin is not None
    assert cos(margin.bearing - 0.3) == pytest.approx(0.0, abs=1e-6)
    assert margin.motion is not None
    assert set(margin.motion.velocity) == {"block"}


def test_a_stepped_column_survives_less_towards_its_steps() -> None:
    #   Four planks stepped by 20 mm tip to the side: 11.7 mm over a height of 15.6 mm. Stepped by 28 mm, the upper
    #   three tip towards the steps: their centre is 56 mm out of 58.8 mm, 11.7 mm above the joint.
    assert accelerated(column(4, 0.02, 2.0)) == pytest.approx(0.75, rel=1e-6)
    assert accelerated(column(4, 0.028, 2.0)) == pytest.approx((58.8 - 56.0) / 11.7, rel=1e-6)


def test_a_ground_tilted_by_the_angle_of_friction_less_the_slope_lets_a_cube_slide() -> None:
    assert tilt(accelerated(on_incline(0.1, 0.5))) == pytest.approx(atan(0.5) - 0.1, rel=2e-6)


@pytest.mark.parametrize("scene", [upright_boxes(four_stack(5)), leaning(0.7, mirrored=True), column(5, 0.015, 0.4)])
def test_no_verdict_on_an_accelerated_assembly_contradicts_its_margin(scene: Problem) -> None:
    margin = acceleration(scene, 1e-3)
    assert margin is not None
    for step in range(12):
        assert balance(pulled(scene, margin.value, margin.bearing + step * pi / 6.0)).forces is not None
    assert balance(pulled(scene, margin.upper * (1.0 + 1e-6), margin.bearing)).motion is not None


def pulled(problem: Problem, acceleration_g: float, bearing: float) -> Problem:
    loads = {}
    for name, load in problem.loads.items():
        weight = -load.force_W[2]
        along = (acceleration_g * weight * cos(bearing), acceleration_g * weight * sin(bearing))
        loads[name] = Wrench((*along, -weight))
    return replace(problem, loads=loads)


def test_the_acceleration_margin_at_the_limit_is_zero() -> None:
    margin = acceleration(column(10, LENGTH / 10.0))
    assert margin is not None
    assert margin.value == 0.0
    assert margin.upper < 1e-6


def test_a_falling_structure_has_no_margins() -> None:
    assert acceleration(column(20, 0.03)) is None
    assert margins(column(20, 0.03)) is None


def test_a_block_held_on_all_sides_survives_any_acceleration() -> None:
    problem = block(0.1, 0.1, 0.1, 0.5)
    corners: tuple[Vec3, ...] = ((0.05, -0.05, 0.0), (0.05, 0.05, 0.0), (0.05, 0.05, 0.1), (0.05, -0.05, 0.1))
    walls = []
    for turn in range(4):
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[turn]
        points: tuple[Vec3, ...] = tuple((c * x - s * y, s * x + c * y, z) for x, y, z in corners)
        walls.append(Contact(f"wall {turn}", "block", points, ((-c, -s, 0.0),), Coulomb(0.5)))
    margin = acceleration(replace(problem, contacts=[*problem.contacts, *walls]))
    assert margin is not None
    assert margin.value == inf


@pytest.mark.parametrize("friction", [0.2, 0.3, 1.0])
@pytest.mark.parametrize("mirrored", [False, True], ids=["ladder", "inverted V"])
def test_planks_that_lean_need_half_the_cotangent_less_their_slenderness(friction: float, mirrored: bool) -> None:
    margin = least_friction(leaning(friction, mirrored))
    assert margin.coefficient == pytest.approx(LEAST, rel=1e-6)
    assert margin.too_little * friction == pytest.approx(LEAST, rel=1e-6)


def test_a_cube_on_an_incline_needs_the_tangent_of_its_slope() -> None:
    assert least_friction(on_incline(0.3, 0.5)).coefficient == pytest.approx(tan(0.3), rel=1e-6)


def test_flat_stacks_need_no_friction_and_what_topples_is_not_saved_by_any() -> None:
    assert least_friction(column(3, 0.02)).factor == 0.0
    assert least_friction(on_incline(0.8, 0.5)).factor == inf


@pytest.mark.parametrize("count", [2, 5, 12])
def test_planks_of_a_column_may_sit_off_by_a_quarter_of_their_width(count: int) -> None:
    #   At every joint the face below moves one way and all above it the other: half of half the width is left.
    assert placement(column(count)).value == pytest.approx(WIDTH / 4.0, rel=1e-6)


def test_a_plank_that_hangs_over_may_sit_off_by_half_of_what_its_centre_is_inside() -> None:
    size = (0.1, 0.1, 0.01)
    margin = placement(upright_boxes([("below", 0.0, 0.0, 0.0, size), ("above", 0.03, 0.0, 0.01, size)]))
    assert margin.value == pytest.approx((0.05 - 0.03) / 2.0, rel=1e-6)
    assert margin.limits == (PlacementLimit("below", "above", (0.0,)),)


@pytest.mark.parametrize("count", [4, 9, 12])
def test_a_column_at_its_exact_limit_has_no_reserve_and_is_limited_by_its_lowest_contact(count: int) -> None:
    margin = placement(column(count, LENGTH / count))
    assert margin.value == 0.0
    assert margin.limits == (PlacementLimit("b000", "b001", (0.0,)),)


def test_all_contacts_that_limit_a_placement_error_equally_are_named_with_their_directions() -> None:
    for count in (3, 9):
        limits = placement(column(count)).limits
        assert [(each.lower, each.upper) for each in limits] == [(f"b{n:03}", f"b{n + 1:03}") for n in range(count - 1)]
        assert {each.bearings for each in limits} == {(pi / 2.0, 3.0 * pi / 2.0)}


def test_bricks_on_the_ground_may_sit_anywhere() -> None:
    size = (0.1, 0.1, 0.1)
    assert placement(upright_boxes([("a", 0.0, 0.0, 0.0, size), ("b", 1.0, 0.0, 0.0, size)])).value == inf


def test_the_placement_margin_of_bricks_on_edges_is_zero() -> None:
    margin = placement(leaning(1.0, mirrored=True))
    assert margin.value == 0.0
    assert "edges" in margin.reason


@pytest.mark.parametrize(
    "boxes",
    [four_stack(4), [(f"b{i}", 0.012 * i, 0.002 * i, i * 0.01, (0.1, 0.04, 0.01)) for i in range(4)]],
    ids=["four-stack", "stepped column"],
)
def test_whatever_errors_within_the_margin_the_stack_stands(boxes: list[Upright]) -> None:
    margin = placement(upright_boxes(boxes)).value
    assert margin > 1e-3
    random = Random(1)
    for _ in range(30):
        turns = [random.uniform(0.0, 2.0 * pi) for _ in boxes]
        off = [
            (n, x + margin * cos(a), y + margin * sin(a), z, s) for (n, x, y, z, s), a in zip(boxes, turns, strict=True)
        ]
        assert balance(upright_boxes(off)).forces is not None


def test_no_stack_of_crossed_planks_survives_more_than_a_column_of_its_patches_would() -> None:
    assert WIDTH / 4.0 * 0.94 < placement(upright_boxes(four_stack(6))).value <= WIDTH / 4.0 * (1.0 + 1e-6)


PLACED = {"stepped": column(4, 0.02, 0.9), "leaning": leaning(0.7, mirrored=True)}


@cache  # all changes are held against it
def as_placed(scene: str) -> Margins | None:
    return margins(PLACED[scene])


@settings(max_examples=4, deadline=None)
@given(
    st.sampled_from([1e-3, 0.3, 1.0, 1e3]),
    st.sampled_from([1e-5, 1.0, 1e5]),
    st.floats(0.0, 2.0 * pi),
    st.sampled_from(["stepped", "leaning"]),
)
def test_margins_do_not_depend_on_size_weight_yaw_or_order(size: float, weight: float, yaw: float, scene: str) -> None:
    problem = PLACED[scene]
    seen, wanted = margins(changed(problem, size, weight, yaw)), as_placed(scene)
    assert seen is not None
    assert wanted is not None
    assert seen.acceleration_g == pytest.approx(wanted.acceleration_g, rel=2e-6)
    assert seen.tilt == pytest.approx(wanted.tilt, rel=2e-6)
    assert seen.friction == pytest.approx(wanted.friction, rel=1e-6)
    assert seen.placement == pytest.approx(size * wanted.placement, rel=1e-6)


def test_a_beam_on_two_posts_may_sit_off_across_by_nearly_a_quarter_of_their_width() -> None:
    #   Nearly: its weight shifts between the posts too, and the linear rule cannot know both at once.
    post, beam = (0.1, 0.1, 0.1), (0.4, 0.1, 0.05)
    posts = [(f"post {side}", 0.15 * side, 0.0, 0.0, post) for side in (-1, 1)]
    margin = placement(upright_boxes([*posts, ("beam", 0.0, 0.0, 0.1, beam)]))
    assert 0.95 * 0.025 < margin.value <= 0.025


def test_blocks_that_a_light_beam_ties_by_friction_alone_survive_small_errors() -> None:
    #   Each upper block hangs 10 mm too far outwards. The beam's weight on its inner edge holds 40 % of that back, the
    #   beam's friction the rest.
    cube, beam = (0.1, 0.1, 0.1), (0.52, 0.1, 0.005)
    boxes = [(f"base {side}", 0.2 * side, 0.0, 0.0, cube) for side in (-1, 1)]
    boxes += [(f"block {side}", 0.26 * side, 0.0, 0.1, cube) for side in (-1, 1)]
    problem = upright_boxes([*boxes, ("beam", 0.0, 0.0, 0.2, beam)], 0.9)
    assert least_friction(problem).factor > 0.1
    assert 1e-4 < placement(problem).value < 0.025
