"""Fragility curves: judges the same samples at several intensities, in supervised processes.

The result of a chunk of samples depends only on their numbers, so it is cached across interrupted calls. For a constant
acceleration and a tilt, the margin of a sample is the intensity at which it falls, so each sample is judged only once.
"""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from math import ceil, inf
from time import process_time

import numpy as np
from scipy.special import ndtr, ndtri

from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import Case
from stackdsl.checking.ensembles import Chunk, judged_chunk, varied_chunk
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.variants import Variant
from stackdsl.sampling.samples import (
    AS_WRITTEN,
    Draws,
    InvalidSampleError,
    Setting,
    build_plan_of,
    timeline_at,
    timelines,
)
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.studies.fragility_curve import CurveSettings, Fragility, curve_of_capacities, curve_of_outcomes
from stackdsl.studies.fragility_intensity import Capacity, Intensity, capacities_of, jitter_text
from stackdsl.supervising.processes import OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from stackdsl.wording import rounded_up

TOGETHER = 500  # samples of a chunk that are judged together, by arithmetic
APART = 25  # samples of a chunk that are compiled, solved or played one by one
FIRST_SHARE, LAST_SHARE = 0.01, 0.99  # of the samples that fall at the first and last of the chosen points
DIGITS = 6  # of the chosen points
ROUNDING = 1e-9  # relative; more than the error of the conversion of units
TIME_LIMIT = 3600.0  # [s] of wall time a chunk


@dataclass(frozen=True, slots=True)
class CapacityChunk:
    """The capacities of a chunk of samples, in order of their numbers."""

    capacities: tuple[Capacity, ...]
    ways: dict[str, int]
    cpu_time: float  # [s]


def outcomes_at(variant: Variant, system: str, draws: Draws, setting: Setting) -> Chunk | Diagnostic:
    """Judge a chunk of samples with changed values; runs in a worker."""
    if variant.values.get("uncertain") is not None:
        return varied_chunk(variant, system, draws, setting)
    timeline = timeline_at(variant, setting)
    return timeline if isinstance(timeline, Diagnostic) else judged_chunk(timeline, system, draws)


def capacity_chunk(variant: Variant, draws: Draws, bearing: float | None) -> CapacityChunk | Diagnostic:
    """Compute the capacities of a chunk of samples; runs in a worker."""
    started, capacities, ways = process_time(), list[Capacity](), Counter[str]()
    try:
        if variant.values.get("uncertain") is None:
            timeline = timeline_at(variant, AS_WRITTEN)
            if isinstance(timeline, Diagnostic):
                return timeline
            capacities, ways = capacities_of(build_plan_of(timeline), draws, bearing)
        else:
            for number, timeline in enumerate(timelines(variant, draws), start=draws.first):
                sample = replace(draws, first=number, count=1)
                own_capacities, own_ways = capacities_of(build_plan_of(timeline), sample, bearing)
                capacities += own_capacities
                ways.update(own_ways)
    except InvalidSampleError as error:
        return error.mistake
    return CapacityChunk(tuple(capacities), dict(ways), process_time() - started)


@dataclass(frozen=True, slots=True)
class FragilityPlan:
    """The settings of a fragility study."""

    case: Case
    intensity: Intensity
    values: tuple[float, ...]  # of the intensity; empty if they follow from the capacities
    points: int
    samples: int
    seed: int
    confidence: float
    bearing: float | None = None  # of the acceleration or tilt [rad]; None for the worst of each sample

    @property
    def name(self) -> str:
        """The name of the curve: that of the case, without the varied value."""
        chosen = [f"{key}={text}" for key, text in self.case.variant.parameters if key != self.intensity.name]
        return f"{self.case.scenario_name}[{','.join([*chosen, self.case.system])}]"

    @property
    def has_capacities(self) -> bool:
        """Whether each sample has a capacity, as the intensity is a tilt or an acceleration."""
        return self.intensity.is_steady

    @property
    def work(self) -> int:
        """Number of verdicts: samples times intensities, or samples if each has a capacity."""
        return self.samples * (1 if self.has_capacities else len(self.values))

    def tasks(self) -> list[tuple[float, Draws]]:
        """Return all chunks, in order of intensity."""
        proven = system_named(self.case.system).method is Method.PROVEN
        together = proven and not self.has_capacities and self.case.variant.values.get("uncertain") is None
        size = TOGETHER if together else APART
        firsts = range(0, self.samples, size)
        name = self.case.scenario.scenario
        chunks = [Draws(self.seed, name, first, min(size, self.samples - first)) for first in firsts]
        return [(value, draws) for value in ((0.0,) if self.has_capacities else self.values) for draws in chunks]

    def task(self, value: float, draws: Draws) -> Task:
        """Return the task of a worker for a chunk."""
        if self.has_capacities:
            return Task(capacity_chunk, (self.case.variant, draws, self.bearing), TIME_LIMIT)
        setting = self.intensity.setting(value)
        return Task(outcomes_at, (self.case.variant, self.case.system, draws, setting), TIME_LIMIT)

    def key(self, value: float, draws: Draws, memory: ResultCache) -> str:
        """Return the key of a chunk in the cache."""
        variant = self.case.variant
        texts = [sha256(text.encode()).hexdigest() for text in variant.source.files.values()]
        written = json.dumps([variant.written.values, dict(variant.choice), texts], sort_keys=True)
        settings = (self.intensity.kind, self.intensity.name, value, self.bearing)
        return memory.key("fragility", written, self.case.system, self.seed, settings, draws.first, draws.count)


