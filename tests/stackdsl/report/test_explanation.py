"""What `explain` says of proofs."""

import subprocess
import sys

import pytest

from stackdsl.report.statics import Extent, explanation_text
from tests.paths import ROOT
from tests.scenes import compiled, scene


def explained(
    build: str, rest: str = "", margins: bool | None = None, remedies: bool | None = None, times: bool = False
) -> list[str]:
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return explanation_text(cases, Extent(margins, remedies, times)).splitlines()


def test_each_placement_has_the_stage_that_proved_it() -> None:
    lines = explained("- four_stack: {levels: 2}\n  every: 1 s", margins=False)
    placed = [line for line in lines if " at (" in line]
    assert len(placed) == 4
    assert all(line.endswith(" load core") for line in placed)
    assert "  statics: every placement is proven to stand" in lines


def test_the_cost_of_proofs_is_printed_on_demand() -> None:
    lines = explained("- four_stack: {levels: 2}\n  every: 1 s", margins=False, times=True)
    assert all(" load core, " in line and line.endswith(" us") for line in lines if " at (" in line)
    assert any("every placement is proven to stand, in " in line and line.endswith(" ms") for line in lines)


def test_two_runs_say_the_same() -> None:
    build = "- column: {levels: 4, step: 40 mm}\n  every: 1 s"
    assert explained(build) == explained(build)


def test_a_group_tells_its_cost_once() -> None:
    lines = explained("- four_stack: {levels: 2}", margins=False, times=True)
    assert [line.endswith(" us for 4 bricks") for line in lines if " at (" in line] == [False] * 3 + [True]


def test_an_explanation_names_falling_bricks_with_the_reason() -> None:
    lines = explained("- column: {levels: 3, step: 45 mm}")  # two planks' centre is 67 mm out, beyond 58.8 mm
    assert [line.split("  ")[-1].split(",")[0] for line in lines if " at (" in line][1:] == ["falls: tipping"] * 2
    assert any("UNSTABLE" in line and "over L1.1" in line for line in lines)
    assert "    direction: towards +x, its weight 8.7 mm beyond the edge" in lines
    assert not any("survive" in line for line in lines)


def test_every_brick_that_moves_is_named_as_people_count() -> None:
    lines = explained("- column: {levels: 10, step: 12 mm}", remedies=False)
    moves = [f"L{level}.1" for level in range(2, 11)]
    assert f"    moves: {', '.join(moves)}" in lines


def test_an_explanation_of_a_fall_has_remedies() -> None:
    #   Ten planks stand up to a step of a tenth of the length of one.
    lines = explained("- column: {levels: 10, step: 12 mm}")
    mended = lines[lines.index("    remedies, each verified:") + 1 :]
    assert mended[:4] == [
        "      step <= 11.76 mm instead of 12 mm at scene.yaml:3:32",
        "      2.76 g on L2.1, at its centre",
        "      levels <= 9 instead of 10 at scene.yaml:3:22",
        "      no friction coefficient is large enough",
    ]


def test_remedies_for_many_bricks_are_left_out_unless_requested() -> None:
    build = "- column: {levels: 61, step: 2 mm}"  # 122 mm, more than the length of a plank
    assert any("add --remedies" in line for line in explained(build))
    assert not any("remed" in line for line in explained(build, remedies=False))


def test_the_weakest_spot_and_the_joint_of_the_least_margin_of_placement_are_told() -> None:
    #   The lowest joint of a leaning column carries the most, furthest out: three planks whose centre is 56 mm out and
    #   11.7 mm up turn about an edge that is 58.8 mm out.
    lines = explained("- column: {levels: 4, step: 28 mm}")
    assert "    weakest: above 0.239 g towards 0 deg (+x), L2.1 to L4.1 (3 bricks) tip over L1.1" in lines
    assert "    limiting contact of the placement error: L2.1 on L1.1, towards +x" in lines
    upright = explained("- column: {levels: 3}")
    several = "limiting contacts of the placement error: L2.1 on L1.1 and L3.1 on L2.1, towards +y or -y"
    assert f"    {several}" in upright


def test_the_placement_margin_on_the_ground_alone_is_infinite() -> None:
    assert any(line.endswith("any placement error of every brick") for line in explained("- column: {levels: 1}"))


def test_margins_follow_the_placements() -> None:
    #   a plank flat on the ground: slides at mu g, at any tilt beyond the angle of friction, and needs no friction
    lines = explained("- column: {levels: 1}", "friction: 0.1")
    survived = next(line for line in lines if "survive" in line)
    assert "a horizontal acceleration of 0.0999 g" in survived
    assert "a tilt of 5.71 deg" in survived
    assert "friction down to 0" in survived


def test_margins_of_many_bricks_are_left_out_until_asked_for() -> None:
    lines = explained("- column: {levels: 301}")
    assert any("add --margins" in line for line in lines)
    assert not any("survive" in line for line in explained("- column: {levels: 2}", margins=False))


def test_from_a_dropped_brick_on_nothing_is_judged() -> None:
    lines = explained("- column: {levels: 1}\n- bricks: [{at: [0 mm, 0 mm, 1 m], drop: true}]")
    assert any("1 of 2 bricks are proven to stand" in line for line in lines)


