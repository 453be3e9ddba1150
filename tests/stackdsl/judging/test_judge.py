"""Claims judged on traces written by hand."""

from dataclasses import dataclass, replace
from math import inf

import pytest

from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Stability, Verdict
from stackdsl.judging.judge import compare_with_truth, judge
from stackdsl.judging.proofs import ALL, margins_of
from stackdsl.results import ClaimOutcome
from stackdsl.timeline import FixedWorld
from stackdsl.trace import (
    BrickState,
    BrickTrack,
    Collapse,
    Cost,
    Edge,
    Energy,
    Penetration,
    Sway,
    Trace,
    VerdictMargins,
)
from tests.scenes import compiled, scene

SIZE = (0.1176, 0.0234, 0.0078)  # so that a brick has left its place when it shifted by more than 3.9 mm


def track(name: str, level: int, shift: float = 0.0, state: BrickState = BrickState.FROZEN) -> BrickTrack:
    pose = Pose((0.0, 0.0, (level - 0.5) * SIZE[2]))
    frozen = state is BrickState.FROZEN
    return BrickTrack(Brick(name, Box(SIZE), 0.012), level, state, pose, pose, pose, shift, tilt=0.0, frozen=frozen)


STANDING = Trace(
    events=(),
    tracks={"L1.1": track("L1.1", 1), "L2.1": track("L2.1", 2, shift=0.001), "L3.1": track("L3.1", 3, shift=0.002)},
    edges=(Edge("L1.1", "ground", 1.0), Edge("L2.1", "L1.1", 0.7), Edge("L3.1", "L2.1", 1.0)),
    collapse=None,
    cost=Cost(0.1, 3.0, 100, 100),
    edges_when_placed={},
)
FALLEN = replace(
    STANDING,
    tracks={**STANDING.tracks, "L3.1": track("L3.1", 3, shift=0.05, state=BrickState.FALLEN)},
    edges=STANDING.edges[:2],
    collapse=Collapse(2.5, level=3, brick="L3.1"),
)


#   A hit threw the top plank down, shifted the middle one by 6 mm, and left the lowest; the missile lies beside.
HIT = replace(
    STANDING,
    tracks={
        "L1.1": replace(track("L1.1", 1), sunk=0.0),
        "L2.1": replace(
            track("L2.1", 2, shift=0.006, state=BrickState.DISPLACED),
            final=Pose((0.006, 0.0, 1.5 * SIZE[2])),
            sunk=0.001,
        ),
        "L3.1": replace(
            track("L3.1", 3, shift=0.05, state=BrickState.FALLEN), final=Pose((0.05, 0.0, 0.5 * SIZE[2])), sunk=0.0156
        ),
        "shot": track("shot", 0, shift=0.2, state=BrickState.THROWN),
    },
    energy=Energy(start=1.0, risen=0.001, of_what_moved=0.5),
)
SWAYING = replace(
    STANDING, sway=Sway(4e-4, 5.0, "L3.1", time=2.0), penetration=Penetration(1.2e-4, "L2.1", "L1.1", time=1.0)
)
PULLED_OUT = replace(
    STANDING,
    tracks={**STANDING.tracks, "L3.1": track("L3.1", 3, shift=0.05, state=BrickState.REMOVED)},
    edges=STANDING.edges[:2],
)


def outcome(claim: str, trace: Trace) -> ClaimOutcome:
    build = "- column: {levels: 3}\n- bricks: [{name: shot, at: [300 mm, 0 mm, 3.9 mm]}]"
    cases, mistakes = compiled(scene(build, f"expect:\n  - {claim}"))
    assert mistakes == []
    return judge(trace, cases[0].scenario, cases[0].variant, cases[0].source, "exact")[0]


