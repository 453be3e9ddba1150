"""Supports that move until the structure falls, against closed forms and a programme written apart."""

from math import atan, cos, degrees, inf, sin, sqrt

import pytest

from stability.analysis.large_motion import LargeMotion, pushover, support_path
from stackdsl.judging.proofs import finished_structure_of
from stackdsl.studies.find_limit import LimitRequest, Want, find_in
from tests.scenes import compiled, mistakes_of, scene, timeline_of
from tests.stackdsl.supports.spreading_arch import Arch

ACCURACY = 1e-6


def moved(build: str, scene: str, until: float = inf) -> LargeMotion:
    timeline = timeline_of(build, scene)
    assembly = finished_structure_of(timeline).assembly
    return support_path(assembly.problem(), timeline.world.supports, assembly.loads, until=until)


def arch(stones: int, thickness: float, supports: str, heading: float = 0.0, size: float = 1.0) -> LargeMotion:
    span = 2.0 * (1.0 - thickness / 2.0) * size
    build = (
        f"- arch: {{span: {span} m, thickness: {thickness * size} m, voussoirs: {stones}, depth: 1 m, "
        f"heading: {heading} deg}}"
    )
    return moved(build, f"\nbrick: {{size: [1 m, 1 m, 1 m], density: 1000 kg/m3}}\nfriction: 0.9\n{supports}")


@pytest.mark.parametrize(("stones", "thickness"), [(12, 0.15), (16, 0.12)])
def test_an_arch_on_spreading_springings_falls_as_three_hinges_and_the_line_of_thrust_say(
    stones: int, thickness: float
) -> None:
    by = "{{under: L1.{}, by: [{} mm, 0 mm, 0 mm]}}"
    found = arch(stones, thickness, f"supports: [{by.format(1, -1)}, {by.format(stones, 1)}]")
    truth = Arch(stones, thickness)
    assert 0.001 * found.holds == pytest.approx(truth.largest_spread(), rel=ACCURACY)
    assert found.falls == pytest.approx(found.holds, rel=ACCURACY)
    # Three hinges, on the inner side at the haunches and on the outer side at the crown.
    first, haunch = found.positions[0], truth.inner(truth.hinge())
    assert sorted(hinge.point_W for hinge in first.hinges) == [
        pytest.approx(place, abs=1e-5)
        for place in ((haunch[0], 0, haunch[1]), (0, 0, 1 + thickness / 2), (-haunch[0], 0, haunch[1]))
    ]
    for position in found.positions:
        thrust = position.reactions_W[0][0] / (9810.0 * truth.weight)
        wanted = truth.thrust(truth.hinge(), 0.001 * position.amount) / truth.weight
        assert thrust == pytest.approx(wanted, rel=ACCURACY)


def test_only_the_distance_of_the_springings_counts_and_neither_heading_nor_scale() -> None:
    whole = arch(12, 0.15, "supports: [{under: L1.1, by: [-1 mm, 0 mm, 0 mm]}]")
    assert 0.0005 * whole.holds == pytest.approx(Arch(12, 0.15).largest_spread(), rel=ACCURACY)
    turned = arch(12, 0.15, "supports: [{under: L1.1, by: [0 mm, -3 mm, 0 mm]}]", heading=90.0, size=3.0)
    assert turned.holds == pytest.approx(whole.holds, rel=ACCURACY)


WALL = "\nbrick: {size: [0.4 m, 1 m, 0.5 m], density: 2000 kg/m3}"


@pytest.mark.parametrize(("friction", "limit"), [(0.8, degrees(atan(0.4 / 1.0))), (0.3, degrees(atan(0.3)))])
def test_a_wall_on_a_tilting_support_tips_at_its_slenderness_or_slides_at_its_friction(
    friction: float, limit: float
) -> None:
    supports = "supports: [{under: L1.1, turn: -1 deg, about: 90 deg}]"
    found = moved("- column: {levels: 2}", f"{WALL}\nfriction: {friction}\n{supports}")
    assert found.holds == pytest.approx(limit, rel=ACCURACY)
    assert found.falls == pytest.approx(limit, rel=ACCURACY)


def test_a_wall_turns_with_its_support_and_stands() -> None:
    rest = f"{WALL}\nfriction: 0.5\nsupports: [{{under: L1.1, turn: 20 deg, about: up, by: [0.1 m, 0 m, -0.2 m]}}]"
    found = moved("- column: {levels: 2}", rest, until=1.0)
    assert (found.holds, found.falls) == (1.0, inf)
    assert found.positions[-1].poses["L2.1"].position_W == pytest.approx((0.1, 0.0, 0.55))
    assert not found.positions[-1].hinges


def test_a_plank_over_a_settling_support_tilts_about_the_edges_of_both_supports() -> None:
    # Both supports touch the plank at the edge towards the sinking one, 2 m apart; the plank slips on the other one.
    build = """- bricks:
    - {name: left, at: [-1 m, 0 m, 0.25 m], brick: {size: [0.2 m, 0.3 m, 0.5 m], mass: 50 kg}}
    - {name: right, at: [1 m, 0 m, 0.25 m], brick: {size: [0.2 m, 0.3 m, 0.5 m], mass: 50 kg}}
    - {name: plank, at: [0 m, 0 m, 0.525 m], brick: {size: [2.4 m, 0.3 m, 0.05 m], mass: 20 kg}}"""
    rest = "\nfriction: 0.5\nsupports: [{under: right, by: [0 m, 0 m, -0.2 m]}]"
    found = moved(build, rest, until=1.0)
    assert found.holds == 1.0
    last = found.positions[-1]
    angle = atan(0.2 / 2.0)
    x, _, z, w = last.poses["plank"].orientation
    assert (x, z) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert last.poses["plank"].orientation[1] == pytest.approx(sin(angle / 2), rel=ACCURACY)
    assert w == pytest.approx(cos(angle / 2), rel=ACCURACY)
    assert {(hinge.lower, hinge.upper) for hinge in last.hinges} >= {("left", "plank"), ("right", "plank")}


