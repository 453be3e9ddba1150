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

from stability.notebook import Printed
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
from stackdsl.studies.sweep_rows import CSV, Counts, ParquetFolder, RowFormat, RowsError, TextRows
from stackdsl.studies.sweep_workers import Workers
from stackdsl.supervising.executors import submit_to
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, interrupts_held_back

# A running sweep: pieces go to an Executor, enough to keep it busy, and rows go to a file, in order.


FIRST: Final = 100  # samples of a piece before the time of one sample is known
MOST: Final = 20_000  # samples of a piece: more would be lost by a kill, and need more memory while they wait
WANTED: Final = 2.0  # [s] time of a piece; longer if the workers would exceed `MESSAGES`
MESSAGES: Final = 200  # per second: a scheduler and this process can handle several times as many
FRESH: Final = 0.2  # weight of the latest piece in the time of a sample
AHEAD: Final = 4  # judged pieces that may wait for earlier rows, as a multiple of the pieces under way
ATTEMPTS: Final = 3  # of an executor to finish a piece
ALONE: Final = 2  # attempts of a single sample, as its failure may be caused by another program
MOST_FAILED: Final = 100  # samples: more are no accident
LONGEST_WAIT: Final = 0.05  # [s] between two calls of `on_wait`
SAME: Final = "install the same stackdsl, Python, numpy, scipy, clarabel and engines there as here"
LOOK: Final = 5.0  # [s] between two queries of the number of workers


class SweepError(Exception):
    """A sweep cannot go on; the rows in its file are kept, and another call resumes it."""


class RowsFile(Protocol):
    """A destination of rows."""

    counts: Counts  # of all rows, those before opening included

    @property
    def form(self) -> RowFormat:
        """Text of the rows."""

    @property
    def rows(self) -> int:
        """Number of rows."""

    def write(self, lines: list[bytes]) -> None:
        """Append rows. Raises RowsError."""


@dataclass
class Piece:
    """Consecutive samples of a case, judged at once, or in parts if that fails."""

    first: int
    count: int
    parts: dict[int, JudgedSamples] = field(default_factory=dict)  # by first sample
    missing: int = field(init=False)

    def __post_init__(self) -> None:
        self.missing = self.count


@dataclass
class Lane:
    """The progress of one case."""

    index: int
    entry: PlannedCase
    next: int  # first sample that is in no piece
    form: RowFormat
    head: bytes = field(init=False)
    pieces: deque[Piece] = field(default_factory=deque)  # under way, in order
    ready: deque[tuple[bytes, RowKind]] = field(default_factory=deque)  # next rows: text after the number, and result
    cost: float | None = None  # time of a sample [s]

    def __post_init__(self) -> None:
        self.head = self.form.head_of(self.entry)

    def cut(self, wanted: float) -> Piece:
        """Return the next piece, of as many samples as take about `wanted` seconds."""
        count = FIRST if self.cost is None else int(min(MOST, wanted / max(self.cost, wanted / MOST)))
        piece = Piece(self.next, max(1, min(count, self.entry.count - self.next)))
        self.next += piece.count
        self.pieces.append(piece)
        return piece

    def done(self, piece: Piece, first: int, judged: JudgedSamples) -> int:
        """Store the results of a part of a piece, and prepare the next rows; return the number of finished pieces."""
        piece.parts[first] = judged
        piece.missing -= len(judged.which)
        if judged.cpu_time > 0.0:
            cost = judged.cpu_time / len(judged.which)
            self.cost = cost if self.cost is None else (1.0 - FRESH) * self.cost + FRESH * cost
        before = len(self.pieces)
        while self.pieces and self.pieces[0].missing == 0:
            parts = self.pieces.popleft().parts
            whole = joined([parts[first] for first in sorted(parts)]) if len(parts) > 1 else next(iter(parts.values()))
            ends = [(self.form.tail_of(kind), kind) for kind in whole.kinds]
            self.ready.extend(map(ends.__getitem__, whole.which))
        return before - len(self.pieces)


@dataclass(frozen=True, slots=True)
class Job:
    """A call of an executor."""

    lane: Lane
    piece: Piece
    first: int
    count: int
    attempt: int = 1


