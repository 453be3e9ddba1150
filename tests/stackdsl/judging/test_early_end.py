"""A collapsed run ends as soon as every claim is decided, with the results of the complete run."""

import re
from dataclasses import replace
from functools import cache

import pytest

from stackdsl.checking.cases import Case
from stackdsl.checking.play_case import play_case
from stackdsl.judging.judge import judge, stop_condition_of
from stackdsl.timeline import Removal
from stackdsl.trace import BrickState, EarlyEnd, Trace
from tests.paths import ROOT
from tests.scenes import compiled, scene
from tests.stackdsl.judging.test_judge import FALLEN, track

SCENARIO = (ROOT / "scenarios" / "jenga.yaml").read_text(encoding="utf-8")
JENGA = "".join(line for line in SCENARIO.splitlines(keepends=True) if not re.match("  - {at: [789].5 s", line))
EARLY = 6.5  # [s] it falls at 5.03, is followed for a second, lies still, and then the next plank would be pulled out
LAST = 8.5  # [s] the last pull, and two seconds


def jenga(expect: str) -> Case:
    """The tower of the scenario with other expectations; nothing is known from outside."""
    cases, mistakes = compiled(f"{JENGA.partition('expect:')[0]}{expect}")
    assert mistakes == []
    return cases[0]


@cache
def asked() -> tuple[Trace, ...]:
    """What the run of the tower shows whenever it asks whether all is known, and at its end: it is always told no."""
    seen: list[Trace] = []

    def note(trace: Trace) -> bool:
        seen.append(trace)
        return False

    last = play_case(jenga("").timeline, "exact", note)
    assert last.cost.simulated_time == pytest.approx(LAST)
    assert last.early_end is None
    return (*seen, last)


def to_its_end() -> Trace:
    return asked()[-1]


def watched(case: Case) -> Trace:
    """What the run shows when it is first told yes, as it then would end; that is why all claims can share one."""
    assert replace(case.timeline, reported_margins=()) == jenga("").timeline  # on those, nothing depends
    known = stop_condition_of(case.scenario, "exact")
    return next((trace for trace in asked()[:-1] if known(trace)), to_its_end())


def verdicts(case: Case, trace: Trace) -> list[bool]:
    return [outcome.passed for outcome in judge(trace, case.scenario, case.variant, case.source, "exact")]


ONE_RUN = pytest.mark.xdist_group("a tower that fell")


@ONE_RUN
@pytest.mark.parametrize(
    ("claim", "end"),
    [
        ("collapses: any", EARLY),
        ("collapses: {at: level 5}", EARLY),  # nor will it come true
        ("stands: all", EARLY),
        ("stands: {levels: 6, for: 2 s}", EARLY),
        ("falls: {count: '>= 2'}", EARLY),
        ("falls: {count: '< 2'}", EARLY),
        ("leaves: {levels: '>= 4'}", EARLY),
        ("drift: <= 1 mm", EARLY),
        ("displaced: {bricks: '>= 3', by: '> 1 mm'}", EARLY),
        ("leaves: {levels: '>= 1'}", LAST),  # the lowest level stands, and something may still hit it
        ("falls: {count: <= 8}", LAST),
        ("drift: {is: <= 1 mm, bricks: [L1.1]}", LAST),
        ("stands: {levels: 1}", LAST),
        ("energy: {gain: <= 1 %}", LAST),
    ],
)
def test_the_early_end_of_a_collapsed_run_waits_for_undecided_claims(claim: str, end: float) -> None:
    case = jenga(f"expect:\n  - {claim}\n")
    assert watched(case).cost.simulated_time == pytest.approx(end)
    assert verdicts(case, watched(case)) == verdicts(case, to_its_end())


@ONE_RUN
def test_an_early_end_says_until_when_it_would_have_gone_on_and_what_was_left_out() -> None:
    case = jenga("expect:\n  - collapses: any\n")
    trace = play_case(case.timeline, "exact", stop_condition_of(case.scenario, "exact"))
    assert trace.early_end is not None
    assert trace.early_end.planned == pytest.approx(LAST)
    assert [action.bricks for action in trace.undone if isinstance(action, Removal)] == [("L3.1",)]
    assert trace.pending_removals == {"L3.1"}
    then = watched(case)
    assert (trace.early_end, trace.tracks, trace.events) == (then.early_end, then.tracks, then.events)


@ONE_RUN
@pytest.mark.parametrize("expect", ["", "truth:\n  - {collapses: any, source: statics}\n"])
def test_a_run_without_expectations_has_no_early_end(expect: str) -> None:
    assert watched(jenga(expect)).early_end is None


