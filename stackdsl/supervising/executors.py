"""Supervised processes as an Executor of the standard library, and supervised calls on any other Executor.

Whatever carries tasks about, a pool of processes, of threads, or a cluster, a task is done in a process that we start
and watch: what crashes, eats up memory or takes too long costs that task, and never whoever carries it.
"""

import os
import pickle
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Executor, Future
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from queue import Empty, SimpleQueue
from typing import Any, ParamSpec, TypeVar

from stackdsl.supervising.processes import LONGEST_WAIT, EnoughSeenError, OnDone, OnWait, Pool, PoolResult
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, WorkerStart, crash

TIME_LIMIT = 600.0  # [s] of wall time a call that says nothing of it

Given = ParamSpec("Given")
Made = TypeVar("Made")


class TaskFailedError(Exception):
    """A call that crashed, took its process down with it, or overran its time."""

    def __init__(self, result: TaskResult) -> None:
        super().__init__(result.message)
        self.result = result


class SupervisedExecutor(Executor):
    """An Executor of so many supervised processes; one that dies costs the call that it was at, which is told.

    Functions, arguments and results are pickled. Make it where there is but one thread, if there is such a place: its
    processes are copies of that one then, and start at once.
    """

    def __init__(self, workers: int | None = None, time_limit: float = TIME_LIMIT) -> None:
        self.workers = max(1, workers or os.cpu_count() or 1)
        self.time_limit = time_limit  # [s] of wall time a call
        self._futures: dict[int, Future[TaskResult]] = {}
        self._arriving: deque[tuple[int, Task]] = deque()
        self._lock = threading.Lock()
        self._count = 0
        self._closed = False  # nothing more is taken
        self._cancelled = False  # what waits is not begun, and what is under way is ended
        self._hears, self._tells = Pipe(duplex=False)
        self._pool = Pool(self.workers, self._done, keeps=True)
        self._pool.prepare()
        self._thread = threading.Thread(target=self._serve, name="supervisor", daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[Given, Made], /, *args: Given.args, **kwargs: Given.kwargs) -> Future[Made]:
        """The future of a call. It raises TaskFailedError where the call did not end as it should."""
        asked = Task(_called, (fn, args, kwargs), self.time_limit)
        found: Future[Made] = Future()
        self.submit_task(asked).add_done_callback(lambda done: _passed_on(done, found))
        return found

    def submit_task(self, task: Task) -> "Future[TaskResult]":
        """The future of a task, which tells how it ended, and raises nothing."""
        with self._lock:
            if self._closed:
                raise RuntimeError("this executor was shut down, and takes no more calls")
            number, future = self._count, Future[TaskResult]()
            self._count += 1
            self._futures[number] = future
            self._arriving.append((number, task))
            self._tells.send_bytes(b"more")
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more calls; wait for those there are, or end them."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._tells.send_bytes(b"end")
            self._cancelled |= cancel_futures
        if wait:
            self._thread.join()

    def _serve(self) -> None:
        try:
            while not self._cancelled and (not self._closed or self._arriving or self._pool.busy):
                self._pool.step(also=(self._hears,))
                self._take()
        finally:
            self._pool.kill()
            self._end()

    def _take(self) -> None:
        """Begin with what has arrived."""
        while self._hears.poll():
            self._hears.recv_bytes()
        while self._arriving:
            number, task = self._arriving.popleft()
            if self._futures[number].set_running_or_notify_cancel():
                self._pool.add(number, task)
            else:
                del self._futures[number]
        self._pool.fill()

    def _end(self) -> None:
        """Take no more, and leave nobody waiting."""
        with self._lock:  # whoever has it may be about to tell something
            self._closed = True
            self._hears.close()
            self._tells.close()
        for future in self._futures.values():
            if future.cancel():
                future.set_running_or_notify_cancel()
            else:  # it had begun
                future.set_result(TaskResult(TaskStatus.NOT_RUN, message="the executor was shut down"))

    def _done(self, number: int, result: TaskResult) -> None:
        self._futures.pop(number).set_result(result)


