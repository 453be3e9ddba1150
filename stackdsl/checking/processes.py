"""Runs tasks in supervised processes: one that crashes or overruns its time is named, replaced, and costs no other.

A pool of the standard library loses all pending work when a native library brings a worker down, and cannot say which
task did it. Here each worker has a pipe of its own and one task at a time.
"""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import StrEnum
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from time import monotonic

INTERRUPTS = (signal.SIGINT, signal.SIGTERM)  # what a listener may turn into KeyboardInterrupt
BEGUN = b"begun"  # a worker's word that it has all it needs and calls the function now
START_LIMIT = 120.0  # [s] for a worker to start and import what a task needs, before the task's own limit counts


@dataclass(frozen=True, slots=True)
class Task:
    """A call to be made in another process."""

    function: Callable[..., object]  # importable by name, as pickle needs it
    arguments: tuple[object, ...]  # picklable
    limit: float  # [s] of wall time


class TaskStatus(StrEnum):
    """How a task ended."""

    DONE = "done"
    CRASHED = "crashed"  # it raised, or took its worker down with it
    TIMED_OUT = "timed out"
    NOT_RUN = "not run"  # the pool was interrupted before it ended


@dataclass(frozen=True, slots=True)
class TaskResult:
    """What became of a task."""

    status: TaskStatus
    value: object = None  # what the function returned
    message: str = ""  # why it did not
    details: str = ""  # the traceback, where there is one


@dataclass(frozen=True, slots=True)
class PoolResult:
    """The results in the order of the tasks."""

    results: tuple[TaskResult, ...]
    interrupted: bool


OnDone = Callable[[int, TaskResult], None]


def run_supervised(
    tasks: Sequence[Task], workers: int, on_done: OnDone = lambda index, result: None, fresh: bool = False
) -> PoolResult:
    """Run all tasks in at most `workers` processes at a time; `on_done` hears of each as it ends.

    An interrupt (Ctrl-C) ends all workers at once; what was done is returned. With `fresh`, each task has a process
    that did nothing before but import what functions of tasks are in.
    """
    pool = _Pool(tasks, on_done, fresh)
    try:
        pool.run(workers)
        return PoolResult(pool.in_order(), interrupted=False)
    except KeyboardInterrupt:
        return PoolResult(pool.in_order(), interrupted=True)
    finally:
        pool.kill()


