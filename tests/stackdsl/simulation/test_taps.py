"""Gentle pushes, again and again: what is pushed keeps what each of them adds, and nothing else moves.

A plank that lies free and is pushed to a speed v slides by v^2 / (2 mu g).
"""

from collections.abc import Mapping
from math import hypot

import pytest

from stability.model import BodyId, Pose, Vec3
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import FixedWorld, Placement, PushAction, Timeline
from stackdsl.trace import Trace
from tests.planks import FLOOR, GRAVITY, MASS, WOOD, column, four_stack, plank

TAPS = 10


def tapped(poses: Mapping[BodyId, Pose], brick: BodyId, velocity_W: Vec3) -> Trace:
    placed = [Placement(0.0, plank(name), number, pose) for number, (name, pose) in enumerate(poses.items(), 1)]
    impulse = (MASS * velocity_W[0], MASS * velocity_W[1], 0.0)
    taps = [PushAction(1.0 + 0.5 * count, brick, impulse) for count in range(TAPS)]
    return play(Timeline(FixedWorld(GRAVITY, WOOD, (FLOOR,)), (*placed, *taps), hold=0.5), SYSTEMS["exact"])


@pytest.mark.parametrize(
    ("speed", "bearing"), [(0.01, (1.0, 0.0)), (0.02, (0.6, -0.8)), (0.05, (1.0, 0.0)), (0.1, (0.6, -0.8))]
)
def test_ten_taps_move_a_plank_ten_times_as_far_as_one_and_nothing_else(
    speed: float, bearing: tuple[float, float]
) -> None:
    trace = tapped(column(3), "L3", (speed * bearing[0], speed * bearing[1], 0.0))
    (x, y, _), (start_x, start_y, _) = (trace.tracks["L3"].final.position_W, trace.tracks["L3"].placed.position_W)
    way = TAPS * speed**2 / (2.0 * WOOD * GRAVITY)
    assert hypot(x - start_x, y - start_y) == pytest.approx(way, rel=0.03)
    assert trace.tracks["L1"].final == trace.tracks["L1"].placed
    assert trace.tracks["L2"].final.position_W == pytest.approx(trace.tracks["L2"].placed.position_W, abs=1e-12)


def test_a_push_as_slow_as_a_brick_at_rest_leaves_it_where_it_is() -> None:
    trace = tapped(column(3), "L3", (0.004, 0.0, 0.0))
    assert trace.tracks["L3"].final == trace.tracks["L3"].placed
    assert trace.cost.steps == 0


def test_a_tap_inside_a_tower_moves_that_plank_alone() -> None:
    #   L3.2 lies between level 2 and what stands on it; friction on both faces stops it sooner than that of its weight.
    trace = tapped(four_stack(range(1, 8)), "L3.2", (0.0, -0.1, 0.0))
    moved = {
        name: hypot(*(a - b for a, b in zip(t.final.position_W, t.placed.position_W, strict=True)))
        for name, t in trace.tracks.items()
    }
    assert 0.0 < moved.pop("L3.2") < TAPS * 0.1**2 / (2.0 * WOOD * GRAVITY)
    assert max(moved.values()) < 1e-9
