"""Fragility curves: the same samples judged at one intensity after the other by supervised processes.

What a chunk of them comes to depends on nothing but its numbers, so it may be remembered from a call that was
interrupted. Where a sample's own margin tells at which intensity it falls, it is asked for that once, and not at each.
"""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from time import process_time

from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case
from stackdsl.checking.ensembles import Chunk, judged_chunk, varied_chunk
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.variants import Variant
from stackdsl.sampling.samples import (
    AS_WRITTEN,
    Draws,
    SampleMistakeError,
    Setting,
    build_plan_of,
    timeline_at,
    timelines,
)
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.studies.fragility_curve import CurveSettings, Fragility, of_capacities, of_fates, spaced
from stackdsl.studies.fragility_intensity import SHAKING, Capacity, Intensity, capacities_of
from stackdsl.supervising.processes import OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus

TOGETHER = 500  # samples of a chunk that are judged together, by arithmetic
APART = 25  # that are compiled, solved or played one by one
NARROW = 0.5  # of the most that any sample survives: where all survive more, points go to where they differ
FEW = 3  # points
TIME_LIMIT = 3600.0  # [s] of wall time a chunk


@dataclass(frozen=True, slots=True)
class CapacityChunk:
    """What some samples survive, in order of their numbers."""

    capacities: tuple[Capacity, ...]
    ways: dict[str, int]
    cpu_time: float  # [s]


def fates_at(variant: Variant, system: str, draws: Draws, setting: Setting) -> Chunk | Diagnostic:
    """What a worker does: judge some samples where something is otherwise than written."""
    if variant.values.get("uncertain") is not None:
        return varied_chunk(variant, system, draws, setting)
    timeline = timeline_at(variant, setting)
    return timeline if isinstance(timeline, Diagnostic) else judged_chunk(timeline, system, draws)


def capacity_chunk(variant: Variant, draws: Draws, bearing: float | None) -> CapacityChunk | Diagnostic:
    """What a worker does: find what some samples survive."""
    started, found, ways = process_time(), list[Capacity](), Counter[str]()
    try:
        if variant.values.get("uncertain") is None:
            timeline = timeline_at(variant, AS_WRITTEN)
            if isinstance(timeline, Diagnostic):
                return timeline
            found, ways = capacities_of(build_plan_of(timeline), draws, bearing)
        else:
            for number, timeline in enumerate(timelines(variant, draws), start=draws.first):
                one, way = capacities_of(build_plan_of(timeline), replace(draws, first=number, count=1), bearing)
                found += one
                ways.update(way)
    except SampleMistakeError as error:
        return error.mistake
    return CapacityChunk(tuple(found), dict(ways), process_time() - started)


@dataclass(frozen=True, slots=True)
class FragilityPlan:
    """What is asked for."""

    case: Case
    intensity: Intensity
    values: tuple[float, ...]  # of the intensity; of what shakes, none if they follow from what is survived
    points: int
    samples: int
    seed: int
    confidence: float
    bearing: float | None = None  # of what shakes [rad]; None for the worst of each sample

    @property
    def shakes(self) -> bool:
        """Whether each sample has a capacity of its own."""
        return self.intensity.kind in SHAKING

    @property
    def work(self) -> int:
        """How many samples are judged, one at two intensities counted twice."""
        return self.samples * (1 if self.shakes else len(self.values))

    def tasks(self) -> list[tuple[float, Draws]]:
        """All chunks, those of one intensity after the other."""
        proven = system_named(self.case.system).method is Method.PROVEN
        together = proven and not self.shakes and self.case.variant.values.get("uncertain") is None
        size = TOGETHER if together else APART
        firsts = range(0, self.samples, size)
        name = self.case.scenario.scenario
        chunks = [Draws(self.seed, name, first, min(size, self.samples - first)) for first in firsts]
        return [(value, draws) for value in ((0.0,) if self.shakes else self.values) for draws in chunks]

    def asked(self, value: float, draws: Draws) -> Task:
        """What a worker is to do for a chunk."""
        if self.shakes:
            return Task(capacity_chunk, (self.case.variant, draws, self.bearing), TIME_LIMIT)
        setting = self.intensity.setting(value)
        return Task(fates_at, (self.case.variant, self.case.system, draws, setting), TIME_LIMIT)

    def key(self, value: float, draws: Draws, memory: ResultCache) -> str:
        """The name of the record of a chunk."""
        variant = self.case.variant
        texts = [sha256(text.encode()).hexdigest() for text in variant.source.files.values()]
        written = json.dumps([variant.written.values, dict(variant.choice), texts], sort_keys=True)
        asked = (self.intensity.kind, self.intensity.name, value, self.bearing)
        return memory.key("fragility", written, self.case.system, self.seed, asked, draws.first, draws.count)