def test_an_early_end_waits_for_claims_of_truth_too() -> None:
    expect = "expect:\n  - collapses: any\n"
    truth = "truth:\n  - {leaves: {levels: '>= 1'}, source: a guess}\n"
    assert stop_condition_of(jenga(expect).scenario, "exact")(FALLEN)
    assert not stop_condition_of(jenga(expect + truth).scenario, "exact")(FALLEN)


# --- each kind of claim, of traces written by hand --------------------------------------------------------------------

# L3.1 of a column of three fell; of five levels, the two above were never placed.
UNBUILT = replace(
    FALLEN,
    tracks={
        **FALLEN.tracks,
        "L4.1": track("L4.1", 4, state=BrickState.UNPLACED),
        "L5.1": track("L5.1", 5, state=BrickState.UNPLACED),
    },
)


def decided(claim: str, trace: Trace) -> bool:
    cases, mistakes = compiled(scene("- column: {levels: 5}", f"expect:\n  - {claim}"))
    assert mistakes == []
    return cases[0].scenario.expect[0].content.is_decided(trace)


@pytest.mark.parametrize(
    ("claim", "known"),
    [
        ("collapses: {brick: L2.1}", True),
        ("stands: all", True),  # it never will
        ("stands: {bricks: [L4.1]}", True),
        ("stands: {bricks: [L2.1]}", False),
        ("stands: {bricks: [L2.1], for: 1 s}", True),  # two seconds passed after the last action
        ("stands: {bricks: [L2.1], for: 9 s}", False),
        ("falls: {bricks: [L3.1]}", False),  # L2.1 may come after it
        ("falls: {bricks: [L2.1]}", True),  # L3.1 was not to
        ("falls: {bricks: [L3.1, L4.1]}", True),  # what was never placed cannot fall
        ("falls: {count: 1 .. 3}", True),
        ("falls: {count: 1 .. 2}", False),
        ("falls: {count: '> 3'}", True),
        ("leaves: {levels: '>= 3'}", True),
        ("leaves: {levels: 0 .. 2}", True),
        ("leaves: {bricks: 2}", False),
        ("leaves: {bricks: '> 2'}", True),
        ("displaced: {bricks: '>= 1', by: '> 5 mm'}", True),
        ("displaced: {bricks: '<= 1', by: '> 5 mm'}", False),
        ("displaced: {bricks: '< 1', by: '> 5 mm'}", True),
        ("drift: <= 49 mm", True),
        ("drift: <= 51 mm", False),
        ("drift: '> 49 mm'", True),
        ("drift: {is: <= 1 mm, bricks: [L5.1]}", True),  # never placed
        ("untouched: {bricks: [L1.1]}", False),
        ("height: {of: L1.1, is: 7.8 mm ± 1 mm}", False),
        ("rests_on: {brick: L2.1, support: L1.1}", False),
        ("energy: {gain: <= 1 %}", False),
        ("lands: {reach: '> 1 mm'}", False),
        ("pivots: {within: 5 deg}", False),  # nothing turned as yet
        ("verdict: stable", True),
    ],
)
def test_a_claim_is_decided_once_nothing_that_may_fall_changes_it(claim: str, known: bool) -> None:
    assert decided(claim, UNBUILT) is known


@pytest.mark.parametrize(
    ("claim", "known"),
    [
        ("stands: all", False),  # the only one that fell is gone by then
        ("falls: {count: '> 0'}", False),
        ("displaced: {bricks: '>= 1', by: '> 5 mm'}", False),
        ("drift: <= 49 mm", False),
        ("verdict: stable", False),  # it is asked again when something is pulled out
        ("collapses: any", True),
    ],
)
def test_planned_removals_keep_claims_undecided(claim: str, known: bool) -> None:
    assert decided(claim, replace(FALLEN, early_end=EarlyEnd(3.0, 9.0, (Removal(7.0, ("L3.1",)),)))) is known


def test_an_unsettled_brick_keeps_claims_undecided() -> None:
    tracks = {**FALLEN.tracks, "L2.1": track("L2.1", 2, state=BrickState.UNSETTLED)}
    assert not decided("leaves: {bricks: 2}", replace(FALLEN, tracks=tracks))
    assert decided("leaves: {bricks: '>= 3'}", replace(FALLEN, tracks=tracks))
    assert decided("leaves: {bricks: '>= 2'}", FALLEN) is False
