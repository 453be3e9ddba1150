"""Bricks pulled out of a standing stack and slid into one, played: what falls, what stands, and with what proof."""

import pytest

from stability.problem import Stability
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import BrickState, EventKind, Trace
from tests.scenes import timeline_of

ON_ALL = pytest.mark.parametrize("system", ["exact", "thesis", "tuned", "stock"])
TURNED = "rotate: [0 deg, 0 deg, 90 deg]"


def played(build: str, impacts: str, system: str, rest: str = "") -> Trace:
    return play(timeline_of(build, f"{rest}\nimpacts: [{impacts}]"), SYSTEMS[system])


def states(trace: Trace) -> dict[str, str]:
    return {name: track.state.value for name, track in trace.tracks.items()}


@ON_ALL
def test_the_topmost_plank_of_a_column_is_pulled_out_and_the_rest_stands(system: str) -> None:
    trace = played("- column: {levels: 3}", "{after: built + 1 s, remove: {brick: L3.1}}", system)
    assert trace.verdict == "stands"
    assert trace.tracks["L3.1"].state is BrickState.REMOVED
    assert [event.kind for event in trace.events if event.bricks == ("L3.1",)][-1] is EventKind.REMOVED
    assert {edge.upper for edge in trace.edges} == {"L1.1", "L2.1"}
    assert trace.last_action == 1.0


@ON_ALL
def test_bricks_on_a_removed_plank_fall_by_its_thickness(system: str) -> None:
    trace = played("- column: {levels: 3}", "{after: built + 1 s, remove: {brick: L2.1}}", system)
    assert trace.collapse is not None
    assert (trace.collapse.brick, trace.collapse.level) == ("L3.1", 3)
    #   half of its smallest side of 7.8 mm takes a free fall of 28 ms, and looks are 10 ms apart
    assert 1.028 <= trace.collapse.time < 1.06
    assert trace.tracks["L3.1"].final.position_W[2] == pytest.approx(1.5 * 0.0078, abs=3e-4)


#     |w|          alone, the beam's centre is 11.2 mm beyond the edge; with the weight it is 8.9 mm within
#     |--beam--|   (70 mm and 29.8 mm are centres, 58.8 mm is the edge)
# |--base--|
OVERHANG = f"""
- bricks:
    - {{name: base, at: [0 mm, 0 mm, 20 mm], brick: {{size: [117.6 mm, 23.4 mm, 40 mm], density: 557 kg/m3}}}}
    - {{name: beam, at: [70 mm, 0 mm, 43.9 mm]}}
    - {{name: weight, at: [29.8 mm, 0 mm, 51.7 mm], {TURNED}}}
"""


def test_a_whole_structure_tells_where_it_broke_and_one_under_construction_at_which_level_that_was() -> None:
    whole = played(OVERHANG, "{after: built + 1 s, remove: {brick: weight}}", "exact").collapse
    assert whole is not None
    assert (whole.level, whole.broke, whole.gave_way) == (3, 2, "beam")
    growing = played("- column: {levels: 10, step: 12 mm}\n  every: 1 s", "", "exact").collapse
    assert growing is not None
    assert (growing.level, growing.broke, growing.gave_way) == (10, None, "L2.1")


def test_exact_wakes_what_the_counterweight_held_and_keeps_the_proof_of_the_rest() -> None:
    trace = played(OVERHANG, "{after: built + 1 s, remove: {brick: weight}}", "exact")
    assert states(trace) == {"base": "frozen", "beam": "fallen", "weight": "removed"}
    assert trace.statics is not None
    assert (trace.statics.stability, trace.statics.moving) == (Stability.UNSTABLE, ("beam",))
    assert trace.collapse is not None
    assert trace.collapse.gave_way == "beam"
    woken = next(event for event in trace.events if event.kind is EventKind.WOKEN)
    assert (woken.time, woken.bricks) == (1.0, ("beam",))
    assert "over base" in woken.reason


def test_exact_opens_no_engine_to_pull_out_what_nothing_needs() -> None:
    impacts = "{remove: {bricks: [L4.1, L4.2]}}, {remove: {brick: L3.2}}"
    trace = played("- four_stack: {levels: 4}", impacts, "exact")
    assert (trace.verdict, trace.cost.steps) == ("stands", 0)
    assert trace.statics is not None
    assert trace.statics.stability is Stability.STABLE


def test_a_falling_brick_that_is_removed_is_no_collapse() -> None:
    #   It is still falling when it is taken away.
    build = "- column: {levels: 1}\n- bricks: [{name: drop, at: [0 mm, 0 mm, 500 mm], drop: true}]"
    for system in SYSTEMS:
        trace = played(build, "{at: 0.2 s, remove: {brick: drop}}", system)
        assert trace.verdict == "stands"
        assert trace.tracks["drop"].state is BrickState.REMOVED