@dataclass
class _Worker:
    process: BaseProcess
    connection: Connection
    index: int = -1  # of the task in hand
    limit: float = START_LIMIT  # [s]
    deadline: float = 0.0  # by the monotonic clock [s]

    @classmethod
    def started(cls, imported: Sequence[str] | None = None) -> "_Worker":
        """A new worker; one that is to have imported some modules comes from a process that did no more than that."""
        ours, theirs = multiprocessing.Pipe()
        process: BaseProcess
        if imported is None:
            process = multiprocessing.get_context("spawn").Process(target=_serve, args=(theirs,), daemon=True)
        else:
            context = multiprocessing.get_context("forkserver")
            context.set_forkserver_preload([*imported])
            process = context.Process(target=_serve, args=(theirs,), daemon=True)
        process.start()
        # As long as this end is open here, the death of the worker would not end the stream.
        theirs.close()
        return cls(process, ours)

    def allow(self, limit: float) -> None:
        """Give it so much time [s] from now."""
        self.limit, self.deadline = limit, monotonic() + limit

    def kill(self) -> None:
        """End it, whatever it does; all that was wanted of it has been received."""
        self.process.kill()
        self.process.join()
        self.connection.close()


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Put off INTERRUPTS to the end; a process started meanwhile gets none, from its first instruction on.

    Ctrl-C reaches the whole process group. A process inherits what is blocked, as it would what is ignored, but what is
    ignored would be lost here. Another thread may take what this one blocks, hence the handler.
    """
    if threading.current_thread() is not threading.main_thread():  # interrupts are not for this one
        yield
        return
    resource_tracker.ensure_running()  # else starting a process would start it, which lets interrupts through again
    pressed: list[int] = []
    handlers = {number: signal.signal(number, lambda number, _: pressed.append(number)) for number in INTERRUPTS}
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for caught in pressed:
            signal.raise_signal(caught)


@dataclass
class _Pool:
    tasks: Sequence[Task]
    on_done: OnDone
    fresh: bool = False
    waiting: list[int] = field(init=False)  # the next one last
    busy: list[_Worker] = field(default_factory=list)
    results: dict[int, TaskResult] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.waiting = list(reversed(range(len(self.tasks))))

    def run(self, workers: int) -> None:
        for _ in range(min(max(1, workers), len(self.tasks))):
            self._employ(None)
        while self.busy:
            soonest = min(worker.deadline for worker in self.busy)
            signs = [sign for worker in self.busy for sign in (worker.connection, worker.process.sentinel)]
            wait(signs, timeout=max(0.0, soonest - monotonic()))
            for worker in tuple(self.busy):
                self._attend(worker)

    def in_order(self) -> tuple[TaskResult, ...]:
        not_run = TaskResult(TaskStatus.NOT_RUN)
        return tuple(self.results.get(index, not_run) for index in range(len(self.tasks)))

    def kill(self) -> None:
        for worker in self.busy:
            worker.kill()

    def _employ(self, worker: _Worker | None) -> None:
        """Hand the next task to a worker, or to a new one; end it if there is none."""
        while self.waiting:
            index = self.waiting.pop()
            try:
                order = pickle.dumps((self.tasks[index].function, self.tasks[index].arguments))
            except Exception as error:  # what pickling raises depends on what is pickled
                self._close(index, _crash(error))
                continue
            with _interrupts_held_back():
                worker = worker if worker is not None else _Worker.started(self._imported())
                worker.index = index
                worker.allow(START_LIMIT)
                self.busy.append(worker)
            # If it is dead by now, its end of the pipe says so at the next look.
            with suppress(OSError):
                worker.connection.send_bytes(order)
            return
        if worker is not None:
            worker.kill()

    def _imported(self) -> Sequence[str] | None:
        """What processes that are started for one task each share: imports, which take longer than most tasks."""
        return sorted({task.function.__module__ for task in self.tasks}) if self.fresh else None

    def _attend(self, worker: _Worker) -> None:
        """See what became of a worker: it may have begun, ended, died or overrun its time."""
        # Asked before the pipe: a worker that was dead by then has nothing more to say than what the pipe holds.
        dead = worker.process.exitcode is not None
        try:
            message = worker.connection.recv_bytes() if worker.connection.poll() else None
        except (EOFError, OSError):
            message, dead = None, True
        if message is not None:
            self._hear(worker, message)
        elif dead:
            # The exit code of a dying process is settled before its pipe closes, so this only ends one that lives on.
            worker.kill()
            self._replace(worker, TaskResult(TaskStatus.CRASHED, message=_cause_of_death(worker.process)))
        elif monotonic() >= worker.deadline:
            self._replace(worker, TaskResult(TaskStatus.TIMED_OUT, message=f"took longer than {worker.limit:g} s"))

    def _hear(self, worker: _Worker, message: bytes) -> None:
        if message == BEGUN:
            worker.allow(self.tasks[worker.index].limit)
            return
        # Still busy while the listener hears of it: if that fails, the worker must not be forgotten.
        self._close(worker.index, _received(message))
        self.busy.remove(worker)
        if self.fresh:
            worker.kill()
        self._employ(None if self.fresh else worker)

    def _replace(self, worker: _Worker, result: TaskResult) -> None:
        worker.kill()
        self.busy.remove(worker)
        self._close(worker.index, result)
        self._employ(None)

    def _close(self, index: int, result: TaskResult) -> None:
        self.results[index] = result
        self.on_done(index, result)


def _received(message: bytes) -> TaskResult:
    try:
        result = pickle.loads(message)
    except Exception as error:  # what unpickling raises depends on what is unpickled
        return _crash(error)
    assert isinstance(result, TaskResult)
    return result


def _crash(error: BaseException) -> TaskResult:
    message = traceback.format_exception_only(error)[-1].strip()
    return TaskResult(TaskStatus.CRASHED, message=message, details="".join(traceback.format_exception(error)))


def _cause_of_death(process: BaseProcess) -> str:
    code = process.exitcode or 0
    if code >= 0:
        return f"the worker exited with code {code}"
    try:
        return f"the worker was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was killed by signal {-code}"


def _serve(connection: Connection) -> None:
    """What a worker does: one order after the other, until nobody is left to give any."""
    # The parent decides what Ctrl-C means; held back so far, it would stay so in whatever a task starts.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, INTERRUPTS)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _keep_off_stdout()
    with suppress(EOFError, OSError):
        while True:
            order = connection.recv_bytes()
            connection.send_bytes(_carry_out(order, lambda: connection.send_bytes(BEGUN)))


def _end_with_parent() -> None:
    """A parent that is killed ends nobody, and a task in hand may take long: nobody is left to want its result."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _keep_off_stdout() -> None:
    """Native libraries chatter on descriptor 1, where the parent writes its report; prints of Python go to stderr."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = sys.stderr


def _carry_out(order: bytes, tell_begun: Callable[[], None]) -> bytes:
    try:
        function, arguments = pickle.loads(order)
        tell_begun()
        return pickle.dumps(TaskResult(TaskStatus.DONE, function(*arguments)))
    except BaseException as error:  # a task that exits Python ends itself, not its worker
        return pickle.dumps(_crash(error))