@dataclass
class Sweep:
    """A running sweep. It holds only rows that wait for earlier ones, and counts of all others."""

    plan: SweepPlan
    file: RowsFile
    executor: Executor
    capacity: Callable[[], int]  # number of pieces that can be judged in parallel; may change
    on_wait: Callable[[int], None] = lambda rows: None  # called many times a second with the number of rows
    _lanes: list[Lane] = field(init=False)
    _order: Iterator[tuple[int, int]] = field(init=False)
    _at: tuple[int, int] | None = field(init=False)  # sample and case of the next row
    _under_way: dict["Future[TaskResult]", Job] = field(default_factory=dict)
    _ended: "SimpleQueue[Future[TaskResult]]" = field(default_factory=SimpleQueue)
    _turns: list[tuple[int, int]] = field(init=False)  # heap of unfinished cases: next sample and case
    _ahead: int = 0  # pieces that are not done, or wait for earlier ones
    _workers: tuple[float, int] = (0.0, 0)  # time of the last query, and number of workers

    def __post_init__(self) -> None:
        sample, index = self.plan.at(self.file.rows)
        self._lanes = [
            Lane(number, entry, min(sample + (number < index), entry.count), self.file.form)
            for number, entry in enumerate(self.plan.entries)
        ]
        self._turns = [(lane.next, lane.index) for lane in self._lanes if lane.next < lane.entry.count]
        heapify(self._turns)
        self._order = self.plan.order(self.file.rows)
        self._at = next(self._order, None)

    def run(self) -> None:
        """Judge all missing samples. Raises SweepError, RowsError and interruptions; rows are kept."""
        try:
            self._refuse_more_failures()
            while self._at is not None:
                self._hand_out()
                for future in self._done():
                    self._receive(self._under_way.pop(future), future)
                self._write()
                self.on_wait(self.file.rows)
        finally:
            for future in self._under_way:
                future.cancel()

    # --- submission ---------------------------------------------------------------------------------------------------

    def _hand_out(self) -> None:
        """Submit enough pieces to keep the executor busy, but not far ahead of the written rows."""
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
            self._submit(Job(lane, piece, piece.first, piece.count))

    def _submit(self, job: Job) -> None:
        entry = job.lane.entry
        arguments = (entry.packed, job.first, job.count, entry.program)
        try:
            future = submit_to(self.executor, Task(judged_piece, arguments, self.plan.time_limit))
        except Exception as error:  # the executor was shut down, its processes died, or its cluster ended
            raise SweepError(f"the executor accepts no more work: {_text(error)}") from error
        self._under_way[future] = job
        future.add_done_callback(self._ended.put)

    def _capacity(self) -> int:
        when, count = self._workers
        if not count or monotonic() > when + LOOK:
            try:
                count = max(1, self.capacity())
            except Exception as error:  # a cluster may raise anything
                raise SweepError(f"the executor no longer answers: {_text(error)}") from error
            self._workers = (monotonic(), count)
        return count

    # --- results ------------------------------------------------------------------------------------------------------

    def _done(self) -> Iterator["Future[TaskResult]"]:
        """Yield finished futures, after a short wait for the first."""
        try:
            yield self._ended.get(timeout=LONGEST_WAIT)
            while True:
                yield self._ended.get_nowait()
        except Empty:
            return

    def _receive(self, job: Job, future: "Future[TaskResult]") -> None:
        try:
            result = future.result()
        except (Exception, CancelledError) as error:  # an executor may raise anything
            self._lost(job, error)
            return
        judged = result.value
        if isinstance(judged, OtherProgram):
            digests = f"its digest is {judged.digest[:12]}, the one here is {job.lane.entry.program[:12]}"
            raise SweepError(f"the worker on {judged.where} has a different program: {digests}; {SAME}")
        if result.status is TaskStatus.DONE and isinstance(judged, JudgedSamples):
            self._ahead -= job.lane.done(job.piece, job.first, judged)
        elif result.status is TaskStatus.NOT_RUN:
            self._lost(job, RuntimeError(result.message))
        else:
            self._failed(job, result)

    def _lost(self, job: Job, error: BaseException) -> None:
        """Submit a job again after a failure of the executor. Raises SweepError after several attempts."""
        if isinstance(error, ImportError | AttributeError):  # the worker cannot unpickle an object of this program
            raise SweepError(f"a worker has a different program: {error}; {SAME}") from error
        if job.attempt >= ATTEMPTS:
            message = f"the executor failed {ATTEMPTS} times with the same samples: {_text(error)}"
            raise SweepError(message) from error
        self._submit(Job(job.lane, job.piece, job.first, job.count, job.attempt + 1))

    def _failed(self, job: Job, result: TaskResult) -> None:
        """Find the sample that crashed its worker or exceeded the time limit, by halving the job."""
        if job.count == 1 and (job.attempt >= ALONE or not job.lane.entry.case.is_sampled):
            kind = RowKind(FAILED, None, result.message or str(result.status))
            self._ahead -= job.lane.done(job.piece, job.first, judged_as([kind], 0.0))
        elif job.count == 1:
            self._submit(Job(job.lane, job.piece, job.first, 1, job.attempt + 1))
        else:
            half = job.count // 2
            self._submit(Job(job.lane, job.piece, job.first, half))
            self._submit(Job(job.lane, job.piece, job.first + half, job.count - half))

    # --- rows ---------------------------------------------------------------------------------------------------------

    def _write(self) -> None:
        """Write all rows that have no missing row before them."""
        lines: list[bytes] = []
        fresh, at = Counts(), self._at
        while at is not None and (lane := self._lanes[at[1]]).ready:
            if len(self._lanes) == 1:  # rows of a single case are consecutive
                ends, sample = [*lane.ready], at[0]
                lane.ready.clear()
                lines = [b"%b%d%b" % (lane.head, number, tail) for number, (tail, _) in enumerate(ends, sample)]
                fresh.of.setdefault(0, Counter()).update(kind for _, kind in ends)
                at = (sample + len(ends), 0) if sample + len(ends) < lane.entry.count else None
                continue
            tail, kind = lane.ready.popleft()
            lines.append(lane.head + lane.form.number_of(lane.entry, at[0]) + tail)
            fresh.add(lane.index, kind)
            at = next(self._order, None)
        self._at = at
        if lines:
            with interrupts_held_back():  # the counts must match the written rows
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
            example = f"one of {self.plan.entries[index].name}: {kind.how}"
            raise SweepError(f"{count} samples failed, {example}; fix the cause and write to a new file")


