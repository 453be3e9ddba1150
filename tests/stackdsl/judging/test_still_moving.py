"""No count of fallen bricks passes while bricks still move at the end of the run."""

from dataclasses import replace
from math import cos, inf, sin

import pytest

from stability.geometry.box import Box
from stability.model import BodyState, Brick, Pose
from stability.name_order import in_order, names_text
from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.judging.judge import judge, stop_condition_of
from stackdsl.results import ClaimOutcome
from stackdsl.simulation.measurements import MotionWatch
from stackdsl.trace import BrickState, Landing, Trace
from tests.paths import ROOT
from tests.scenes import compiled, timeline_of
from tests.stackdsl.judging.test_judge import FALLEN, SIZE, outcome

SCENARIO = (ROOT / "scenarios" / "dominoes.yaml").read_text(encoding="utf-8")


def dominoes(count: int, watch: float, *claims: str) -> Case:
    """The first planks of the row of the scenario, watched for so long [s]."""
    expect = "\n".join(f"  - {claim}" for claim in claims)
    text = SCENARIO.partition("truth:")[0].replace("bricks: 80", f"bricks: {count}")
    text = text.replace("watch: 6 s", f"watch: {watch} s").replace("  - falls: {count: 80}", expect)
    cases, mistakes = compiled(text)
    assert mistakes == []
    return cases[0]


def played(case: Case, system: str) -> Trace:
    return play_case(case.timeline, system, stop_condition_of(case.scenario, system))


def outcome_of(claim: str, trace: Trace, count: int) -> ClaimOutcome:
    case = dominoes(count, 1.0, claim)
    return judge(trace, case.scenario, case.variant, case.source, "exact")[0]


def fallen(trace: Trace) -> int:
    return sum(track.state is BrickState.FALLEN for track in trace.tracks.values())


SYSTEMS = pytest.mark.parametrize("system", ["exact", "tuned"])


@pytest.mark.parametrize("system", [pytest.param("exact", marks=pytest.mark.slow), "tuned"])
def test_in_the_middle_of_a_cascade_no_count_passes_but_one_that_nothing_can_change(system: str) -> None:
    trace = played(dominoes(20, 0.4, "falls: {count: 20}"), system)
    assert 3 < fallen(trace) < 18
    assert len(trace.moving) > 3
    counts = [outcome_of(f"falls: {{count: {count}}}", trace, 20) for count in range(21)]
    assert not any(count.passed for count in counts)
    told = f"{fallen(trace)} bricks fell; still moving when the simulation ended: "
    advice = "; simulate longer, for example with `watch: 2 s`, or judge only this time with `for: 1 s`"
    assert counts[fallen(trace)].measured == f"{told}{names_text(in_order(trace.moving), among=trace.tracks)}{advice}"
    assert outcome_of("falls: {count: '>= 3'}", trace, 20).passed
    assert outcome_of("falls: {count: 3 .. 20}", trace, 20).passed
    assert not outcome_of("falls: {count: 3 .. 19}", trace, 20).passed


@SYSTEMS
@pytest.mark.parametrize(
    ("count", "watch"),
    [(6, 1.5), pytest.param(12, 2.0, marks=pytest.mark.slow), pytest.param(20, 3.0, marks=pytest.mark.slow)],
)
def test_watched_for_long_enough_all_fall_and_lie_still(system: str, count: int, watch: float) -> None:
    case = dominoes(count, watch, f"falls: {{count: {count}}}", "energy: {gain: <= 1 %}")  # which goes on to the end
    trace = played(case, system)
    assert trace.moving == ()
    assert [each.passed for each in judge(trace, case.scenario, case.variant, case.source, system)] == [True, True]


@pytest.mark.slow
@SYSTEMS
def test_of_eighty_nobody_knows_after_two_seconds_how_many_fall_and_then_all_do(system: str) -> None:
    trace = played(dominoes(80, 2.0, "falls: {count: 80}"), system)
    assert 40 < fallen(trace) < 80
    assert not outcome_of(f"falls: {{count: {fallen(trace)}}}", trace, 80).passed
    assert outcome_of("falls: {count: '> 40'}", trace, 80).passed
    assert outcome_of("falls: {count: 80}", played(dominoes(80, 6.0, "falls: {count: 80}"), system), 80).passed


