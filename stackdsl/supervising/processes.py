"""Runs tasks in supervised processes: a process that crashes or exceeds its time is replaced, and its task is named.

A pool of the standard library loses all pending work when a native library kills a worker, and cannot name the guilty
task. Here each worker has a pipe of its own and one task at a time.
"""

import pickle
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from time import monotonic

from stackdsl.supervising.worker import (
    BEGUN,
    START_LIMIT,
    GarbledError,
    Task,
    TaskResult,
    TaskStatus,
    Worker,
    WorkerStart,
    cause_of_death,
    crash,
    interrupts_held_back,
    safe,
)

LONGEST_WAIT = 0.02  # [s] between two calls of `on_wait`


@dataclass(frozen=True, slots=True)
class PoolResult:
    """The results in the order of the tasks."""

    results: tuple[TaskResult, ...]
    interrupted: bool


class EnoughSeenError(Exception):
    """Raised by a listener to cancel the remaining tasks."""


OnDone = Callable[[int, TaskResult], None]
OnWait = Callable[[], None]


def run_supervised(
    tasks: Sequence[Task],
    workers: int,
    on_done: OnDone = lambda index, result: None,
    on_wait: OnWait = lambda: None,
    start: WorkerStart = WorkerStart.COPY,
) -> PoolResult:
    """Run all tasks in at most `workers` processes at a time.

    `on_done` is called with each result, and `on_wait` many times per second. An interrupt (Ctrl-C), or an
    EnoughSeenError of `on_done`, kills all workers; the results so far are returned.
    """
    results: dict[int, TaskResult] = {}

    def done(index: int, result: TaskResult) -> None:
        results[index] = result
        on_done(index, result)

    pool, interrupted = Pool(workers, done, start), False
    try:
        for index, task in enumerate(tasks):
            pool.add(index, task)
        pool.fill()
        while pool.busy:
            pool.step(on_wait)
    except EnoughSeenError:
        pass
    except KeyboardInterrupt:
        interrupted = True
    finally:
        pool.kill()
    not_run = TaskResult(TaskStatus.NOT_RUN)
    return PoolResult(tuple(results.get(index, not_run) for index in range(len(tasks))), interrupted)


