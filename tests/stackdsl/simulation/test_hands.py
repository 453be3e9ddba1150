"""Hands against closed forms: what they carry, push, slide and hold, on every engine and under both methods."""

from math import cos, radians, sin

import pytest
from _pytest.mark import ParameterSet

from stability.dynamics.ground_motion import HandCourse
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import BrickState, EventKind, RunVerdict, Trace
from tests.engines_at_hand import PEERS
from tests.scenes import timeline_of

ENGINES = ["exact", "tuned", *PEERS]
ALL = [*ENGINES, *(pytest.param(name, marks=pytest.mark.slow) for name in ("stock", "thesis"))]


def sides(*cells: tuple[object, ...]) -> list[ParameterSet]:
    """All cells on `exact`, one of them on each other engine; the others where there is time."""
    found = []
    for place, system in enumerate((*ENGINES, "stock", "thesis")):
        for number, cell in enumerate(cells):
            quick = system == "exact" or (system in ENGINES and number == place % len(cells))
            found.append(pytest.param(system, *cell, marks=[] if quick else [pytest.mark.slow]))
    return found


CUBE = "brick: {size: [40 mm, 40 mm, 40 mm], mass: 30 g}"


def played(build: str, rest: str = "", system: str = "exact") -> Trace:
    """A run that is watched for a short time after the last hand has let go."""
    watch = "" if "watch" in rest else "watch: 0.3 s"
    return play(timeline_of(build, f"{rest}\n{watch}\nexpect: [energy: {{gain: <= 1 %}}]"), system_named(system))


def way(trace: Trace, name: str, bearing: float = 0.0) -> float:
    """How far a brick ends along a bearing [deg] from where it was placed [mm]."""
    (x, y, _), (start_x, start_y, _) = (trace.tracks[name].final.position_W, trace.tracks[name].placed.position_W)
    return 1e3 * ((x - start_x) * cos(radians(bearing)) + (y - start_y) * sin(radians(bearing)))


def row(gaps: list[float], bearing: float = 0.0, origin: tuple[float, float] = (0.0, 0.0)) -> str:
    """Cubes of 40 mm in a row, `b0` first, with gaps between them [mm]."""
    lines, along = ["- bricks:"], 0.0
    c, s = cos(radians(bearing)), sin(radians(bearing))
    for number, gap in enumerate([0.0, *gaps]):
        along += gap + 40.0 * (number > 0)
        place = f"[{origin[0] + along * c} mm, {origin[1] + along * s} mm, 20 mm]"
        lines.append(f"    - {{name: b{number}, at: {place}, rotate: [0 deg, 0 deg, {bearing} deg]}}")
    return "\n".join(lines)


def pushed_row(gaps: list[float], by: float, bearing: float = 0.0, how: str = "") -> str:
    x, y = by * cos(radians(bearing)), by * sin(radians(bearing))
    return f"{CUBE}\nimpacts: [move: {{brick: b0, by: [{x} mm, {y} mm, 0 mm]{how}}}]"


# --- what is pushed ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("system", "how"), sides(("",), (", slid: true",)))
def test_a_row_is_squeezed_gap_by_gap_and_each_brick_goes_as_far_as_the_gaps_before_it_leave(
    system: str, how: str
) -> None:
    gaps = [10.0, 5.0, 7.0]
    trace = played(row(gaps), pushed_row(gaps, 18.0, how=how), system)
    error = 0.3 if system == "stock" else 0.06
    assert [way(trace, f"b{i}") for i in range(4)] == pytest.approx([18.0, 8.0, 3.0, 0.0], abs=error)
    assert [way(trace, f"b{i}", 90.0) for i in range(4)] == pytest.approx([0.0] * 4, abs=4.0 * error)
    assert trace.verdict is RunVerdict.STANDS


@pytest.mark.parametrize("bearing", [30.0, 215.0])
def test_a_pushed_row_moves_alike_in_every_direction_and_place(bearing: float) -> None:
    gaps = [6.0]
    trace = played(row(gaps, bearing, (250.0, -130.0)), pushed_row(gaps, 20.0, bearing))
    assert [way(trace, f"b{i}", bearing) for i in range(2)] == pytest.approx([20.0, 14.0], abs=0.02)
    assert [way(trace, f"b{i}", bearing + 90.0) for i in range(2)] == pytest.approx([0.0] * 2, abs=0.02)


