"""Bricks of limited strength in scenarios, against closed forms: what crushes, at what load, and what is not judged."""

import copy
import pickle
from dataclasses import replace
from math import cos, inf, pi, sin

import pytest

from stability import Assembly, Box, Brick, Placed, Pose, Stability, Strength
from stability.joints import Bond, JointRule, Joints
from stability.loads import Load, Loads
from stability.statics.used_strength import UsedStrength
from stackdsl.api.studies import margins
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.judging.judge import judge
from stackdsl.judging.proofs import margins_of, proofs_of
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.studies.find_limit import LimitRequest, Want, find_in
from stackdsl.trace import BrickState, EventKind, RunVerdict, Trace
from tests.scenes import compiled, mistakes_of, scene, timeline_of

EXACT = 1e-6
CARTON = "\nbrick: {{size: [400 mm, 300 mm, 250 mm], mass: 12 kg, strength: {{{}}}}}"
STACK = CARTON.format("stack: 60 kg")  # five more cartons
G = 9.81


def column(levels: int) -> str:
    return f"- column: {{levels: {levels}}}\n  every: 1 s"


def played(build: str, rest: str) -> Trace:
    return play(timeline_of(build, f"{rest}\nexpect: [stands: all]"), system_named("exact"))


@pytest.mark.parametrize(
    "strength", ["stack: 60 kg", "stack: 588.6 N", "pressure: 5.886 kPa", "stack: 60 kg, pressure: 1 MPa"]
)
def test_a_stack_crushes_at_the_first_carton_too_many(strength: str) -> None:
    assert proofs_of(timeline_of(column(6), CARTON.format(strength))).verdict.stability is Stability.STABLE
    verdict = proofs_of(timeline_of(column(7), CARTON.format(strength))).verdict
    assert verdict.stability is Stability.UNSTABLE
    assert verdict.crushing is not None
    assert verdict.crushing.brick == "L1.1"
    # A pressure also bears the lowest carton itself, on the ground: 6 * 12 kg * g on 0.12 m2.
    need = 6 / 5 if "stack" in strength else 7 / 6
    assert verdict.crushing.share == pytest.approx(need, rel=EXACT)


def test_a_run_ends_when_a_brick_crushes_and_names_it_with_its_share() -> None:
    trace = played(column(9), STACK)
    assert trace.verdict is RunVerdict.COLLAPSES
    assert trace.collapse is not None
    assert trace.collapse.text == "crushes at level 7 after 6.000 s: L1.1 crushes: it needs 120 % of its strength"
    assert (trace.collapse.level, trace.collapse.brick) == (7, "L1.1")
    assert trace.events[-1].kind is EventKind.CRUSHED
    assert trace.tracks["L9.1"].state is BrickState.UNPLACED
    assert {trace.tracks[f"L{level}.1"].state for level in range(1, 8)} == {BrickState.UNSETTLED}
    assert trace.cost.steps == 0


def test_the_largest_number_of_levels_is_found() -> None:
    (case,), mistakes = compiled(scene(column(3), STACK))
    assert mistakes == []
    found = find_in(case, "stack", LimitRequest(Want.MOST, "levels"))
    assert (found.stands, found.beyond) == (6.0, 7.0)


def test_bricks_apart_from_what_crushes_stay_proven() -> None:
    apart = "- bricks: [{name: apart, at: [2 m, 0 m, 125 mm]}]"
    trace = played(f"{apart}\n{column(7)}", STACK)
    assert trace.tracks["apart"].state is BrickState.FROZEN
    assert trace.crushing is not None
    assert trace.tracks[trace.crushing.brick].state is BrickState.UNSETTLED


BLOCKS = "\nbrick: {size: [0.4 m, 0.2 m, 0.1 m], mass: 0.001 g, strength: {pressure: 10 kPa}}"


def off_centre(off: float, weight: float, turn: float = 0.0, shift: float = 0.0) -> str:
    """Two light blocks, and a weight on the upper one, off its centre along the longer side."""
    x, y = off * cos(turn), off * sin(turn)
    place = f"rotate: [0 deg, 0 deg, {turn} rad]"
    bricks = ", ".join(
        f"{{name: {n}, at: [{shift} m, {-shift} m, {z} m], {place}}}" for n, z in (("a", 0.05), ("b", 0.15))
    )
    load = f"{{weight: {weight} N, brick: b, point: [{x} m, {y} m, 0.05 m]}}"
    return f"{scene(f'- bricks: [{bricks}]', BLOCKS)}\nloads: [{load}]"


