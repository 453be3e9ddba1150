"""A fall before the first impact is a failure, unless a claim expects it; on traces written by hand."""

from dataclasses import replace

import pytest

from stability.problem import Stability, Verdict
from stackdsl.judging.judge import judge
from stackdsl.results import ClaimOutcome
from stackdsl.trace import BrickState, Collapse, Event, EventKind, Trace
from tests.scenes import compiled, scene
from tests.stackdsl.judging.test_judge import STANDING, track

COLUMN = "- column: {levels: 3}"  # all at 0 s
THROW = "throw: {at: level 3, from: {bearing: 90 deg, distance: 100 mm}, speed: 0.5 m/s}"  # flies for 0.2 s


def fallen(time: float, *others: Event) -> Trace:
    """The uppermost plank left its place at a time [s]."""
    loose = replace(track("L3.1", 3, shift=0.05, state=BrickState.FALLEN), left_at=time)
    tracks = {**STANDING.tracks, "L3.1": loose}
    return replace(STANDING, tracks=tracks, collapse=Collapse(time, level=3, brick="L3.1"), events=others)


def failures(impacts: str, claim: str, trace: Trace, rest: str = "") -> list[ClaimOutcome]:
    """The failures that come of no claim of the file."""
    cases, mistakes = compiled(scene(COLUMN, f"{impacts}\nexpect:\n  - {claim}\n{rest}"))
    assert mistakes == []
    case = cases[0]
    return list(judge(trace, case.scenario, case.variant, case.source, "exact")[1:])


@pytest.mark.parametrize(
    "impact",
    [
        THROW,
        "drop: {onto: L3.1, height: 0.2 m}",
        "push: {brick: L3.1, impulse: [0.001 N*s, 0 N*s, 0 N*s]}",
        "remove: {brick: L3.1}",
        "insert: {name: late, at: [300 mm, 0 mm, 3.9 mm]}",
        "move: {brick: L3.1, by: [0 mm, 0 mm, 20 mm]}",
    ],
)
def test_a_fall_before_an_impact_of_any_kind_is_a_failure_at_its_line(impact: str) -> None:
    (found,) = failures(f"impacts: [{{at: 5 s, {impact}}}]", "falls: {count: <= 5}", fallen(1.0))
    assert not found.passed
    assert found.margin < -3.9
    assert found.unit == "s"
    assert (found.span.line, found.name) == (4, f"until impact 1 ({impact.split(':', maxsplit=1)[0]})")
    assert "it gave way at level 3 at 1.000 s" in found.measured
    assert failures(f"impacts: [{{at: 5 s, {impact}}}]", "falls: {count: <= 5}", fallen(5.6)) == []


def test_a_fall_before_shaking_is_a_failure() -> None:
    shaken = "world: {shake: {acceleration: 0.1 m/s2, frequency: 2 Hz, for: 2 s, at: 4 s}}"
    (found,) = failures(shaken, "falls: {count: <= 5}", fallen(1.0))
    assert found.name == "until the shaking"
    assert failures(shaken, "falls: {count: <= 5}", fallen(4.5)) == []


def test_where_nothing_is_done_there_is_nothing_before_it() -> None:
    assert failures("", "falls: {count: <= 5}", fallen(1.0)) == []


def test_a_hand_that_holds_a_brick_does_something_to_the_others_only_as_it_lets_go() -> None:
    held = "impacts: [{at: 0.5 s, hold: {brick: L1.1, for: 1 s}}]"
    (found,) = failures(held, "falls: {count: <= 5}", fallen(1.0))
    assert found.name == "until impact 1 (hold)"
    assert failures(held, "falls: {count: <= 5}", fallen(1.6)) == []


def test_the_impact_that_comes_first_counts_wherever_it_is_written() -> None:
    two = f"impacts: [{{at: 5 s, {THROW}}}, {{at: 1 s, push: {{brick: L3.1, impulse: [0.001 N*s, 0 N*s, 0 N*s]}}}}]"
    assert failures(two, "falls: {count: <= 5}", fallen(1.5)) == []
    assert failures(two, "falls: {count: <= 5}", fallen(0.5)) != []


def test_a_throw_begins_to_count_when_it_meets_what_it_is_aimed_at() -> None:
    impacts = f"impacts: [{{at: 1 s, {THROW}}}]"
    assert failures(impacts, "falls: {count: <= 5}", fallen(1.1)) != []  # it flies until 1.2 s
    assert failures(impacts, "falls: {count: <= 5}", fallen(1.19)) == []  # or a little less, where something leans


@pytest.mark.parametrize(
    ("claim", "expects"),
    [
        ("collapses: any", True),
        ("collapses: {at: level 3}", True),
        ("verdict: unstable", True),
        ("falls: {bricks: [L3.1]}", True),
        ("pivots: {about: L2.1}", True),
        ("lands: {reach: <= 1 m}", True),
        ("falls: {count: 1}", False),
        ("falls: {bricks: [L2.1]}", False),
        ("leaves: {levels: 2}", False),
        ("stands: {levels: 2}", False),
        ("height: <= 1 m", False),
        ("verdict: stable", False),
    ],
)
def test_a_claim_expects_a_fall_if_it_says_that_something_falls_and_not_if_it_says_how_much(
    claim: str, expects: bool
) -> None:
    assert (failures(f"impacts: [{{at: 5 s, {THROW}}}]", claim, fallen(1.0)) == []) is expects


def test_a_fall_before_an_impact_that_truth_states_is_no_failure() -> None:
    known = "truth: [{collapses: any, source: a book}]"
    assert failures(f"impacts: [{{at: 5 s, {THROW}}}]", "falls: {count: <= 5}", fallen(1.0), known) == []


def test_a_slow_fall_that_is_proven_counts_as_before_the_impact() -> None:
    #   It is woken at 0 s, as statics prove that it falls, and leaves its place only after the push.
    push = "impacts: [{at: 1 s, push: {brick: L3.1, impulse: [0.001 N*s, 0 N*s, 0 N*s]}}]"
    slow = fallen(1.4, Event(0.0, EventKind.WOKEN, ("L3.1",), "L3.1 tips over L2.1"))
    proven = replace(slow, statics=Verdict(Stability.UNSTABLE, reason="L3.1 tips over L2.1", moving=("L3.1",)))
    (found,) = failures(push, "falls: {count: <= 5}", proven)
    assert "at 0.000 s" in found.measured
    stable = replace(slow, statics=Verdict(Stability.STABLE, reason="load core"))
    assert failures(push, "falls: {count: <= 5}", stable) == []