@dataclass(slots=True)
class CurveResult:
    """What came of it so far."""

    plan: FragilityPlan
    chunks: dict[tuple[float, int], Chunk | CapacityChunk] = field(default_factory=dict)
    mistake: Diagnostic | None = None  # of a sample, or of a point
    failed: TaskResult | None = None  # of a chunk that crashed or overran its time
    interrupted: bool = False

    @property
    def done(self) -> int:
        """How many samples are judged."""
        return sum(len(chunk.fates if isinstance(chunk, Chunk) else chunk.capacities) for chunk in self.chunks.values())

    def fragility(self) -> Fragility | None:
        """The curve by all points of which every sample is judged; None if there is none."""
        plan = self.plan
        terms = CurveSettings(plan.intensity, plan.seed, plan.confidence)
        made = _of_capacities(self, terms) if plan.shakes else _of_fates(self, terms)
        cpu_time = sum(chunk.cpu_time for chunk in self.chunks.values())
        return None if made is None else replace(made, cpu_time=cpu_time)


def _of_fates(found: CurveResult, terms: CurveSettings) -> Fragility | None:
    fates: dict[float, list[int]] = {}
    ways: dict[float, Counter[str]] = {}
    for value in found.plan.values:
        chunks = [found.chunks[value, first] for at, first in sorted(found.chunks) if at == value]
        own = [fate for chunk in chunks if isinstance(chunk, Chunk) for fate in chunk.fates]
        if len(own) == found.plan.samples:
            fates[value], ways[value] = own, Counter()
            for chunk in chunks:
                ways[value].update(chunk.ways)
    return of_fates(terms, fates, ways) if fates else None


def _of_capacities(found: CurveResult, terms: CurveSettings) -> Fragility | None:
    chunks = [found.chunks[key] for key in sorted(found.chunks)]
    capacities = [each for chunk in chunks if isinstance(chunk, CapacityChunk) for each in chunk.capacities]
    if not capacities:
        return None
    ways = Counter[str]()
    for chunk in chunks:
        ways.update(chunk.ways)
    return of_capacities(terms, capacities, found.plan.values or _reached(found.plan, capacities), ways)


def _reached(plan: FragilityPlan, capacities: Sequence[Capacity]) -> tuple[float, ...]:
    """None, and from where the first falls to where the last does; evenly from none where that is most of the way."""
    ends = [each.fails for each in capacities if each.survived > 0.0 and each.fails < float("inf")]
    least, most = (plan.intensity.of_acceleration(end) for end in (min(ends, default=1.0), max(ends, default=1.0)))
    if least <= NARROW * most or least == most or plan.points <= FEW:
        return tuple(float(value) for value in spaced(0.0, most, plan.points))
    before = least - (most - least) / (plan.points - FEW)
    return (0.0, *(float(value) for value in spaced(before, most, plan.points - 1)))


def draw(
    plan: FragilityPlan,
    workers: int,
    memory: ResultCache,
    on_done: Callable[[int], None],
    on_wait: OnWait = lambda: None,
) -> CurveResult:
    """Judge all samples at all intensities; `on_done` hears how many are judged. An interrupt keeps what is done."""
    found, left = CurveResult(plan), []
    for value, draws in plan.tasks():
        record = memory.recall(plan.key(value, draws, memory))
        if isinstance(record, list):
            found.chunks[value, draws.first] = _from_record(plan, record)
        else:
            left.append((value, draws))

    def done(index: int, result: TaskResult) -> None:
        value, draws = left[index]
        if isinstance(result.value, Chunk | CapacityChunk):
            found.chunks[value, draws.first] = result.value
            memory.remember(plan.key(value, draws, memory), _as_record(result.value))
            memory.settle()
        elif isinstance(result.value, Diagnostic):
            found.mistake = found.mistake or result.value
        elif result.status is not TaskStatus.NOT_RUN:
            found.failed = found.failed or result
        on_done(found.done)

    found.interrupted = run_supervised([plan.asked(*each) for each in left], workers, done, on_wait).interrupted
    return found


def _as_record(chunk: Chunk | CapacityChunk) -> object:
    rows = list(chunk.fates) if isinstance(chunk, Chunk) else [[c.fate, c.survived, c.fails] for c in chunk.capacities]
    return [rows, chunk.ways, chunk.cpu_time]


def _from_record(plan: FragilityPlan, record: list[object]) -> Chunk | CapacityChunk:
    rows, ways, cpu_time = record
    assert isinstance(rows, list)
    assert isinstance(ways, dict)
    assert isinstance(cpu_time, float)
    if plan.shakes:
        return CapacityChunk(tuple(Capacity(*row) for row in rows), ways, cpu_time)
    return Chunk(tuple(rows), ways, cpu_time)
