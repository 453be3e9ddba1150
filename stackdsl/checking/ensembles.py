"""Plays cases of many samples in chunks, until every claim is decided, and judges the counts."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from time import process_time

from stability.problem import Placed
from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import STDIN_SHOWN, Case
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import Goldens, checked, compare_with_golden
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.snapshot import current_stamp, snapshot_of_samples
from stackdsl.judging.judge import judge_shares
from stackdsl.judging.statistics import Decision, looks
from stackdsl.language.variants import Variant
from stackdsl.results import RunStatus, VariantResult
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import SampleOutcome, sample_outcomes_of
from stackdsl.sampling.samples import (
    AS_WRITTEN,
    BuildPlan,
    Draws,
    InvalidSampleError,
    Setting,
    build_plan_of,
    timelines,
)
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.supervising.executors import run_on
from stackdsl.supervising.processes import EnoughSeenError, OnDone, OnWait, PoolResult, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import Cost, Ensemble, OnDrawn, Trace, ignore_progress

# Judges a chunk of the samples of one case, in a worker.


PLAYED = "played"  # method of systems that prove nothing


@dataclass(frozen=True, slots=True)
class Chunk:
    """The outcomes of consecutive samples (see `SampleOutcome`), and how many each method decided."""

    outcomes: tuple[int, ...]
    ways: dict[str, int]
    cpu_time: float  # [s]


def varied_chunk(variant: Variant, system: str, draws: Draws, setting: Setting = AS_WRITTEN) -> Chunk | Diagnostic:
    """Judge samples with a timeline each, since values of the scenario vary; or return the mistake of a sample."""
    started = process_time()
    try:
        samples = [
            judged_chunk(timeline, system, replace(draws, first=number, count=1))
            for number, timeline in enumerate(timelines(variant, draws, setting), start=draws.first)
        ]
    except InvalidSampleError as error:
        return error.mistake
    ways = Counter[str]()
    for sample in samples:
        ways.update(sample.ways)
    return Chunk(tuple(sample.outcomes[0] for sample in samples), dict(ways), process_time() - started)


def judged_chunk(timeline: Timeline, system: str, draws: Draws) -> Chunk:
    """Judge samples of one timeline with placement errors; by statics alone if the system is proven."""
    started = process_time()
    judged = judged_each(build_plan_of(timeline), timeline, system, draws)
    ways = Counter(method for _, method in judged if method)
    return Chunk(tuple(outcome for outcome, _ in judged), dict(ways), process_time() - started)


def judged_each(design: BuildPlan, timeline: Timeline, system: str, draws: Draws) -> list[tuple[int, str]]:
    """Return the outcome and the deciding method of each sample; "" for a sample that needed none."""
    if system_named(system).method is Method.PROVEN:
        outcomes = sample_outcomes_of(design, draws)
        return [
            (outcome, str(method or ""))
            for outcome, method in zip(outcomes.values.tolist(), outcomes.ways, strict=True)
        ]
    hands = PlacementSampler(design, draws).build()
    return [
        (_played(timeline, hands.placed(sample), system), PLAYED)
        if hands.fits[sample]
        else (int(SampleOutcome.UNFIT), "")
        for sample in range(draws.count)
    ]


def _played(timeline: Timeline, placed: Sequence[Placed], system: str) -> int:
    """Play one sample on an engine until it falls, and return its outcome."""
    poses = {each.brick.id: each.pose for each in placed}
    actions = tuple(
        replace(action, pose=poses[action.brick.id]) if isinstance(action, Placement) else action
        for action in timeline.actions
    )
    sample = replace(timeline, actions=actions, jitter={}, aftermath=False, margins=(), reported_margins=(), tests=())
    try:
        trace = play_case(sample, system, has_fallen)
    except BlockedPlacementError:  # a brick moved into the place, but not far enough to count as a fall
        return int(SampleOutcome.UNDECIDED)
    return trace.collapse.level if trace.collapse is not None else int(SampleOutcome.STANDS)


def has_fallen(trace: Trace) -> bool:
    """Whether the outcome of a sample is known."""
    return trace.collapse is not None


# Sampled cases. Supervised processes draw their samples in chunks, up to one interim look after the other, until every
# claim is decided.
#
# A chunk depends only on its sample numbers. So the number of processes and the order of chunks change nothing, and the
# cached chunks of an interrupted check remain valid.


CHUNK = 500  # samples; larger chunks are hardly cheaper per sample


@dataclass
class Drawing:
    """The samples of one case drawn so far."""

    case: Case
    digest: str  # of the inputs of the case; "" to cache nothing
    chunks: dict[int, Chunk] = field(default_factory=dict)  # by the number of the first sample
    failed: TaskResult | None = None  # of a chunk that crashed or overran its time
    at: int = 0  # index of the next look

    @property
    def planned(self) -> int:
        """The largest number of samples."""
        return self.case.scenario.samples or 0

    @property
    def drawn(self) -> int:
        """The number of samples drawn so far."""
        return sum(len(chunk.outcomes) for chunk in self.chunks.values())

    def due(self) -> list[tuple[int, int]]:
        """Return the missing chunks of the next look, each by its first sample number and its size."""
        ends = looks(self.planned)
        cuts = sorted({*ends, *range(0, self.planned, CHUNK)})  # every look is at the end of a chunk
        parts = [(first, last - first) for first, last in zip([0, *cuts], [*cuts, self.planned], strict=True)]
        return [part for part in parts if part[1] and part[0] < ends[self.at] and part[0] not in self.chunks]

    def look(self) -> bool:
        """Return whether the case is finished: decided, or completely drawn; advance to the next look otherwise."""
        ends = looks(self.planned)
        if self.at + 1 == len(ends) or self._is_decided():
            return True
        self.at += 1
        return False

    def _is_decided(self) -> bool:
        case = self.case
        *_, decisions = judge_shares(self.ensemble(), case.scenario, case.variant, case.source, case.system)
        return bool(decisions) and Decision.OPEN not in decisions

    def ensemble(self) -> Ensemble:
        """Return the counts of outcomes up to the next look."""
        chunks = [chunk for first, chunk in self.chunks.items() if first < looks(self.planned)[self.at]]
        counts = Counter(outcome for chunk in chunks for outcome in chunk.outcomes)
        methods = Counter[str]()
        for chunk in chunks:
            methods.update(chunk.ways)
        return Ensemble(
            drawn=sum(counts.values()),
            planned=self.planned,
            seed=self.case.scenario.seed,
            stood=counts[SampleOutcome.STANDS],
            fell={level: counts[level] for level in sorted(counts) if level > 0},
            undecided=counts[SampleOutcome.UNDECIDED],
            unfit=counts[SampleOutcome.UNFIT],
            ways=dict(sorted(methods.items())),
            cpu_time=sum(chunk.cpu_time for chunk in chunks),
        )


OnEnded = Callable[[int, Drawing], None]
Run = Callable[[Sequence[Task], int, OnDone, OnWait], PoolResult]  # as `run_supervised`


def draw(  # noqa: PLR0913, PLR0917 -- how a check is carried out
    drawings: Mapping[int, Drawing],
    workers: int,
    time_limit: float,
    memory: ResultCache,
    on_ended: OnEnded,
    on_wait: OnWait = lambda: None,
    run: Run = run_supervised,
    on_drawn: OnDrawn = ignore_progress,
) -> bool:
    """Draw the samples of all cases until each is decided; return whether it was interrupted.

    `on_ended` is called with each finished case and may raise EnoughSeenError to stop. `run` runs the tasks, by default
    in supervised processes. `on_drawn` is called when a case begins, and after each chunk.
    """
    undecided = dict(drawings)
    for drawing in undecided.values():
        _recall(drawing, memory)
        on_drawn(drawing.case.name, drawing.drawn, drawing.planned)
    try:
        while undecided:
            for number, drawing in list(undecided.items()):
                while not drawing.due() and drawing.failed is None and not drawing.look():
                    pass
                if drawing.failed is not None or not drawing.due():
                    del undecided[number]
                    on_ended(number, drawing)
            if _drawn(undecided, time_limit, memory, lambda tasks, done: run(tasks, workers, done, on_wait), on_drawn):
                return True
    except EnoughSeenError:
        pass
    return False


def draw_samples(
    case: Case, workers: int, time_limit: float, run: Run = run_supervised, on_drawn: OnDrawn = ignore_progress
) -> Drawing | None:
    """Draw the samples of one case without the cache; return None if it was interrupted."""
    ended: list[Drawing] = []
    memory = ResultCache(Path(), used=False)
    drawings = {0: Drawing(case, "")}
    interrupted = draw(
        drawings, workers, time_limit, memory, lambda _, drawing: ended.append(drawing), run=run, on_drawn=on_drawn
    )
    return None if interrupted else ended[0]


def _drawn(
    undecided: Mapping[int, Drawing],
    time_limit: float,
    memory: ResultCache,
    run: Callable[[Sequence[Task], OnDone], PoolResult],
    on_drawn: OnDrawn,
) -> bool:
    """Draw the chunks of the next look of each case; return whether it was interrupted."""
    parts = [(drawing, *part) for drawing in undecided.values() for part in drawing.due()]

    def done(index: int, result: TaskResult) -> None:
        drawing, first, count = parts[index]
        if isinstance(result.value, Chunk):
            drawing.chunks[first] = result.value
            _remember(drawing, first, count, result.value, memory)
            on_drawn(drawing.case.name, drawing.drawn, drawing.planned)
        elif result.status is not TaskStatus.NOT_RUN:
            drawing.failed = result

    tasks = [Task(*_call(drawing, first, count), time_limit) for drawing, first, count in parts]
    return run(tasks, done).interrupted if tasks else False


def _call(drawing: Drawing, first: int, count: int) -> tuple[Callable[..., Chunk | Diagnostic], tuple[object, ...]]:
    """Return the function that judges a chunk in a worker, and its arguments."""
    case = drawing.case
    draws = Draws(case.scenario.seed, case.scenario.scenario, first, count)
    if case.scenario.uncertain is not None:
        return varied_chunk, (case.variant, case.system, draws)
    return judged_chunk, (case.timeline, case.system, draws)


def _key(drawing: Drawing, first: int, count: int, memory: ResultCache) -> str:
    return memory.key("samples", drawing.case.file, drawing.digest, drawing.case.name, first, count)


def _remember(drawing: Drawing, first: int, count: int, chunk: Chunk, memory: ResultCache) -> None:
    if drawing.digest:
        memory.remember(_key(drawing, first, count, memory), [list(chunk.outcomes), chunk.ways, chunk.cpu_time])
        memory.settle()


def _recall(drawing: Drawing, memory: ResultCache) -> None:
    """Add the chunks that are in the cache."""
    if not drawing.digest:
        return
    look, drawing.at = drawing.at, len(looks(drawing.planned)) - 1
    for first, count in drawing.due():
        record = memory.recall(_key(drawing, first, count, memory))
        if isinstance(record, list):
            outcomes, methods, cpu_time = record
            drawing.chunks[first] = Chunk(tuple(outcomes), dict(methods), cpu_time)
    drawing.at = look


# Judges a sampled case and compares its counts with its golden file.


TIME_LIMIT = 600.0  # [s] of wall time per chunk of samples
NO_GOLDENS = Goldens(None)


def sampled_result(
    case: Case,
    workers: int,
    goldens: Goldens = NO_GOLDENS,
    executor: Executor | None = None,
    on_drawn: OnDrawn = ignore_progress,
) -> VariantResult:
    """Draw samples of a case until it is decided, here or on an executor with this many workers, and judge it.

    Raises KeyboardInterrupt if it is interrupted.
    """
    run = partial(run_on, executor) if executor else run_supervised
    drawing = draw_samples(case, workers, TIME_LIMIT, run, on_drawn)
    if drawing is None:
        raise KeyboardInterrupt
    if drawing.failed is not None:
        return checked(case, drawing.failed, NO_GOLDENS)
    return checked_samples(case, drawing.ensemble(), goldens)


def checked_samples(case: Case, ensemble: Ensemble, goldens: Goldens, must_claim: bool = False) -> VariantResult:
    """Return the result of a sampled case: expectations, truths, and the comparison with its golden file.

    With `must_claim`, a case without claims fails.
    """
    result = replace(judged_samples(case, ensemble), must_claim=must_claim)
    proven = system_named(case.system).method is Method.PROVEN  # counts of an engine are not locked
    if goldens.folder is None or not proven or case.file == STDIN_SHOWN:
        return result
    snapshot = snapshot_of_samples(ensemble, case.timeline.world, case.identity, current_stamp("", 0))
    return replace(result, golden=compare_with_golden(snapshot, goldens, case.source.file, result))


def judged_samples(case: Case, ensemble: Ensemble) -> VariantResult:
    """Return the result of a sampled case without the comparison with its golden file."""
    outcomes, truths, _ = judge_shares(ensemble, case.scenario, case.variant, case.source, case.system)
    xfail = case.scenario.xfail
    marked = xfail is not None and xfail.is_of(case.system)
    result = VariantResult(case.identity.scenario, case.identity.variant, case.system, case.file, RunStatus.DONE)
    return replace(
        result,
        xfail=xfail.reason if xfail is not None and marked else None,
        strict=xfail is not None and marked and xfail.strict,
        verdict=ensemble.summary,
        ensemble=ensemble,
        warnings=case.source.warnings,
        cost=Cost(wall_time=ensemble.cpu_time, simulated_time=0.0, steps=0, judgements=ensemble.drawn),
        outcomes=outcomes,
        truths=truths,
        parameters=case.parameters,
    )
