"""Plays one case on one system at one time step in a worker, and measures the cost.

Each measurement has a process of its own: data that an engine keeps between worlds affect no other case, and the peak
memory of a process is that of one case.
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

ENOUGH = 0.25  # [s] total duration of the repetitions of short runs
MOST_RUNS = 9
WORTH_REPEATING = 5.0  # [s] for longer runs the tenth of a second of imports is negligible
BYTES_PER_UNIT = 1 if sys.platform == "darwin" else 1024  # of the memory reported by getrusage


@dataclass(frozen=True, slots=True)
class Played:
    """Measurements of one case."""

    result: Result
    wall_time: float  # [s], median of the runs
    updates: Updates | None  # medians over the runs of the median and the worst update
    peak_memory: int  # [bytes] of the whole process, including Python and libraries


def measured_or_blocked(timeline: Timeline, system: str, factor: float) -> Played | Blocked:
    """Return the result of `measured`, or the reason why the run cannot continue."""
    return played_or_blocked(measured, timeline, system, factor)


def measured(timeline: Timeline, system: str, factor: float) -> Played:
    """Play a timeline at a factor on the time step; short runs are repeated."""
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
        took = next(walls())  # imports during the first run, such as those of solvers, do not count
    else:
        costs.append(first.cost)
        took = first.cost.wall_time
    times = enough(took, walls())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * BYTES_PER_UNIT
    return Played(entrant.checked(first, timeline), median(times), usual_updates(costs), peak)


def usual_updates(costs: Sequence[Cost]) -> Updates | None:
    """Return the medians, over the runs, of the median and of the worst update."""
    updates = [cost.updates for cost in costs if cost.updates is not None]
    if not updates:
        return None
    return Updates(median(each.median for each in updates), median(each.worst for each in updates))


def enough(first: float, more: Iterator[float]) -> list[float]:
    """Return times [s] of repeated runs until their sum reaches ENOUGH."""
    times = [first]
    while sum(times) < ENOUGH and len(times) < MOST_RUNS:
        times.append(next(more))
    return times
