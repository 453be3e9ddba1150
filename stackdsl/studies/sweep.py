"""Runs a sweep on an Executor and writes its rows in order."""

from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from heapq import heapify, heappop, heapreplace
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Final, Protocol

from stackdsl.judging.statistics import Interval, interval
from stackdsl.studies.sweep_plan import (
    FAILED,
    JudgedSamples,
    OtherProgram,
    PlannedCase,
    RowKind,
    SweepPlan,
    joined,
    judged_as,
    judged_piece,
)
from stackdsl.studies.sweep_rows import Counts, JsonLines, ParquetFolder, RowsError, head_of, number_of, tail_of
from stackdsl.studies.sweep_workers import Workers
from stackdsl.supervising.executors import asked_of
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, interrupts_held_back

# A sweep under way: pieces go to an Executor, as many at a time as keep it busy, and rows to a file, in order.


FIRST: Final = 100  # samples of the pieces that go out before it is known what one takes
MOST: Final = 20_000  # samples of a piece: more would be lost by a kill, and take more memory where they are waited for
WANTED: Final = 2.0  # [s] of a piece, or longer where so many workers would send more messages than these
MESSAGES: Final = 200  # a second: a scheduler, and this process, can do some times as many
FRESH: Final = 0.2  # how much the latest piece counts in what a sample takes
AHEAD: Final = 4  # times what is under way may be judged, and wait for a row before theirs
ATTEMPTS: Final = 3  # that an executor has to carry a piece to an end
ALONE: Final = 2  # that a sample by itself has: what brings it down may be somebody else's doing
MOST_FAILED: Final = 100  # samples: more are no accident
LONGEST_WAIT: Final = 0.05  # [s] between two looks at whoever is told that we wait
SAME: Final = "install the same stackdsl, Python, numpy, scipy, clarabel and engines there as here"
LOOK: Final = 5.0  # [s] between two looks at how many workers there are


class SweepError(Exception):
    """A sweep that cannot go on; what is in its file is kept, and is gone on with by calling it again."""


class RowsFile(Protocol):
    """Where rows go."""

    counts: Counts  # of what was there on opening, to which is added what is written

    @property
    def rows(self) -> int:
        """How many there are."""

    def write(self, lines: list[bytes]) -> None:
        """Add some. Raises RowsError."""


@dataclass
class Piece:
    """Some samples of a case that follow each other, judged at once, or in parts where that fails."""

    first: int
    count: int
    parts: dict[int, JudgedSamples] = field(default_factory=dict)  # by their first sample
    missing: int = field(init=False)

    def __post_init__(self) -> None:
        self.missing = self.count


@dataclass
class Lane:
    """The rows of one case."""

    index: int
    entry: PlannedCase
    next: int  # the first sample that is in no piece
    head: bytes = field(init=False)
    pieces: deque[Piece] = field(default_factory=deque)  # under way, in their order
    ready: deque[tuple[bytes, RowKind]] = field(default_factory=deque)  # of the rows that come next: how each ends
    cost: float | None = None  # [s] that a sample takes

    def __post_init__(self) -> None:
        self.head = head_of(self.entry)

    def cut(self, wanted: float) -> Piece:
        """The next piece: so many samples as take about so long [s]."""
        count = FIRST if self.cost is None else int(min(MOST, wanted / max(self.cost, wanted / MOST)))
        piece = Piece(self.next, max(1, min(count, self.entry.count - self.next)))
        self.next += piece.count
        self.pieces.append(piece)
        return piece

    def done(self, piece: Piece, first: int, judged: JudgedSamples) -> int:
        """Keep what became of a part of a piece, and get ready what comes next; how many pieces are done by that."""
        piece.parts[first] = judged
        piece.missing -= len(judged.which)
        if judged.cpu_time > 0.0:
            cost = judged.cpu_time / len(judged.which)
            self.cost = cost if self.cost is None else (1.0 - FRESH) * self.cost + FRESH * cost
        before = len(self.pieces)
        while self.pieces and self.pieces[0].missing == 0:
            parts = self.pieces.popleft().parts
            whole = joined([parts[first] for first in sorted(parts)]) if len(parts) > 1 else next(iter(parts.values()))
            ends = [(tail_of(kind), kind) for kind in whole.kinds]
            self.ready.extend(map(ends.__getitem__, whole.which))
        return before - len(self.pieces)