@pytest.mark.parametrize(
    ("claim", "trace", "passed", "margin", "unit"),
    [
        ("stands: all", STANDING, True, 1.9, "mm"),  # 3.9 mm less the largest shift of 2 mm
        ("stands: all", FALLEN, False, -46.1, "mm"),
        ("stands: {levels: 2}", FALLEN, True, 2.9, "mm"),
        ("stands: {bricks: [L1.1]}", FALLEN, True, 3.9, "mm"),
        ("stands: all", PULLED_OUT, True, 2.9, "mm"),  # of what was pulled out nothing is expected any more
        ("stands: {bricks: [L3.1]}", PULLED_OUT, False, -1.0, "bricks"),
        ("collapses: any", PULLED_OUT, False, -2.9, "mm"),
        ("drift: < 2 mm", PULLED_OUT, True, 1.0, "mm"),
        ("displaced: {bricks: 0, by: '> 3 mm'}", PULLED_OUT, True, 0.0, "bricks"),
        # After a hit only sinking counts, or a tilt: 3.9 mm less 1 mm.
        ("stands: {levels: 2}", HIT, True, 2.9, "mm"),
        ("stands: all", HIT, False, -11.7, "mm"),
        ("stands: {bricks: [shot]}", HIT, False, -1.0, "bricks"),
        ("leaves: {levels: 2}", HIT, True, 0.0, "levels"),
        ("leaves: {levels: 2 .. 3}", FALLEN, True, 0.0, "levels"),
        ("leaves: {levels: '>= 3'}", HIT, False, -1.0, "levels"),
        ("leaves: {bricks: '>= 1'}", HIT, True, 1.0, "bricks"),  # neither the missile nor what fell
        ("falls: {bricks: [L3.1]}", HIT, True, 0.0, "bricks"),
        ("falls: {bricks: [L2.1]}", HIT, False, -2.0, "bricks"),  # one that did not, one that was not named
        ("falls: {count: <= 4}", HIT, True, 3.0, "bricks"),
        ("falls: {count: 0}", HIT, False, -1.0, "bricks"),
        ("displaced: {bricks: 2, by: '> 5 mm'}", HIT, True, 0.0, "bricks"),
        ("drift: < 100 mm", HIT, True, 50.0, "mm"),
        ("height: {is: 15.6 mm ± 0.5 mm}", HIT, True, 0.5, "mm"),
        ("untouched: {levels: 1}", HIT, True, inf, ""),
        ("untouched: {levels: 2}", HIT, False, -6.0, "mm"),
        ("untouched: {bricks: [L2.1]}", HIT, False, -6.0, "mm"),
        ("untouched: {except: [L2.1, L3.1]}", HIT, True, inf, ""),
        ("energy: {gain: <= 1 %}", HIT, True, 0.8, "%"),  # 1 mJ of 0.5 J are 0.2 %
        ("energy: {gain: < 0.1 %}", HIT, False, -0.1, "%"),
        ("sway: {amplitude: <= 0.5 mm}", SWAYING, True, 0.1, "mm"),
        ("sway: {amplitude: <= 0.3 mm}", SWAYING, False, -0.1, "mm"),
        ("sway: {frequency: 4 Hz ± 1 Hz}", SWAYING, True, 0.0, "Hz"),
        ("sway: {amplitude: <= 0.5 mm, frequency: '>= 6 Hz'}", SWAYING, False, -1.0, "Hz"),
        ("sway: {amplitude: <= 0.3 mm}", STANDING, True, 0.3, "mm"),  # what does not come back does not sway
        ("sway: {frequency: '>= 1 Hz'}", STANDING, False, -1.0, ""),
        ("penetration: <= 0.2 mm", SWAYING, True, 0.08, "mm"),
        ("penetration: {is: < 0.1 mm}", SWAYING, False, -0.02, "mm"),
        ("penetration: < 0.1 mm", STANDING, False, -inf, "mm"),  # nothing was placed, or it was not looked for
        ("collapses: any", FALLEN, True, inf, ""),
        ("collapses: any", STANDING, False, -1.9, "mm"),
        ("collapses: {at: level 2 ± 1}", FALLEN, True, 0.0, "levels"),
        ("collapses: {at: level 2}", FALLEN, False, -1.0, "levels"),
        ("collapses: {at: level 3, time: 2 s ± 1 s}", FALLEN, True, 0.0, "levels"),
        ("collapses: {at: level 3, time: 2 s ± 0.25 s}", FALLEN, False, -0.25, "s"),
        ("collapses: {brick: L2.1}", FALLEN, False, -1.0, "bricks"),
        ("collapses: {brick: L3.1}", FALLEN, True, 0.0, "bricks"),
        ("displaced: {bricks: <= 2, by: '> 1.5 mm'}", STANDING, True, 1.0, "bricks"),
        ("displaced: {bricks: 2, by: '> 1.5 mm'}", STANDING, False, -1.0, "bricks"),
        ("drift: <= 2.5 mm", STANDING, True, 0.5, "mm"),
        ("drift: {is: <= 0.5 mm, bricks: [L2.1]}", STANDING, False, -0.5, "mm"),
        ("rests_on: {brick: L2.1, support: L1.1, share: 0.65 ± 0.1}", STANDING, True, 0.05, "of its load"),
        ("rests_on: {brick: L2.1, support: L1.1, share: 0.5 ± 0.1}", STANDING, False, -0.1, "of its load"),
        ("rests_on: {brick: L1.1, support: ground}", STANDING, True, 1.0, "of its load"),
        ("rests_on: {brick: L3.1, support: L2.1}", FALLEN, False, 0.0, "of its load"),
        ("height: 23.4 mm ± 0.5 mm", STANDING, True, 0.5, "mm"),
        ("height: 15.6 mm ± 0.5 mm", FALLEN, True, 0.5, "mm"),
        ("height: {of: L1.1, is: 9 mm ± 1 mm}", STANDING, False, -0.2, "mm"),
    ],
)
def test_a_claim_passes_by_its_margin(claim: str, trace: Trace, passed: bool, margin: float, unit: str) -> None:
    found = outcome(claim, trace)
    assert found.passed is passed
    assert found.margin == pytest.approx(margin, abs=1e-9)
    assert found.unit == unit
    assert found.measured