@pytest.mark.parametrize("travel", [0.05, 0.2])
def test_the_least_push_is_kept(travel: float) -> None:
    gaps = [0.0]
    trace = played(row(gaps), pushed_row(gaps, travel, how=", speed: 2 mm/s"))
    assert way(trace, "b1") == pytest.approx(travel, abs=0.01)


def test_bricks_that_a_hand_does_not_reach_stay_to_the_last_digit() -> None:
    gaps = [10.0, 20.0]
    trace = played(row(gaps), pushed_row(gaps, 15.0))
    assert trace.tracks["b2"].final == trace.tracks["b2"].placed
    assert trace.tracks["b2"].state is BrickState.FROZEN


@pytest.mark.parametrize("system", ENGINES)
def test_a_hand_that_pushes_a_row_against_a_wall_is_told_to_end_its_way(system: str) -> None:
    gaps, wall = [10.0], "world: {walls: [{bearing: 0 deg, distance: 75 mm}]}\n"
    with pytest.raises(BlockedPlacementError, match="the hand cannot continue to move brick 'b0'"):
        played(row(gaps), wall + pushed_row(gaps, 40.0), system)  # 10 + 5 mm is all there is


# --- what is carried --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("system", ENGINES)
def test_bricks_on_a_carried_brick_move_along_and_bricks_below_stay(system: str) -> None:
    move = "impacts: [move: {brick: L2.1, by: [30 mm, 10 mm, 0 mm]}]"
    trace = played("- column: {levels: 4}", move, system)
    assert [way(trace, f"L{i}.1") for i in range(1, 5)] == pytest.approx([0.0, 30.0, 30.0, 30.0], abs=0.03)
    assert [way(trace, f"L{i}.1", 90.0) for i in range(1, 5)] == pytest.approx([0.0, 10.0, 10.0, 10.0], abs=0.12)


def left_behind(way_m: float, speed: float, friction: float) -> float:
    """Where what lies on a carried brick ends that accelerates too much for friction: Coulomb in steps of 2 us [m]."""
    course, step = HandCourse(((way_m, 0.0, 0.0),), speed), 2e-6
    below = place = own = time = 0.0
    while time < course.duration or own != 0.0:
        after = course.at(time + step)[0]
        its, below, time = (after - below) / step, after, time + step
        most = friction * 9.81 * step
        own += min(most, max(-most, its - own))
        place += own * step
    return place


@pytest.mark.parametrize("system", ["exact", "tuned"])
@pytest.mark.parametrize("share", [pytest.param(0.9, marks=pytest.mark.slow), 4.0])
def test_a_brick_on_a_carried_one_is_left_behind_by_more_acceleration_than_friction_bears(
    system: str, share: float
) -> None:
    way_mm, friction = 30.0, 0.05
    speed = 15.0 / 8.0 * (share * friction * 9.81 * way_mm / 1e3 * 3.0**0.5 / 10.0) ** 0.5
    rest = f"friction: {friction}\nimpacts: [move: {{brick: L1.1, by: [{way_mm} mm, 0 mm, 0 mm], speed: {speed} m/s}}]"
    trace = played("- column: {levels: 2}", rest, system)
    expected = 1e3 * left_behind(way_mm / 1e3, speed, friction)
    assert way(trace, "L2.1") == pytest.approx(expected, rel=0.03)
    assert (abs(expected - way_mm) < 0.01) is (share < 1.0)