@dataclass(frozen=True, slots=True)
class Order:
    """What an executor was asked for."""

    lane: Lane
    piece: Piece
    first: int
    count: int
    attempt: int = 1


@dataclass
class Sweep:
    """Pieces under way, and rows that wait for those before them; this process holds counts, and no rows else."""

    plan: SweepPlan
    file: RowsFile
    executor: Executor
    capacity: Callable[[], int]  # how many pieces can be judged at a time; may change
    on_wait: Callable[[int], None] = lambda rows: None  # called many times a second with the number of rows
    _lanes: list[Lane] = field(init=False)
    _order: Iterator[tuple[int, int]] = field(init=False)
    _at: tuple[int, int] | None = field(init=False)  # the sample and the case of the next row
    _under_way: dict["Future[TaskResult]", Order] = field(default_factory=dict)
    _ended: "SimpleQueue[Future[TaskResult]]" = field(default_factory=SimpleQueue)
    _turns: list[tuple[int, int]] = field(
        init=False
    )  # a heap: the next sample of each case that has more, and the case
    _ahead: int = 0  # pieces that are not done, or wait for those before them
    _workers: tuple[float, int] = (0.0, 0)  # how many there are, and when that was asked

    def __post_init__(self) -> None:
        sample, index = self.plan.at(self.file.rows)
        self._lanes = [
            Lane(number, entry, min(sample + (number < index), entry.count))
            for number, entry in enumerate(self.plan.entries)
        ]
        self._turns = [(lane.next, lane.index) for lane in self._lanes if lane.next < lane.entry.count]
        heapify(self._turns)
        self._order = self.plan.order(self.file.rows)
        self._at = next(self._order, None)

    def run(self) -> None:
        """Judge all that is not there. Raises SweepError, RowsError, and what interrupts it; rows are kept."""
        try:
            self._refuse_more_failures()
            while self._at is not None:
                self._hand_out()
                for future in self._done():
                    self._hear(self._under_way.pop(future), future)
                self._write()
                self.on_wait(self.file.rows)
        finally:
            for future in self._under_way:
                future.cancel()

    # --- what goes out ------------------------------------------------------------------------------------------------

    def _hand_out(self) -> None:
        """Keep the executor busy, but do not run far ahead of what is written."""
        workers = self._capacity()
        most, wanted = 2 * workers, max(WANTED, workers / MESSAGES)
        while self._turns and len(self._under_way) < most and self._ahead < AHEAD * most:
            _, index = self._turns[0]
            lane = self._lanes[index]
            piece = lane.cut(wanted)
            self._ahead += 1
            if lane.next < lane.entry.count:
                heapreplace(self._turns, (lane.next, index))
            else:
                heappop(self._turns)
            self._ask(Order(lane, piece, piece.first, piece.count))

    def _ask(self, order: Order) -> None:
        entry = order.lane.entry
        arguments = (entry.packed, order.first, order.count, entry.program)
        try:
            future = asked_of(self.executor, Task(judged_piece, arguments, self.plan.time_limit))
        except Exception as error:  # it was shut down, its processes have died, or its cluster has gone
            raise SweepError(f"the executor takes no more work: {_what(error)}") from error
        self._under_way[future] = order
        future.add_done_callback(self._ended.put)

    def _capacity(self) -> int:
        when, count = self._workers
        if not count or monotonic() > when + LOOK:
            try:
                count = max(1, self.capacity())
            except Exception as error:  # whatever its cluster makes of its own troubles
                raise SweepError(f"the executor no longer answers: {_what(error)}") from error
            self._workers = (monotonic(), count)
        return count

    # --- what comes back ----------------------------------------------------------------------------------------------

    def _done(self) -> Iterator["Future[TaskResult]"]:
        """The futures that have ended, at least one if that does not take too long."""
        try:
            yield self._ended.get(timeout=LONGEST_WAIT)
            while True:
                yield self._ended.get_nowait()
        except Empty:
            return

    def _hear(self, order: Order, future: "Future[TaskResult]") -> None:
        try:
            result = future.result()
        except (Exception, CancelledError) as error:  # whatever the executor makes of its own troubles
            self._lost(order, error)
            return
        judged = result.value
        if isinstance(judged, OtherProgram):
            told = f"it has the digest {judged.digest[:12]}, and this one {order.lane.entry.program[:12]}"
            raise SweepError(f"the worker on {judged.where} has another program: {told}; {SAME}")
        if result.status is TaskStatus.DONE and isinstance(judged, JudgedSamples):
            self._ahead -= order.lane.done(order.piece, order.first, judged)
        elif result.status is TaskStatus.NOT_RUN:
            self._lost(order, RuntimeError(result.message))
        else:
            self._failed(order, result)

    def _lost(self, order: Order, error: BaseException) -> None:
        """Nothing is known of the samples: whoever was to carry them out has failed."""
        if isinstance(error, ImportError | AttributeError):  # so says Python of what is missing in what it is to read
            raise SweepError(f"a worker has another program: {error}; {SAME}") from error
        if order.attempt >= ATTEMPTS:
            told = f"the executor failed {ATTEMPTS} times with the same samples: {_what(error)}"
            raise SweepError(told) from error
        self._ask(Order(order.lane, order.piece, order.first, order.count, order.attempt + 1))

    def _failed(self, order: Order, result: TaskResult) -> None:
        """Some sample brings down what judges it, or takes too long: find out which."""
        if order.count == 1 and (order.attempt >= ALONE or not order.lane.entry.case.is_sampled):
            kind = RowKind(FAILED, None, result.message or str(result.status))
            self._ahead -= order.lane.done(order.piece, order.first, judged_as([kind], 0.0))
        elif order.count == 1:
            self._ask(Order(order.lane, order.piece, order.first, 1, order.attempt + 1))
        else:
            half = order.count // 2
            self._ask(Order(order.lane, order.piece, order.first, half))
            self._ask(Order(order.lane, order.piece, order.first + half, order.count - half))

    # --- what is written ----------------------------------------------------------------------------------------------

    def _write(self) -> None:
        """Write all rows whose turn it is."""
        lines: list[bytes] = []
        fresh, at = Counts(), self._at
        while at is not None and (lane := self._lanes[at[1]]).ready:
            if len(self._lanes) == 1:  # no other case's rows come between
                ends, sample = [*lane.ready], at[0]
                lane.ready.clear()
                lines = [b"%b%d%b" % (lane.head, number, tail) for number, (tail, _) in enumerate(ends, sample)]
                fresh.of.setdefault(0, Counter()).update(kind for _, kind in ends)
                at = (sample + len(ends), 0) if sample + len(ends) < lane.entry.count else None
                continue
            tail, kind = lane.ready.popleft()
            lines.append(lane.head + number_of(lane.entry, at[0]) + tail)
            fresh.add(lane.index, kind)
            at = next(self._order, None)
        self._at = at
        if lines:
            with interrupts_held_back():  # what is told of rows is to be what is there
                self.file.write(lines)
                self.file.counts.merge(fresh)
            self._refuse_more_failures()

    def _refuse_more_failures(self) -> None:
        failed = [
            (index, kind, n) for index, of in self.file.counts.of.items() for kind, n in of.items() if _fails(kind)
        ]
        count = sum(n for *_, n in failed)
        if count > MOST_FAILED:
            index, kind, _ = failed[0]
            told = f"of {self.plan.entries[index].name}: {kind.how}"
            raise SweepError(f"{count} samples failed, which is no accident; one {told}; mend that and write anew")


