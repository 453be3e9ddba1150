"""What is far away and touches nothing changes no digit of what moves."""

import pytest

from stackdsl.playing.runner import play
from stackdsl.systems.systems import SYSTEMS
from tests.scenes import timeline_of

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


@pytest.mark.parametrize("far", FAR_AWAY)
@pytest.mark.parametrize("before", [True, False], ids=["before", "after"])
def test_a_plank_that_tips_over_a_fin_falls_alike_whatever_stands_elsewhere(far: str, before: bool) -> None:
    steps = [FAR_AWAY[far], FIN_AND_PLANK] if before else [FIN_AND_PLANK, FAR_AWAY[far]]
    alone = play(timeline_of(FIN_AND_PLANK), SYSTEMS["exact"])
    beside = play(timeline_of("\n".join(steps)), SYSTEMS["exact"])
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
    alone, beside = (
        play(timeline_of(build, rest), SYSTEMS["exact"]) for build in (column, column + "\n" + FAR_AWAY[far])
    )
    assert 0.9e-3 < alone.tracks["L3.1"].shift < 1.1e-3
    assert repr(beside.tracks["L3.1"].final) == repr(alone.tracks["L3.1"].final)


POST = """
- bricks:
    - {name: post, at: [0 mm, 0 mm, 50 mm], brick: {size: [20 mm, 20 mm, 100 mm], density: 500 kg/m3}}
    - {name: plank, at: [0 mm, 0 mm, 103.9 mm]}
"""
BLOCK = "- bricks: [{name: block, at: [5 m, 0 mm, 500 mm], brick: {size: [1 m, 1 m, 1 m], density: 500 kg/m3}}]"
SHOT = "{size: [8 mm, 20 mm, 7 mm], density: 8000 kg/m3}"


@pytest.mark.parametrize("build", [POST, POST + BLOCK], ids=["alone", "with a block five metres away"])
def test_a_fast_hit_moves_what_it_hits_whatever_stands_elsewhere(build: str) -> None:
    #   9 g at 15 m/s give a plank of 12 g at least 6.4 m/s.
    throw = f"{{at: plank, from: {{bearing: 90 deg, distance: 100 mm}}, speed: 15 m/s, name: shot, brick: {SHOT}}}"
    trace = play(timeline_of(build, f"impacts: [{{at: 1 s, throw: {throw}}}]"), SYSTEMS["exact"])
    assert trace.tracks["plank"].shift > 0.5
    assert trace.collapse is not None


def test_how_thin_a_brick_is_that_is_set_down_elsewhere_changes_no_digit_of_what_moves_meanwhile() -> None:
    build = "- column: {levels: 8, step: 5 mm}\n- column: {levels: 5, origin: [0 m, 1 m, 0 mm]}\n  name: far"
    push = "{at: 1 s, push: {brick: L3.1, impulse: [60 mN*s, 0 N*s, 0 N*s], point: [0 mm, 8 mm, 0 mm]}}"
    insert = "{{name: late, at: [0 m, 1 m, {at} mm], brick: {{size: [50 mm, 20 mm, {side} mm], density: 500 kg/m3}}}}"
    sheet, plate = (
        play(timeline_of(build, f"impacts: [{push}, {{at: 1.05 s, insert: {late}}}]"), SYSTEMS["exact"])
        for late in (insert.format(at=39.1, side=0.2), insert.format(at=41.5, side=5))
    )
    assert sheet.cost.steps > 0
    for name in sheet.tracks.keys() - {"late"}:
        assert repr(sheet.tracks[name].final) == repr(plate.tracks[name].final)
