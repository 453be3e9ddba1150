"""Ties of scenarios: their course and tension, what they hold against closed forms, and what is refused with them."""

from math import hypot

import pytest

from stability.analysis.bearings import by_bearing
from stability.problem import Stability
from stability.statics.assembly import Assembly
from stability.ties import length_of
from stackdsl.checking.play_case import play_case
from stackdsl.judging.proofs import margins_of, margins_of_assembly, proofs_of
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from tests.scenes import compiled, mistakes_of, scene, timeline_of

G = 9.81
CARTON = "\nbrick: {size: [400 mm, 300 mm, 250 mm], mass: 12 kg}\nfriction: 0.9"
PALLET = "- bricks: [{name: pallet, at: [0 mm, 0 mm, 50 mm], brick: {size: [400 mm, 300 mm, 100 mm], mass: 500 kg}}]"
STRAPPED = "{around: all, along: 0 deg, tension: 5 N}"
PUSH = "{force: 600 N, towards: 0 deg, brick: cartons.L1.1, at: 0 s}"
LOAD = f"{PALLET}\n- column: {{levels: 4, origin: [0 mm, 0 mm, 100 mm]}}\n  name: cartons"


def proven(build: str, ties: str, rest: str = CARTON) -> Assembly:
    return proofs_of(timeline_of(build, f"{rest}\nties: [{ties}]")).assembly


@pytest.mark.parametrize("tilt", ["", "\nworld: {tilt: {angle: 0 deg, towards: 30 deg}}"])
def test_two_straps_hold_a_stack_on_its_pallet(tilt: str) -> None:
    ties = ", ".join(f"{{around: all, along: 90 deg, offset: {x} mm, tension: 60 N}}" for x in (-100, 100))
    problem = proven(LOAD, ties, CARTON + tilt).problem()
    along = by_bearing(problem, 4, 1e-7, G)
    assert along is not None
    weight, height = 48.0 * G, 1.0
    tips = [(weight + 4.0 * 60.0) * side / (weight * height) for side in (0.4, 0.3)]
    assert [each.value for each in along] == pytest.approx([*tips, *tips], rel=1e-5)


def test_a_tie_holds_from_the_placement_of_its_last_brick_on() -> None:
    bricks = "  - {name: low, at: [0 mm, 0 mm, 125 mm]}\n  - {name: high, at: [210 mm, 0 mm, 375 mm]}"
    leaning = f"- bricks:\n{bricks}\n  every: 1 s"
    assert proven(leaning, "{around: low, along: 0 deg, anchors: [-1 m, 1 m], tension: 0 N}").verdict().stability is (
        Stability.UNSTABLE
    )
    # The tie turns at the far upper corner of the lower brick, beyond the edge about which the upper one tips.
    held = proven(leaning, "{around: all, along: 0 deg, tension: 60 N}")
    assert held.verdict().stability is Stability.STABLE


def test_straps_are_labelled_in_decanewtons() -> None:
    build = "- column: {levels: 2}"
    (tie,) = timeline_of(build, f"{CARTON}\nties: [{{around: all, along: 0 deg, tension: 30 daN}}]").world.ties
    assert (tie.tension, tie.strength) == (300.0, 300.0)


def test_a_lashing_pulls_down_by_the_slope_of_its_ends() -> None:
    (tie,) = timeline_of(
        "- column: {levels: 1}", f"{CARTON}\nties: [{{around: all, along: 0 deg, anchors: [-1 m, 1 m], tension: 1 N}}]"
    ).world.ties
    down = -sum(pull.force[2] for pull in tie.pulls)
    assert down == pytest.approx(2.0 * 0.25 / hypot(0.8, 0.25))
    assert length_of(tie.course_W) == pytest.approx(2.0 + 0.4 + 2.0 * hypot(0.8, 0.25))


def test_a_tie_turns_with_a_tilted_scene() -> None:
    level, tilted = (
        timeline_of(LOAD, f"{CARTON}{world}\nties: [{{around: all, along: 0 deg, tension: 1 N}}]").world.ties[0]
        for world in ("", "\nworld: {tilt: {angle: 10 deg, towards: 0 deg}}")
    )
    assert length_of(tilted.course_W) == pytest.approx(length_of(level.course_W))
    downhill = sum(pull.force[0] for pull in tilted.pulls if pull.brick == "cartons.L4.1")
    assert downhill == pytest.approx(-2.0 * 0.17364817766693033)


