"""Bricks far away do not change any digit of the motion of others."""

from functools import cache

import pytest

from stability.model import AT_REST
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Action, Placement, PushAction
from stackdsl.trace import Trace
from tests.scenes import timeline_of
from tests.stackdsl.simulation.let_go import CUBE, FLAT, SHEET, TIPPING, let_go, over

# What is alone is played once for all that it is held against, which so stay in one process.
pytestmark = pytest.mark.xdist_group("far away")

FIN_AND_PLANK = """
- bricks:
    - {name: fin, brick: {size: [60 mm, 3.43 mm, 40 mm], density: 700 kg/m3}, at: [0 mm, 0 mm, 20 mm]}
    - {name: plank, at: [0 mm, 4 mm, 43.9 mm]}
"""
# A sheet by far thinner than all else, a plank like the one that falls, a tower of a hundred of them.
FAR_AWAY = {
    "sheet": """
- bricks:
    - {name: sheet, brick: {size: [50 mm, 50 mm, 0.0128 mm], density: 700 kg/m3}, at: [0 mm, -150 mm, 0.0064 mm]}
""",
    "plank": "- bricks: [{name: other, at: [0 mm, 700 mm, 3.9 mm]}]",
    "tower": "- four_stack: {levels: 50, origin: [1 m, 0 mm, 0 mm]}",
    "block": """
- bricks:
    - {name: block, at: [20 m, 0 mm, 500 mm], brick: {size: [1 m, 1 m, 1 m], density: 500 kg/m3}}
""",
}


@cache
def played(build: str, rest: str = "") -> Trace:
    return play(timeline_of(build, rest), SYSTEMS["exact"])


@pytest.mark.parametrize(("far", "before"), [*((far, True) for far in FAR_AWAY), ("sheet", False)])
def test_a_plank_that_tips_over_a_fin_falls_alike_whatever_stands_elsewhere(far: str, before: bool) -> None:
    steps = [FAR_AWAY[far], FIN_AND_PLANK] if before else [FIN_AND_PLANK, FAR_AWAY[far]]
    alone = played(FIN_AND_PLANK)
    beside = played("\n".join(steps))
    for name in ("fin", "plank"):
        assert repr(beside.tracks[name].final) == repr(alone.tracks[name].final)
    assert beside.cost.steps == alone.cost.steps > 0
    assert alone.collapse is not None
    assert beside.collapse is not None
    assert beside.collapse.time == alone.collapse.time


@pytest.mark.parametrize("far", FAR_AWAY)
def test_a_gentle_push_moves_a_plank_alike_whatever_stands_elsewhere(far: str) -> None:
    #   v^2 / (2 mu g) = 1 mm at 0.1 m/s
    rest = "impacts: [{after: built + 1 s, push: {brick: L3.1, impulse: [0 N*s, 1.2 mN*s, 0 N*s]}}]"
    column = "- column: {levels: 3, origin: [0 mm, 300 mm, 0 mm]}"
    alone, beside = (played(build, rest) for build in (column, column + "\n" + FAR_AWAY[far]))
    assert 0.9e-3 < alone.tracks["L3.1"].shift < 1.1e-3
    assert repr(beside.tracks["L3.1"].final) == repr(alone.tracks["L3.1"].final)


POST = """
- bricks:
    - {name: post, at: [0 mm, 0 mm, 50 mm], brick: {size: [20 mm, 20 mm, 100 mm], density: 500 kg/m3}}
    - {name: plank, at: [0 mm, 0 mm, 103.9 mm]}
"""
BLOCK = "- bricks: [{name: block, at: [5 m, 0 mm, 500 mm], brick: {size: [1 m, 1 m, 1 m], density: 500 kg/m3}}]"
SHOT = "{size: [8 mm, 20 mm, 7 mm], density: 8000 kg/m3}"


@pytest.mark.parametrize(
    "build",
    [
        pytest.param(POST, id="alone", marks=pytest.mark.slow),
        pytest.param(POST + BLOCK, id="with a block five metres away", marks=pytest.mark.slow),
    ],
)
def test_a_fast_hit_moves_what_it_hits_whatever_stands_elsewhere(build: str) -> None:
    #   9 g at 15 m/s give a plank of 12 g at least 6.4 m/s.
    throw = f"{{at: plank, from: {{bearing: 90 deg, distance: 100 mm}}, speed: 15 m/s, name: shot, brick: {SHOT}}}"
    trace = played(build, f"impacts: [{{at: 1 s, throw: {throw}}}]")
    assert trace.tracks["plank"].shift > 0.5
    assert trace.collapse is not None