@pytest.mark.parametrize(
    ("off", "turn", "shift"),
    [(0.0, 0.0, 0.0), (0.03, 0.0, 0.0), (0.03, 0.7, 3.0), (0.4 / 6.0, pi, 1.0), (0.15, 0.0, 0.0)],
)
def test_an_eccentric_load_crushes_where_its_stress_block_is_full(off: float, turn: float, shift: float) -> None:
    """Within and beyond the middle third: N = p d (b - 2 e), wherever the blocks are and however they are turned."""
    limit = 1e4 * 0.2 * (0.4 - 2.0 * off)
    for share, stability in ((1.0 - 1e-3, Stability.STABLE), (1.0 + 1e-3, Stability.UNSTABLE)):
        (case,), mistakes = compiled(off_centre(off, share * limit, turn, shift))
        assert mistakes == []
        assert proofs_of(case.timeline).verdict.stability is stability


def test_a_weight_may_be_off_centre_by_as_much_as_its_stress_block_allows() -> None:
    text = off_centre(0.0, 400.0).replace("point: [0.0 m", 'point: ["${x} mm"') + "\nlet: {x: 1}\n"
    (case,), mistakes = compiled(text)
    assert mistakes == []
    found = find_in(case, "weight", LimitRequest(Want.LARGEST, "x", "90", "110", 0.01))
    assert found.stands == pytest.approx(1e3 * 0.5 * (0.4 - 400.0 / (1e4 * 0.2)), rel=0.01)


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_strengths_scale_with_the_cube_of_the_size(size: float) -> None:
    brick = f"\nbrick: {{size: [{0.4 * size} m, {0.3 * size} m, {0.25 * size} m], density: 400 kg/m3, "
    weight = 400.0 * 0.03 * size**3
    trace = played(column(5), f"{brick}strength: {{stack: {5.0 * weight} kg}}}}")
    assert margins_of(trace, ("used_strength",)).used_strength == pytest.approx(4 / 5, rel=EXACT)


def test_the_order_and_names_of_bricks_do_not_matter() -> None:
    places = [("a", 0.125), ("b", 0.375), ("c", 0.625)]
    shares = []
    for order in (places, places[::-1], [(f"z{name}", z) for name, z in places]):
        bricks = ", ".join(f"{{name: {name}, at: [0 m, 0 m, {z} m]}}" for name, z in order)
        trace = played(f"- bricks: [{bricks}]", STACK)
        shares.append(margins_of(trace, ("used_strength",)).used_strength)
    assert shares == pytest.approx([2 / 5] * 3, rel=EXACT)


def outcomes(levels: int, *claims: str) -> dict[str, tuple[bool, str]]:
    cases, mistakes = compiled(scene(column(levels), f"{STACK}\nexpect: [{', '.join(claims)}]"))
    assert mistakes == []
    case = cases[0]
    trace = play(case.timeline, system_named("exact"))
    trace_with = margins_of(trace, [*case.timeline.margins, *case.timeline.reported_margins])
    judged = judge(replace(trace, margins=trace_with), case.scenario, case.variant, case.source, "exact")
    return {each.name: (each.passed, each.measured) for each in judged}


def test_claims_about_the_motion_after_crushing_fail_as_not_modelled() -> None:
    found = outcomes(7, "falls: {count: 0}", "verdict: unstable", "collapses: {brick: L1.1}")
    cause = "L1.1 crushes: it needs 120 % of its strength"
    assert found["falls"] == (False, f"0 bricks fell; {cause}; the motion after crushing is not modelled")
    assert outcomes(7, "stands: all")["stands"] == (False, f"{cause}; the motion after crushing is not modelled")
    assert found["verdict"] == (True, f"unstable: {cause}")
    assert found["collapses"][0]