@dataclass(slots=True)
class CurveResult:
    """The results of a fragility study so far."""

    plan: FragilityPlan
    chunks: dict[tuple[float, int], Chunk | CapacityChunk] = field(default_factory=dict)  # by value and first sample
    mistake: Diagnostic | None = None  # first error in a sample or a value
    failed: TaskResult | None = None  # first chunk that crashed or exceeded its time
    interrupted: bool = False

    @property
    def done(self) -> int:
        """Number of judged samples."""
        return sum(
            len(chunk.outcomes if isinstance(chunk, Chunk) else chunk.capacities) for chunk in self.chunks.values()
        )

    def fragility(self) -> Fragility | None:
        """Return the curve through all points whose samples are all judged; None if there are no such points."""
        plan = self.plan
        jitter = jitter_text(plan.case.timeline.jitter.values())
        terms = CurveSettings(plan.intensity, plan.seed, plan.confidence, plan.bearing, jitter)
        curve = _curve_of_capacities(self, terms) if plan.has_capacities else _curve_of_outcomes(self, terms)
        cpu_time = sum(chunk.cpu_time for chunk in self.chunks.values())
        return None if curve is None else replace(curve, name=plan.name, cpu_time=cpu_time)


def _curve_of_outcomes(result: CurveResult, terms: CurveSettings) -> Fragility | None:
    outcomes: dict[float, list[int]] = {}
    ways: dict[float, Counter[str]] = {}
    for value in result.plan.values:
        chunks = [result.chunks[value, first] for at, first in sorted(result.chunks) if at == value]
        own = [outcome for chunk in chunks if isinstance(chunk, Chunk) for outcome in chunk.outcomes]
        if len(own) == result.plan.samples:
            outcomes[value], ways[value] = own, Counter()
            for chunk in chunks:
                ways[value].update(chunk.ways)
    return curve_of_outcomes(terms, outcomes, ways) if outcomes else None


def _curve_of_capacities(result: CurveResult, terms: CurveSettings) -> Fragility | None:
    chunks = [(first, chunk) for (_, first), chunk in sorted(result.chunks.items())]
    by_number = {
        number: capacity
        for first, chunk in chunks
        if isinstance(chunk, CapacityChunk)
        for number, capacity in enumerate(chunk.capacities, start=first)
    }
    if not by_number:
        return None
    ways = Counter[str]()
    for _, chunk in chunks:
        ways.update(chunk.ways)
    capacities = list(by_number.values())
    curve = curve_of_capacities(terms, capacities, result.plan.values or _chosen(result.plan, capacities), ways)
    return replace(curve, capacities=by_number)


def _chosen(plan: FragilityPlan, capacities: Sequence[Capacity]) -> tuple[float, ...]:
    """Return intensities where the samples fall: capacities at shares with equal steps of the normal quantile.

    Each is rounded up, so that its sample falls. The interval of Clopper and Pearson also holds at such points.
    """
    intensity = plan.intensity
    ends = sorted(each.fails for each in capacities if each.survived > 0.0 and each.fails < inf)
    if not ends:
        return (0.0,)
    first, last = float(ndtri(FIRST_SHARE)), float(ndtri(LAST_SHARE))
    shares = ndtr(np.linspace(first, last, plan.points))
    chosen = (ends[ceil(share * len(ends)) - 1] for share in shares)
    shown = (intensity.shown(intensity.of_acceleration(end)) * (1.0 + ROUNDING) for end in chosen)
    return tuple(dict.fromkeys(intensity.in_si(float(rounded_up(value, DIGITS))) for value in shown))


def draw(
    plan: FragilityPlan,
    workers: int,
    memory: ResultCache,
    on_done: Callable[[int], None],
    on_wait: OnWait = lambda: None,
) -> CurveResult:
    """Judge all samples at all intensities; an interrupt keeps the finished chunks.

    `on_done` is called with the number of judged samples.
    """
    results, left = CurveResult(plan), []
    for value, draws in plan.tasks():
        record = memory.recall(plan.key(value, draws, memory))
        if isinstance(record, list):
            results.chunks[value, draws.first] = _from_record(plan, record)
        else:
            left.append((value, draws))

    def done(index: int, result: TaskResult) -> None:
        value, draws = left[index]
        if isinstance(result.value, Chunk | CapacityChunk):
            results.chunks[value, draws.first] = result.value
            memory.remember(plan.key(value, draws, memory), _as_record(result.value))
            memory.settle()
        elif isinstance(result.value, Diagnostic):
            results.mistake = results.mistake or result.value
        elif result.status is not TaskStatus.NOT_RUN:
            results.failed = results.failed or result
        on_done(results.done)

    results.interrupted = run_supervised([plan.task(*each) for each in left], workers, done, on_wait).interrupted
    return results


def _as_record(chunk: Chunk | CapacityChunk) -> object:
    rows = (
        list(chunk.outcomes)
        if isinstance(chunk, Chunk)
        else [[c.outcome, c.survived, c.fails] for c in chunk.capacities]
    )
    return [rows, chunk.ways, chunk.cpu_time]


def _from_record(plan: FragilityPlan, record: list[object]) -> Chunk | CapacityChunk:
    rows, ways, cpu_time = record
    assert isinstance(rows, list)
    assert isinstance(ways, dict)
    assert isinstance(cpu_time, float)
    if plan.has_capacities:
        return CapacityChunk(tuple(Capacity(*row) for row in rows), ways, cpu_time)
    return Chunk(tuple(rows), ways, cpu_time)
