"""Scores -> points: each system at each time step over all scenarios, and the Pareto-optimal points."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import geometric_mean, median

from benchmarks.systems.run_record import Record, step_text
from benchmarks.systems.scoring import Score
from stackdsl.trace import NUMERICAL_COLLAPSE

PERCENT = 100.0
COMPARED_WITH = "exact"  # system whose pace is the unit of other paces, case by case
MEASURES: Mapping[str, str] = {  # kinds of error, and their displayed units
    "wrong": "%",
    "levels": "levels",
    "creep": "mm",
    "mm": "mm",
    "deg": "deg",
    "seconds": "s",
}


@dataclass(frozen=True, slots=True)
class Point:
    """One system at one time step. Errors are the largest over the scenarios; None if none is known."""

    system: str
    factor: float
    runs: int
    done: int
    known: int  # runs with a known answer
    wrong_verdicts: int
    numerical: int  # numerical collapses
    errors: Mapping[str, float | None]  # by measure
    energy: float | None  # [%]
    # Wall time per simulated second, geometric mean over the cases that every capable point has finished; None for a
    # point that has not finished all of these.
    pace: float | None
    times_exact: float | None  # pace relative to COMPARED_WITH, geometric mean over the cases that both have finished
    wall_time: float  # [s], sum
    simulated_time: float  # [s], sum
    steps: int
    solves: int
    peak_memory: int  # [bytes], largest
    update_median: float | None  # [s] of one update of the extension, median over the cases; None without one
    update_worst: float | None  # [s] the largest of all

    @property
    def name(self) -> str:
        """Return the displayed name."""
        return f"{self.system}, {step_text(self.factor)}"


def points_of(scores: Iterable[Score]) -> list[Point]:
    """Return a point for each system and time step, in order of appearance, then from coarse to fine."""
    grouped: defaultdict[tuple[str, float], list[Score]] = defaultdict(list)
    for score in scores:
        grouped[score.record.system, score.record.factor].append(score)
    order = list(dict.fromkeys(system for system, _ in grouped))
    shared = _shared_cases(grouped.values())
    fastest = paces_of(score.record for score in grouped[COMPARED_WITH, 1.0]) if (COMPARED_WITH, 1.0) in grouped else {}
    keys = sorted(grouped, key=lambda key: (order.index(key[0]), -key[1]))
    return [_point(*key, grouped[key], shared, fastest) for key in keys]


def _shared_cases(groups: Iterable[Sequence[Score]]) -> frozenset[str]:
    """Return the cases that all capable points have finished, so that paces are comparable."""
    done = [frozenset(s.record.case for s in group if s.record.done or not s.record.taken) for group in groups]
    return frozenset.intersection(*done) if done else frozenset()


def _point(
    system: str, factor: float, scores: Sequence[Score], shared: frozenset[str], fastest: Mapping[str, float]
) -> Point:
    records = [score.record for score in scores]
    known = [score for score in scores if score.wrong is not None]
    own = paces_of(records)
    return Point(
        system=system,
        factor=factor,
        runs=len(records),
        done=sum(record.done for record in records),
        known=len(known),
        wrong_verdicts=sum(bool(score.wrong) for score in known),
        numerical=sum(score.verdict == NUMERICAL_COLLAPSE for score in scores),
        errors=_errors(scores, known),
        energy=_largest(scores, "energy"),
        pace=_shared_pace(own, records, shared),
        times_exact=_mean([pace / fastest[case] for case, pace in own.items() if case in fastest]),
        wall_time=sum(record.wall_time for record in records),
        simulated_time=sum(record.simulated_time for record in records),
        steps=sum(record.steps for record in records),
        solves=sum(record.solves for record in records),
        peak_memory=max(record.peak_memory for record in records),
        update_median=median(medians) if (medians := _told(record.update_median for record in records)) else None,
        update_worst=max(_told(record.update_worst for record in records), default=None),
    )


def _errors(scores: Sequence[Score], known: Sequence[Score]) -> dict[str, float | None]:
    wrong = PERCENT * sum(bool(score.wrong) for score in known) / len(known) if known else None
    return {"wrong": wrong} | {measure: _largest(scores, measure) for measure in MEASURES if measure != "wrong"}


def _shared_pace(own: Mapping[str, float], records: Sequence[Record], shared: frozenset[str]) -> float | None:
    """Return the pace over the shared cases; None if one of these is not finished."""
    if not shared <= {record.case for record in records if record.done}:
        return None
    return _mean([pace for case, pace in own.items() if case in shared])


def _mean(paces: Sequence[float]) -> float | None:
    return geometric_mean(paces) if paces else None


def paces_of(records: Iterable[Record]) -> dict[str, float]:
    """Return the pace of each case that has one."""
    return {record.case: pace for record in records if record.done and (pace := pace_of(record)) is not None}


def pace_of(record: Record) -> float | None:
    """Return the wall time per simulated second [s]; None if nothing was simulated."""
    if min(record.wall_time, record.simulated_time) <= 0.0:
        return None
    return record.wall_time / record.simulated_time


def _largest(scores: Iterable[Score], measure: str) -> float | None:
    return max(_told(getattr(score, measure) for score in scores), default=None)


def _told(values: Iterable[float | None]) -> list[float]:
    return [value for value in values if value is not None]


def pareto_front(costs_and_errors: Sequence[tuple[float, float]]) -> list[int]:
    """Return the indices of the points that no other point beats in cost or error without being worse in the other.

    They are ordered by cost, then error.
    """
    return sorted(
        (i for i, own in enumerate(costs_and_errors) if not any(_beats(other, own) for other in costs_and_errors)),
        key=lambda index: costs_and_errors[index],
    )


def _beats(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return one != other and one[0] <= other[0] and one[1] <= other[1]


def fronts_of(points: Sequence[Point]) -> Mapping[str, list[Point]]:
    """Return the Pareto front of pace against each measure, from the fastest point to the most accurate one."""
    fronts = {}
    for measure in MEASURES:
        told = [
            (point, (point.pace, error))
            for point in points
            if point.pace is not None and (error := point.errors[measure]) is not None
        ]
        if told:
            fronts[measure] = [told[index][0] for index in pareto_front([pair for _, pair in told])]
    return fronts
