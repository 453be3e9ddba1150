"""Joints of a scenario: their bodies, their strengths, and refusals of all that is not played for joined bricks."""

from math import inf

import pytest

from stability.joints import Bond, Joint, Pull, Studs
from stackdsl.diagnostics import Diagnostic
from stackdsl.timeline import FixedWorld, JointsAction
from tests.scenes import compiled

HEAD = """
scenario: scene
brick_types:
  stone: {size: [200 mm, 100 mm, 60 mm], density: 1800 kg/m3}
  plate: {size: [32 mm, 16 mm, 9.6 mm], mass: 2 g}
brick: stone
joints: [%s]
"""
BUILD = """
build:
  - bricks:
      - {name: base, on: ground}
      - {name: low, on: base}
  - name: roof
    bricks:
      - {name: top, on: low, brick: plate}
"""
BOND = "bond: {tension: 0.1 MPa, cohesion: 200 kPa}"


def world(joints: str) -> FixedWorld:
    cases, mistakes = compiled(HEAD % joints + BUILD)
    assert mistakes == []
    return cases[0].timeline.world


def mistakes(joints: str, rest: str = "") -> list[Diagnostic]:
    """Mistakes in these items, which stand in line 7."""
    return compiled(HEAD % joints + BUILD + rest)[1]


@pytest.mark.parametrize(
    ("written", "joint"),
    [
        (BOND, Bond(1e5, 2e5, inf)),
        ("bond: {tension: 1 N/mm2, cohesion: 2 MPa, shear: 3 MPa}", Bond(1e6, 2e6, 3e6)),
        ("pull: 0.5 kN", Pull(500.0)),
        ("studs: {pitch: 20 mm, pull: 980 mN, shear: 10 N}", Studs(0.02, 0.98, 10.0)),
        ("dry: true", None),
    ],
)
def test_a_joint_has_its_strength_in_si(written: str, joint: Joint | None) -> None:
    joints = world(f"{{{written}}}").joints
    assert [joints.of(*pair) for pair in (("base", "low"), ("roof.top", "low"), ("base", "ground"))] == [joint] * 3


def test_a_joint_is_between_bodies_by_kind_step_name_or_plane() -> None:
    joints = world(
        "{between: [plate, low], pull: 1 N}, {of: stone, pull: 2 N}, {of: [roof, low, base, ground], pull: 4 N}"
    ).joints
    pairs = {
        ("roof.top", "low"): 1.0,  # the first item about two bodies counts
        ("base", "low"): 2.0,
        ("base", "ground"): 4.0,
        ("roof.top", "ground"): 4.0,
    }
    assert {pair: joint.force for pair in pairs if isinstance(joint := joints.of(*pair), Pull)} == pairs
    assert {pair: joint.force for pair in pairs if isinstance(joint := joints.of(*pair[::-1]), Pull)} == pairs


def test_an_earlier_dry_item_makes_an_exception() -> None:
    joints = world(f"{{between: [base, ground], dry: true}}, {{{BOND}}}").joints
    assert joints.of("base", "ground") is None
    assert joints.of("low", "base") == Bond(1e5, 2e5)


@pytest.mark.parametrize(
    ("joints", "code", "place", "message"),
    [
        (f"{{of: ston, {BOND}}}", "SD204", "7:15", "there is no kind of brick, step or brick 'ston'"),
        (f"{{between: [stone, wall1], {BOND}}}", "SD204", "7:28", "there is no kind of brick, step or brick 'wall1'"),
        (f"{{of: [ground], {BOND}}}", "SD104", "7:15", "these bodies are fixed, so no joint acts between them"),
        ("{of: stone}", "SD108", "7:10", "exactly one of the keys bond, pull, studs, dry is required, not none"),
        (f"{{pull: 1 N, {BOND}}}", "SD108", "7:10", "is required, not bond and pull"),
        (f"{{of: stone, between: [low, top], {BOND}}}", "SD108", "7:10", "`of` and `between` exclude each other"),
        ("{pull: 3}", "SD105", "7:17", ""),
        ("{pull: 3 mm}", "SD106", "7:17", ""),
        ("{bond: {tension: -1 MPa, cohesion: 1 MPa}}", "SD104", "7:27", ""),
        ("{bond: {tension: 1 MPa, cohesion: 2 MPa, shear: 1 MPa}}", "SD104", "7:17", "`shear` is less than `cohesion`"),
        ("{studs: {pitch: 8 mm, pull: 1 N}}", "SD102", "7:18", "missing key 'shear'"),
        ("{between: [base, roof.top], pull: 1 N}", "SD104", "7:10", "no two of these bodies touch"),
        ("{of: low, pull: 1 N}", "SD104", "7:10", "no two of these bodies touch"),
        ("{pull: 1 N}, {of: stone, pull: 2 N}", "SD104", "7:23", "so this item never counts"),
        ("{of: stone, studs: lego}", "SD104", "7:22", "no two of these bodies are boxes on one grid of 8 mm"),
    ],
)
def test_mistakes_in_joints_are_told_with_their_place(joints: str, code: str, place: str, message: str) -> None:
    mistake, *others = mistakes(joints)
    assert others == []
    assert (mistake.code, f"{mistake.span.line}:{mistake.span.column}") == (code, place)
    assert message in mistake.message
    assert mistake.hint


