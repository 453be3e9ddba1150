"""Bricks without support fall freely, land at the right time, and rest if their support is strong enough."""

from dataclasses import replace
from math import dist, sqrt

import pytest

from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import BrickState, EventKind, Trace
from tests.engines_at_hand import needs_pybullet
from tests.scenes import timeline_of

G = 9.81  # [m/s2]
THICKNESS = 0.0078  # of a KAPLA plank [m]
STEP = SYSTEMS["exact"].engine.time_step

PULLED = """
impacts:
  - remove: {bricks: [%s]}
    after: built + 1 s
expect: [{collapses: any}]
"""


def pulled(build: str, bricks: str, system: str = "exact") -> Trace:
    return play(timeline_of(build, PULLED % bricks), SYSTEMS[system])


def dropped(build: str, system: str = "exact", finer: float = 1.0) -> Trace:
    played_on = SYSTEMS[system]
    engine = replace(played_on.engine, time_step=played_on.engine.time_step / finer)
    return play(timeline_of(build, "expect: [{stands: {for: 1 s}}]"), replace(played_on, engine=engine))


def frozen_at(trace: Trace, brick: str) -> float:
    return next(
        event.time for event in reversed(trace.events) if event.kind is EventKind.FROZEN and brick in event.bricks
    )


@pytest.mark.parametrize("height", [1.0, 30.0, 1000.0])
def test_a_plank_lands_after_the_time_of_its_fall_and_rests_where_it_lands(height: float) -> None:
    trace = dropped(f"- bricks: [{{name: plank, at: [0 mm, 0 mm, {height + 3.9} mm], drop: true}}]")
    assert trace.cost.steps == 0
    assert 0.0 <= frozen_at(trace, "plank") - sqrt(2.0e-3 * height / G) <= STEP
    assert trace.tracks["plank"].final.position_W == pytest.approx((0.0, 0.0, 0.5 * THICKNESS), abs=1e-12)


@pytest.mark.parametrize("levels", [3, 60])
def test_a_tower_whose_lowest_level_is_pulled_comes_down_by_a_level_and_stands(levels: int) -> None:
    trace = pulled(f"- four_stack: {{levels: {levels}}}", "L1.1, L1.2")
    assert trace.cost.steps == 0
    assert 0.0 <= frozen_at(trace, f"L{levels}.1") - 1.0 - sqrt(2.0 * THICKNESS / G) <= STEP
    for name, track in trace.tracks.items():
        if not name.startswith("L1."):
            x, y, z = track.placed.position_W
            assert track.final.position_W == pytest.approx((x, y, z - THICKNESS), abs=1e-12)


