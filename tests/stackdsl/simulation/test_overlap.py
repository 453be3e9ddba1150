"""Depth of overlap of bodies, against overlaps computed by hand."""

from math import cos, pi, sin

import pytest

from stability.geometry.box import Box
from stability.geometry.vectors import about
from stability.model import GROUND, BodyState, Brick, Plane, Pose
from stackdsl.simulation.measurements import OverlapMeter, RunMeasurements
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import Penetration
from tests.scenes import timeline_of

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)  # [m]
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
BRICKS = {name: Brick(name, Box(SIZE), 0.012) for name in "abc"}


def deepest(*seen: dict[str, Pose]) -> Penetration:
    """The deepest of several looks, a second apart."""
    meter = OverlapMeter((FLOOR,))
    for time, poses in enumerate(seen):
        meter.see(float(time), BRICKS, poses)
    assert meter.penetration is not None
    return meter.penetration


def at(x: float, y: float, z: float) -> Pose:
    return Pose((x, y, z))


@pytest.mark.parametrize("deep", [0.0, 1e-6, 1e-3])
def test_a_plank_sunk_into_the_one_below_is_so_deep_in_it(deep: float) -> None:
    found = deepest({"a": at(0.0, 0.0, 0.5 * THICKNESS), "b": at(0.0, 0.0, 1.5 * THICKNESS - deep)})
    assert found.depth == pytest.approx(deep, abs=1e-15)


def test_a_plank_on_its_edge_in_the_ground_is_as_deep_as_its_lowest_edge() -> None:
    turn, height = pi / 6.0, 0.01
    tilted = Pose((0.0, 0.0, height), about((1.0, 0.0, 0.0), turn))
    lowest = 0.5 * WIDTH * sin(turn) + 0.5 * THICKNESS * cos(turn) - height
    found = deepest({"a": tilted})
    assert found.depth == pytest.approx(max(0.0, lowest), abs=1e-12)
    assert found.other == GROUND


def test_the_shortest_way_out_counts_and_not_the_volume_that_is_shared() -> None:
    found = deepest({"a": at(0.0, 0.0, 0.05), "b": at(LENGTH - 0.002, 0.0, 0.05)})  # end to end, 2 mm in each other
    assert found.depth == pytest.approx(0.002)
    assert (found.brick, found.other) == ("a", "b")


def test_the_deepest_look_of_all_is_told_with_its_time() -> None:
    def looks(deep: float) -> dict[str, Pose]:
        return {"b": at(0.0, 0.0, 1.5 * THICKNESS - deep)}

    found = deepest({"a": at(0.0, 0.0, 0.5 * THICKNESS), **looks(0.0)}, looks(0.001), looks(0.0005))
    assert found.depth == pytest.approx(0.001)
    assert found.time == 1.0
    assert {found.brick, found.other} == {"a", "b"}


def test_a_removed_brick_overlaps_nothing() -> None:
    meter = OverlapMeter((FLOOR,))
    meter.see(0.0, BRICKS, {"a": at(0.0, 0.0, 0.5 * THICKNESS)})
    meter.forget(["a"])
    meter.see(1.0, BRICKS, {"b": at(0.0, 0.0, 0.5 * THICKNESS)})
    assert meter.penetration is not None
    assert meter.penetration.depth == pytest.approx(0.0, abs=1e-15)


def test_overlap_uses_the_pose_at_which_a_brick_froze() -> None:
    #   One slides out of the way and is frozen there, before another comes to where it was last looked at.
    build = "- bricks: [{name: a, at: [0 mm, 0 mm, 3.9 mm]}, {name: b, at: [0 mm, 100 mm, 3.9 mm]}]"
    timeline = timeline_of(build, "expect: [penetration: < 1 mm]")
    measures = RunMeasurements(timeline)
    for placement in timeline.placements:
        measures.add(placement)
    measures.judged(0.005, {"a": BodyState(at(0.2, 0.0, 0.5 * THICKNESS))}, ["a"])
    came = {"b": BodyState(at(0.0, 0.0, 0.5 * THICKNESS))}
    measures.look(0.01, came, came)
    assert measures.overlapped is not None
    assert measures.overlapped.depth < 1e-15


def sinks(system: str, upper: str, expect: str = "penetration: < 1 mm") -> Penetration | None:
    build = f"- bricks:\n    - {{name: under, at: [0 mm, 0 mm, 3.9 mm]}}\n    - {upper}"
    return play(timeline_of(build, f"brick: kapla\nexpect: [{expect}]\n"), SYSTEMS[system]).penetration


def test_proven_bricks_touch_without_overlap() -> None:
    found = sinks("exact", "{name: upper, at: [0 mm, 0 mm, 11.7 mm]}")
    assert found is not None
    assert found.depth < 1e-15


def test_an_engine_lets_a_brick_sink_into_another_that_it_lies_on() -> None:
    found = sinks("stock", "{name: upper, at: [0 mm, 0 mm, 11.7 mm]}")
    assert found is not None
    assert 1e-6 < found.depth < 1e-3


def test_overlaps_are_not_measured_where_nobody_asks() -> None:
    assert sinks("stock", "{name: upper, at: [0 mm, 0 mm, 11.7 mm]}", "stands: all") is None