def test_a_block_pushed_over_bears_less_the_further_it_turns() -> None:
    #  F at 0.85 m above the ground; about the edge, F z = W x, until the centre of mass stands over the edge.
    block = "\nbrick: {size: [0.3 m, 0.4 m, 0.9 m], mass: 20 kg}\nfriction: 0.6"
    load = "loads: [{force: 10 N, towards: 0 deg, brick: L1.1, point: [0 m, 0 m, 0.4 m]}]"
    timeline = timeline_of("- column: {levels: 1}", f"{block}\n{load}")
    assembly = finished_structure_of(timeline).assembly
    found = pushover(assembly.problem(), timeline.final_world.loads)
    assert found.positions[0].factor == pytest.approx(20 * 9.81 * 0.15 / 0.85 / 10, rel=1e-5)
    for position in found.positions:
        _, y, _, w = position.poses["L1.1"].orientation
        s, c = 2 * y * w, 1 - 2 * y * y
        arm, height = 0.15 * c - 0.45 * s, 0.15 * s + 0.85 * c
        assert position.factor == pytest.approx(20 * 9.81 * arm / height / 10, abs=1e-6)
        assert position.amount == pytest.approx(0.15 - 0.15 * c + 0.85 * s, abs=1e-9)
    overturns = 0.15 - 0.15 * 0.45 / sqrt(0.225) + 0.85 * 0.15 / sqrt(0.225)
    assert found.holds == pytest.approx(overturns, rel=ACCURACY)
    assert found.falls == pytest.approx(overturns, rel=ACCURACY)


def test_find_gives_the_largest_settlement_in_the_unit_of_the_movement() -> None:
    supports = "supports: [{under: L1.1, turn: 2 deg, about: 0 deg}]"
    (case,), _ = compiled(scene("- column: {levels: 2}", f"{WALL}\nfriction: 0.8\n{supports}"))
    found = find_in(case, "wall", LimitRequest(Want.LARGEST, "settlement"))
    assert found.stands == pytest.approx(degrees(atan(0.8)), rel=ACCURACY)
    assert found.unit == "deg"
    assert found.written == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("support", "code", "words"),
    [
        ("{under: ^L9.1, by: [1 mm, 0 mm, 0 mm]}", "SD204", "no brick 'L9.1'"),
        ("{under: ^L2.1, by: [1 mm, 0 mm, 0 mm]}", "SD204", "does not stay on the ground"),
        ("^{under: L1.1}", "SD102", "no condition"),
        ("^{under: L1.1, turn: 2 deg}", "SD102", "no axis"),
        ("^{under: L1.1, by: [1 mm, 0 mm, 0 mm], about: up}", "SD108", "needs a `turn`"),
        ("^{under: L1.1, by: [0 mm, 0 mm, 0 mm]}", "SD104", "does not move"),
        ("{under: L1.1, turn: ^2 mm, about: up}", "SD106", "an angle"),
        ("{under: L1.1, turn: 2 deg, about: ^north}", "SD104", "not a direction"),
        ("{under: [L1.1, ^L1.1], by: [1 mm, 0 mm, 0 mm]}", "SD104", "already has a moving support"),
    ],
)
def test_a_mistake_in_a_support_is_told_at_its_place(support: str, code: str, words: str) -> None:
    (mistake,) = mistakes_of("- column: {levels: 2}", f"{WALL}\nsupports: [{support.replace('^', '')}]")
    assert mistake.code == code
    assert mistake.span.column == len("supports: [") + support.index("^") + 1
    assert words in mistake.message
    assert mistake.hint


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("systems: [exact, tuned]", "not on the system 'tuned'"),
        ("expect: [{stands: all}]", "not played"),
        ("joints: [{pull: 2 N}]", "not computed for joined bricks"),
    ],
)
def test_what_is_not_computed_on_moving_supports_is_refused(more: str, words: str) -> None:
    rest = f"{WALL}\nsupports: [{{under: L1.1, by: [1 mm, 0 mm, 0 mm]}}]\n{more}"
    assert words in mistakes_of("- column: {levels: 2}", rest)[0].message


def test_a_plank_slides_on_supports_that_spread_and_keeps_its_height() -> None:
    # It slips on one support or both; their thrust is mu N.
    build = """- bricks:
    - {name: left, at: [-1 m, 0 m, 0.1 m], brick: {size: [0.4 m, 0.3 m, 0.2 m], mass: 50 kg}}
    - {name: right, at: [1 m, 0 m, 0.1 m], brick: {size: [0.4 m, 0.3 m, 0.2 m], mass: 50 kg}}
    - {name: plank, at: [0 m, 0 m, 0.225 m], brick: {size: [2.4 m, 0.3 m, 0.05 m], mass: 20 kg}}"""
    found = moved(build, "\nfriction: 0.3\nsupports: [{under: right, by: [0.1 m, 0 m, 0 m]}]", until=1.0)
    assert (found.holds, found.ends) == (1.0, "")
    last = found.positions[-1]
    assert last.poses["right"].position_W[0] == pytest.approx(1.1)
    assert last.poses["plank"].position_W[2] == pytest.approx(0.225, abs=1e-7)
    assert last.reactions_W[0][0] == pytest.approx(0.3 * 10 * 9.81, rel=1e-5)  # it drags the pier along