def test_the_tension_that_a_loose_strap_would_need_is_told() -> None:
    rest = f"{CARTON}\nloads: [{PUSH.replace('at:', 'point: [0 mm, 0 mm, -125 mm], at:')}]"
    # 0.9 (4 m g + 2 T) = 600 N
    verdict = proven(LOAD, "{around: all, along: 0 deg, tension: 50 N, strength: 4 kN, name: strap}", rest).verdict()
    assert verdict.stability is Stability.UNDECIDED
    assert verdict.reason.startswith(f"it needs a tension of {0.5 * (600.0 / 0.9 - 48.0 * G):.4g} N in the tie 'strap'")


def test_tied_bricks_that_are_not_proven_to_stand_are_not_played() -> None:
    text = f"{CARTON}\nloads: [{PUSH}]\nties: [{STRAPPED}]"
    with pytest.raises(BlockedPlacementError) as blocked:
        play(timeline_of(LOAD, f"{text}\nexpect: [stands: all]"), system_named("exact"))
    told = blocked.value.blocked.unplayed
    assert "is UNSTABLE at 0 s" in told
    assert told.endswith("ties such as 'tie 1' are judged at rest only, and not played")
    timeline = timeline_of(LOAD, f"{text}\nexpect: [verdict: unstable]")
    assert play(timeline, system_named("exact")).cost.steps == 0


def test_margins_of_tied_bricks_leave_out_those_that_are_not_computed() -> None:
    timeline = timeline_of(
        LOAD, f"{CARTON}\nties: [{{around: all, along: 0 deg, tension: 50 N}}]\nexpect: [stands: all]"
    )
    margins = margins_of(play(timeline, system_named("exact")), ("acceleration", "tilt", "friction", "placement"))
    assert margins.acceleration is not None
    assert (margins.tilt, margins.placement) == (None, None)


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("systems: [exact, tuned]", "on `exact` only, not on the system 'tuned'"),
        ('samples: 10\nuncertain: {x: 0 mm .. 1 mm}\nexpect: [stands: {share: ">= 1 %"}]', "samples are not drawn"),
        ("supports: [{under: [pallet], by: [1 mm, 0 mm, 0 mm]}]", "not judged on supports that move"),
        ("impacts: [{push: {brick: pallet, impulse: [1 N*s, 0 N*s, 0 N*s]}}]", "and `push` moves bricks"),
        ("impacts: [{remove: {bricks: [cartons.L4.1]}}]", "holds brick 'cartons.L4.1', which is pulled out"),
        ("world: {shake: {frequency: 2 Hz, amplitude: 1 mm, for: 1 s}}", "and `shake` moves bricks"),
        ("loads: [{force: from 0 N to 5 N over 1 s, towards: 0 deg, brick: pallet}]", "loads that do not change"),
        ("expect: [{margin: {tilt: '>= 1 deg'}}]", "`tilt` is not computed for tied bricks"),
    ],
)
def test_what_is_not_judged_with_ties_is_refused(rest: str, words: str) -> None:
    found = [each for each in mistakes_of(LOAD, f"{CARTON}\nties: [{STRAPPED}]\n{rest}") if each.code == "SD214"]
    assert [words in each.message for each in found] == [True]
    assert found[0].hint


@pytest.mark.parametrize(
    "rest",
    [
        "expect: [{margin: {friction: '<= 0.5'}}]",
        "expect: [{protocol: en-12195-1}]",
        "expect: [{load: {is: <= 1 kN, bricks: [pallet]}}]",
    ],
)
def test_more_is_judged_with_a_known_tension(rest: str) -> None:
    assert mistakes_of(LOAD, f"{CARTON}\nties: [{STRAPPED}]\n{rest}") == []
    loose = STRAPPED.replace("tension: 5 N", "tension: 5 N, strength: 9 N")
    (mistake,) = mistakes_of(LOAD, f"{CARTON}\nties: [{loose}]\n{rest}")
    assert mistake.code == "SD214"
    assert "whose tension is not known" in mistake.message


def test_a_strap_adds_twice_its_tension_to_the_load_that_crushes_a_carton() -> None:
    weak = CARTON.replace("mass: 12 kg", "mass: 12 kg, strength: {stack: 60 kg}")
    timeline = timeline_of("- column: {levels: 4}", f"{weak}\nties: [{{around: all, along: 0 deg, tension: 50 N}}]")
    margins = margins_of_assembly(proofs_of(timeline).assembly, ["used_strength"])
    assert margins.used_strength == pytest.approx((3 * 12.0 * G + 2 * 50.0) / (60.0 * G), rel=1e-6)
    crushed = timeline_of("- column: {levels: 4}", f"{weak}\nties: [{{around: all, along: 0 deg, tension: 120 N}}]")
    assert proofs_of(crushed).verdict.crushing is not None