@pytest.mark.parametrize("system", ALL)
def test_a_ruler_on_two_fingers_is_left_by_the_nearer_one_only_when_both_are_equally_near(system: str) -> None:
    #   The nearer finger carries more, and so holds more. Fingers at 60 mm, held, and at 30 mm, drawn in by 50 mm: it
    #   goes with this one for 30 mm, until both are 30 mm away, and then by half of the rest.
    fingers = """- bricks:
    - {name: far, at: [-60 mm, 0 mm, 20 mm], brick: {size: [4 mm, 40 mm, 40 mm], mass: 30 g}}
    - {name: near, at: [30 mm, 0 mm, 20 mm], brick: {size: [4 mm, 40 mm, 40 mm], mass: 30 g}}
    - {name: ruler, at: [0 mm, 0 mm, 45 mm], brick: {size: [200 mm, 40 mm, 10 mm], mass: 50 g}}"""
    impacts = """impacts:
    - hold: {brick: far, for: 2.5 s}
    - {at: 0 s, move: {brick: near, by: [-50 mm, 0 mm, 0 mm], held: 0.5 s}}
watch: 0.01 s"""
    trace = played(fingers, impacts, system)
    assert way(trace, "ruler") == pytest.approx(-40.0, abs=2.0)  # each finger is 4 mm wide


# --- what is slid -----------------------------------------------------------------------------------------------------

EDGE = """- bricks:
    - {name: table, at: [0 mm, 0 mm, 20 mm], brick: {size: [100 mm, 40 mm, 40 mm], mass: 500 g}}
    - {name: plank, at: [0 mm, 0 mm, 45 mm], brick: {size: [100 mm, 40 mm, 10 mm], mass: 30 g}}"""


@pytest.mark.parametrize(("system", "over", "falls"), sides((49.0, False), (51.0, True)))
def test_a_plank_that_is_carried_over_an_edge_tips_when_let_go_beyond_half_its_length(
    system: str, over: float, falls: bool
) -> None:
    trace = played(EDGE, f"impacts: [move: {{brick: plank, by: [{over} mm, 0 mm, 0 mm]}}]", system)
    assert (trace.tracks["plank"].state is BrickState.FALLEN) is falls
    if falls:
        assert trace.collapse is not None
        (let_go,) = (event.time for event in trace.events if event.kind is EventKind.LET_GO)
        assert trace.collapse.time > let_go


@pytest.mark.parametrize(("system", "over", "falls"), sides((46.0, False), (52.0, True)))
def test_a_slid_plank_tips_over_an_edge_sooner_by_half_its_thickness_times_friction(
    system: str, over: float, falls: bool
) -> None:
    #   Pushed at its centre against friction at its bottom it presses 2.5 mm ahead of its centre.
    trace = played(EDGE, f"impacts: [move: {{brick: plank, by: [{over} mm, 0 mm, 0 mm], slid: true}}]", system)
    assert (trace.tracks["plank"].state is BrickState.FALLEN) is falls


@pytest.mark.parametrize(("system", "ground", "goes"), sides((0.3, True), (0.5, False)))
def test_a_plank_under_a_slid_one_follows_if_ground_friction_is_less(system: str, ground: float, goes: bool) -> None:
    #   On top of the lowest 4 planks rub with 0.5 * 4 m g, below it 5 with those of the ground.
    rest = f"""world: {{ground: {{friction: {ground}}}}}
impacts: [move: {{brick: L2.1, by: [30 mm, 0 mm, 0 mm], slid: true}}]"""
    trace = played("- column: {levels: 5}", rest, system)
    assert way(trace, "L2.1") == pytest.approx(30.0, abs=0.1)
    assert way(trace, "L1.1") == pytest.approx(30.0 if goes else 0.0, abs=0.6)


# --- what is held -----------------------------------------------------------------------------------------------------


def overhanging(counterweight: bool) -> str:
    """A plank whose centre is 10 mm beyond the edge, held for 3 s; with 30 g at 80 mm on the other side, or without."""
    weight = (
        "- bricks: [{name: w, at: [-30 mm, 0 mm, 55 mm], brick: {size: [20 mm, 40 mm, 10 mm], mass: 30 g}}]\n  at: 2 s"
    )
    return f"""- bricks:
    - {{name: table, at: [0 mm, 0 mm, 20 mm], brick: {{size: [100 mm, 40 mm, 40 mm], mass: 500 g}}}}
- bricks: [{{name: plank, at: [60 mm, 0 mm, 45 mm], brick: {{size: [200 mm, 40 mm, 10 mm], mass: 30 g}}}}]
  place: {{held: 3 s}}
{weight if counterweight else ""}"""