def test_a_failed_stands_claim_names_the_fallen_bricks() -> None:
    assert outcome("stands: all", FALLEN).measured == "1 of 3 bricks fell: L3.1"


def test_bricks_that_were_never_placed_do_not_stand() -> None:
    unplaced = replace(STANDING, tracks={**STANDING.tracks, "L3.1": track("L3.1", 3, state=BrickState.UNPLACED)})
    assert not outcome("stands: all", unplaced).passed
    assert outcome("stands: {levels: 2}", unplaced).passed


def test_a_fall_after_the_claimed_time_does_not_count() -> None:
    fell = replace(track("L3.1", 3, shift=0.05, state=BrickState.FALLEN), left_at=2.5)
    late = replace(FALLEN, tracks={**STANDING.tracks, "L3.1": fell})
    assert outcome("stands: {for: 2 s}", late).passed
    assert not outcome("stands: {for: 3 s}", late).passed


def test_of_what_falls_only_that_counts_which_falls_in_the_time_that_was_asked_for() -> None:
    fell = replace(track("L3.1", 3, shift=0.05, state=BrickState.FALLEN), left_at=2.5)
    moving = replace(FALLEN, tracks={**STANDING.tracks, "L3.1": fell}, moving=("L2.1",))
    assert outcome("falls: {bricks: [L3.1], for: 3 s}", moving).passed
    assert outcome("falls: {count: 1, for: 3 s}", moving).passed
    assert outcome("falls: {count: 0, for: 2 s}", moving).passed
    assert not outcome("falls: {count: 1, for: 2 s}", moving).passed
    assert "still moving" in outcome("falls: {count: 1}", moving).measured  # which nobody can count yet


def test_the_height_of_a_brick_that_was_never_placed_is_not_met() -> None:
    unplaced = replace(STANDING, tracks={**STANDING.tracks, "L3.1": track("L3.1", 3, state=BrickState.UNPLACED)})
    assert not outcome("height: {of: L3.1, is: '< 200 mm'}", unplaced).passed


