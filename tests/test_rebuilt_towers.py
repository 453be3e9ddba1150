"""A hard case that is no scenario: one process builds, plays and closes a tower again and again."""

import gc
import tracemalloc
from dataclasses import dataclass, replace
from pathlib import Path
from resource import getpagesize

import pytest

from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Timeline
from stackdsl.trace import Trace
from tests.scenes import timeline_of

WARM = 10  # runs after which modules are loaded and caches filled
# Of Python's objects, by a run after those [bytes]. PyBullet never lets go of a kilobyte of corners that it is given
# for the two solids of this tower; all else must go.
MOST_KEPT = 4 * 1024
# Of the process, by all the runs after those [bytes]: two worlds of PyBullet, of 29 MB each, as the allocator may keep
# one more at any time. Were they left open, it would be ten of them or more.
MOST_GROWN = 60 * 1024 * 1024
MEMORY = Path("/proc/self/statm")  # of this process, now: the peak, which `getrusage` knows, would hide what is small

TOWER = "- four_stack: {levels: 10}"
LOW_TOWER = "- four_stack: {levels: 4}"  # of which a bare engine steps every plank
# `exact` opens no engine for what stands, falls freely, or turns about an edge, so this lands on a corner.
TOWER_AND_DROP = (
    TOWER
    + """
- bricks: [{name: falling, at: [300 mm, 0 mm, 48.3 mm], rotate: [30 deg, 45 deg, 0 deg], drop: true}]"""
)


@dataclass(frozen=True, slots=True)
class Size:
    """How much memory is in use."""

    objects: int  # of Python [bytes]
    process: int  # [bytes]


def size_now() -> Size:
    gc.collect()
    return Size(tracemalloc.get_traced_memory()[0], int(MEMORY.read_text().split()[1]) * getpagesize())


def what_happened(timeline: Timeline, system: str) -> Trace:
    """The trace of one more run, without the wall time that it took."""
    trace = play(timeline, SYSTEMS[system])
    return replace(trace, cost=replace(trace.cost, wall_time=0.0))


@pytest.mark.parametrize("times", [20, pytest.param(50, marks=pytest.mark.slow)])
@pytest.mark.skipif(not MEMORY.exists(), reason="only Linux tells the memory of a process there")
@pytest.mark.parametrize(
    ("system", "build", "engine"),
    [
        pytest.param("exact", TOWER, False, marks=pytest.mark.slow),
        ("exact", TOWER_AND_DROP, True),
        pytest.param("tuned", LOW_TOWER, True, marks=pytest.mark.slow),
    ],
)
def test_a_tower_rebuilt_many_times_repeats_to_the_last_bit_and_leaves_nothing(
    system: str, build: str, engine: bool, times: int
) -> None:
    timeline = timeline_of(build, "expect: [{stands: {for: 0.05 s}}]")
    tracemalloc.start()
    try:
        first = what_happened(timeline, system)
        warm = size_now()
        for count in range(2, times + 1):
            assert what_happened(timeline, system) == first, f"run {count} is another than the first"
            warm = size_now() if count == WARM else warm
        end = size_now()
    finally:
        tracemalloc.stop()
    assert (first.cost.steps > 0) is engine
    assert end.objects - warm.objects <= MOST_KEPT * (times - WARM)
    assert end.process - warm.process <= MOST_GROWN