@pytest.mark.parametrize(("system", "counterweight"), sides((True,), (False,)))
def test_a_held_plank_stands_and_stays_if_it_is_balanced_when_let_go(system: str, counterweight: bool) -> None:
    trace = played(overhanging(counterweight), system=system)
    assert (trace.verdict is RunVerdict.STANDS) is counterweight
    if not counterweight:
        assert trace.collapse is not None
        assert 3.75 < trace.collapse.time < 4.0  # 20 mm at 50 mm/s take 0.75 s


def test_while_it_is_held_all_is_proven_without_an_engine() -> None:
    trace = played(overhanging(counterweight=True))
    assert trace.cost.steps == 0
    assert trace.tracks["plank"].state is BrickState.FROZEN


@pytest.mark.parametrize("system", ALL)
def test_a_held_brick_carries_what_lies_on_it_when_its_own_support_is_gone(system: str) -> None:
    rest = "impacts: [hold: {brick: L2.1, for: 2 s}, {at: 1 s, remove: {brick: L1.1}}]"
    trace = played("- column: {levels: 3}", rest, system)
    assert trace.collapse is not None
    assert 2.0 < trace.collapse.time < 2.1
    for name in ("L2.1", "L3.1"):
        assert trace.tracks[name].final.position_W[2] - trace.tracks[name].placed.position_W[2] == pytest.approx(
            -7.8e-3, abs=1e-4
        )


# --- what is brought --------------------------------------------------------------------------------------------------


def test_a_column_built_by_hand_collapses_at_the_level_of_the_closed_form() -> None:
    #   N d > L from the fourth on, 30 mm each
    trace = played("- column: {levels: 6, step: 30 mm}\n  place: by hand")
    assert trace.collapse is not None
    assert trace.collapse.level == 4


def test_bricks_that_are_brought_together_are_judged_together() -> None:
    leaning = """- bricks:
    - {at: [-12 mm, 0 mm, 30 mm], rotate: [0 deg, 0 deg, 0 deg], brick: {size: [20 mm, 40 mm, 60 mm], mass: 30 g}}
    - {at: [12 mm, 0 mm, 30 mm], brick: {size: [20 mm, 40 mm, 60 mm], mass: 30 g}}
    - {at: [0 mm, 0 mm, 65 mm], brick: {size: [60 mm, 40 mm, 10 mm], mass: 20 g}}
  place: {from: [0 mm, 0 mm, 100 mm], speed: 200 mm/s}"""
    trace = played(leaning)
    assert trace.verdict is RunVerdict.STANDS
    assert trace.cost.steps == 0


@pytest.mark.parametrize("system", ALL)
def test_a_brick_that_is_lifted_carried_and_put_down_stands_where_it_was_put(system: str) -> None:
    path = "[[0 mm, 0 mm, 30 mm], [0 mm, 100 mm, 30 mm], [0 mm, 100 mm, -15.6 mm]]"
    move = f"impacts: [move: {{brick: L3.1, speed: 200 mm/s, path: {path}}}]"
    trace = played("- column: {levels: 3}", move, system)
    assert trace.verdict is RunVerdict.STANDS
    final = trace.tracks["L3.1"].final.position_W
    assert final == pytest.approx((0.0, 0.1, 3.9e-3), abs=2e-4)
    assert trace.tracks["L3.1"].shift < 2e-4  # since it was let go


def test_a_brick_that_is_let_go_in_the_air_falls_from_there() -> None:
    trace = played("- column: {levels: 2}", "impacts: [move: {brick: L2.1, by: [0 mm, 0 mm, 50 mm]}]")
    (let_go,) = (event.time for event in trace.events if event.kind is EventKind.LET_GO)
    assert trace.collapse is not None
    assert trace.collapse.time - let_go == pytest.approx((2.0 * 3.9e-3 / 9.81) ** 0.5, abs=0.012)


def test_work_of_hands_is_no_energy_gain() -> None:
    trace = played("- column: {levels: 4}", "impacts: [move: {brick: L2.1, by: [20 mm, 0 mm, 40 mm], held: 1 s}]")
    assert trace.energy is not None
    assert trace.energy.gain < 0.01


def test_a_timeline_without_hands_is_the_same_for_statics() -> None:
    timeline = timeline_of("- column: {levels: 3}")
    assert timeline.as_set_down() is timeline
