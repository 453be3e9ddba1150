"""What a worker does: play one case on one system at one time step, and measure what that took.

Each measurement has a process of its own: what an engine keeps from one world to the next touches no other, and the
most memory that a process ever had is that of one case.
"""

import resource
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median

from stackdsl.bench.entrants import Result, entrant_named
from stackdsl.checking.one_case import played_or_blocked
from stackdsl.playing.clearance import Blocked
from stackdsl.timeline import Timeline

ENOUGH = 0.25  # [s] of playing, so that a run of a millisecond is not timed by its first time alone
MOST_RUNS = 9
WORTH_REPEATING = 5.0  # [s] beyond, the tenth of a second that imports take on the way makes no difference
BYTES_PER_UNIT = 1 if sys.platform == "darwin" else 1024  # of the memory that getrusage tells


@dataclass(frozen=True, slots=True)
class Played:
    """One case, played."""

    result: Result
    wall_time: float  # [s], median of the runs
    runs: int
    peak_memory: int  # [bytes] of the whole process, Python and libraries included


def measured_or_blocked(timeline: Timeline, system: str, factor: float) -> Played | Blocked:
    """The same as `measured`, or what keeps the run from going on."""
    return played_or_blocked(measured, timeline, system, factor)


def measured(timeline: Timeline, system: str, factor: float) -> Played:
    """Play a timeline at so many times the time step; what takes no time is played several times."""
    entrant = entrant_named(system)

    def walls() -> Iterator[float]:
        while True:
            yield entrant.play(timeline, factor).cost.wall_time

    entrant.load()
    loaded = len(sys.modules)
    first = entrant.play(timeline, factor)
    took = first.cost.wall_time
    if len(sys.modules) > loaded and took < WORTH_REPEATING:
        took = next(walls())  # what is imported on the way, as solvers are, is no part of a run
    times = enough(took, walls())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_PER_UNIT
    return Played(entrant.checked(first, timeline), median(times), len(times), peak)


def enough(first: float, more: Iterator[float]) -> list[float]:
    """Times [s] of one run after the other, until they add up to ENOUGH."""
    times = [first]
    while sum(times) < ENOUGH and len(times) < MOST_RUNS:
        times.append(next(more))
    return times