#       |load|       the load comes 48 mm out: the centre of beam and load is 24 mm out
# |---beam----|
#  |s|  |s|  |filler| the right one of the two supports ends at 11.7 mm, the filler at 51.7 mm
# |---base----|
GAP = f"""
- bricks:
    - {{name: base, at: [0 mm, 0 mm, 3.9 mm]}}
    - {{name: left, at: [-40 mm, 0 mm, 11.7 mm], {TURNED}}}
    - {{name: middle, at: [0 mm, 0 mm, 11.7 mm], {TURNED}}}
    - {{name: beam, at: [0 mm, 0 mm, 19.5 mm]}}
"""
FILLER = f"{{after: built + 1 s, insert: {{name: filler, at: [40 mm, 0 mm, 11.7 mm], {TURNED}}}}}"
LOAD = f"{{after: built + 2 s, insert: {{name: load, at: [47 mm, 0 mm, 27.3 mm], {TURNED}}}}}"


@ON_ALL
def test_a_load_beyond_the_supports_tips_the_beam(system: str) -> None:
    trace = played(GAP, LOAD, system)
    #   The base catches the beam after 10 deg, but by then the load is down by more than half its thickness.
    assert trace.collapse is not None
    assert trace.collapse.brick == "load"
    assert trace.tracks["beam"].tilt > 0.1


@pytest.mark.parametrize("system", ["exact", "thesis", "tuned"])
def test_a_plank_slid_into_the_gap_carries_the_load(system: str) -> None:
    trace = played(GAP, f"{FILLER}, {LOAD}", system)
    assert trace.verdict == "stands"
    assert trace.drift < 0.0005
    assert ("beam", "filler") in {(edge.upper, edge.lower) for edge in trace.edges}


def test_exact_proves_at_once_what_is_slid_in_and_what_it_carries_later() -> None:
    trace = played(GAP, f"{FILLER}, {LOAD}", "exact")
    assert trace.cost.steps == 0
    assert set(states(trace).values()) == {"frozen"}


def test_under_thesis_what_lies_above_gains_a_support_only_when_it_has_been_woken() -> None:
    woken = [event.bricks for event in played(GAP, f"{FILLER}, {LOAD}", "thesis").events if event.kind == "woken"]
    # Beam and load have their centre 23.5 mm out. By merge case 2 each of the three supports is given a third of both,
    # at that place: `left` carries 5/3 of a plank, 14.6 mm left of the middle, but its contact ends 28.3 mm left.
    assert woken == [("beam", "load"), ("beam", "left", "load")]
    alone = played(GAP, FILLER, "thesis")
    assert ("beam", "filler") not in {(edge.upper, edge.lower) for edge in alone.edges}


def test_the_level_under_construction_is_not_that_of_a_brick_slid_in_below() -> None:
    impacts = "{insert: {at: [0 mm, 50 mm, 3.9 mm]}}, {after: impact 1 + 1 s, remove: {brick: L2.1}}"
    trace = played("- column: {levels: 3}", impacts, "exact")
    assert trace.collapse is not None
    assert trace.collapse.level == 3


@pytest.mark.parametrize("system", ["exact", "thesis"])
def test_initial_supports_of_a_plank_are_kept_after_a_removal(system: str) -> None:
    trace = played(GAP, "{after: built + 1 s, remove: {brick: left}}", system)
    assert trace.verdict == "stands"
    assert {edge.lower for edge in trace.edges_when_placed["beam"]} == {"left", "middle"}
    assert {edge.lower for edge in trace.edges if edge.upper == "beam"} == {"middle"}


def test_after_a_collapse_bricks_are_still_pulled_out_but_none_is_slid_in() -> None:
    late = "{at: 9 s, remove: {brick: L1.1}}, {at: 10 s, insert: {name: late, at: [300 mm, 0 mm, 3.9 mm]}}"
    trace = played("- column: {levels: 3}", f"{{at: 1 s, remove: {{brick: L2.1}}}}, {late}", "exact")
    assert trace.collapse is not None
    assert (trace.tracks["L1.1"].state, trace.tracks["late"].state) == (BrickState.REMOVED, BrickState.UNPLACED)
    assert trace.last_action == 9.0
    assert trace.cost.simulated_time == pytest.approx(11.0)  # two seconds after the last action, as ever


@pytest.mark.parametrize(("placed", "time"), [("drop: true", 0.4), ("drop: false", 0.045)])
def test_nothing_is_slid_into_what_has_moved_there_by_then(placed: str, time: float) -> None:
    #   Of two planks end to end, one slides down the slope to where the other was; at 2.5 m/s2, in 45 ms by 2.6 mm, not
    #   far enough to count as a collapse.
    build = f"""
    - bricks: [{{name: upper, at: [0 mm, 0 mm, 3.9 mm], {placed}}}, {{name: lower, at: [117.6 mm, 0 mm, 3.9 mm]}}]
    """
    impacts = f"{{at: 0 s, remove: {{brick: lower}}}}, {{at: {time} s, insert: {{at: [117.6 mm, 0 mm, 3.9 mm]}}}}"
    with pytest.raises(BlockedPlacementError, match="'upper' has moved into its place"):
        played(build, impacts, "tuned", "world: {tilt: 40 deg}")


def test_a_brick_may_be_placed_where_a_dropped_one_was_pulled_out() -> None:
    build = """
    - bricks: [{name: first, at: [0 mm, 0 mm, 20 mm], drop: true}]
    - bricks: [{name: second, at: [0 mm, 0 mm, 3.9 mm]}]
      at: 2 s
    """
    trace = played(build, "{at: 1 s, remove: {brick: first}}", "exact")
    assert states(trace) == {"first": "removed", "second": "frozen"}
