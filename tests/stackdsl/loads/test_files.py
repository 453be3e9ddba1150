"""Loads over time from CSV files: the same as tables in the scenario, or refused at their place."""

from pathlib import Path

import pytest

from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.timeline import LoadsAction
from stackdsl.trace import EventKind
from tests.records import at2, csv, scene_with

LIMIT = 200.0 * 0.3 * 0.4 * 0.9 * 9.81 * 0.15 / 0.8  # [N] of a push at a height of 0.8 m
AT = "brick: block, towards: 0 deg, point: [0 m, 0 m, 0.35 m]"


def loaded(load: str) -> str:
    brick = "{size: [0.3 m, 0.4 m, 0.9 m], density: 200 kg/m3}"
    build = "[bricks: [{name: block, at: [0 m, 0 m, 0.45 m]}]]"
    rest = f"watch: 1 s\nloads: [{{{load}}}]\nexpect: [stands: all]"
    return f"scenario: scene\nbrick: {brick}\nfriction: 0.5\nbuild: {build}\n{rest}\n"


@pytest.mark.parametrize(("unit", "factor"), [("", 1.0), (" [%]", 100.0)])
def test_a_block_begins_to_move_when_the_share_in_a_file_reaches_the_limit(
    tmp_path: Path, unit: str, factor: float
) -> None:
    rows = [(0.0, 0.0), (1.0, 0.8 * factor), (2.0, 0.2 * factor), (4.0, 1.8 * factor)]
    text = csv(f"time [s],share{unit}", rows)
    (timeline,), mistakes = scene_with(tmp_path, {"f.csv": text}, loaded(f"force: {LIMIT} N, file: f.csv, {AT}"))
    assert mistakes == []
    trace = play(timeline, system_named("exact"))
    woken = [event.time for event in trace.events if event.kind is EventKind.WOKEN]
    assert woken[0] == pytest.approx(3.0, abs=1e-4)


def test_a_file_and_a_table_of_the_same_shares_are_one_load(tmp_path: Path) -> None:
    files = {"f.csv": csv("time [ms],share", [(0, -0.5), (500, 0.25), (500, 0.75), (2000, 0.1)])}
    table = "[[0 s, -0.5], [0.5 s, 0.25], [0.5 s, 0.75], [2 s, 0.1]]"
    (one,), _ = scene_with(tmp_path, files, loaded(f"force: 8 N, file: f.csv, {AT}"))
    (other,), _ = scene_with(tmp_path, files, loaded(f"force: 8 N, table: {table}, {AT}"))
    assert [action for action in one.actions if isinstance(action, LoadsAction)]
    assert one.actions == other.actions


@pytest.mark.parametrize(
    ("load", "code", "words"),
    [
        ("force: 1 N, file: none.csv", "SD113", "does not exist"),
        ("force: 1 N, file: r.at2", "SD114", "r.at2 has no column `share`"),
        ("force: 1 N, file: a.csv", "SD114", "a.csv has no column `share`"),
        ("force: 1 N, file: long.csv", "SD114", "has 1001 rows; the maximum for a load is 1000"),
        ("force: 1 N, file: large.csv", "SD114", "a share beyond 1000"),
        ("force: 1 N, file: unit.csv", "SD114", "unit.csv:1:10: 'N' is not a unit of a share"),
        ("force: 1 N, file: cut.csv", "SD114", "cut.csv:3:4: the last line has no line end"),
        ("force: 1 N, file: f.csv, table: [[0 s, 0], [1 s, 1]]", "SD108", "has a `file` and has a `table`"),
        ("force: from 0 N to 2 N over 1 s, file: f.csv", "SD108", "has a `file` and grows"),
    ],
)
def test_a_load_from_another_file_is_refused(tmp_path: Path, load: str, code: str, words: str) -> None:
    files = {
        "r.at2": at2([0.0, 1.0, 0.0], 0.01),
        "a.csv": csv("time [s],acceleration [g]", [(0, 0), (1, 1)]),
        "f.csv": csv("time [s],share", [(0, 0), (1, 1)]),
        "long.csv": csv("time [s],share", [(number, 0) for number in range(1001)]),
        "large.csv": csv("time [s],share", [(0, 0), (1, 1001)]),
        "unit.csv": csv("time [s],share [N]", [(0, 0), (1, 1)]),
        "cut.csv": "time [s],share\n0,0\n1,1",
    }
    _, mistakes = scene_with(tmp_path, files, loaded(f"{load}, {AT}"))
    assert [mistake.code for mistake in mistakes] == [code]
    assert words in mistakes[0].message
    assert mistakes[0].hint