def test_a_removal_has_a_line_of_its_own_and_makes_room() -> None:
    impacts = "impacts: [{remove: {bricks: [L2.1, L3.1]}}, {insert: {name: new, at: [0 mm, 0 mm, 11.7 mm]}}]"
    lines = explained("- column: {levels: 3}", impacts, margins=False)
    assert any(line.split() == ["0.000", "s", "L2.1,", "L3.1", "pulled", "out"] for line in lines)
    assert any("  new " in line and "on L1.1  load core" in line for line in lines)
    assert any("every placement is proven to stand" in line for line in lines)


def test_the_ground_and_the_walls_are_named_that_a_brick_stands_on_and_touches() -> None:
    #   A plank flat on the ground with its end at the second of two walls, and one upon it, short of the wall.
    walls = "world: {walls: [{bearing: 90 deg, distance: 1 m}, {bearing: 0 deg, distance: 58.8 mm}]}"
    build = "- bricks: [{at: [0 mm, 0 mm, 3.9 mm]}, {at: [-20 mm, 0 mm, 11.7 mm]}]"
    placed = [line for line in explained(build, walls, margins=False) if " at (" in line]
    assert ["  on ground, against wall2  " in placed[0], "  on L1.1  " in placed[1]] == [True, True]


@pytest.mark.parametrize(("thickness", "told"), [(0.39, True), (0.41, False)])
def test_a_contact_through_a_sheet_is_named(thickness: float, told: bool) -> None:
    #   2 % of 20 mm are 0.4 mm.
    build = f"""
- bricks:
    - {{name: sheet, at: [0 mm, 0 mm, {thickness / 2} mm], brick: {{size: [9 cm, 9 cm, {thickness} mm], mass: 1 g}}}}
    - {{name: block, at: [0 mm, 0 mm, {thickness + 10} mm], brick: {{size: [20 mm, 20 mm, 20 mm], density: 1 g/cm3}}}}
"""
    block = next(line for line in explained(build, margins=False) if " block " in line)
    through = "  on sheet, ground (touched through sheet, thinner than 2 % of block)  "
    assert (through in block, "  on sheet  " in block) == (told, not told)


def test_of_a_plank_wedged_between_two_walls_both_are_named() -> None:
    walls = "world: {walls: [{bearing: 0 deg, distance: 58.8 mm}, {bearing: 180 deg, distance: 58.8 mm}]}"
    lines = explained("- bricks: [{at: [0 mm, 0 mm, 50 mm]}]", walls, margins=False)
    assert any("  between wall1, wall2  " in line for line in lines)


def test_a_push_and_a_throw_have_lines_of_their_own() -> None:
    push = "{push: {brick: L2.1, impulse: [3 mN*s, 0 N*s, 0 N*s]}}"
    throw = "{throw: {at: L1.1, from: {bearing: 0 deg}, speed: 2 m/s}}"
    lines = explained("- column: {levels: 2}", f"impacts: [{push}, {throw}]", margins=False)
    assert any(line.split() == ["0.000", "s", "L2.1", "pushed", "by", "(3", "0", "0)", "mN*s"] for line in lines)
    assert any("thrown-2" in line and line.endswith("thrown at 2 m/s") for line in lines)
    assert any("2 bricks on 2 levels" in line for line in lines)


def test_an_explanation_names_bricks_that_fall_after_a_removal() -> None:
    lines = explained("- column: {levels: 3}", "impacts: [{remove: {brick: L2.1}}]")
    assert any("UNSTABLE" in line and "L3.1" in line for line in lines)


def test_other_systems_ask_no_statics() -> None:
    assert not any("statics:" in line for line in explained("- column: {levels: 1}", "systems: [tuned]"))


def test_explaining_needs_no_engine() -> None:
    code = (
        "import sys; from tests.stackdsl.report.test_explanation import explained; explained('- column: {levels: 2}');"
        "sys.exit('pybullet' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


SLIPPING = "- bricks: [{name: base, brick: sheet, on: ground}, {name: low, on: base}]"
SLIP_SHEET = """
brick_types:
  sheet: {size: [200 mm, 120 mm, 2 mm], mass: 40 g, friction: 0.1}
  carton: {size: [100 mm, 80 mm, 60 mm], mass: 200 g}
brick: carton
world:
  tilt: 12 deg
  friction: {between: [{pair: [sheet, ground], friction: 0.6}, {pair: [carton, ground], friction: 0.3}]}
"""


def test_frictions_of_bricks_and_pairs_are_told_with_those_that_never_touch() -> None:
    lines = explained(
        "- bricks: [{name: base, brick: sheet, on: ground}, {name: low, on: base}]", SLIP_SHEET, remedies=False
    )
    assert lines[1:5] == [
        "  gravity 9.81 m/s2, friction between bricks 0.5",
        "  own friction of bodies: sheet 0.1; friction of a contact: lower",
        "  friction 0.3 between carton and ground; no two of these touch when they are set down",
        "  friction 0.6 between sheet and ground",
    ]


def test_how_rough_a_sheet_would_have_to_be_is_told() -> None:
    #   A carton on a sheet stands up to a slope whose tangent is their friction: tan 12 deg is 0.21256.
    lines = explained(SLIPPING, SLIP_SHEET)
    (told,) = [line.strip() for line in lines if "friction of sheet" in line]
    assert told.startswith("friction of sheet >= 0.2126 instead of 0.1 at scene.yaml:")