def test_a_brick_that_has_not_come_to_rest_does_not_stand() -> None:
    falling = replace(STANDING, tracks={**STANDING.tracks, "L3.1": track("L3.1", 3, state=BrickState.UNSETTLED)})
    found = outcome("stands: all", falling)
    assert not found.passed
    assert found.measured.startswith("L3.1 has not come to rest; not settled when the simulation ended: L3.1")
    height = outcome("height: 15.6 mm ± 0.5 mm", falling)
    assert not height.passed
    assert height.measured.startswith("15.6 mm; not settled when the simulation ended")


def test_a_brick_that_only_tilts_is_judged_by_its_angle() -> None:
    tilted = replace(STANDING, tracks={"L1.1": replace(track("L1.1", 1), tilt=0.25)})
    found = outcome("stands: {bricks: [L1.1]}", tilted)
    assert found.unit == "deg"
    assert found.margin == pytest.approx(15.0 - 14.32394487827058)


def test_an_outcome_points_at_its_line_and_repeats_what_was_written() -> None:
    found = outcome("stands: {levels: 3, for: 2 s}", STANDING)
    assert (found.span.line, found.span.column) == (6, 5)
    assert found.expected == "levels 3, for 2 s"


def test_an_expectation_for_another_system_is_left_out() -> None:
    text = scene("- column: {levels: 1}", "systems: [thesis, stock]\nexpect:\n  - stands: all\n    system: stock")
    case = compiled(text)[0][0]
    assert judge(STANDING, case.scenario, case.variant, case.source, "thesis") == ()
    assert len(judge(STANDING, case.scenario, case.variant, case.source, "stock")) == 1


def test_a_truth_is_compared_in_the_same_way() -> None:
    text = scene("- column: {levels: 1}", "truth:\n  - collapses: any\n    source: made up")
    case = compiled(text)[0][0]
    assert [truth.passed for truth in compare_with_truth(FALLEN, case.scenario, case.variant, case.source)] == [True]


# --- what statics alone can tell --------------------------------------------------------------------------------------

ONE_PLANK = replace(
    STANDING,
    tracks={"L1.1": track("L1.1", 1)},
    world=FixedWorld(9.81, 0.5, (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1),)),
    statics=Verdict(Stability.STABLE),
)


def measured_by_margins(trace: Trace) -> Trace:
    return replace(trace, margins=margins_of(trace, ALL))


@pytest.mark.parametrize(
    ("stability", "claim", "passed"),
    [("stable", "stable", True), ("unstable", "stable", False), ("undecided", "undecided", True)],
)
def test_a_verdict_is_what_statics_said_when_the_last_bricks_were_set_down(
    stability: str, claim: str, passed: bool
) -> None:
    found = outcome(f"verdict: {claim}", replace(STANDING, statics=Verdict(Stability(stability), reason="so it is")))
    assert found.passed is passed
    assert found.measured == f"{stability}: so it is"


@pytest.mark.parametrize(
    ("guaranteed", "claim", "passed"),
    [
        (True, "guaranteed", True),
        (True, "possible", False),
        (False, "possible", True),
        (False, "guaranteed", False),
        (True, "stable", True),
        (None, "guaranteed", False),
    ],
)
def test_the_verdict_of_a_stable_structure_is_guaranteed_or_possible(
    guaranteed: bool | None, claim: str, passed: bool
) -> None:
    trace = replace(STANDING, statics=Verdict(Stability.STABLE), margins=VerdictMargins(guaranteed=guaranteed))
    assert outcome(f"verdict: {claim}", trace).passed is passed


def test_a_verdict_says_how_what_is_possible_could_let_go() -> None:
    margins = VerdictMargins(
        guaranteed=False, certainty="the bricks could also start to move: plank slides on left, right"
    )
    found = outcome("verdict: possible", replace(STANDING, statics=Verdict(Stability.STABLE), margins=margins))
    assert found.passed
    assert found.measured == "possible: the bricks could also start to move: plank slides on left, right"


