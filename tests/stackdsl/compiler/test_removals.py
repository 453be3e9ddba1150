"""Bricks that are pulled out or slid in: when, in which order, and what cannot be."""

from dataclasses import replace

import pytest

from stackdsl.timeline import Arrival, Placement, Removal, Timeline
from tests.scenes import assert_told_in_its_place, mistakes_of, timeline_of

SLID_IN = "insert: {name: wedge, at: [200 mm, 0 mm, 3.9 mm]}"


def order(timeline: Timeline) -> list[tuple[float, str]]:
    """Every action after the build: when, and what."""
    return [
        (action.time, f"out {' '.join(action.bricks)}" if isinstance(action, Removal) else f"in {action.brick.id}")
        for action in timeline.actions
        if isinstance(action, Removal) or (isinstance(action, Placement) and action.arrival is Arrival.SLID_IN)
    ]


def test_impacts_follow_the_build_and_one_another() -> None:
    impacts = f"impacts:\n  - remove: {{brick: L2.2}}\n  - {SLID_IN}\n  - remove: {{bricks: [wedge, L1.1]}}"
    timeline = timeline_of("- four_stack: {levels: 2}\n  every: 1 s", impacts)
    assert order(timeline) == [(4.0, "out L2.2"), (4.0, "in wedge"), (4.0, "out wedge L1.1")]


@pytest.mark.parametrize(
    ("when", "time"),
    [
        ("at: 1.5 s", 1.5),
        ("after: start + 7 s", 7.0),
        ("after: built + 2 s", 4.0),  # not after the brick that was slid in at 9 s
        ("after: level 2", 1.0),
        ("after: brick wedge + 1 s", 10.0),
        ("after: impact 1 + 2 s", 11.0),
    ],
)
def test_an_impact_comes_at_its_time_or_when_its_event_is_over(when: str, time: float) -> None:
    impacts = f"impacts:\n  - {{at: 9 s, {SLID_IN}}}\n  - {{{when}, remove: {{brick: L1.1}}}}"
    timeline = timeline_of("- column: {levels: 3}\n  every: 1 s", impacts)
    assert (time, "out L1.1") in order(timeline)
    assert [action.time for action in timeline.actions] == sorted(action.time for action in timeline.actions)


def test_a_structure_is_watched_after_the_last_impact() -> None:
    impacts = "impacts: [{after: built + 3 s, remove: {brick: L2.1}}]\nexpect: [{stands: {for: 5 s}}]"
    timeline = timeline_of("- column: {levels: 2}\n  every: 1 s", impacts)
    assert (timeline.built, timeline.end) == (1.0, 9.0)


def test_a_brick_may_take_the_place_of_one_that_was_pulled_out() -> None:
    impacts = "impacts: [{remove: {brick: L2.1}}, {insert: {at: [0 mm, 0 mm, 11.7 mm]}}]"
    timeline = timeline_of("- column: {levels: 3}", impacts)
    assert order(timeline) == [(0.0, "out L2.1"), (0.0, "in L2.2")]
    assert [placement.level for placement in timeline.placements] == [1, 2, 3, 2]


def test_what_is_slid_in_is_turned_and_tilted_like_all_that_is_built() -> None:
    low, high = "{at: [0 mm, 0 mm, 3.9 mm]}", "{at: [0 mm, 0 mm, 11.7 mm], rotate: [0 deg, 0 deg, 90 deg]}"
    tilt = "world: {tilt: 5 deg}"
    built = timeline_of(f"- bricks: [{low}, {high}]", tilt).placements[1]
    slid_in = timeline_of(f"- bricks: [{low}]", f"{tilt}\nimpacts: [{{insert: {high}}}]").placements[1]
    assert slid_in == replace(built, arrival=Arrival.SLID_IN)


@pytest.mark.parametrize(
    ("impacts", "code", "words"),  # ^ marks the place that is told
    [
        ("{remove: {brick: ^roof}}", "SD204", "there is no brick 'roof'"),
        ("{remove: {bricks: [L2.1, ^roof]}}", "SD204", "there is no brick 'roof'"),
        (
            "{remove: {brick: L1.1}}, {remove: {brick: ^L1.1}}",
            "SD204",
            "another impact also pulls out brick 'L1.1', at 6:28",
        ),
        ("{remove: {bricks: [L1.1, ^L1.1]}}", "SD204", "another impact also pulls out brick 'L1.1', at 6:30"),
        ("{at: 1 s, remove: {brick: ^L2.1}}", "SD204", "not placed before 4 s"),
        ("{insert: ^{at: [0 mm, 0 mm, 3 mm]}}", "SD201", "0.9 mm inside ground"),
        ("{insert: ^{at: [0 mm, 0 mm, 11.7 mm]}}", "SD201", "inside brick 'L2.1'"),
        ("{insert: ^{at: [0 mm, 0 mm, 11.7 mm]}}, {remove: {brick: L2.1}}", "SD201", "inside brick 'L2.1'"),
        ("{insert: ^{at: [0 mm, 0 mm, 50 mm]}}", "SD202", "has no support"),
        ("{insert: ^{name: L1.1, at: [0 mm, 90 mm, 3.9 mm]}}", "SD203", "two bricks have the name 'L1.1'"),
        (
            "^{remove: {brick: L2.1}, insert: {at: [0 mm, 0 mm, 5 mm]}}",
            "SD108",
            "exactly one of the keys remove, insert, throw, push, drop",
        ),
        ("{remove: ^{}}", "SD108", "exactly one of the keys brick, bricks"),
        ("^{at: 1 s, after: built, remove: {brick: L2.1}}", "SD108", "exclude each other"),
        ("{after: ^impact 1, remove: {brick: L2.1}}", "SD205", "waits for impact 1"),
    ],
)
def test_an_impact_that_cannot_be_is_told_in_its_place(impacts: str, code: str, words: str) -> None:
    assert_told_in_its_place(impacts, code, words)


@pytest.mark.parametrize(
    "claim", ["stands: {bricks: [L2.1]}", "height: {is: < 8 mm, of: L2.1}", "drift: {is: < 1 mm, bricks: [L2.1]}"]
)
def test_nothing_is_expected_of_a_brick_that_is_pulled_out(claim: str) -> None:
    impacts = f"impacts: [{{remove: {{brick: L2.1}}}}]\nexpect: [{{{claim}}}]"
    (mistake,) = mistakes_of("- column: {levels: 2}", impacts)
    assert (mistake.code, mistake.span.line) == ("SD204", 5)
    assert "pulled out" in mistake.message
    assert mistakes_of("- column: {levels: 2}", impacts.replace(claim, "collapses: {brick: L2.1}")) == []