def _what(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split()).rstrip(":")


def _fails(kind: RowKind) -> bool:
    return kind.verdict == FAILED


# A whole sweep: rows into a file, on whatever Executor there is; and what came of it.


FORMS: Final[dict[str, type[JsonLines | ParquetFolder]]] = {
    ".jsonl": JsonLines,
    ".parquet": ParquetFolder,
}
UNKNOWN: Final = ("undecided", "unfit", FAILED)  # verdicts of samples that may have stood


@dataclass(frozen=True, slots=True)
class SweptCase:
    """What became of the samples of one case so far, or of the case that has none."""

    entry: PlannedCase
    kinds: Counter[RowKind]

    @property
    def rows(self) -> int:
        """How many there are."""
        return self.kinds.total()

    @property
    def verdicts(self) -> dict[str, int]:
        """How many rows have each verdict."""
        return self._by(lambda kind: kind.verdict)

    @property
    def ways(self) -> dict[str, int]:
        """How many rows each way decided."""
        return self._by(lambda kind: kind.how if kind.verdict != FAILED else "")

    @property
    def fell(self) -> dict[int, int]:
        """How many fell, by the level under construction."""
        found = Counter[int]()
        for kind, count in self.kinds.items():
            if kind.level is not None:
                found[kind.level] += count
        return dict(sorted(found.items()))

    @property
    def failed(self) -> dict[str, int]:
        """How many brought down what judged them, and why."""
        return {kind.how: count for kind, count in self.kinds.items() if kind.verdict == FAILED}

    @property
    def stands(self) -> Interval | None:
        """Between which the share that stands lies, as sure as the scenario says; None of what has no samples."""
        if not self.entry.case.is_sampled or not self.rows:
            return None
        stood, unknown = self.verdicts.get("stands", 0), sum(self.verdicts.get(each, 0) for each in UNKNOWN)
        return interval(stood, stood + unknown, self.rows, 1.0 - self.entry.case.scenario.confidence)

    def _by(self, word: Callable[[RowKind], str]) -> dict[str, int]:
        found = Counter[str]()
        for kind, count in self.kinds.items():
            if word(kind):
                found[word(kind)] += count
        return dict(sorted(found.items(), key=lambda each: (-each[1], each[0])))