@dataclass(frozen=True)
class AcrossGaps:
    """The answer that what stands counts on gaps up to a width [m]."""

    width: float

    def within(self) -> float:
        return self.width


@pytest.mark.parametrize(
    ("width", "claim", "passed"),
    [
        (0.0, "stable", True),
        (5e-5, "stable", True),
        (0.0, "stable, counting on no gap", True),
        (5e-5, "stable, counting on no gap", False),
    ],
)
def test_a_verdict_across_gaps_is_stable_and_says_how_wide_they_are(width: float, claim: str, passed: bool) -> None:
    found = outcome(
        f"verdict: {claim}", replace(STANDING, statics=Verdict(Stability.STABLE, gaps=(AcrossGaps(width),)))
    )
    assert found.passed is passed
    assert found.measured == ("stable, if gaps up to 0.05 mm count as contact" if width else "stable")


def test_the_verdict_of_a_falling_structure_is_neither_guaranteed_nor_possible() -> None:
    trace = replace(STANDING, statics=Verdict(Stability.UNSTABLE))
    assert not outcome("verdict: guaranteed", trace).passed
    assert not outcome("verdict: possible", trace).passed


def test_without_any_brick_set_down_there_is_no_verdict() -> None:
    assert not outcome("verdict: stable", STANDING).passed


@pytest.mark.parametrize(
    ("claim", "passed", "measured"),
    [
        ('acceleration: "0.1 ± 0.001"', True, "acceleration 0.1 g"),  # a flat plank slides at the friction coefficient
        ('acceleration: ">= 0.11"', False, "acceleration 0.1 g"),
        ("tilt: 5.711 deg ± 0.01 deg", True, "tilt 5.711 deg"),  # the arc tangent of it
        ('friction: "<= 0.01"', True, "friction 0"),
    ],
)
def test_a_margin_is_measured_on_what_stands_at_the_end(claim: str, passed: bool, measured: str) -> None:
    found = outcome(f"margin: {{{claim}}}", measured_by_margins(ONE_PLANK))
    assert found.measured == measured
    assert found.passed is passed


def test_several_margins_stand_and_fall_together() -> None:
    found = outcome('margin: {acceleration: ">= 0.05", tilt: ">= 20 deg"}', measured_by_margins(ONE_PLANK))
    assert not found.passed
    assert found.unit == "deg"
    assert found.measured == "acceleration 0.1 g, tilt 5.711 deg"


def test_a_margin_claim_fails_for_a_falling_structure() -> None:
    found = outcome('margin: {placement: ">= 1 mm"}', measured_by_margins(replace(ONE_PLANK, tracks={})))
    assert not found.passed
    assert found.measured == "no margin of placement is proven"


def test_a_truth_that_only_statics_can_tell_is_passed_over_on_a_bare_engine() -> None:
    text = scene("- column: {levels: 1}", "systems: [exact, stock]\ntruth:\n  - verdict: stable\n    source: made up")
    case = compiled(text)[0][0]
    assert compare_with_truth(STANDING, case.scenario, case.variant, case.source) == ()
    assert len(compare_with_truth(ONE_PLANK, case.scenario, case.variant, case.source)) == 1


def test_several_bricks_that_fall_are_counted_and_those_beside_the_expected_ones_are_named() -> None:
    tracks = {f"L{level}.1": track(f"L{level}.1", level, state=BrickState.FALLEN) for level in (1, 3, 5)}
    trace = replace(HIT, tracks={**HIT.tracks, **tracks})
    told = outcome("falls: {bricks: [L3.1, L2.1]}", trace).measured
    assert told == "3 bricks fell: L1.1, L3.1, L5.1; unexpected: L1.1, L5.1; missing: L2.1"
    assert outcome("falls: {bricks: [L3.1]}", HIT).measured == "L3.1 fell"