def test_a_stack_that_stands_reports_the_share_of_its_strength() -> None:
    found = outcomes(4, "stands: all", "margin: {used_strength: <= 60.1 %}")
    assert found["stands"] == (True, "4 bricks stand, with 60 % of their strength")
    assert found["margin"][0]
    assert not outcomes(4, "margin: {used_strength: <= 59.9 %}")["margin"][0]


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        ("systems: [exact, tuned]", "is judged on `exact` only, not on the system 'tuned'"),
        ("joints: [{bond: {tension: 1 MPa, cohesion: 1 MPa}}]", "not judged together with joints"),
        (
            'samples: 10\nuncertain: {x: 0 mm .. 1 mm}\nexpect: [stands: {share: ">= 1 %"}]',
            "samples are not drawn for bricks with a strength",
        ),
        ("supports: [{under: [L1.1], by: [1 mm, 0 mm, 0 mm]}]", "not judged on supports that move"),
        ("impacts: [{push: {brick: L1.1, impulse: [1 N*s, 0 N*s, 0 N*s]}}]", "and `push` moves bricks"),
        ("world: {shake: {frequency: 2 Hz, amplitude: 1 mm, for: 1 s}}", "and `shake` moves bricks"),
        ("loads: [{force: from 0 N to 5 N over 1 s, towards: 0 deg, brick: L1.1}]", "loads that do not change"),
        ("expect: [{margin: {tilt: '>= 1 deg'}}]", "`tilt` does not include the strengths"),
        ("expect: [{protocol: en-12195-1}]", "`protocol` does not include the strengths"),
    ],
)
def test_what_is_not_judged_with_strengths_is_refused(rest: str, words: str) -> None:
    found = [each for each in mistakes_of(column(2), f"{STACK}\n{rest}") if each.code == "SD213"]
    assert [words in each.message for each in found] == [True]
    assert found[0].hint


@pytest.mark.parametrize(
    ("strength", "code", "words"),
    [
        ("{}", "SD102", "the mapping is empty"),
        ("{stack: 0 kg}", "SD104", "not greater than zero"),
        ("{stack: 60}", "SD105", "has no unit"),
        ("{stack: 60 mm}", "SD106", "is not a unit of a load"),
        ("{pressure: -1 kPa}", "SD104", "not greater than zero"),
        ("{pressure: 60 kg}", "SD106", "is a value of `stack`"),
        ("60 kg", "SD103", "expected a mapping"),
        ("{weight: 60 kg}", "SD101", "unknown key"),
    ],
)
def test_a_strength_is_a_positive_pressure_or_load(strength: str, code: str, words: str) -> None:
    brick = f"\nbrick: {{size: [400 mm, 300 mm, 250 mm], mass: 12 kg, strength: {strength}}}"
    (mistake,) = mistakes_of(column(2), brick)
    assert mistake.code == code
    assert words in mistake.message
    assert mistake.hint


def test_a_margin_of_strength_needs_a_strength() -> None:
    (mistake,) = mistakes_of(column(2), "\nexpect: [{margin: {used_strength: <= 80 %}}]")
    assert (mistake.code, mistake.message) == ("SD213", "no brick has a `strength`")


# --- the assembly of statics ------------------------------------------------------------------------------------------


def cartons(count: int) -> list[Placed]:
    return [
        Placed(Brick(f"c{i}", Box((0.4, 0.3, 0.25)), 12.0), Pose((0.0, 0.0, 0.125 + 0.25 * i))) for i in range(count)
    ]


STRENGTHS = {f"c{i}": Strength(stack=60.0 * G) for i in range(20)}


def test_an_assembly_stands_again_when_the_brick_too_many_is_removed() -> None:
    assembly = Assembly(strengths=STRENGTHS)
    assert assembly.add_all(cartons(6)).stability is Stability.STABLE
    seventh = cartons(7)[-1]
    assert assembly.would(seventh.brick, seventh.pose).crushing is not None
    assert assembly.add(seventh.brick, seventh.pose).crushing is not None
    for same in (assembly.copied(), copy.deepcopy(assembly), pickle.loads(pickle.dumps(assembly))):
        assert same.verdict() == assembly.verdict()
        assert same.remove(["c6"]).stability is Stability.STABLE
    heavier = assembly.with_loads(Loads((Load("c5", (0.0, 0.0, -1.0)),)))
    more, less = heavier.verdict().crushing, assembly.verdict().crushing
    assert more is not None
    assert less is not None
    assert more.share > less.share


