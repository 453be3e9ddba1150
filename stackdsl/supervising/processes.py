"""Runs tasks in supervised processes: one that crashes or overruns its time is named, replaced, and costs no other.

A pool of the standard library loses all pending work when a native library brings a worker down, and cannot say which
task did it. Here each worker has a pipe of its own and one task at a time.
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

LONGEST_WAIT = 0.02  # [s] between two looks at whoever is told that we wait


@dataclass(frozen=True, slots=True)
class PoolResult:
    """The results in the order of the tasks."""

    results: tuple[TaskResult, ...]
    interrupted: bool


class EnoughSeenError(Exception):
    """Raised by a listener: what is not done yet need not be."""


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

    `on_done` hears of each as it ends, and `on_wait` is called many times a second meanwhile. An interrupt (Ctrl-C)
    ends all workers at once; what was done is returned. So does an EnoughSeenError of `on_done`.
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
    """Supervised processes, what they do, and what waits for them; whoever calls `step` again and again moves it on."""

    workers: int  # at most, at a time
    on_done: OnDone
    start: WorkerStart = WorkerStart.COPY
    keeps: bool = False  # a worker that has nothing to do, for what comes later; else it is ended
    waiting: deque[int] = field(default_factory=deque)
    busy: list[Worker] = field(default_factory=list)
    idle: list[Worker] = field(default_factory=list)
    tasks: dict[int, Task] = field(default_factory=dict)  # those that are not done, by number

    def add(self, index: int, task: Task) -> None:
        """One more task, which `fill` begins with."""
        self.tasks[index] = task
        self.waiting.append(index)

    def fill(self) -> None:
        """Begin with as many of the tasks that wait as there may be workers."""
        while self.waiting and len(self.busy) < max(1, self.workers):
            self._employ(self._idle())

    def prepare(self) -> None:
        """Start all workers before there is anything to do, if they can be copies: of others more is known later."""
        while len(self.idle) < max(1, self.workers) and self._start() is WorkerStart.COPY:
            with interrupts_held_back(WorkerStart.COPY):
                self.idle.append(Worker.started(WorkerStart.COPY, ()))

    def step(self, on_wait: OnWait = lambda: None, also: Sequence[Connection] = ()) -> None:
        """Wait a moment for a sign of a worker, or of what else is waited for, and attend to all workers."""
        soonest = min((worker.deadline for worker in self.busy), default=monotonic() + LONGEST_WAIT)
        signs = [sign for worker in self.busy for sign in (worker.connection, worker.process.sentinel)]
        wait([*signs, *also], timeout=max(0.0, min(LONGEST_WAIT, soonest - monotonic())))
        on_wait()
        for worker in tuple(self.busy):
            self._attend(worker)

    def kill(self) -> None:
        """End all workers, whatever they do."""
        for worker in (*self.busy, *self.idle):
            worker.kill()

    def _idle(self) -> Worker | None:
        """A worker that waits; one that has died meanwhile is let go, for no task is to be blamed for that."""
        while self.idle:
            worker = self.idle.pop()
            if worker.process.exitcode is None:
                return worker
            worker.kill()
        return None

    def _employ(self, worker: Worker | None) -> None:
        """Hand the next task to a worker, or to a new one; let it go if there is none."""
        while self.waiting:
            index = self.waiting.popleft()
            try:
                order = pickle.dumps((self.tasks[index].function, self.tasks[index].arguments))
            except Exception as error:  # what pickling raises depends on what is pickled
                self._close(index, crash(error))
                continue
            start = self._start()
            with interrupts_held_back(start):
                worker = worker if worker is not None else Worker.started(start, self._imported())
                worker.index = index
                worker.allow(START_LIMIT)
                self.busy.append(worker)
            # If it is dead by now, its end of the pipe says so at the next look.
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
        """How to start a worker. Whoever keeps workers may have to replace many: a process from which to copy pays."""
        start = safe(self.start)
        return WorkerStart.PREPARED if self.keeps and start is WorkerStart.NEW else start

    def _imported(self) -> Sequence[str]:
        """What processes that are started for one task each share: imports, which take longer than most tasks."""
        return sorted({task.function.__module__ for task in self.tasks.values()})

    def _attend(self, worker: Worker) -> None:
        """See what became of a worker: it may have begun, ended, died or overrun its time."""
        # Asked before the pipe: a worker that was dead by then has nothing more to say than what the pipe holds.
        dead = worker.process.exitcode is not None
        try:
            message = worker.message()
        except (EOFError, OSError):
            message, dead = None, True
        except GarbledError:
            said = "something other than its worker wrote into the worker's pipe"
            self._replace(worker, TaskResult(TaskStatus.CRASHED, message=said))
            return
        if message is not None:
            self._hear(worker, message)
        elif dead:
            # The exit code of a dying process is settled before its pipe closes, so this only ends one that lives on.
            worker.kill()
            self._replace(worker, TaskResult(TaskStatus.CRASHED, message=cause_of_death(worker.process)))
        elif monotonic() >= worker.deadline:
            self._replace(worker, TaskResult(TaskStatus.TIMED_OUT, message=f"took longer than {worker.limit:g} s"))

    def _hear(self, worker: Worker, message: bytes) -> None:
        if message == BEGUN:
            worker.allow(self.tasks[worker.index].limit)
            return
        # Still busy while the listener hears of it: if that fails, the worker must not be forgotten.
        self._close(worker.index, _received(message))
        self.busy.remove(worker)
        if self.start is WorkerStart.PREPARED:
            worker.kill()
        self._employ(None if self.start is WorkerStart.PREPARED else worker)

    def _replace(self, worker: Worker, result: TaskResult) -> None:
        worker.kill()
        self.busy.remove(worker)
        self._close(worker.index, result)
        self._employ(None)

    def _close(self, index: int, result: TaskResult) -> None:
        del self.tasks[index]
        self.on_done(index, result)


def _received(message: bytes) -> TaskResult:
    try:
        result = pickle.loads(message)
    except Exception as error:  # what unpickling raises depends on what is unpickled
        return crash(error)
    if not isinstance(result, TaskResult):
        return crash(TypeError(f"a worker sent a {type(result).__name__} in place of a result"))
    return result