@pytest.mark.slow
def test_how_thin_a_brick_is_that_is_set_down_elsewhere_changes_no_digit_of_what_moves_meanwhile() -> None:
    build = "- column: {levels: 8, step: 5 mm}\n- column: {levels: 5, origin: [0 m, 1 m, 0 mm]}\n  name: far"
    push = "{at: 1 s, push: {brick: L3.1, impulse: [60 mN*s, 0 N*s, 0 N*s], point: [0 mm, 8 mm, 0 mm]}}"
    insert = "{{name: late, at: [0 m, 1 m, {at} mm], brick: {{size: [50 mm, 20 mm, {side} mm], density: 500 kg/m3}}}}"
    sheet, plate = (
        played(build, f"impacts: [{push}, {{at: 1.05 s, insert: {late}}}]")
        for late in (insert.format(at=39.1, side=0.2), insert.format(at=41.5, side=5))
    )
    assert sheet.cost.steps > 0
    for name in sheet.tracks.keys() - {"late"}:
        assert repr(sheet.tracks[name].final) == repr(plate.tracks[name].final)


@pytest.mark.slow
def test_how_many_bricks_lie_elsewhere_changes_no_digit_of_what_gives_way() -> None:
    #   Two that stand and two that fall on them: with a third that stands, as many are not frozen as move.
    debris = """
- bricks:
    - {name: b0, at: [25.105 mm, 9.016 mm, 4.3325 mm],
       brick: {size: [50.43 mm, 12.664 mm, 8.665 mm], density: 945 kg/m3}}
    - {name: b1, at: [29.589 mm, 11.525 mm, 17.6915 mm],
       brick: {size: [9.57 mm, 9.031 mm, 18.053 mm], density: 863 kg/m3}}
    - {name: b2, at: [24.618 mm, -23.935 mm, 29.5705 mm], rotate: [0 deg, 0 deg, 111.722 deg],
       brick: {size: [67.208 mm, 12.875 mm, 41.811 mm], density: 7383 kg/m3}}
    - {name: b3, at: [14.394 mm, -22.001 mm, 55.925 mm],
       brick: {size: [11.171 mm, 43.157 mm, 10.898 mm], density: 2788 kg/m3}}
"""
    far = "    - {name: other, at: [25 m, 7 m, 3.9 mm]}\n"
    alone, beside = (played(build, "friction: 1.2") for build in (debris, debris + far))
    assert alone.collapse is not None
    for name in ("b0", "b1", "b2", "b3"):
        assert repr(beside.tracks[name].final) == repr(alone.tracks[name].final)


# The tenth plank comes at 9 s, and all above the first begin to turn over its edge.
TOWER = "- column: {levels: 10, step: 12 mm}\n  every: 1 s"
OTHERS = "- column: {levels: 2, origin: [10 m, 10 m, 0 mm]}\n  name: far\n" + TOWER
ASKED = "expect: [{pivots: {about: L1.1, within: 2 deg, proportions: 2 %}}]"
DONE_FAR_AWAY = {
    "placed": (TOWER, "{at: 9.05 s, insert: {name: late, at: [10 m, 10 m, 3.9 mm]}}"),
    "pulled out": (OTHERS, "{at: 9.05 s, remove: {brick: far.L2.1}}"),
    "pushed gently": (OTHERS, "{at: 9.05 s, push: {brick: far.L2.1, impulse: [0.05 mN*s, 0 N*s, 0 N*s]}}"),
}


@pytest.mark.parametrize(
    "done",
    [
        pytest.param("placed", marks=pytest.mark.slow),
        "pulled out",
        pytest.param("pushed gently", marks=pytest.mark.slow),
    ],
)
def test_a_tower_topples_alike_whatever_is_done_elsewhere_meanwhile(done: str) -> None:
    build, impact = DONE_FAR_AWAY[done]
    alone = played(TOWER, ASKED)
    beside = played(build, f"impacts: [{impact}]\n{ASKED}")
    assert alone.onset is not None
    assert beside.onset == alone.onset


@pytest.mark.slow
def test_when_something_is_frozen_elsewhere_is_not_when_a_fall_is_seen() -> None:
    #   Looks are a hundredth of a second apart. The clock is a sum of what passes between them.
    late = "{{at: {at} s, insert: {{name: late, at: [10 m, 10 m, 3.9 mm]}}}}"
    build = "- column: {levels: 8, step: 20 mm}"
    alone = played(build)
    fell = {name: track.left_at for name, track in alone.tracks.items()}
    first = min(left for left in fell.values() if left is not None)
    for before in (0.003, 0.002, 0.001):
        beside = played(build, f"impacts: [{late.format(at=first - before)}]")
        assert {name: beside.tracks[name].left_at for name in fell} == pytest.approx(fell)


@pytest.mark.slow
def test_what_is_done_within_reach_of_what_topples_parts_it() -> None:
    near = "impacts: [{at: 9.05 s, insert: {name: late, at: [0 mm, 100 mm, 3.9 mm]}}]"
    alone, beside = (played(TOWER, f"{rest}\n{ASKED}") for rest in ("", near))
    assert beside.cost.steps > alone.cost.steps