BOTH = "between: [pallet, cartons.L1.1]"


@pytest.mark.parametrize(
    ("tie", "code", "words"),
    [
        ("{around: all, tension: 5 N}", "SD102", "either upright, along a line, or level, at a height"),
        ("{around: all, along: 0 deg, height: 1 m, tension: 5 N}", "SD108", "either upright"),
        ("{around: all, height: 1 m, offset: 1 m, tension: 5 N}", "SD108", "`offset` does not apply to a level loop"),
        ("{around: all, along: 0 deg}", "SD102", "neither a `tension` nor a `strength`"),
        ("{around: all, along: 0 deg, tension: 500}", "SD105", "has no unit"),
        ("{around: all, along: 0 deg, tension: 5 kg}", "SD106", "is not a unit of a force"),
        ("{around: all, along: 0 deg, tension: 5 N, strength: 4 N}", "SD104", "more than its strength of 4 N"),
        ("{around: all, along: 0 deg, tension: 5 N, anchors: [1 m, 1 m]}", "SD104", "both anchors are one place"),
        ("{around: all, between: [pallet, cartons.L1.1], tension: 5 N}", "SD108", "exactly one of the keys"),
        ("{around: cartoons, along: 0 deg, tension: 5 N}", "SD204", "no brick, step or kind of brick 'cartoons'"),
        ("{around: [ground, cartons], along: 0 deg, tension: 5 N}", "SD104", "not around 'ground'"),
        ("{between: [pallet, cartons], tension: 5 N}", "SD104", "'cartons' stands for 4 bricks"),
        ("{between: [pallet, pallet], tension: 5 N}", "SD104", "both ends of the tie are at one brick"),
        (f"{{{BOTH}, points: [[0 m, 0 m, 1 m], [0 m, 0 m, 200 mm]], tension: 5 N}}", "SD207", "900 mm outside brick"),
        ("{around: cartons, height: 10 mm, tension: 5 N}", "SD207", "meets none of its bricks at a height of 10 mm"),
        ("{around: cartons, height: 200 mm, tension: 5 N}", "SD207", "pulls at 'cartons.L1.1' alone"),
        ("{around: all, along: 0 deg, offset: 1 m, tension: 5 N}", "SD207", "meets none of its bricks there"),
        ("{around: [cartons.L2.1, cartons.L4.1], height: 300 mm, tension: 5 N}", "SD207", "meets none"),
        ("{around: all, along: 0 deg, anchors: [-0.1 m, 1 m], tension: 5 N}", "SD207", "cannot reach its anchor"),
        ("{wrap: all, tension: 5 N}", "SD101", "unknown key 'wrap'"),
    ],
)  # fmt: skip
def test_a_wrong_tie_names_its_remedy(tie: str, code: str, words: str) -> None:
    mistakes = mistakes_of(LOAD, f"{CARTON}\nties: [{tie}]")
    assert [(each.code, words in each.message) for each in mistakes[:1]] == [(code, True)]
    assert mistakes[0].hint


def test_a_tie_does_not_pass_through_other_bricks() -> None:
    row = "- bricks:\n" + "\n".join(
        f"  - {{name: {name}, at: [{x} mm, 0 mm, 125 mm], brick: {{size: [400 mm, {depth} mm, 250 mm], mass: 9 kg}}}}"
        for name, x, depth in (("a", 0, 200), ("b", 400, 300), ("c", 800, 200))
    )
    (mistake,) = mistakes_of(row, "\nties: [{around: [a, c], height: 100 mm, tension: 5 N}]")
    assert (mistake.code, mistake.hint) == ("SD207", "add 'b' to `around`, or move the tie")
    assert mistakes_of(row, "\nties: [{around: [a, b, c], height: 100 mm, tension: 5 N}]") == []
    assert (
        mistakes_of(
            row.replace("300 mm, 250", "200 mm, 250"), "\nties: [{around: [a, c], height: 100 mm, tension: 5 N}]"
        )
        == []
    )


def test_the_claims_of_a_tied_stack_are_proven_without_motion() -> None:
    claims = ["stands: all", "verdict: stable", "protocol: eumos-40509"]
    rest = f"{CARTON}\nties: [{STRAPPED}]\nexpect: [{', '.join(f'{{{claim}}}' for claim in claims)}]"
    (case,), _ = compiled(scene(LOAD, rest))
    result = play_case(case.timeline, "exact")
    assert result.cost.steps == 0
    assert result.tests is not None
    assert [test.survived < test.test.acceleration for test in result.tests] == [True] * 4
    assert [test.motion for test in result.tests] == [None] * 4
