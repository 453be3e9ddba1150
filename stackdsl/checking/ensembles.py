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
    SampleMistakeError,
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
from stackdsl.trace import Cost, Ensemble, OnDrawn, Trace, untold

# A chunk of the samples of one case: what a worker does.


PLAYED = "played"  # the way of systems that prove nothing


@dataclass(frozen=True, slots=True)
class Chunk:
    """What became of some samples, in order of their numbers: see `SampleOutcome`; and how many each way decided."""

    fates: tuple[int, ...]
    ways: dict[str, int]
    cpu_time: float  # [s]


def varied_chunk(variant: Variant, system: str, draws: Draws, setting: Setting = AS_WRITTEN) -> Chunk | Diagnostic:
    """What a worker does where more than hands is uncertain: judge each sample by itself; or what one has mistaken."""
    started = process_time()
    try:
        each = [
            judged_chunk(timeline, system, replace(draws, first=number, count=1))
            for number, timeline in enumerate(timelines(variant, draws, setting), start=draws.first)
        ]
    except SampleMistakeError as error:
        return error.mistake
    ways = Counter[str]()
    for one in each:
        ways.update(one.ways)
    return Chunk(tuple(one.fates[0] for one in each), dict(ways), process_time() - started)


def judged_chunk(timeline: Timeline, system: str, draws: Draws) -> Chunk:
    """What a worker does: judge some samples, by statics alone where the system proves."""
    started = process_time()
    each = judged_each(build_plan_of(timeline), timeline, system, draws)
    ways = Counter(way for _, way in each if way)
    return Chunk(tuple(fate for fate, _ in each), dict(ways), process_time() - started)


def judged_each(design: BuildPlan, timeline: Timeline, system: str, draws: Draws) -> list[tuple[int, str]]:
    """The fate of each of some samples, and the way that decided it; no way where there was nothing to judge."""
    if system_named(system).method is Method.PROVEN:
        found = sample_outcomes_of(design, draws)
        return [(fate, str(way or "")) for fate, way in zip(found.fates.tolist(), found.ways, strict=True)]
    hands = PlacementSampler(design, draws).build()
    return [
        (_played(timeline, hands.placed(sample), system), PLAYED)
        if hands.fits[sample]
        else (int(SampleOutcome.UNFIT), "")
        for sample in range(draws.count)
    ]


def _played(timeline: Timeline, placed: Sequence[Placed], system: str) -> int:
    """The fate of one sample on an engine, which is followed until it falls."""
    poses = {each.brick.id: each.pose for each in placed}
    actions = tuple(
        replace(action, pose=poses[action.brick.id]) if isinstance(action, Placement) else action
        for action in timeline.actions
    )
    sample = replace(timeline, actions=actions, jitter={}, aftermath=False, margins=(), told_margins=())
    try:
        trace = play_case(sample, system, has_fallen)
    except BlockedPlacementError:  # something had moved, and not as far as counts as fallen
        return int(SampleOutcome.UNDECIDED)
    return trace.collapse.level if trace.collapse is not None else int(SampleOutcome.STANDS)


def has_fallen(trace: Trace) -> bool:
    """Whether all is known of a sample."""
    return trace.collapse is not None


# Cases of many samples: drawn in chunks by the processes of a check, look by look, until all that is asked is decided.
#
# What a chunk came to depends on nothing but its numbers, so neither the processes nor the order make a difference, and
# a chunk that is remembered from a call that was interrupted need not be drawn again.


CHUNK = 500  # samples; so many are judged together about as cheaply as any number


@dataclass
class Drawing:
    """The samples of one case so far."""

    case: Case
    digest: str  # of the text that the case came from; empty where nothing may be remembered
    chunks: dict[int, Chunk] = field(default_factory=dict)  # by the number of the first sample
    failed: TaskResult | None = None  # of a chunk that crashed or overran its time
    at: int = 0  # the look that is due

    @property
    def planned(self) -> int:
        """How many samples there may be."""
        return self.case.scenario.samples or 0

    @property
    def drawn(self) -> int:
        """How many there are."""
        return sum(len(chunk.fates) for chunk in self.chunks.values())

    def due(self) -> list[tuple[int, int]]:
        """The chunks that the next look needs and that are not there: the number of the first sample, and how many."""
        ends = looks(self.planned)
        cuts = sorted({*ends, *range(0, self.planned, CHUNK)})  # so that no chunk is cut by a look
        parts = [(first, last - first) for first, last in zip([0, *cuts], [*cuts, self.planned], strict=True)]
        return [part for part in parts if part[1] and part[0] < ends[self.at] and part[0] not in self.chunks]

    def look(self) -> bool:
        """Whether all is decided, or drawn; else the next look is due."""
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
        """What became of the samples up to the look that is due."""
        chunks = [chunk for first, chunk in self.chunks.items() if first < looks(self.planned)[self.at]]
        fates = Counter(fate for chunk in chunks for fate in chunk.fates)
        ways = Counter[str]()
        for chunk in chunks:
            ways.update(chunk.ways)
        return Ensemble(
            drawn=sum(fates.values()),
            planned=self.planned,
            seed=self.case.scenario.seed,
            stood=fates[SampleOutcome.STANDS],
            fell={level: fates[level] for level in sorted(fates) if level > 0},
            undecided=fates[SampleOutcome.UNDECIDED],
            unfit=fates[SampleOutcome.UNFIT],
            ways=dict(sorted(ways.items())),
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
    on_drawn: OnDrawn = untold,
) -> bool:
    """Draw all samples that are needed, and tell of each case as it ends; whether it was interrupted.

    `on_ended` may raise EnoughSeenError: then no more is drawn. `run` does the tasks, by default processes of ours.
    `on_drawn` hears of each case as it begins, and with each chunk.
    """
    open_ones = dict(drawings)
    for drawing in open_ones.values():
        _recall(drawing, memory)
        on_drawn(drawing.case.name, drawing.drawn, drawing.planned)
    try:
        while open_ones:
            for number, drawing in list(open_ones.items()):
                while not drawing.due() and drawing.failed is None and not drawing.look():
                    pass
                if drawing.failed is not None or not drawing.due():
                    del open_ones[number]
                    on_ended(number, drawing)
            if _drawn(open_ones, time_limit, memory, lambda tasks, done: run(tasks, workers, done, on_wait), on_drawn):
                return True
    except EnoughSeenError:
        pass
    return False