def _text(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split()).rstrip(":")


def _fails(kind: RowKind) -> bool:
    return kind.verdict == FAILED


# A whole sweep: rows into a file, on an Executor; and its results.


FORMS: Final[dict[str, Callable[[Path, SweepPlan], TextRows | ParquetFolder]]] = {
    ".jsonl": TextRows,
    ".csv": lambda path, plan: TextRows(path, plan, CSV),
    ".parquet": ParquetFolder,
}
UNKNOWN: Final = ("undecided", "unfit", FAILED)  # verdicts of samples that may stand


@dataclass(frozen=True, slots=True)
class SweptCase(Printed):
    """The results of one case so far."""

    entry: PlannedCase
    kinds: Counter[RowKind]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.kinds.total()

    @property
    def verdicts(self) -> dict[str, int]:
        """Number of rows by verdict."""
        return self._by(lambda kind: kind.verdict)

    @property
    def ways(self) -> dict[str, int]:
        """Number of rows by kind of proof or decision."""
        return self._by(lambda kind: kind.how if kind.verdict != FAILED else "")

    @property
    def fell(self) -> dict[int, int]:
        """Number of fallen samples by the level under construction."""
        counts = Counter[int]()
        for kind, count in self.kinds.items():
            if kind.level is not None:
                counts[kind.level] += count
        return dict(sorted(counts.items()))

    @property
    def failed(self) -> dict[str, int]:
        """Number of failed samples by reason."""
        return {kind.how: count for kind, count in self.kinds.items() if kind.verdict == FAILED}

    @property
    def stands(self) -> Interval | None:
        """Confidence interval of the share that stands; None without samples."""
        if not self.entry.case.is_sampled or not self.rows:
            return None
        stood, unknown = self.verdicts.get("stands", 0), sum(self.verdicts.get(each, 0) for each in UNKNOWN)
        return interval(stood, stood + unknown, self.rows, 1.0 - self.entry.case.scenario.confidence)

    def _by(self, word: Callable[[RowKind], str]) -> dict[str, int]:
        counts = Counter[str]()
        for kind, count in self.kinds.items():
            if word(kind):
                counts[word(kind)] += count
        return dict(sorted(counts.items(), key=lambda each: (-each[1], each[0])))


def rows_file(path: Path, plan: SweepPlan) -> TextRows | ParquetFolder:
    """Open the file or folder for rows, by the suffix of the path. Raises RowsError."""
    try:
        form = FORMS[path.suffix.lower()]
    except KeyError:
        raise RowsError(
            f"{path}: the name must end in .jsonl or .csv for a file, or in .parquet for a folder"
        ) from None
    return form(path, plan)


def sweep(
    plan: SweepPlan,
    out: Path,
    workers: Callable[[], AbstractContextManager[Workers]],
    on_rows: Callable[[int], None] = lambda rows: None,
    on_counts: Callable[[Counts], None] = lambda counts: None,
) -> tuple[SweptCase, ...]:
    """Append all missing rows of a plan to a file; `on_counts` is called first with the counts of existing rows.

    Raises RowsError, SweepError, and any error of `workers`. Written rows are kept in any case.
    """
    with rows_file(out, plan) as file:
        on_counts(file.counts)
        if file.rows < plan.total:
            with workers() as pool:
                Sweep(plan, file, pool.executor, pool.capacity, on_rows).run()
    return swept_cases(plan, file.counts)


def swept_cases(plan: SweepPlan, counts: Counts) -> tuple[SweptCase, ...]:
    """Return the results of each case."""
    return tuple(SweptCase(entry, counts.of.get(index, Counter())) for index, entry in enumerate(plan.entries))
