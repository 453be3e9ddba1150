"""Loads that grow or follow a table: a structure begins to move at the time of the closed form."""

import pytest

from stability import Stability
from stackdsl.judging.proofs import proofs_of
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.timeline import Timeline
from stackdsl.trace import EventKind, RunVerdict
from tests.scenes import timeline_of

BLOCK = "- bricks: [{name: block, at: [0 m, 0 m, 0.45 m]}]"
SCENE = "\nbrick: {size: [0.3 m, 0.4 m, 0.9 m], density: 200 kg/m3}\nfriction: 0.5\nwatch: 1 s"
LIMIT = 200.0 * 0.3 * 0.4 * 0.9 * 9.81 * 0.15 / 0.8  # [N] of a push at a height of 0.8 m
AT = "brick: block, towards: 0 deg, point: [0 m, 0 m, 0.35 m]"


def scene(load: str, build: str = BLOCK, more: str = "expect: [stands: all]") -> Timeline:
    return timeline_of(build, f"{SCENE}\nloads: [{{{load}}}]\n{more}")


def moves_at(timeline: Timeline) -> float | None:
    """Return the time at which bricks begin to move [s]; None if none does."""
    trace = play(timeline, system_named("exact"))
    woken = [event.time for event in trace.events if event.kind is EventKind.WOKEN]
    return woken[0] if woken else None


@pytest.mark.parametrize(
    ("load", "time"),
    [
        (f"force: from 0 to {2 * LIMIT} N over 10 s, {AT}", 5.0),
        (f"force: from {LIMIT / 2} N to {1.5 * LIMIT} N over 1 min, after: built + 2 s, {AT}", 32.0),
        (f"force: {LIMIT} N, table: [[0 s, 0 %], [1 s, 80 %], [2 s, 20 %], [4 s, 180 %]], {AT}", 3.0),
        # beyond a jump, for a moment: the block moves, and need not fall
        (f"force: {LIMIT} N, table: [[0 s, 20 %], [3 s, 90 %], [3 s, 101 %], [4 s, 0 %]], {AT}", 3.0),
    ],
)
def test_a_block_begins_to_move_when_its_load_reaches_the_limit(load: str, time: float) -> None:
    timeline = scene(load)
    assert moves_at(timeline) == pytest.approx(time, abs=1e-4)
    assert proofs_of(timeline).verdict.stability is Stability.UNSTABLE


@pytest.mark.parametrize(
    "load",
    [
        f"force: from 0 to {0.999 * LIMIT} N over 10 s, {AT}",
        f"force: from {0.999 * LIMIT} N to 0 N over 10 s, {AT}",
        f"force: {LIMIT} N, table: [[0 s, -20 %], [3 s, 99.9 %], [3 s, 20 %], [4 s, 30 %]], {AT}",
    ],
)
def test_a_block_stands_under_a_load_that_stays_below_the_limit(load: str) -> None:
    timeline = scene(load)
    assert moves_at(timeline) is None
    assert proofs_of(timeline).verdict.stability is Stability.STABLE


def test_a_peak_of_a_table_is_judged_although_the_load_ends_small() -> None:
    timeline = scene(f"force: {LIMIT} N, table: [[0 s, 0 %], [1 s, 100.1 %], [1 s, 0 %], [2 s, 0 %]], {AT}")
    assert proofs_of(timeline).verdict.stability is Stability.UNSTABLE
    assert moves_at(timeline) == pytest.approx(1.0 / 1.001, abs=1e-4)


def test_two_loads_that_grow_alone_are_borne_and_together_are_not() -> None:
    one, other = (f"force: from 0 N to {0.8 * LIMIT} N over 8 s, after: built + {begins} s, {AT}" for begins in (0, 4))
    timeline = timeline_of(BLOCK, f"{SCENE}\nloads: [{{{one}}}, {{{other}}}]\nexpect: [stands: all]")
    # 0.1 t + 0.1 (t - 4) = 1
    assert moves_at(timeline) == pytest.approx(7.0, abs=1e-4)


def test_a_load_may_begin_before_its_brick_is_placed() -> None:
    timeline = scene(f"force: {1.1 * LIMIT} N, after: start, {AT}", f"{BLOCK}\n  at: 3 s")
    assert moves_at(timeline) == pytest.approx(3.0)
    assert play(timeline, system_named("exact")).verdict is RunVerdict.COLLAPSES