@needs_pybullet
@pytest.mark.parametrize("levels", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_a_tower_dropped_by_a_pull_lands_as_on_the_bare_engine(levels: int) -> None:
    removed = f"- four_stack: {{levels: {levels}}}"
    as_proven, awake = pulled(removed, "L1.1, L1.2"), pulled(removed, "L1.1, L1.2", "tuned")
    for name, track in awake.tracks.items():
        assert dist(track.final.position_W, as_proven.tracks[name].final.position_W) < 0.01 * THICKNESS


def test_two_columns_that_lose_their_feet_land_one_after_the_other() -> None:
    # The second stands on a post of 50 mm.
    trace = pulled(
        """
- column: {levels: 3}
- bricks: [{name: post, at: [300 mm, 0 mm, 25 mm], brick: {size: [20 mm, 20 mm, 50 mm], density: 1000 kg/m3}}]
- bricks: [{name: top, at: [300 mm, 0 mm, 53.9 mm]}]
""",
        "L1.1, post",
    )
    assert trace.cost.steps == 0
    assert 0.0 <= frozen_at(trace, "L2.1") - 1.0 - sqrt(2.0 * THICKNESS / G) <= STEP
    assert 0.0 <= frozen_at(trace, "top") - 1.0 - sqrt(0.1 / G) <= STEP


def test_planks_that_are_let_go_while_others_fall_fall_with_them() -> None:
    trace = dropped(
        """
- bricks: [{name: a, at: [0 mm, 0 mm, 1 m], drop: true}]
- bricks: [{name: b, at: [0 mm, 0 mm, 1.5 m], drop: true}]
  after: start + 0.1 s
"""
    )
    assert trace.cost.steps == 0
    assert 0.0 <= frozen_at(trace, "a") - sqrt(2.0 * (1.0 - 0.5 * THICKNESS) / G) <= STEP
    assert 0.0 <= frozen_at(trace, "b") - 0.1 - sqrt(2.0 * (1.5 - 1.5 * THICKNESS) / G) <= STEP
    assert trace.edges[-1].lower == "a"


def test_a_plank_that_is_let_go_beside_a_wall_falls_along_it() -> None:
    trace = dropped(
        """
- bricks: [{name: wall, at: [0 mm, 0 mm, 100 mm], brick: {size: [200 mm, 20 mm, 200 mm], density: 1000 kg/m3}}]
- bricks: [{name: plank, at: [0 mm, 21.7 mm, 150 mm], drop: true}]
  after: built + 1 s
"""
    )
    assert trace.cost.steps == 0
    assert trace.tracks["plank"].final.position_W == pytest.approx((0.0, 0.0217, 0.5 * THICKNESS), abs=1e-12)


@pytest.mark.parametrize(("beside", "stands"), [(0.0, True), (11.2, True), (11.8, False)])
def test_a_brick_landing_with_its_centre_beyond_the_edge_tips(beside: float, stands: bool) -> None:
    # Half the width of a plank is 11.7 mm.
    trace = dropped(
        f"""
- bricks: [{{name: post, at: [0 mm, 0 mm, 50 mm], brick: {{size: [23.4 mm, 23.4 mm, 100 mm], density: 1 g/cm3}}}}]
- bricks: [{{name: plank, at: [{beside} mm, 0 mm, 150 mm], drop: true}}]
  after: built + 1 s
"""
    )
    assert (trace.cost.steps == 0) is stands
    assert (trace.tracks["plank"].final.position_W[2] > 0.1) is stands


def test_a_counterweighted_plank_does_not_bear_a_landing() -> None:
    # Statics lets the beam stand with the plank on its free end: a blow of the same place is many times its weight.
    beam = """
- bricks: [{name: post, at: [0 mm, 0 mm, 50 mm], brick: {size: [40 mm, 23.4 mm, 100 mm], density: 1000 kg/m3}}]
- bricks: [{name: beam, at: [0 mm, 0 mm, 103.9 mm]}]
- bricks: [{name: weight, at: [-40 mm, 0 mm, 117.8 mm], brick: {size: [20 mm, 20 mm, 20 mm], density: 2500 kg/m3}}]
"""
    at = "{name: plank, at: [35 mm, 0 mm, %s mm], rotate: [0 deg, 0 deg, 90 deg]%s}"
    assert dropped(f"{beam}- bricks: [{at % (111.7, '')}]").tracks["plank"].state is BrickState.FROZEN
    hit = dropped(f"{beam}- bricks: [{at % (211.7, ', drop: true')}]\n  after: built + 1 s")
    assert hit.cost.steps > 0


def test_a_brick_that_fell_past_a_place_does_not_land_on_a_brick_landing_there_later() -> None:
    # The plank comes to lie across two posts when the cube, which was below it all the time, is between them already.
    trace = dropped(
        """
- bricks:
    - {name: p, at: [-40 mm, 0 mm, 250 mm], brick: {size: [20 mm, 40 mm, 500 mm], density: 1000 kg/m3}}
    - {name: q, at: [40 mm, 0 mm, 250 mm], brick: {size: [20 mm, 40 mm, 500 mm], density: 1000 kg/m3}}
- bricks:
    - {name: plank, at: [0 mm, 0 mm, 1 m], drop: true}
    - {name: cube, at: [0 mm, 0 mm, 0.8 m], drop: true, brick: {size: [20 mm, 20 mm, 20 mm], density: 1 g/cm3}}
  after: built + 1 s
"""
    )
    assert trace.cost.steps == 0
    assert trace.tracks["plank"].final.position_W[2] == pytest.approx(0.5 + 0.5 * THICKNESS)
    assert trace.tracks["cube"].final.position_W[2] == pytest.approx(0.01)
    assert 0.0 <= frozen_at(trace, "cube") - 1.0 - sqrt(2.0 * 0.79 / G) <= STEP


def test_a_brick_falls_through_a_slot_that_is_written_a_little_too_narrow() -> None:
    trace = dropped(
        """
- bricks:
    - {name: p, at: [-20 mm, 0 mm, 250 mm], brick: {size: [20 mm, 40 mm, 500 mm], density: 1000 kg/m3}}
    - {name: q, at: [20 mm, 0 mm, 250 mm], brick: {size: [20 mm, 40 mm, 500 mm], density: 1000 kg/m3}}
- bricks: [{name: b, at: [0 mm, 0 mm, 0.4 m], drop: true, brick: {size: [20.02 mm, 20 mm, 20 mm], density: 1 g/cm3}}]
  after: built + 1 s
"""
    )
    assert trace.cost.steps == 0
    assert trace.tracks["b"].final.position_W[2] == pytest.approx(0.01)


def test_a_block_that_would_land_near_an_edge_is_left_to_the_engine() -> None:
    # Nothing lands quite flat: a blow a tenth of the height of its centre beside it, here 5 mm, must be borne as well.
    for inside, steps in ((4.0, True), (6.0, False)):
        trace = dropped(
            f"""
- bricks: [{{name: s, at: [0 mm, 0 mm, 5 mm], brick: {{size: [60 mm, 60 mm, 10 mm], density: 1000 kg/m3}}}}]
- bricks:
    - {{name: d, at: [{30 - inside} mm, 0 mm, 80 mm], drop: true, brick: {{size: [2 cm, 2 cm, 10 cm], mass: 40 g}}}}
  after: built + 1 s
"""
        )
        assert (trace.cost.steps > 0) is steps


def test_in_weak_gravity_what_has_hardly_begun_to_fall_does_not_count_as_resting() -> None:
    build = "- bricks: [{name: plank, at: [0 mm, 0 mm, 400 mm], drop: true}]"
    trace = play(timeline_of(build, "world: {gravity: 0.01 m/s2}"), SYSTEMS["exact"])
    assert trace.collapse is None
    assert trace.tracks["plank"].state is BrickState.UNSETTLED