def rows_file(path: Path, plan: SweepPlan) -> JsonLines | ParquetFolder:
    """Where the rows go, by the ending of the path. Raises RowsError."""
    try:
        form = FORMS[path.suffix.lower()]
    except KeyError:
        raise RowsError(f"{path}: write to a file that ends in .jsonl, or to a folder that ends in .parquet") from None
    return form(path, plan)


def sweep(
    plan: SweepPlan,
    out: Path,
    workers: Callable[[], AbstractContextManager[Workers]],
    on_rows: Callable[[int], None] = lambda rows: None,
    on_counts: Callable[[Counts], None] = lambda counts: None,
) -> tuple[SweptCase, ...]:
    """Bring all rows of a plan into a file, those that lack there; `on_counts` is told what is there before it begins.

    Raises RowsError and SweepError, and whatever `workers` raises. However it ends, rows that are there are kept.
    """
    with rows_file(out, plan) as file:
        on_counts(file.counts)
        if file.rows < plan.total:
            with workers() as those:
                Sweep(plan, file, those.executor, those.capacity, on_rows).run()
    return told(plan, file.counts)


def told(plan: SweepPlan, counts: Counts) -> tuple[SweptCase, ...]:
    """What became of each case."""
    return tuple(SweptCase(entry, counts.of.get(index, Counter())) for index, entry in enumerate(plan.entries))