def _called(function: Callable[..., object], args: tuple[object, ...], kwargs: dict[str, object]) -> object:
    return function(*args, **kwargs)


def _passed_on(done: "Future[TaskResult]", found: "Future[Any]") -> None:
    if done.cancelled():
        found.cancel()
        found.set_running_or_notify_cancel()
    elif (result := done.result()).status is TaskStatus.DONE:
        found.set_result(result.value)
    else:
        found.set_exception(TaskFailedError(result))


def asked_of(executor: Executor, task: Task) -> "Future[TaskResult]":
    """The future of a task on any Executor, done in a supervised process wherever that carries it to.

    It raises only what befalls the executor, such as an ImportError where it has no such program.
    """
    if isinstance(executor, SupervisedExecutor):
        return executor.submit_task(task)
    return executor.submit(pickle.loads, pickle.dumps(_Carried(task)))


@dataclass(frozen=True)
class _Carried:
    """A task as bytes that do it where they are read.

    Whoever only passes them on, such as the scheduler of a cluster, needs nothing of ours for that; and where it is
    missing, this fails as the call does, and brings down nobody who takes arguments apart before.
    """

    task: Task

    def __reduce__(self) -> tuple[Callable[[Task], TaskResult], tuple[Task]]:
        return supervised, (self.task,)


def run_on(
    executor: Executor,
    tasks: Sequence[Task],
    workers: int,
    on_done: OnDone = lambda index, result: None,
    on_wait: OnWait = lambda: None,
) -> PoolResult:
    """Run all tasks on any Executor, as `run_supervised` does here; so many of them can be done at a time."""
    waiting, results = deque(enumerate(tasks)), dict[int, TaskResult]()
    under_way: dict[Future[TaskResult], int] = {}
    ended = SimpleQueue[Future[TaskResult]]()
    interrupted = False
    try:
        while waiting or under_way:
            while waiting and len(under_way) < 2 * workers:
                index, task = waiting.popleft()
                future = asked_of(executor, task)
                under_way[future] = index
                future.add_done_callback(ended.put)
            on_wait()
            with suppress(Empty):
                future = ended.get(timeout=LONGEST_WAIT)
                index = under_way.pop(future)
                results[index] = _ended(future)
                on_done(index, results[index])
    except EnoughSeenError:
        pass
    except KeyboardInterrupt:
        interrupted = True
    finally:
        for future in under_way:
            future.cancel()
    not_run = TaskResult(TaskStatus.NOT_RUN)
    return PoolResult(tuple(results.get(index, not_run) for index in range(len(tasks))), interrupted)


def _ended(future: "Future[TaskResult]") -> TaskResult:
    """What became of a task; what befalls the executor counts as a crash of it."""
    try:
        return future.result()
    except (Exception, CancelledError) as error:
        return crash(error)


_OWN = threading.local()  # the process that a thread of some executor has here
if hasattr(os, "register_at_fork"):  # not on Windows
    os.register_at_fork(after_in_child=_OWN.__dict__.clear)  # a copy of this process would share it, and both hang


def supervised(task: Task) -> TaskResult:
    """Do a task in a process that belongs to this thread, and is there for the next one."""
    pool: Pool | None = getattr(_OWN, "pool", None)
    if pool is None:
        pool = _OWN.pool = Pool(1, _nobody, WorkerStart.COPY, keeps=True)
    results: list[TaskResult] = []
    pool.on_done = lambda _, result: results.append(result)
    try:
        pool.add(0, task)
        pool.fill()
        while not results:
            pool.step()
    except BaseException:
        del _OWN.pool
        pool.kill()
        raise
    return results[0]


_nobody: OnDone = lambda number, result: None  # noqa: E731 -- its type is said
