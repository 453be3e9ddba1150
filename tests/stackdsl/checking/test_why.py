"""Why a run came out otherwise than expected: the proof, what was done before, what moved first, how to see it."""

import re
from math import pi

import pytest

from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.results import FailureCause
from tests.scenes import compiled, scene

COLUMN = "- column: {levels: 12, step: 12 mm}\n  every: 1 s"  # ten planks reach 120 mm, and each is 117.6 mm long


def why(build: str, rest: str) -> FailureCause | None:
    (case,), mistakes = compiled(scene(build, rest))
    assert mistakes == []
    return judged(case, play_case(case.timeline, case.system)).why


def test_an_expected_outcome_has_no_cause() -> None:
    assert why(COLUMN, "expect: [{collapses: {at: level 10}}]") is None


@pytest.mark.parametrize("system", ["exact", pytest.param("tuned", marks=pytest.mark.slow)])
def test_a_column_that_leans_too_far_tips_over_its_lowest_plank(system: str) -> None:
    found = why(COLUMN, f"systems: [{system}]\nexpect: [stands: all]")
    assert found is not None
    assert found.cause == "L2.1 to L10.1 (9 bricks) tip over L1.1"
    assert found.moving == tuple(f"L{level}.1" for level in range(2, 11))
    assert found.bearing == pytest.approx(0.0)
    assert found.overhang == pytest.approx(0.060 - 0.0588)  # five steps, and half a plank
    assert found.before == "build step 1, column at scene.yaml:3:5: L10.1 set down at 9 s, level 10"
    assert found.first.startswith("L10.1 fell first: it had moved ")
    assert re.search(r"had moved (3\.9|[4-9])\S* mm at 9\.1", found.first)


def test_a_brick_pulled_out_is_told_by_the_number_of_its_impact() -> None:
    impacts = "impacts: [{remove: {brick: L3.1}}, {after: impact 1 + 1 s, remove: {brick: L1.1}}]"
    found = why("- column: {levels: 3}\n  every: 1 s", f"expect: [stands: all]\n{impacts}")
    assert found is not None
    assert found.before == "impact 2, remove at scene.yaml:6:60: L1.1 pulled out at 4 s"
    assert found.cause == "L2.1 falls: nothing is under it"
    assert (found.bearing, found.overhang) == (None, None)


def test_the_step_that_a_brick_belongs_to_is_told_where_levels_begin_anew() -> None:
    garden = """
- brick: {size: [60 mm, 20 mm, 30 mm], density: 500 kg/m3}
  every: 1 s
  bricks: [{at: [0 mm, 30 mm, 15 mm]}, {name: far, at: [40 mm, 30 mm, 45 mm]}]"""
    found = why(f"- column: {{levels: 13}}\n{garden}", "expect: [stands: all]")
    assert found is not None
    assert found.before == "build step 2, bricks at scene.yaml:7:42: far set down at 1 s, level 2"


def test_the_cause_of_a_collapse_is_the_first_fall() -> None:
    block = "brick: {size: [60 mm, 20 mm, 30 mm], density: 500 kg/m3}"
    spots = ", ".join(f"{{name: {n}, at: [0 mm, {y} mm, {z} mm]}}" for n, y, z in (("a", 0, 15), ("b", 0, 45)))
    others = spots.replace("a,", "c,").replace("b,", "d,").replace("0 mm, 0 mm", "0 mm, 99 mm")
    impacts = "impacts: [{remove: {brick: a}}, {after: impact 1 + 0.3 s, remove: {brick: c}}]"
    found = why(f"- bricks: [{spots}, {others}]", f"expect: [falls: {{count: 1}}]\n{impacts}\n{block}")
    assert found is not None
    assert found.cause == "b falls: nothing is under it"
    assert found.before.endswith(": a pulled out at 0 s")


def test_the_cause_of_a_slide_names_the_downhill_bearing() -> None:
    tilted = "world: {tilt: {angle: 30 deg, towards: 90 deg}}\nfriction: 0.5\nexpect: [stands: all]"
    found = why("- column: {levels: 1}", tilted)
    assert found is not None
    assert found.cause == "L1.1 slides on ground"
    assert found.bearing == pytest.approx(pi / 2.0)
    assert found.overhang is None


def test_a_hit_is_told_as_what_was_done_before() -> None:
    throw = "impacts: [{throw: {at: L5.1, from: {bearing: 90 deg}, speed: 4 m/s}}]"
    found = why("- column: {levels: 8}", f"expect: [stands: all]\n{throw}")
    assert found is not None
    assert found.cause == "thrown-1 hits L5.1, with L6.1 at 4 m/s"
    assert found.before == "impact 1, throw at scene.yaml:5:12: thrown-1 thrown at 0 s"
    assert found.see.startswith("stackdsl run scene.yaml ")  # statics does not follow what flies


def test_the_cause_of_an_unexpected_stand_is_its_proof() -> None:
    found = why("- column: {levels: 3}", "expect: [collapses: any]")
    assert found is not None
    assert found.cause == "statics prove that it stands"
    assert found.first == ""
    assert found.see == "stackdsl explain scene.yaml -k 'scene[exact]'"