# --- each kind of claim, of traces written by hand --------------------------------------------------------------------

#   L3.1 of a column of three fell, and something still moves.
MOVING = replace(FALLEN, moving=("L3.1",))


@pytest.mark.parametrize(
    ("claim", "passes"),
    [
        ("falls: {bricks: [L3.1]}", False),
        ("falls: {count: 1}", False),
        ("falls: {count: '>= 1'}", True),
        ("leaves: {levels: 2}", False),
        ("leaves: {levels: '<= 2'}", True),
        ("leaves: {bricks: '>= 2'}", False),
        ("displaced: {bricks: 1, by: '> 5 mm'}", False),
        ("displaced: {bricks: '>= 1', by: '> 5 mm'}", True),
        ("drift: < 60 mm", False),
        ("drift: '> 40 mm'", True),
        ("untouched: {levels: 2}", False),
        ("height: 15.6 mm ± 1 mm", False),
        ("rests_on: {brick: L2.1, support: L1.1}", False),
        ("stands: {levels: 2}", False),
        ("stands: {levels: 2, for: 1 s}", True),  # that time is over
        ("collapses: {at: level 3}", True),  # it has
    ],
)
def test_a_brick_still_moving_leaves_claims_about_it_open(claim: str, passes: bool) -> None:
    assert outcome(claim, FALLEN).passed
    found = outcome(claim, MOVING)
    assert found.passed is passes
    assert ("still moving when the simulation ended: L3.1;" in found.measured) is not passes
    assert (found.margin == -inf) is not passes
    assert ("`for: 3 s`" in found.measured) == (not passes and claim.startswith(("falls", "stands")))


@pytest.mark.parametrize(
    ("claim", "passes"),
    [
        ("falls: {count: '<= 2'}", True),
        ("falls: {bricks: [L3.1]}", True),
        ("leaves: {levels: 2}", True),
        ("stands: {levels: 2}", True),
        ("height: 15.6 mm ± 1 mm", False),
        ("drift: < 60 mm", False),
    ],
)
def test_a_fallen_brick_that_rocks_in_place_leaves_no_claim_about_falls_open(claim: str, passes: bool) -> None:
    assert outcome(claim, replace(MOVING, rocking=("L3.1",))).passed is passes
    assert not outcome(claim, replace(MOVING, moving=("L2.1", "L3.1"), rocking=("L3.1",))).passed


@pytest.mark.parametrize("over", [True, False])
def test_where_it_landed_is_known_once_the_ground_has_taken_all_but_a_hundredth_of_the_energy(over: bool) -> None:
    landed = replace(MOVING, landing=Landing(2.7, (0.05, 0.0), over))
    assert outcome("lands: {reach: 40 mm .. 60 mm}", landed).passed is over


def test_a_claim_that_failed_already_is_not_open_while_bricks_move() -> None:
    assert outcome("falls: {count: 2}", MOVING).measured.startswith("1 brick fell; still moving")
    assert outcome("falls: {count: 0}", MOVING).measured == "1 brick fell"  # it will not be less


# --- what moves -------------------------------------------------------------------------------------------------------


def watch(times: float = 1.0, gravity: float = 9.81) -> MotionWatch:
    found = MotionWatch(gravity)
    found.add(Brick("plank", Box(tuple(times * side for side in SIZE)), 0.012))  # type: ignore[arg-type]  # three sides
    return found


def looks(seen: MotionWatch, *heights: float) -> None:
    """A look every 10 ms at a plank that is so high [m]."""
    for number, height in enumerate(heights):
        seen.see(0.01 * number, {"plank": BodyState(Pose((0.0, 0.0, height)))})


