"""What a snapshot locks of a run, and what it leaves open because a small disturbance changes it."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from math import cos, nan, pi, radians, sin, sqrt
from typing import TypeVar

import pytest

from stability.model import Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.snapshots.canonical import canonical_text, document
from stackdsl.snapshots.comparison import compare, compare_documents
from stackdsl.snapshots.record import UNCLEAR, Identity, Pushing, Removing, Snapshot
from stackdsl.snapshots.snapshot import take
from stackdsl.timeline import World
from stackdsl.trace import BrickState, BrickTrack, Collapse, Cost, Edge, Event, EventKind, Trace

T = TypeVar("T")
PLANK: Vec3 = (0.120, 0.024, 0.008)
THRESHOLD = 0.004  # [m] half of the plank's smallest side: a collapse begins beyond this shift
IDENTITY = Identity("tower", "thesis", "thesis")
STAMP = {"stackdsl": "0.1.0", "pybullet": "3.2.7", "python": "3.11"}
FALL = Collapse(time=2.5, level=3, brick="L2.1", gave_way="L1.1")


def track(name: str, level: int, state: BrickState = BrickState.FROZEN, shift: float = 0.0) -> BrickTrack:
    """A plank that lies on the one below, centred on the z axis."""
    place = Pose((0.0, 0.0, 0.008 * level - 0.004))
    return BrickTrack(Brick(name, PLANK, 0.0119), level, state, place, place, place, shift, tilt=0.0)


#   |--L3.1--|
#   |--L2.1--|
#   |--L1.1--|
#   =========  ground
def tower(*changed: BrickTrack, collapse: Collapse | None = None) -> Trace:
    """Three levels of one plank, a second apart; the first rests on the ground with all its weight, and so on."""
    tracks = {name: track(name, level) for level, name in enumerate(("L1.1", "L2.1", "L3.1"), start=1)}
    tracks |= {one.brick.id: one for one in changed}
    below = {"L1.1": "ground", "L2.1": "L1.1", "L3.1": "L2.1"}
    edges = {name: Edge(name, lower, 1.0) for name, lower in below.items()}
    placed = [name for name in below if tracks[name].state is not BrickState.UNPLACED]
    return Trace(
        events=tuple(Event(float(i), EventKind.PLACED, (name,), margin=0.012) for i, name in enumerate(placed)),
        tracks=tracks,
        edges=tuple(edge for name, edge in edges.items() if tracks[name].state is BrickState.FROZEN),
        collapse=collapse,
        cost=Cost(wall_time=1.0, simulated_time=5.0, steps=100, judgements=3),
        edges_when_placed={name: (edges[name],) for name in placed},
    )


WORLD = World(9.81, 0.5, (Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.4),))


def taken(trace: Trace, proven: bool = True) -> Snapshot:
    return take(trace, WORLD, IDENTITY, STAMP, proven)


def states(snapshot: Snapshot) -> dict[str, str]:
    return {name: brick.state for name, brick in snapshot.bricks.items()}


def test_a_proven_run_locks_everything() -> None:
    snapshot = taken(tower())
    assert (snapshot.verdict, snapshot.collapse) == ("stands", None)
    assert (snapshot.height_mm, snapshot.levels_standing) == (24.0, 3)
    assert [(event.time_s, event.margin_mm) for event in snapshot.placings] == [(0.0, 12.0), (1.0, 12.0), (2.0, 12.0)]
    second = snapshot.placings[1].placed["L2.1"]
    assert (second.at_mm, second.rests_on) == ((0.0, 0.0, 12.0), {"L1.1": 1.0})
    last = snapshot.bricks["L3.1"]
    assert (last.level, last.state, last.at_mm, last.rests_on) == (3, "frozen", (0.0, 0.0, 20.0), {"L2.1": 1.0})


def test_a_bare_engine_locks_only_where_bricks_were_placed_and_that_they_stand() -> None:
    standing = [replace(each, state=BrickState.STANDING) for each in tower().tracks.values()]
    snapshot = taken(tower(*standing), proven=False)
    assert (snapshot.height_mm, snapshot.levels_standing) == (None, None)
    assert {event.margin_mm for event in snapshot.placings} == {None}
    second = snapshot.placings[1].placed["L2.1"]
    assert (second.at_mm, second.rests_on) == ((0.0, 0.0, 12.0), None)
    assert states(snapshot) == dict.fromkeys(("L1.1", "L2.1", "L3.1"), "standing")
    assert {(brick.at_mm, brick.rests_on) for brick in snapshot.bricks.values()} == {(None, None)}


def test_a_collapse_is_locked_with_time_and_culprit_only_where_a_model_tells() -> None:
    fallen = track("L3.1", 3, BrickState.FALLEN, shift=1.0)
    proven = taken(tower(fallen, collapse=FALL)).collapse
    assert proven is not None
    assert (proven.level, proven.time_s, proven.gave_way) == (3, 2.5, "L1.1")
    bare = taken(tower(fallen, collapse=FALL), proven=False).collapse
    assert bare is not None
    assert (bare.level, bare.time_s, bare.gave_way) == (3, None, None)


CLEAR_CUT = [
    (BrickState.FALLEN, 3.1, "fallen"),
    (BrickState.FALLEN, 2.9, UNCLEAR),
    (BrickState.STANDING, 0.32, "standing"),
    (BrickState.STANDING, 0.34, UNCLEAR),
    (BrickState.STANDING, nan, UNCLEAR),
]


@pytest.mark.parametrize(("state", "thresholds", "locked"), CLEAR_CUT)
def test_a_bare_engine_locks_a_state_only_where_it_is_clear_cut(
    state: BrickState, thresholds: float, locked: str
) -> None:
    last = track("L3.1", 3, state, shift=thresholds * THRESHOLD)
    assert states(taken(tower(last, collapse=FALL), proven=False))["L3.1"] == locked


@pytest.mark.parametrize(("tilt", "locked"), [(46.0, "fallen"), (44.0, UNCLEAR)])
def test_a_brick_that_turned_over_in_its_place_has_clearly_fallen(tilt: float, locked: str) -> None:
    # The threshold is 15 deg.
    last = replace(track("L3.1", 3, BrickState.FALLEN), tilt=radians(tilt))
    assert states(taken(tower(last, collapse=FALL), proven=False))["L3.1"] == locked


def test_a_proven_state_is_locked_whatever_the_drift_as_long_as_nothing_collapsed() -> None:
    last = track("L3.1", 3, BrickState.STANDING, shift=0.9 * THRESHOLD)
    assert states(taken(tower(last)))["L3.1"] == "standing"
    assert states(taken(tower(last, collapse=FALL)))["L3.1"] == UNCLEAR


@pytest.mark.parametrize("proven", [True, False])
def test_where_fallen_bricks_landed_is_never_locked(proven: bool) -> None:
    last = track("L3.1", 3, BrickState.FALLEN, shift=1.0)
    brick = taken(tower(last, collapse=FALL), proven).bricks["L3.1"]
    assert (brick.state, brick.at_mm, brick.rests_on) == ("fallen", None, None)


@pytest.mark.parametrize(("state", "locked"), [(BrickState.FROZEN, True), (BrickState.STANDING, False)])
def test_after_a_collapse_only_what_is_held_fixed_has_a_place(state: BrickState, locked: bool) -> None:
    fallen = track("L3.1", 3, BrickState.FALLEN, shift=1.0)
    brick = taken(tower(track("L2.1", 2, state), fallen, collapse=FALL)).bricks["L2.1"]
    assert brick.state == state
    assert (brick.at_mm is not None) is locked


def test_height_and_levels_are_those_of_what_stands() -> None:
    snapshot = taken(tower(track("L2.1", 2, BrickState.FALLEN, shift=1.0), collapse=FALL))
    assert (snapshot.height_mm, snapshot.levels_standing) == (24.0, 1)


def test_height_and_levels_are_unclear_where_they_hang_on_an_unclear_brick() -> None:
    snapshot = taken(tower(track("L3.1", 3, BrickState.STANDING, shift=0.5 * THRESHOLD), collapse=FALL))
    assert (snapshot.height_mm, snapshot.levels_standing) == (UNCLEAR, UNCLEAR)
    below = taken(tower(track("L2.1", 2, BrickState.STANDING, shift=0.5 * THRESHOLD), collapse=FALL))
    assert (below.height_mm, below.levels_standing) == (24.0, UNCLEAR)


def test_the_height_is_that_of_the_highest_corner() -> None:
    # Turned by 45 deg about y, a plank reaches (length + thickness) / sqrt(8) above its centre.
    turn = (0.0, sin(pi / 8.0), 0.0, cos(pi / 8.0))
    leaning = replace(track("L3.1", 3), final=Pose((0.0, 0.0, 0.1), turn))
    assert taken(tower(leaning)).height_mm == pytest.approx(100.0 + 128.0 / sqrt(8.0), abs=0.01)


def test_nothing_that_stands_has_no_height() -> None:
    fallen = [track(f"L{level}.1", level, BrickState.FALLEN, shift=1.0) for level in (1, 2, 3)]
    snapshot = taken(tower(*fallen, collapse=FALL))
    assert (snapshot.height_mm, snapshot.levels_standing) == (0.0, 0)


@pytest.mark.parametrize(("level", "locked"), [(3, UNCLEAR), (4, "unplaced")])
def test_with_a_bare_engine_it_is_a_matter_of_moments_who_was_still_placed_in_the_level_that_fell(
    level: int, locked: str
) -> None:
    snapshot = taken(tower(track("L3.1", level, BrickState.UNPLACED), collapse=FALL), proven=False)
    assert states(snapshot)["L3.1"] == locked


def test_with_a_bare_engine_placings_are_locked_up_to_the_level_that_fell() -> None:
    trace = tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL)
    assert [list(event.placed) for event in taken(trace, proven=False).placings] == [["L1.1"], ["L2.1"]]
    assert [list(event.placed) for event in taken(trace).placings] == [["L1.1"], ["L2.1"], ["L3.1"]]


def test_of_the_placing_that_brought_the_stack_down_no_model_tells() -> None:
    *before, last = taken(tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL)).placings
    assert (last.time_s, last.margin_mm, last.placed["L3.1"].rests_on) == (2.0, None, None)
    assert [event.margin_mm for event in before] == [12.0, 12.0]
    assert [brick.rests_on for event in before for brick in event.placed.values()] == [{"ground": 1.0}, {"L1.1": 1.0}]


def pulled_out() -> Trace:
    """The tower without its topmost plank, which was pulled out after 5 s."""
    trace = tower(track("L3.1", 3, BrickState.REMOVED, shift=nan))
    return replace(trace, events=(*trace.events, Event(5.0, EventKind.REMOVED, ("L3.1",))))


@pytest.mark.parametrize("proven", [True, False])
def test_a_brick_that_was_pulled_out_is_locked_with_its_time_and_without_a_place(proven: bool) -> None:
    snapshot = taken(pulled_out(), proven)
    assert snapshot.events[-1] == Removing(5.0, ("L3.1",))
    last = snapshot.bricks["L3.1"]
    assert (last.state, last.at_mm, last.rests_on) == ("removed", None, None)


def test_what_was_pulled_out_is_no_part_of_what_stands() -> None:
    snapshot = taken(pulled_out())
    assert (snapshot.verdict, snapshot.height_mm, snapshot.levels_standing) == ("stands", 16.0, 2)


def test_the_text_of_a_removal_is_one_line() -> None:
    assert '    {"time_s": 5.0, "removed": ["L3.1"]}\n' in canonical_text(taken(pulled_out()))


def test_a_brick_pulled_out_at_another_time_or_not_at_all_is_a_difference() -> None:
    trace = pulled_out()
    later = replace(trace, events=(*trace.events[:-1], Event(6.0, EventKind.REMOVED, ("L3.1",))))
    never = replace(trace, events=trace.events[:-1])
    expected = document(taken(trace))
    assert compare(expected, taken(trace)) == ()
    assert [each.quantity for other in (later, never) for each in compare(expected, taken(other))] == [
        "pulled out at"
    ] * 2


def test_what_a_run_cost_is_not_locked() -> None:
    dear = replace(tower(), cost=Cost(wall_time=nan, simulated_time=nan, steps=-1, judgements=-1))
    assert canonical_text(taken(dear)) == canonical_text(taken(tower()))


def test_what_the_extension_did_between_placings_is_not_locked() -> None:
    trace = tower()
    busy = replace(trace, events=(*trace.events, Event(nan, EventKind.FROZEN, ("L1.1",), "settled")))
    assert taken(busy) == taken(trace)


def test_two_contacts_with_one_support_count_together() -> None:
    halves = (Edge("L2.1", "L1.1", 0.4), Edge("L2.1", "L1.1", 0.6))
    snapshot = taken(replace(tower(), edges=halves))
    assert snapshot.bricks["L2.1"].rests_on == {"L1.1": 1.0}


CANONICAL = """\
{
  "format": 1,
  "scenario": "tower",
  "variant": "thesis",
  "system": "thesis",
  "stamp": {"pybullet": "3.2.7", "python": "3.11", "stackdsl": "0.1.0"},
  "world": {"gravity": 9.81, "friction": 0.5, "planes": {"ground": {"at_mm": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "friction": 0.4}}},
  "verdict": "collapses",
  "collapse": {"level": 3, "time_s": 2.5, "gave_way": "L1.1"},
  "height_mm": 16.0,
  "levels_standing": 2,
  "events": [
    {"time_s": 0.0, "margin_mm": 12.0, "placed": {
      "L1.1": {"at_mm": [0.0, 0.0, 4.0], "turn_deg": [0.0, 0.0, 0.0], "size_mm": [120.0, 24.0, 8.0], "mass_g": 11.9, "rests_on": {"ground": 1.0}}
    }},
    {"time_s": 1.0, "placed": {
      "L2.1": {"at_mm": [0.0, 0.0, 12.0], "turn_deg": [0.0, 0.0, 0.0], "size_mm": [120.0, 24.0, 8.0], "mass_g": 11.9}
    }}
  ],
  "bricks": {
    "L1.1": {"level": 1, "state": "frozen", "at_mm": [0.0, 0.0, 4.0], "rests_on": {"ground": 1.0}},
    "L2.1": {"level": 2, "state": "frozen", "at_mm": [0.0, 0.0, 12.0], "rests_on": {"L1.1": 1.0}},
    "L3.1": {"level": 3, "state": "unplaced"}
  }
}
"""  # noqa: E501 -- a golden file has one line an event


def test_the_text_has_one_line_a_brick_and_an_event() -> None:
    assert canonical_text(taken(tower(track("L3.1", 3, BrickState.UNPLACED), collapse=FALL))) == CANONICAL


def test_the_text_is_the_json_of_the_document() -> None:
    snapshot = taken(tower())
    assert json.loads(canonical_text(snapshot)) == document(snapshot)


def test_an_empty_run_has_a_text() -> None:
    empty = Trace((), {}, (), None, Cost(0.0, 0.0, 0, 0), {})
    assert '"events": [],\n  "bricks": {}\n}\n' in canonical_text(taken(empty))


def test_the_text_is_rounded_and_has_no_negative_zero_and_no_infinity() -> None:
    place = Pose((-1e-9, 0.1 + 0.2, nan))
    snapshot = taken(tower(replace(track("L1.1", 1), placed=place)))
    assert '{"at_mm": [0.0, 300.0, "nan"], "turn_deg": [0.0, 0.0, 0.0]' in canonical_text(snapshot)


def test_the_text_is_ascii_whatever_the_names() -> None:
    snapshot = take(tower(), WORLD, replace(IDENTITY, scenario="tårn\ud800"), STAMP, proven=True)
    assert r'"t\u00e5rn\ud800"' in canonical_text(snapshot)
    assert canonical_text(snapshot).isascii()


def test_the_order_of_bricks_edges_and_versions_does_not_reach_the_text() -> None:
    trace = tower()
    trace = replace(trace, edges=(*trace.edges, Edge("L3.1", "L1.1", 0.0)))
    turned = replace(trace, tracks=_reversed(trace.tracks), edges=trace.edges[::-1])
    assert canonical_text(take(turned, WORLD, IDENTITY, _reversed(STAMP), proven=True)) == canonical_text(taken(trace))


def _reversed(values: Mapping[str, T]) -> dict[str, T]:
    return dict(reversed(list(values.items())))


@pytest.mark.parametrize("seed", ["0", "1"])
def test_another_process_writes_the_same_bytes(seed: str) -> None:
    program = "from tests.test_snapshot import *; print(canonical_text(taken(tower())), end='')"
    environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, check=True)
    assert done.stdout.decode("ascii") == canonical_text(taken(tower()))


def test_a_snapshot_says_of_which_scene_it_is() -> None:
    world = document(taken(tower()))["world"]
    assert world == {
        "gravity": 9.81,
        "friction": 0.5,
        "planes": {"ground": {"at_mm": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "friction": 0.4}},
    }


@pytest.mark.parametrize(
    ("orientation", "turn"),
    [
        ((0.0, 0.0, 0.0, 1.0), [0.0, 0.0, 0.0]),
        ((0.0, 0.0, sqrt(0.5), sqrt(0.5)), [0.0, 0.0, 90.0]),
        ((0.0, 0.0, -sqrt(0.5), -sqrt(0.5)), [0.0, 0.0, 90.0]),
        ((0.0, 0.0, -1.0, 1e-17), [0.0, 0.0, 180.0]),
        ((0.0, 0.0, 1.0, -1e-17), [0.0, 0.0, 180.0]),
    ],
)
def test_the_same_turn_is_written_the_same_way(orientation: Quaternion, turn: list[float]) -> None:
    turned = replace(track("L1.1", 1), placed=Pose((0.0, 0.0, 0.004), orientation))
    placing = taken(tower(turned)).placings[0].placed["L1.1"]
    assert list(placing.turn_deg) == turn


# --- hits -------------------------------------------------------------------------------------------------------------


def struck(name: str, level: int, shift: float, sunk: float = 0.0, state: BrickState = BrickState.FROZEN) -> BrickTrack:
    """A plank of a tower that was hit, which shifted and sank by so much [m]."""
    return replace(track(name, level, state, shift), sunk=sunk)


def hit_tower(*changed: BrickTrack, collapse: Collapse | None = None) -> Trace:
    """A missile comes at 3 s; what is not among `changed` it did not move."""
    missile = replace(track("shot", 0, BrickState.THROWN), shift=0.0)
    still = [struck(name, level, 0.0) for level, name in enumerate(("L1.1", "L2.1", "L3.1"), start=1)]
    trace = tower(*still, *changed, missile, collapse=collapse)
    return replace(trace, events=(*trace.events, Event(3.0, EventKind.PLACED, ("shot",))))


def test_where_nothing_was_moved_by_a_hit_all_is_locked_as_ever() -> None:
    snapshot = taken(hit_tower())
    assert states(snapshot) == {"shot": "thrown", "L1.1": "frozen", "L2.1": "frozen", "L3.1": "frozen"}
    assert snapshot.bricks["L2.1"].at_mm == (0.0, 0.0, 12.0)
    assert snapshot.bricks["L2.1"].rests_on == {"L1.1": 1.0}
    assert (snapshot.bricks["shot"].at_mm, snapshot.bricks["shot"].rests_on) == (None, None)
    assert (snapshot.height_mm, snapshot.levels_standing) == (24.0, 3)


@pytest.mark.parametrize(
    ("shift", "sunk", "state", "expected"),
    [
        (0.25, 0.0, BrickState.FROZEN, "frozen"),
        (0.5, 0.0, BrickState.FROZEN, UNCLEAR),  # half of the threshold: another engine may shift it beyond
        (1.5, 0.0, BrickState.DISPLACED, UNCLEAR),
        (3.5, 0.0, BrickState.DISPLACED, "displaced"),
        (3.5, 0.5, BrickState.DISPLACED, UNCLEAR),  # it might have sunk
        (9.0, 1.5, BrickState.FALLEN, UNCLEAR),
        (9.0, 3.5, BrickState.FALLEN, "fallen"),
    ],
)
def test_what_a_hit_did_to_a_brick_is_locked_where_it_is_clear_cut(
    shift: float, sunk: float, state: BrickState, expected: str
) -> None:
    moved = struck("L3.1", 3, shift * THRESHOLD, sunk * THRESHOLD, state)
    snapshot = taken(hit_tower(moved))
    assert snapshot.bricks["L3.1"].state == expected
    assert snapshot.bricks["L3.1"].at_mm in (None, (UNCLEAR, UNCLEAR, UNCLEAR))
    assert snapshot.bricks["L2.1"].at_mm == (0.0, 0.0, 12.0)
    assert {brick.rests_on for brick in snapshot.bricks.values()} == {None}


def test_a_hit_after_a_collapse_changes_nothing_of_what_was_told_before_it() -> None:
    fallen = track("L3.1", 3, BrickState.FALLEN, 5.0 * THRESHOLD)
    margins = [event.margin_mm for event in taken(hit_tower(fallen, collapse=FALL)).placings]
    assert margins == [12.0, 12.0, None, None]  # neither of what brought it down nor of what came later


def test_a_push_is_locked_with_its_time() -> None:
    trace = tower()
    pushed = taken(replace(trace, events=(*trace.events, Event(3.0, EventKind.PUSHED, ("L3.1",)))))
    assert pushed.events[-1] == Pushing(3.0, ("L3.1",))
    assert compare(document(pushed), pushed) == ()
    later = replace(pushed, events=(*pushed.events[:-1], Pushing(3.5, ("L3.1",))))
    assert [found.quantity for found in compare(document(pushed), later)] == ["pushed at"]
    twice = replace(pushed, events=(*pushed.events, Pushing(4.0, ("L3.1",))))
    assert [found.expected for found in compare(document(pushed), twice)] == ["none"]


def test_after_a_collapse_it_is_no_matter_whether_what_stands_was_proven_by_the_end() -> None:
    fell = {"collapse": {"level": 2}, "bricks": {"a": {"state": "frozen"}}}
    alike = {"collapse": {"level": 2}, "bricks": {"a": {"state": "standing"}}}
    other = {"collapse": {"level": 2}, "bricks": {"a": {"state": "fallen"}}}
    assert compare_documents(fell, alike) == ()
    assert [found.quantity for found in compare_documents(fell, other)] == ["state"]
    stood = [{"bricks": {"a": {"state": state}}} for state in ("frozen", "standing")]
    assert [found.quantity for found in compare_documents(*stood)] == ["state"]
