"""What a worker does: play one case on one system at one time step, and measure what that took.

Each measurement has a process of its own: what an engine keeps from one world to the next touches no other, and the
most memory that a process ever had is that of one case.
"""

import resource
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import median

from benchmarks.systems.entrants import Result, entrant_named
from stackdsl.checking.play_case import played_or_blocked
from stackdsl.simulation.brick_tracks import Blocked
from stackdsl.timeline import Timeline
from stackdsl.trace import Cost, Updates

ENOUGH = 0.25  # [s] of playing, so that a run of a millisecond is not timed by its first time alone
MOST_RUNS = 9
WORTH_REPEATING = 5.0  # [s] beyond, the tenth of a second that imports take on the way makes no difference
BYTES_PER_UNIT = 1 if sys.platform == "darwin" else 1024  # of the memory that getrusage tells


@dataclass(frozen=True, slots=True)
class Played:
    """One case, played."""

    result: Result
    wall_time: float  # [s], median of the runs
    updates: Updates | None  # medians of the runs, each of its median and its worst update
    peak_memory: int  # [bytes] of the whole process, Python and libraries included


def measured_or_blocked(timeline: Timeline, system: str, factor: float) -> Played | Blocked:
    """The same as `measured`, or what keeps the run from going on."""
    return played_or_blocked(measured, timeline, system, factor)


def measured(timeline: Timeline, system: str, factor: float) -> Played:
    """Play a timeline at so many times the time step; what takes no time is played several times."""
    entrant = entrant_named(system)

    costs: list[Cost] = []

    def walls() -> Iterator[float]:
        while True:
            costs.append(entrant.play(timeline, factor).cost)
            yield costs[-1].wall_time

    entrant.load()
    loaded = len(sys.modules)
    first = entrant.play(timeline, factor)
    if len(sys.modules) > loaded and first.cost.wall_time < WORTH_REPEATING:
        took = next(walls())  # what is imported on the way, as solvers are, is no part of a run
    else:
        costs.append(first.cost)
        took = first.cost.wall_time
    times = enough(took, walls())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_PER_UNIT
    return Played(entrant.checked(first, timeline), median(times), usual_updates(costs), peak)


def usual_updates(costs: Sequence[Cost]) -> Updates | None:
    """The median and the worst update of one run after the other, each as it is in the median of them."""
    updates = [cost.updates for cost in costs if cost.updates is not None]
    if not updates:
        return None
    return Updates(median(each.median for each in updates), median(each.worst for each in updates))


def enough(first: float, more: Iterator[float]) -> list[float]:
    """Times [s] of one run after the other, until they add up to ENOUGH."""
    times = [first]
    while sum(times) < ENOUGH and len(times) < MOST_RUNS:
        times.append(next(more))
    return times