def drawn_alone(
    case: Case, workers: int, time_limit: float, run: Run = run_supervised, on_drawn: OnDrawn = untold
) -> Drawing | None:
    """The samples of one case, of which nothing is remembered; None if it was interrupted."""
    ended: list[Drawing] = []
    memory = ResultCache(Path(), used=False)
    one = {0: Drawing(case, "")}
    interrupted = draw(
        one, workers, time_limit, memory, lambda _, drawing: ended.append(drawing), run=run, on_drawn=on_drawn
    )
    return None if interrupted else ended[0]


def _drawn(
    open_ones: Mapping[int, Drawing],
    time_limit: float,
    memory: ResultCache,
    run: Callable[[Sequence[Task], OnDone], PoolResult],
    on_drawn: OnDrawn,
) -> bool:
    """Draw what the next look of each case needs; whether it was interrupted."""
    parts = [(drawing, *part) for drawing in open_ones.values() for part in drawing.due()]

    def done(index: int, result: TaskResult) -> None:
        drawing, first, count = parts[index]
        if isinstance(result.value, Chunk):
            drawing.chunks[first] = result.value
            _remember(drawing, first, count, result.value, memory)
            on_drawn(drawing.case.name, drawing.drawn, drawing.planned)
        elif result.status is not TaskStatus.NOT_RUN:
            drawing.failed = result

    tasks = [Task(*_asked(drawing, first, count), time_limit) for drawing, first, count in parts]
    return run(tasks, done).interrupted if tasks else False


def _asked(drawing: Drawing, first: int, count: int) -> tuple[Callable[..., Chunk | Diagnostic], tuple[object, ...]]:
    """What a worker is to call, and with what."""
    case = drawing.case
    draws = Draws(case.scenario.seed, case.scenario.scenario, first, count)
    if case.scenario.uncertain is not None:
        return varied_chunk, (case.variant, case.system, draws)
    return judged_chunk, (case.timeline, case.system, draws)


def _key(drawing: Drawing, first: int, count: int, memory: ResultCache) -> str:
    return memory.key("samples", drawing.case.file, drawing.digest, drawing.case.name, first, count)


def _remember(drawing: Drawing, first: int, count: int, chunk: Chunk, memory: ResultCache) -> None:
    if drawing.digest:
        memory.remember(_key(drawing, first, count, memory), [list(chunk.fates), chunk.ways, chunk.cpu_time])
        memory.settle()


def _recall(drawing: Drawing, memory: ResultCache) -> None:
    """Take over the chunks that are remembered."""
    if not drawing.digest:
        return
    was, drawing.at = drawing.at, len(looks(drawing.planned)) - 1
    for first, count in drawing.due():
        found = memory.recall(_key(drawing, first, count, memory))
        if isinstance(found, list):
            fates, ways, cpu_time = found
            drawing.chunks[first] = Chunk(tuple(fates), dict(ways), cpu_time)
    drawing.at = was


# Judges a case of many samples and compares its counts with its golden file.


TIME_LIMIT = 600.0  # [s] of wall time a chunk of samples
NO_GOLDENS = Goldens(None)


def drawn_result(
    case: Case,
    workers: int,
    goldens: Goldens = NO_GOLDENS,
    executor: Executor | None = None,
    on_drawn: OnDrawn = untold,
) -> VariantResult:
    """Draw the samples of a case, as many as decide: here, or on an executor that does so many calls at a time.

    Raises KeyboardInterrupt where somebody interrupts that.
    """
    run = partial(run_on, executor) if executor else run_supervised
    drawing = drawn_alone(case, workers, TIME_LIMIT, run, on_drawn)
    if drawing is None:
        raise KeyboardInterrupt
    if drawing.failed is not None:
        return checked(case, drawing.failed, NO_GOLDENS)
    return checked_samples(case, drawing.ensemble(), goldens)


def checked_samples(case: Case, ensemble: Ensemble, goldens: Goldens, must_claim: bool = False) -> VariantResult:
    """The result of a case of many samples: expectations, truths, and the comparison with its golden file.

    With `must_claim` it is a failure if nothing is expected of the case.
    """
    result = replace(judged_samples(case, ensemble), must_claim=must_claim)
    proven = system_named(case.system).method is Method.PROVEN  # what an engine makes of samples is its own affair
    if goldens.folder is None or not proven or case.file == STDIN_SHOWN:
        return result
    snapshot = snapshot_of_samples(ensemble, case.timeline.world, case.identity, current_stamp("", 0))
    return replace(result, golden=compare_with_golden(snapshot, goldens, case.source.file, result))


def judged_samples(case: Case, ensemble: Ensemble) -> VariantResult:
    """The result of a case of many samples, without its golden file."""
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
