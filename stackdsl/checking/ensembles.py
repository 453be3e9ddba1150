"""Cases of many samples: drawn in chunks by the processes of a check, look by look, until all that is asked is decided.

What a chunk came to depends on nothing but its numbers, so neither the processes nor the order make a difference, and
a chunk that is remembered from a call that was interrupted need not be drawn again.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from stackdsl.checking.chunks import Chunk, judged_chunk, varied_chunk
from stackdsl.checking.gathering import Case
from stackdsl.checking.memory import Memory
from stackdsl.diagnostics import Diagnostic
from stackdsl.ensemble import Ensemble, OnDrawn, untold
from stackdsl.judging.judge import judge_shares
from stackdsl.judging.shares import Decision, looks
from stackdsl.sampling.draws import Draws
from stackdsl.sampling.fates import Fate
from stackdsl.supervising.processes import EnoughSeenError, OnDone, OnWait, PoolResult, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus

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
            stood=fates[Fate.STANDS],
            fell={level: fates[level] for level in sorted(fates) if level > 0},
            undecided=fates[Fate.UNDECIDED],
            unfit=fates[Fate.UNFIT],
            ways=dict(sorted(ways.items())),
            cpu_time=sum(chunk.cpu_time for chunk in chunks),
        )


OnEnded = Callable[[int, Drawing], None]
Run = Callable[[Sequence[Task], int, OnDone, OnWait], PoolResult]  # as `run_supervised`


def draw(  # noqa: PLR0913, PLR0917 -- how a check is carried out
    drawings: Mapping[int, Drawing],
    workers: int,
    time_limit: float,
    memory: Memory,
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
    memory = Memory(Path(), used=False)
    one = {0: Drawing(case, "")}
    interrupted = draw(
        one, workers, time_limit, memory, lambda _, drawing: ended.append(drawing), run=run, on_drawn=on_drawn
    )
    return None if interrupted else ended[0]


def _drawn(
    open_ones: Mapping[int, Drawing],
    time_limit: float,
    memory: Memory,
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


def _key(drawing: Drawing, first: int, count: int, memory: Memory) -> str:
    return memory.key("samples", drawing.case.file, drawing.digest, drawing.case.name, first, count)


def _remember(drawing: Drawing, first: int, count: int, chunk: Chunk, memory: Memory) -> None:
    if drawing.digest:
        memory.remember(_key(drawing, first, count, memory), [list(chunk.fates), chunk.ways, chunk.cpu_time])
        memory.settle()


def _recall(drawing: Drawing, memory: Memory) -> None:
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