@dataclass
class Pool:
    """Supervised processes, their tasks, and the waiting tasks; it advances when its owner calls `step`."""

    workers: int  # largest number at a time
    on_done: OnDone
    start: WorkerStart = WorkerStart.COPY
    keeps: bool = False  # whether idle workers stay for later tasks
    waiting: deque[int] = field(default_factory=deque)
    busy: list[Worker] = field(default_factory=list)
    idle: list[Worker] = field(default_factory=list)
    tasks: dict[int, Task] = field(default_factory=dict)  # waiting and running tasks, by index

    def add(self, index: int, task: Task) -> None:
        """Add a task, which `fill` starts."""
        self.tasks[index] = task
        self.waiting.append(index)

    def fill(self) -> None:
        """Start waiting tasks, as many as there may be workers."""
        while self.waiting and len(self.busy) < max(1, self.workers):
            self._employ(self._idle())

    def prepare(self) -> None:
        """Start all workers in advance if they are copies; other workers need the modules of their tasks."""
        while len(self.idle) < max(1, self.workers) and self._start() is WorkerStart.COPY:
            with interrupts_held_back(WorkerStart.COPY):
                self.idle.append(Worker.started(WorkerStart.COPY, ()))

    def step(self, on_wait: OnWait = lambda: None, also: Sequence[Connection] = ()) -> None:
        """Wait briefly for a message or the death of a worker, or for the pipes in `also`; then check all workers."""
        soonest = min((worker.deadline for worker in self.busy), default=monotonic() + LONGEST_WAIT)
        sources = [source for worker in self.busy for source in (worker.connection, worker.process.sentinel)]
        wait([*sources, *also], timeout=max(0.0, min(LONGEST_WAIT, soonest - monotonic())))
        on_wait()
        for worker in tuple(self.busy):
            self._check_worker(worker)

    def kill(self) -> None:
        """Kill all workers."""
        for worker in (*self.busy, *self.idle):
            worker.kill()

    def _idle(self) -> Worker | None:
        """Take an idle worker; drop those that have died, which is the fault of no task."""
        while self.idle:
            worker = self.idle.pop()
            if worker.process.exitcode is None:
                return worker
            worker.kill()
        return None

    def _employ(self, worker: Worker | None) -> None:
        """Give the next task to the worker, or to a new one if it is None; keep or kill it if no task waits."""
        while self.waiting:
            index = self.waiting.popleft()
            try:
                order = pickle.dumps((self.tasks[index].function, self.tasks[index].arguments))
            except Exception as error:  # pickling may raise any error of the objects
                self._report(index, crash(error))
                continue
            start = self._start()
            with interrupts_held_back(start):
                worker = worker if worker is not None else Worker.started(start, self._imported())
                worker.index = index
                worker.allow(START_LIMIT)
                self.busy.append(worker)
            # If the worker is dead by now, the next `step` detects it.
            with suppress(OSError):
                worker.order(order)
            return
        if worker is None:
            return
        if self.keeps:
            self.idle.append(worker)
        else:
            worker.kill()

    def _start(self) -> WorkerStart:
        """Return how to start a worker; for kept workers that cannot be copies, a prepared process saves time."""
        start = safe(self.start)
        return WorkerStart.PREPARED if self.keeps and start is WorkerStart.NEW else start

    def _imported(self) -> Sequence[str]:
        """Return the modules of all tasks; a prepared process imports them once, which takes longer than most tasks."""
        return sorted({task.function.__module__ for task in self.tasks.values()})

    def _check_worker(self, worker: Worker) -> None:
        """Handle the state of a worker: its task began or ended, it died, or it exceeded its time limit."""
        # Check for death before reading the pipe: a worker that was dead then sends nothing later.
        dead = worker.process.exitcode is not None
        try:
            message = worker.message()
        except (EOFError, OSError):
            message, dead = None, True
        except GarbledError:
            garbled = "the pipe of the worker contains bytes that the worker did not write"
            self._replace(worker, TaskResult(TaskStatus.CRASHED, message=garbled))
            return
        if message is not None:
            self._handle_message(worker, message)
        elif dead:
            # A dying process has its exit code before its pipe closes, so this kills only a process that lives on.
            worker.kill()
            self._replace(worker, TaskResult(TaskStatus.CRASHED, message=cause_of_death(worker.process)))
        elif monotonic() >= worker.deadline:
            self._replace(worker, TaskResult(TaskStatus.TIMED_OUT, message=f"took longer than {worker.limit:g} s"))

    def _handle_message(self, worker: Worker, message: bytes) -> None:
        if message == BEGUN:
            worker.allow(self.tasks[worker.index].limit)
            return
        # Keep the worker among the busy ones during `on_done`: if that raises an error, `kill` must find the worker.
        self._report(worker.index, _received(message))
        self.busy.remove(worker)
        if self.start is WorkerStart.PREPARED:
            worker.kill()
        self._employ(None if self.start is WorkerStart.PREPARED else worker)

    def _replace(self, worker: Worker, result: TaskResult) -> None:
        worker.kill()
        self.busy.remove(worker)
        self._report(worker.index, result)
        self._employ(None)

    def _report(self, index: int, result: TaskResult) -> None:
        del self.tasks[index]
        self.on_done(index, result)


def _received(message: bytes) -> TaskResult:
    try:
        result = pickle.loads(message)
    except Exception as error:  # unpickling may raise any error of the objects
        return crash(error)
    if not isinstance(result, TaskResult):
        return crash(TypeError(f"a worker sent a {type(result).__name__} instead of a result"))
    return result
