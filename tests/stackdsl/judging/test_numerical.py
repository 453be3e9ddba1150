"""A collapse that statics disprove, or that does not occur at a finer step, is reported as numerical."""

from dataclasses import replace
from math import inf

import pytest

from stability.engines.pybullet.settings import PyBulletSettings
from stackdsl.checking.results import judged
from stackdsl.exits import ExitCode
from stackdsl.judging.judge import REMOVED, compare_with_refined, with_numerical_collapse
from stackdsl.judging.proofs import DISPROVED, stands_until
from stackdsl.results import Change, Report, RunStatus, Seen, VariantResult, changes, exit_code, observations
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import STOCK, SYSTEMS, TUNED, System
from stackdsl.trace import STAND, Collapse, Cost, Trace
from tests.scenes import compiled, scene, timeline_of

# A stack of 60 steps a second, which the solver shakes down.
COARSE = System("coarse", "a deliberately coarse step", replace(STOCK, time_step=1.0 / 60.0), method=None)
TOWER = "- four_stack: {levels: 6}\n  every: 1 s"
# Planks stepped by 18 mm fall with number floor(117.6 / 18) + 1 = 7.
COLUMN = "- column: {levels: 7, step: 18 mm}\n  every: 1 s"
FELL = Collapse(time=6.2, level=7, brick="L7.1")


def trace(collapse: Collapse | None = None, numerical: str = "") -> Trace:
    cost = Cost(wall_time=1.0, simulated_time=1.0, steps=1, judgements=0)
    return Trace((), {}, (), collapse, cost, {}, numerical=numerical)


@pytest.mark.parametrize("settings", [STOCK, TUNED])
def test_refined_is_half_the_step_and_twice_the_iterations_and_nothing_else(settings: PyBulletSettings) -> None:
    fine = settings.refined()
    assert fine.time_step == settings.time_step / 2.0
    assert fine.iterations == settings.iterations * 2
    assert replace(fine, time_step=settings.time_step, iterations=settings.iterations) == settings


def test_another_step_leaves_the_iterations() -> None:
    assert TUNED.at_step(0.25) == replace(TUNED, time_step=TUNED.time_step / 4.0)


def test_a_four_stack_that_a_coarse_step_brings_down_is_a_numerical_collapse() -> None:
    cases, mistakes = compiled(scene(TOWER, "expect:\n  - collapses: any\n  - falls: {count: '>= 1'}\n"))
    assert mistakes == []
    fell = play(cases[0].timeline, COARSE)
    assert fell.collapse is not None  # or the step is not coarse enough to show anything
    told = with_numerical_collapse(fell, cases[0].timeline, COARSE)
    assert told.numerical == DISPROVED
    result = judged(cases[0], told)
    assert result.verdict == result.conclusion == "numerical-collapse"
    assert [outcome.passed for outcome in result.outcomes] == [False, False]
    assert all(outcome.passed for outcome in judged(cases[0], fell).outcomes)  # as they would without the proof


def test_a_collapse_that_could_come_as_well_as_not_is_physics() -> None:
    # Aslant between walls of 0.5 and 0.15; the slope of its diagonal is 0.29. As their mean is more, friction can hold
    # it, and where nothing presses it falls freely.
    walls = [
        f"{{bearing: {bearing} deg, distance: 56.587804661181515 mm, friction: {friction}}}"
        for bearing, friction in ((0, 0.5), (180, 0.15))
    ]
    plank = "{name: plank, at: [0 mm, 0 mm, 100 mm], rotate: [0 deg, 20 deg, 0 deg]}"
    timeline = timeline_of(f"- bricks: [{plank}]", f"world: {{walls: [{', '.join(walls)}]}}\n")
    assert stands_until(timeline, 1.0)
    fell = trace(replace(FELL, time=1.0, brick="plank"))
    assert with_numerical_collapse(fell, timeline, SYSTEMS["tuned"]).numerical == ""


def test_a_column_beyond_its_limit_falls_by_physics() -> None:
    timeline, tuned = timeline_of(COLUMN, "expect:\n  - collapses: any\n"), SYSTEMS["tuned"]
    fell = with_numerical_collapse(play(timeline, tuned), timeline, tuned)
    assert fell.collapse is not None
    assert fell.collapse.level == 7
    assert fell.numerical == ""


@pytest.mark.parametrize(("time", "stands"), [(5.9, True), (6.1, False)])
def test_statics_judge_the_structure_of_the_moment(time: float, stands: bool) -> None:
    # The seventh plank comes after 6 s, and is the one too many.
    assert stands_until(timeline_of(COLUMN), time) is stands


