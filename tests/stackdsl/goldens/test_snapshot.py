"""What a snapshot locks of a run, and what it leaves open because a small disturbance changes it."""

from dataclasses import replace
from math import cos, nan, pi, radians, sin, sqrt

import pytest

from stability.model import Pose, Quaternion
from stackdsl.goldens.file_format import canonical_text, document
from stackdsl.goldens.snapshot import UNCLEAR
from stackdsl.trace import BrickState, Cost, Edge, Event, EventKind
from tests.stackdsl.goldens.towers import FALL, THRESHOLD, states, taken, tower, track


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
    snapshot = taken(tower(*standing), modelled=False)
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
    bare = taken(tower(fallen, collapse=FALL), modelled=False).collapse
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
    assert states(taken(tower(last, collapse=FALL), modelled=False))["L3.1"] == locked


@pytest.mark.parametrize(("tilt", "locked"), [(46.0, "fallen"), (44.0, UNCLEAR)])
def test_a_brick_that_turned_over_in_its_place_has_clearly_fallen(tilt: float, locked: str) -> None:
    # The threshold is 15 deg.
    last = replace(track("L3.1", 3, BrickState.FALLEN), tilt=radians(tilt))
    assert states(taken(tower(last, collapse=FALL), modelled=False))["L3.1"] == locked


def test_a_proven_state_is_locked_whatever_the_drift_as_long_as_nothing_collapsed() -> None:
    last = track("L3.1", 3, BrickState.STANDING, shift=0.9 * THRESHOLD)
    assert states(taken(tower(last)))["L3.1"] == "standing"
    assert states(taken(tower(last, collapse=FALL)))["L3.1"] == UNCLEAR


@pytest.mark.parametrize("proven", [True, False])
def test_where_fallen_bricks_landed_is_never_locked(proven: bool) -> None:
    last = track("L3.1", 3, BrickState.FALLEN, shift=1.0)
    brick = taken(tower(last, collapse=FALL), proven).bricks["L3.1"]
    assert (brick.state, brick.at_mm, brick.rests_on) == ("fallen", None, None)


@pytest.mark.parametrize(("moved", "locked"), [(0.0, {"ground": UNCLEAR, "L2.1": UNCLEAR}), (0.5, {"ground": UNCLEAR})])
def test_an_undecided_brick_with_unknown_load_is_no_support(moved: float, locked: dict[str, str]) -> None:
    wedged = track("L2.1", 2, BrickState.FROZEN, shift=moved * THRESHOLD)
    run = tower(wedged, track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL)
    edges = (Edge("L1.1", "ground", nan), Edge("L1.1", "L2.1", nan))
    assert taken(replace(run, edges=edges)).bricks["L1.1"].rests_on == locked


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
    snapshot = taken(tower(track("L3.1", level, BrickState.UNPLACED), collapse=FALL), modelled=False)
    assert states(snapshot)["L3.1"] == locked


def test_with_a_bare_engine_placings_are_locked_up_to_the_level_that_fell() -> None:
    trace = tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL)
    assert [list(event.placed) for event in taken(trace, modelled=False).placings] == [["L1.1"], ["L2.1"]]
    assert [list(event.placed) for event in taken(trace).placings] == [["L1.1"], ["L2.1"], ["L3.1"]]


def test_of_the_placing_that_brought_the_stack_down_no_model_tells() -> None:
    *before, last = taken(tower(track("L3.1", 3, BrickState.FALLEN, shift=1.0), collapse=FALL)).placings
    assert (last.time_s, last.margin_mm, last.placed["L3.1"].rests_on) == (2.0, None, None)
    assert [event.margin_mm for event in before] == [12.0, 12.0]
    assert [brick.rests_on for event in before for brick in event.placed.values()] == [{"ground": 1.0}, {"L1.1": 1.0}]


def test_the_cost_of_a_run_is_not_locked() -> None:
    dear = replace(tower(), cost=Cost(wall_time=nan, simulated_time=nan, steps=-1, judgements=-1))
    assert canonical_text(taken(dear)) == canonical_text(taken(tower()))


def test_freezing_between_placements_is_not_locked() -> None:
    trace = tower()
    busy = replace(trace, events=(*trace.events, Event(nan, EventKind.FROZEN, ("L1.1",), "settled")))
    assert taken(busy) == taken(trace)


def test_two_contacts_with_one_support_count_together() -> None:
    halves = (Edge("L2.1", "L1.1", 0.4), Edge("L2.1", "L1.1", 0.6))
    snapshot = taken(replace(tower(), edges=halves))
    assert snapshot.bricks["L2.1"].rests_on == {"L1.1": 1.0}


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


def test_supports_that_have_fallen_are_not_locked() -> None:
    # Whether debris leans on what stands hangs on a hair.
    fallen = track("L3.1", 3, BrickState.FALLEN, shift=0.05)
    bare = tower(fallen, collapse=replace(FALL, brick="L3.1"))
    leant_on = replace(bare, edges=(*bare.edges, Edge("L1.1", "L3.1", nan)))
    assert taken(leant_on) == taken(bare)