@pytest.mark.parametrize(
    ("times", "gravity", "limit"),
    [
        (1.0, 9.81, 0.005),
        (100.0, 9.81, 0.05),  # what is a hundred times as large falls ten times as fast
        (1.0, 0.0981, 0.0005),  # and in a hundredth of the gravity, ten times as slowly
    ],
)
def test_the_speed_limit_of_rest_scales_with_the_size_of_the_brick(times: float, gravity: float, limit: float) -> None:
    for share, moves in ((0.9, ()), (1.1, ("plank",))):
        seen = watch(times, gravity)
        looks(seen, 0.0, 0.01 * share * limit)
        assert seen.moving(0.01) == moves


def test_a_rocking_brick_has_stopped_after_a_tenth_of_a_second_at_rest() -> None:
    seen = watch()
    looks(seen, 0.0, 0.001, 0.001, 0.001)
    assert seen.moving(0.1) == ("plank",)
    assert seen.moving(0.12) == ()


def test_a_brick_that_rocks_for_a_second_about_one_place_stays_in_place_and_one_that_creeps_away_does_not() -> None:
    rocks, creeps = watch(), watch()
    for number in range(201):
        for seen, height in ((rocks, 0.0005 * (-1) ** (number // 5)), (creeps, 0.0001 * number)):
            seen.see(0.01 * number, {"plank": BodyState(Pose((0.0, 0.0, height)))})
    assert rocks.moving(2.0) == creeps.moving(2.0) == ("plank",)
    assert rocks.in_place(0.9) == frozenset()
    assert rocks.in_place(2.0) == {"plank"}
    assert creeps.in_place(2.0) == frozenset()


def test_a_brick_spinning_in_place_counts_as_moving() -> None:
    seen = watch()
    for time, angle in ((0.0, 0.0), (0.01, 0.002)):  # 0.2 rad/s
        turned = Pose((0.0, 0.0, 0.0), (0.0, 0.0, sin(0.5 * angle), cos(0.5 * angle)))
        seen.see(time, {"plank": BodyState(turned)})
    assert seen.moving(0.01) == ("plank",)


def test_solver_jitter_is_no_motion() -> None:
    seen = watch()
    for number in range(10):
        shaken = BodyState(Pose((0.0, 0.0, 1e-5 * (-1) ** number)), velocity_W=(0.0, 0.0, 0.02))
        seen.see(0.01 * number, {"plank": shaken})
    assert seen.moving(0.09) == ()


def test_a_fixed_brick_does_not_move() -> None:
    seen = watch()
    looks(seen, 0.0, 0.001)
    seen.stopped(["plank"])
    assert seen.moving(0.01) == ()


# --- for how long -----------------------------------------------------------------------------------------------------

PUSHED = "impacts: [{at: 0.1 s, push: {brick: post, impulse: [10 mN*s, 0 N*s, 0 N*s]}}]\n"
POST = "- bricks: [{name: post, at: [0 mm, 0 mm, 58.8 mm], rotate: [0 deg, 90 deg, 0 deg]}]"


@pytest.mark.parametrize(
    ("rest", "hold", "followed"),
    [
        ("", 2.0, 1.0),
        ("watch: 5 s\n", 5.0, 5.0),
        ("watch: 500 ms\n", 0.5, 0.5),
        ("watch: 5 s\nexpect: [{stands: {for: 9 s}}]\n", 9.0, 5.0),
    ],
)
def test_the_author_says_how_long_it_is_watched(rest: str, hold: float, followed: float) -> None:
    timeline = timeline_of(POST, PUSHED + rest)
    assert (timeline.hold, timeline.followed) == (hold, followed)


def test_a_fall_without_a_hit_is_followed_for_as_long_as_the_author_says() -> None:
    timeline = timeline_of("- column: {levels: 3, step: 45 mm}", "watch: 2.5 s\n")
    trace = play_case(timeline, "tuned")
    assert trace.collapse is not None
    assert trace.cost.simulated_time == pytest.approx(trace.collapse.time + 2.5, abs=0.01)


def test_motion_is_played_where_the_author_wants_to_watch_it() -> None:
    only_statics = "expect: [{verdict: unstable}]\n"
    assert not timeline_of("- column: {levels: 3, step: 45 mm}", only_statics).watched
    assert timeline_of("- column: {levels: 3, step: 45 mm}", "watch: 1 s\n" + only_statics).watched
