"""`stands` reports the margin of its proof."""

from math import radians, tan

import pytest

from stackdsl.checking.play_case import MAX_BRICKS_FOR_REPORTED_MARGINS, play_case
from stackdsl.judging.judge import judge
from stackdsl.report.text import outcome_text
from stackdsl.results import ClaimOutcome
from tests.scenes import compiled, scene

LENGTH, WIDTH = 117.6, 23.4  # of a KAPLA plank [mm]


def stands(build: str, rest: str = "") -> ClaimOutcome:
    (case,), mistakes = compiled(scene(build, f"expect: [stands: all]\n{rest}"))
    assert mistakes == []
    trace = play_case(case.timeline, case.system)
    (outcome,) = judge(trace, case.scenario, case.variant, case.source, case.system)
    assert outcome.passed
    return outcome


@pytest.mark.parametrize("step", [5.0, 12.0, 13.06])
def test_a_column_tells_how_far_its_planks_may_be_beside_their_places(step: float) -> None:
    #   What lies on the lowest of nine planks has its centre (L - 9 d) / 2 inside the edge. The lowest may be as far
    #   off its place one way as all others the other way. With 13.06 mm the column is 0.03 mm from falling. Across,
    #   centres lie half the width inside.
    outcome = stands(f"- column: {{levels: 9, step: {step} mm}}")
    assert outcome.unit == "mm"
    assert outcome.margin == pytest.approx(min(LENGTH - 9.0 * step, WIDTH) / 4.0, rel=1e-6)
    assert "9 bricks stand, also with placement errors of " in outcome.measured
    assert "(margin " in outcome_text(outcome)


def test_a_stands_claim_shows_its_friction_margin() -> None:
    #   A plank on a slope of 10 deg, with friction 0.3.
    outcome = stands("- column: {levels: 1}", "friction: 0.3\nworld: {tilt: 10 deg}")
    assert outcome.margin == pytest.approx(0.3 - tan(radians(10.0)), rel=1e-5)
    assert outcome.unit == "of friction"
    assert outcome.measured == "1 brick stands, also with friction reduced to 0.1763"


def test_many_bricks_tell_how_far_they_may_shift_instead() -> None:
    outcome = stands(f"- column: {{levels: {MAX_BRICKS_FOR_REPORTED_MARGINS + 1}}}")
    assert (outcome.margin, outcome.unit) == (3.9, "mm")
    assert outcome_text(outcome).endswith(" bricks stand (largest shift 0 mm of 3.9 mm allowed)")
    assert outcome.measured == f"{MAX_BRICKS_FOR_REPORTED_MARGINS + 1} bricks stand"


def test_a_system_without_proofs_tells_how_far_they_may_shift() -> None:
    outcome = stands("- column: {levels: 2}", "systems: [thesis]")
    assert outcome.measured == "2 bricks stand"
    assert outcome.margin == pytest.approx(3.9, abs=0.1)


def test_of_several_frictions_it_tells_the_roughest_and_all_lose_in_proportion() -> None:
    #   Its friction on the slope is 0.3 of their own; the wall is rougher, and touches nothing.
    world = "{tilt: 10 deg, ground: {friction: 0.9}, walls: [{bearing: 0 deg, distance: 1 m, friction: 2}]"
    pair = "friction: {between: [{pair: [kapla, ground], friction: 0.3}]}}"
    outcome = stands("- column: {levels: 1}", f"world: {world}, {pair}")
    assert outcome.margin == pytest.approx(0.3 - tan(radians(10.0)), rel=1e-5)


# Two cubes of 0.2 m on the ground, friction 0.4: both would slide at 0.4 g. The centre of a third, placed last, lies
# 20 mm beyond the edge of the cube below, so it tips.
CUBES = """
- bricks:
    - {name: low, at: [0 m, 0 m, 0.1 m], brick: {size: [0.2 m, 0.2 m, 0.2 m], mass: 2 kg}}
    - {name: beside, at: [0.5 m, 0 m, 0.1 m], brick: {size: [0.2 m, 0.2 m, 0.2 m], mass: 2 kg}}
  every: 1 s
- bricks: [{name: top, at: [0.12 m, 0 m, 0.3 m], brick: {size: [0.2 m, 0.2 m, 0.2 m], mass: 2 kg}}]
"""


@pytest.mark.parametrize(
    "limit", ['acceleration: ">= 0.3 g"', 'tilt: ">= 10 deg"', 'friction: "<= 0.2"', 'placement: ">= 1 mm"']
)
@pytest.mark.parametrize("others", ["", "- falls: {bricks: [top]}\n"])  # without another claim the fall is not watched
def test_a_structure_of_which_a_brick_falls_has_no_margin(limit: str, others: str) -> None:
    (case,), mistakes = compiled(scene(CUBES, f"friction: 0.4\nexpect:\n{others}- margin: {{{limit}}}"))
    assert mistakes == []
    outcome = judge(play_case(case.timeline, case.system), case.scenario, case.variant, case.source, case.system)[-1]
    assert not outcome.passed
    assert outcome.measured == "no margin: 1 of 3 bricks does not stand: top"


def test_a_margin_covers_what_is_left_after_a_brick_was_pulled_out() -> None:
    #   Without it, cubes on a ground with friction 0.4 slide from 0.4 g on.
    build = CUBES.replace("0.12 m", "0.05 m")
    pull = 'friction: 0.4\nimpacts: [{remove: {brick: top}}]\nexpect: [margin: {acceleration: "0.4 ± 0.0001"}]'
    (case,), mistakes = compiled(scene(build, pull))
    assert mistakes == []
    (outcome,) = judge(play_case(case.timeline, case.system), case.scenario, case.variant, case.source, case.system)
    assert outcome.passed, outcome.measured


def test_bricks_that_fell_and_bricks_that_were_never_placed_are_counted_apart() -> None:
    #   Of planks with steps of 12 mm, the tenth brings down all but the first; the last two are not placed any more.
    claims = "expect: [stands: all, margin: {placement: '>= 1 mm'}]"
    (case,), mistakes = compiled(scene("- column: {levels: 12, step: 12 mm}\n  every: 1 s", claims))
    assert mistakes == []
    outcomes = judge(play_case(case.timeline, case.system), case.scenario, case.variant, case.source, case.system)
    assert [outcome.measured for outcome in outcomes] == [
        "the structure collapsed at level 10; 9 of 12 bricks fell, and 2 were never placed",
        "no margin: 9 of 12 bricks do not stand: L2.1 to L10.1 (9 bricks), and 2 were never placed",
    ]


def test_a_shaken_brick_does_not_tell_margins_of_rest() -> None:
    shake = "shake: {pulse: half-sine, acceleration: 0.01 g, for: 0.2 s}"
    outcome = stands("- column: {levels: 1}", f"world: {{{shake}}}")
    assert outcome.measured == "1 brick stands"
    assert outcome.unit != "of friction"