def test_a_far_block_does_not_change_when_a_tower_comes_down() -> None:
    #   A block of 5 km asks for steps a hundred times as long, but nothing of it moves.
    tower = "- column: {levels: 10, step: 12 mm}\n  every: 0.03 s"
    block = (
        "- at: 0 s\n  bricks: [{name: far, at: [9 km, 0 m, 2.5 km],"
        " brick: {size: [5 km, 5 km, 5 km], density: 500 kg/m3}}]"
    )
    alone, beside = (played(build) for build in (tower, f"{tower}\n{block}"))
    assert alone.collapse is not None
    assert beside.collapse == alone.collapse
    times = [event.time for event in beside.events]
    assert times == sorted(times)


# --- what moves there -------------------------------------------------------------------------------------------------


def planks(count: int, at: float = 10.0, speed: float = 0.0) -> list[Placement]:
    """They fall, or are thrown away; their names come before and after those of others."""
    velocity_W = (speed, 0.0, 2.0) if speed else AT_REST
    names = [f"{'0' if n % 2 else 'z'}{n}" for n in range(count)]
    return [
        let_go(name, (at, 0.14 * (n % 4), 0.08 + 0.15 * (n // 4)), velocity_W=velocity_W)
        for n, name in enumerate(names)
    ]


FALLS_FAR_AWAY = {
    "eight planks": planks(8),
    "two planks, thrown": planks(2, speed=6.0),
    "two thin sheets": [let_go(name, (10.0, y, 0.03), SHEET) for name, y in (("0", 0.0), ("z", 0.1))],
    "ten kilometres away": planks(2, at=1e4),
}
FALLS_HERE = {
    "askew": [let_go("plank", (0.0, 0.0, 0.09))],
    "flat": [let_go("plank", (0.0, 0.0, 0.05), turned=FLAT)],
    "thrown": [let_go("plank", (0.0, 0.0, 0.09), velocity_W=(0.8, -0.5, 0.3))],
    "over an edge": [
        let_go("post", (0.0, 0.0, 0.0501), CUBE, FLAT),
        let_go("plank", (0.06, 0.0, 0.1041), turned=TIPPING),
    ],
}


@cache
def fallen_alone(here: str) -> Trace:
    return play(over(FALLS_HERE[here]), SYSTEMS["exact"])


def assert_same(beside: Trace, alone: Trace) -> None:
    for name, track in alone.tracks.items():
        assert repr(beside.tracks[name].final) == repr(track.final)
        assert beside.tracks[name].state is track.state


@pytest.mark.parametrize("far", FALLS_FAR_AWAY)
def test_a_plank_falls_alike_to_the_last_bit_whatever_falls_far_away(far: str) -> None:
    assert_same(play(over(FALLS_HERE["askew"] + FALLS_FAR_AWAY[far]), SYSTEMS["exact"]), fallen_alone("askew"))


@pytest.mark.parametrize("here", FALLS_HERE)
def test_however_a_plank_falls_it_falls_alike_beside_others_that_fall_far_away(here: str) -> None:
    assert_same(play(over(planks(2) + FALLS_HERE[here]), SYSTEMS["exact"]), fallen_alone(here))


def test_what_has_come_to_rest_is_moved_again_alike_while_others_fall_far_away() -> None:
    again: list[Action] = [
        PushAction(0.45, "plank", (0.006, 0.004, 0.0), (0.03, 0.0, 0.0)),
        let_go("second", (0.0, 0.0, 0.09), velocity_W=(0.8, 0.0, 0.0), time=0.7),  # and pushed as it comes
        PushAction(0.7, "second", (0.006, 0.0, 0.0)),
    ]
    far: list[Action] = [
        let_go("late", (10.5, 0.0, 0.05), time=0.42),
        let_go("later", (10.5, 0.0, 0.3), time=0.44),
        PushAction(0.7, "late", (0.006, 0.0, 0.0)),
    ]
    alone, beside = (
        play(over([*FALLS_HERE["askew"], *again, *others]), SYSTEMS["exact"]) for others in ([], planks(1) + far)
    )
    assert alone.tracks["second"].frozen
    assert alone.cost.steps > fallen_alone("askew").cost.steps
    assert_same(beside, alone)


def test_two_towers_topple_at_once_as_each_does_alone() -> None:
    build = "- column: {{levels: 3, step: 50 mm, origin: [{at}, 0 m, 0 m]}}\n  name: {name}\n  at: 0 s"
    here, there = build.format(at="0 m", name="here"), build.format(at="20 m", name="there")
    one, other, both = (played(text) for text in (here, there, f"{here}\n{there}"))
    assert one.collapse is not None
    assert both.collapse is not None
    assert both.collapse.time == one.collapse.time
    assert_same(both, one)
    assert_same(both, other)
    assert both.statics is not None
    assert {"here.L2.1", "there.L2.1"} <= set(both.statics.moving)