def test_a_hand_below_the_top_or_a_prop_relieves_what_would_crush() -> None:
    # A plank over two piers: the weaker one may bear its load as long as the stronger one takes the rest.
    def verdict(strength: float) -> Stability:
        piers = [
            Placed(Brick(name, Box((0.1, 0.1, 0.1)), 1.0), Pose((x, 0.0, 0.05)))
            for name, x in (("l", -0.2), ("r", 0.2))
        ]
        plank = Placed(Brick("plank", Box((0.8, 0.1, 0.02)), 3.0), Pose((0.05, 0.0, 0.11)))
        return Assembly(strengths={"r": Strength(stack=strength)}).add_all([*piers, plank]).stability

    least = 3.0 * G * (0.05 + 0.15) / (0.15 + 0.25)  # the left pier bears at its edge nearest to the right one
    assert verdict(least * (1.0 + 1e-5)) is Stability.STABLE
    assert verdict(least * (1.0 - 1e-5)) is Stability.UNSTABLE


def test_joints_and_strengths_together_are_undecided() -> None:
    joints = Joints((JointRule(Bond(1e3, 1e3), (frozenset({"c0"}), frozenset({"c1"}))),))
    verdict = Assembly(joints=joints, strengths=STRENGTHS).add_all(cartons(2))
    assert (verdict.stability, verdict.moving) == (Stability.UNDECIDED, ("c0", "c1"))
    assert "not judged with joints" in verdict.reason


def test_an_invalid_strength_of_an_assembly_is_refused() -> None:
    with pytest.raises(ValueError, match="the stack that 'a' bears is 0"):
        Assembly(strengths={"a": Strength(stack=0.0)})
    assert Strength().pressure == inf


#  |a5|b5|   Friction on the side faces of the light cartons b2 to b5 relieves a1 by mu^2 V / (1 - mu^2), with V their
#   ...       weight: 8 kg / 3. Without it a1 carries 4 * 15.6 kg.
#  |a1|b1|
SIDE_BY_SIDE = "- bricks:\n" + "\n".join(
    f"    - {{name: {name}{i}, brick: {kind}, at: [{x} mm, 0 mm, {125 + 250 * (i - 1)} mm]}}"
    for i in range(1, 6)
    for name, kind, x in (("a", "heavy", 150), ("b", "light", 450))
)


def kinds(stack: str) -> str:
    size = "size: [300 mm, 400 mm, 250 mm]"
    heavy, light = (f"{{{size}, mass: {mass}, strength: {{stack: {stack}}}}}" for mass in ("15.6 kg", "2 kg"))
    return f"brick_types:\n  heavy: {heavy}\n  light: {light}\nfriction: 0.5"


@pytest.mark.parametrize(("stack", "apart"), [("60 kg", "a1 crushes: it needs 104 % of its strength"), ("63 kg", "")])
def test_what_bears_only_by_friction_between_neighbours_is_told(stack: str, apart: str) -> None:
    cases, mistakes = compiled(scene(SIDE_BY_SIDE, f"{kinds(stack)}\nexpect: [stands: all]"))
    assert mistakes == []
    found = margins(cases[0])
    assert found.used_strength == pytest.approx((4 * 15.6 - 8.0 / 3.0) / float(stack[:2]), rel=EXACT)
    assert found.crushes_apart == apart
    result = judged(cases[0], play_case(cases[0].timeline, "exact"))
    assert result.passed
    assert [apart in warning.message for warning in result.warnings] == [True] * bool(apart)


def test_bricks_of_which_it_is_not_proven_whether_they_crush_are_not_played(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.statics.used_strength.used_strength", lambda *_, **__: UsedStrength(0.9, inf, None))
    with pytest.raises(BlockedPlacementError) as caught:
        played(column(7), STACK)
    assert caught.value.blocked.unplayed == (
        "the structure is UNDECIDED at 6 s: it is proven neither that the bricks bear their loads nor that one "
        "crushes; crushing is judged at rest only, and not played"
    )