@pytest.mark.parametrize(
    ("item", "hint"),
    [
        ("glue: 5 N", "write `bond`"),
        ("mortar: {tension: 1 MPa, cohesion: 1 MPa}", "write `bond`"),
        ("magnet: 2 N", "write `pull`"),
        ("dry: false", "write `dry: true`, or remove the key"),
    ],
)
def test_a_wrong_key_or_value_of_a_joint_has_a_remedy(item: str, hint: str) -> None:
    assert hint in mistakes(f"{{of: stone, {item}}}")[0].hint


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        ("systems: [exact, tuned]\n", "not everything is played with joints: the system 'tuned' plays no joints"),
        (
            "impacts: [{move: {brick: low, by: [5 mm, 0 mm, 0 mm], slid: true}}]\n",
            "a brick with joints is not slid",
        ),
        ("expect: [{verdict: guaranteed}]\n", "the margin `guaranteed` is not computed for bricks with joints"),
        (
            "expect: [{margin: {placement: '> 3 mm'}}]\n",
            "the margin `placement` is not computed for bricks with joints",
        ),
    ],
)
def test_what_is_not_played_for_joined_bricks_is_refused(rest: str, message: str) -> None:
    told = mistakes(f"{{{BOND}}}", rest)
    assert [mistake.code for mistake in told] == ["SD211"]
    assert message in told[0].message
    assert "remove" in told[0].hint or "claim" in told[0].hint


def test_a_dry_scenario_may_have_all_of_that() -> None:
    assert mistakes("", "expect: [{drift: 0 mm}]\nsystems: [exact, tuned]\n") == []


def test_the_strength_of_a_joint_may_be_a_variable() -> None:
    text = HEAD % "{of: stone, bond: {tension: '${2 * strength}', cohesion: 1 MPa}}, {pull: '${hold}'}" + BUILD
    cases, told = compiled(f"{text}let: {{strength: 0.1 MPa, hold: 2 N}}\n")
    assert told == []
    assert [rule.joint for rule in cases[0].timeline.world.joints.rules] == [Bond(2e5, 1e6), Pull(2.0)]


def test_mortar_sets_some_time_after_the_later_of_two_bricks_and_the_next_item_counts_until_then() -> None:
    strong = "bond: {tension: 1 MPa, cohesion: 1 MPa, from: 2 d after placing}"
    weak = "bond: {tension: 0 MPa, cohesion: 1 kPa}"
    build = """
build:
  - bricks: [{name: base, on: ground}, {name: low, on: base}, {name: top, on: low, brick: plate}]
    every: 6 h
"""
    cases, told = compiled(HEAD % f"{{{strong}}}, {{{weak}}}" + build)
    assert told == []
    timeline = cases[0].timeline
    pairs = (("base", "ground"), ("base", "low"), ("low", "top"))
    fresh, cured = Bond(0.0, 1e3), Bond(1e6, 1e6)
    assert [timeline.world.joints.of(*pair) for pair in pairs] == [fresh, fresh, fresh]
    changes = [action for action in timeline.actions if isinstance(action, JointsAction)]
    assert [change.time / 3600.0 for change in changes] == [48.0, 54.0, 60.0]
    assert [change.bricks for change in changes] == [("base",), ("low",), ("top",)]
    for number, change in enumerate(changes, 1):
        expected = [cured] * number + [fresh] * (3 - number)
        assert [change.joints.of(*pair) for pair in pairs] == expected
    assert timeline.final_world.joints == changes[-1].joints