def test_a_pushed_structure_is_no_numerical_collapse() -> None:
    pushed = "impacts:\n  - after: built + 1 s\n    push: {brick: L1.1, impulse: [0.001 N*s, 0 N*s, 0 N*s]}\n"
    timeline = timeline_of("- column: {levels: 1}", pushed)
    assert stands_until(timeline, 0.5)
    assert not stands_until(timeline, 1.5)


def test_pulling_out_what_is_needed_is_judged_too() -> None:
    pulled = "impacts:\n  - after: built + 1 s\n    remove: {brick: L2.1}\n"
    timeline = timeline_of("- four_stack: {levels: 4}", pulled)
    assert stands_until(timeline, 0.5)
    assert not stands_until(timeline, 1.5)


def test_a_collapse_that_refinement_removes_is_numerical() -> None:
    refinement = compare_with_refined(trace(FELL), trace(), timeline_of(TOWER))
    assert refinement.trace.numerical == REMOVED
    assert {change.name for change in refinement.changes if change.moved} == {
        *("verdict", "collapse level", "collapse time", "first to leave")
    }


def test_a_collapse_that_is_proven_stays_one_whatever_a_refined_run_shows() -> None:
    refinement = compare_with_refined(trace(FELL), trace(), timeline_of(COLUMN))
    assert refinement.trace.numerical == ""
    assert next(change for change in refinement.changes if change.name == "verdict").moved


def test_a_collapse_that_stays_is_none_of_the_solver() -> None:
    refinement = compare_with_refined(trace(FELL), trace(replace(FELL, time=6.21)), timeline_of(TOWER))
    assert refinement.trace.numerical == ""
    assert not any(change.moved for change in refinement.changes)


@pytest.mark.parametrize(
    ("name", "before", "after", "moved"),
    [
        ("collapse level", 7.0, 7.0, False),
        ("collapse level", 7.0, 8.0, True),
        ("collapse time", 1.0, 1.04, False),
        ("collapse time", 1.0, 1.06, True),
        ("drift", 0.3, 0.35, False),
        ("drift", 0.3, 0.45, True),
        ("drift", 300.0, 310.0, False),  # 3 % of what flies far
        ("drift", 300.0, 320.0, True),
        ("bearing", 179.6, -179.6, False),  # 0.8 deg apart
        ("bearing", 179.0, -179.0, True),
        ("fallen", ("a",), ("a", "b"), True),
        ("height", None, 3.0, True),
    ],
)
def test_an_observation_moves_beyond_its_tolerance(name: str, before: Seen, after: Seen, moved: bool) -> None:
    assert Change(name, before, after).moved is moved


def test_every_observation_that_either_run_has_is_compared() -> None:
    seen = observations(trace(FELL))
    assert [change.name for change in changes(seen, observations(trace()))] == [
        name for name, value in seen.items() if value is not None
    ]


def test_a_numerical_collapse_fails_where_convergence_is_asked_for_and_is_told_where_it_is_not() -> None:
    plain = VariantResult("tower", "stock", "stock", "tower.yaml", RunStatus.DONE, numerical=DISPROVED)
    assert exit_code(Report((plain,))) == ExitCode.OK
    asked = replace(plain, refinement=())
    assert exit_code(Report((asked,))) == ExitCode.FAILED
    assert asked.conclusion == "numerical-collapse"


def test_a_collapse_on_exact_is_no_numerical_collapse() -> None:
    fell = trace(FELL)
    assert with_numerical_collapse(fell, timeline_of(TOWER), SYSTEMS["exact"]) is fell
    assert with_numerical_collapse(fell, timeline_of(TOWER), SYSTEMS["tuned"]).numerical == DISPROVED


def test_margins_of_what_the_solver_did_are_no_numbers() -> None:
    cases, _ = compiled(scene(TOWER, "expect:\n  - collapses: {at: level 6}\n"))
    outcome = judged(cases[0], trace(FELL, DISPROVED)).outcomes[0]
    assert outcome.margin == -inf
    assert not outcome.passed


def test_drift_is_the_same_in_the_table_in_a_claim_and_beside_a_refined_run() -> None:
    #   Of seven planks stepped by 18 mm the topmost ones fall, by far more than 10 mm, and the lowest hardly moves.
    rest = "systems: [exact]\nexpect:\n  - drift: '> 10 mm'\n  - drift: {is: <= 0.1 mm, bricks: [L1.1]}\n"
    case = compiled(scene(COLUMN, rest))[0][0]
    fell = play(case.timeline, SYSTEMS["exact"])
    seen, result = observations(fell), judged(case, fell)
    assert seen["drift"] == 1000.0 * result.drift == pytest.approx(10.0 + result.outcomes[0].margin)
    assert isinstance(seen["drift"], float)
    assert seen["drift"] > 10.0
    standing = [track for track in fell.tracks.values() if track.state in STAND]
    assert seen["drift of what stands"] == 1000.0 * max(track.shift for track in standing)
    assert result.outcomes[1].passed
