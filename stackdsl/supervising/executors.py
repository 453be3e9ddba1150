"""Supervised processes as an Executor of the standard library, and supervised calls on any other Executor.

On any executor, whether of processes, of threads or of a cluster, each task runs in a process that this module starts
and supervises. A task that crashes, exhausts memory or takes too long never harms the executor.
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

TIME_LIMIT = 600.0  # [s] of wall time per call, by default

Given = ParamSpec("Given")
Made = TypeVar("Made")


class TaskFailedError(Exception):
    """A call raised an error, killed its process, or exceeded its time limit."""

    def __init__(self, result: TaskResult) -> None:
        super().__init__(result.message)
        self.result = result


class SupervisedExecutor(Executor):
    """An Executor of supervised processes. If a process dies, only the future of its current call gets the error.

    Functions, arguments and results are pickled. Create it while the program has only one thread, if possible: its
    processes are then copies of this process, which start fastest.
    """

    def __init__(self, workers: int | None = None, time_limit: float = TIME_LIMIT) -> None:
        self.workers = max(1, workers or os.cpu_count() or 1)
        self.time_limit = time_limit  # [s] of wall time per call
        self._futures: dict[int, Future[TaskResult]] = {}
        self._arriving: deque[tuple[int, Task]] = deque()
        self._lock = threading.Lock()
        self._count = 0
        self._closed = False  # refuses further calls
        self._cancelled = False  # drops waiting calls and kills running ones
        self._signal_in, self._signal_out = Pipe(duplex=False)  # wakes the thread of the pool
        self._pool = Pool(self.workers, self._done, keeps=True)
        self._pool.prepare()
        self._thread = threading.Thread(target=self._serve, name="supervisor", daemon=True)
        self._thread.start()

    def submit(self, fn: Callable[Given, Made], /, *args: Given.args, **kwargs: Given.kwargs) -> Future[Made]:
        """Return the future of a call, which raises TaskFailedError if the call fails."""
        task = Task(_called, (fn, args, kwargs), self.time_limit)
        future: Future[Made] = Future()
        self.submit_task(task).add_done_callback(lambda done: _copy_result(done, future))
        return future

    def submit_task(self, task: Task) -> "Future[TaskResult]":
        """Return the future of a task, whose result says how the task ended; the future raises no errors."""
        with self._lock:
            if self._closed:
                raise RuntimeError("the executor is shut down, and accepts no more calls")
            number, future = self._count, Future[TaskResult]()
            self._count += 1
            self._futures[number] = future
            self._arriving.append((number, task))
            self._signal_out.send_bytes(b"more")
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Refuse further calls; wait for the submitted ones, or cancel them."""
        with self._lock:
            if not self._closed:
                self._closed = True
                self._signal_out.send_bytes(b"end")
            self._cancelled |= cancel_futures
        if wait:
            self._thread.join()

    def _serve(self) -> None:
        try:
            while not self._cancelled and (not self._closed or self._arriving or self._pool.busy):
                self._pool.step(also=(self._signal_in,))
                self._take()
        finally:
            self._pool.kill()
            self._end()

    def _take(self) -> None:
        """Start the submitted tasks, as far as workers are free."""
        while self._signal_in.poll():
            self._signal_in.recv_bytes()
        while self._arriving:
            number, task = self._arriving.popleft()
            if self._futures[number].set_running_or_notify_cancel():
                self._pool.add(number, task)
            else:
                del self._futures[number]
        self._pool.fill()

    def _end(self) -> None:
        """Refuse further calls, and set a result for every future."""
        with self._lock:  # `submit_task` may be about to use the pipe
            self._closed = True
            self._signal_in.close()
            self._signal_out.close()
        for future in self._futures.values():
            if future.cancel():
                future.set_running_or_notify_cancel()
            else:  # it was running
                future.set_result(TaskResult(TaskStatus.NOT_RUN, message="the executor was shut down"))

    def _done(self, number: int, result: TaskResult) -> None:
        self._futures.pop(number).set_result(result)


def _called(function: Callable[..., object], args: tuple[object, ...], kwargs: dict[str, object]) -> object:
    return function(*args, **kwargs)


def _copy_result(done: "Future[TaskResult]", future: "Future[Any]") -> None:
    if done.cancelled():
        future.cancel()
        future.set_running_or_notify_cancel()
    elif (result := done.result()).status is TaskStatus.DONE:
        future.set_result(result.value)
    else:
        future.set_exception(TaskFailedError(result))


def submit_to(executor: Executor, task: Task) -> "Future[TaskResult]":
    """Submit a task to any Executor; it runs in a supervised process on the machine of the executor.

    The future raises only errors of the executor, such as an ImportError if StackDSL is not installed there.
    """
    if isinstance(executor, SupervisedExecutor):
        return executor.submit_task(task)
    return executor.submit(pickle.loads, pickle.dumps(_RunWhenUnpickled(task)))


@dataclass(frozen=True)
class _RunWhenUnpickled:
    """A task whose pickle runs the task when it is loaded, and gives its result.

    Processes that only pass the bytes on, such as the scheduler of a cluster, need no StackDSL. If the worker lacks it,
    the call fails there, and no process fails earlier while unpickling arguments.
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
    """Run all tasks on any Executor with this number of workers, like `run_supervised` on this machine."""
    waiting, results = deque(enumerate(tasks)), dict[int, TaskResult]()
    running: dict[Future[TaskResult], int] = {}
    ended = SimpleQueue[Future[TaskResult]]()
    interrupted = False
    try:
        while waiting or running:
            while waiting and len(running) < 2 * workers:
                index, task = waiting.popleft()
                future = submit_to(executor, task)
                running[future] = index
                future.add_done_callback(ended.put)
            on_wait()
            with suppress(Empty):
                future = ended.get(timeout=LONGEST_WAIT)
                index = running.pop(future)
                results[index] = _ended(future)
                on_done(index, results[index])
    except EnoughSeenError:
        pass
    except KeyboardInterrupt:
        interrupted = True
    finally:
        for future in running:
            future.cancel()
    not_run = TaskResult(TaskStatus.NOT_RUN)
    return PoolResult(tuple(results.get(index, not_run) for index in range(len(tasks))), interrupted)


def _ended(future: "Future[TaskResult]") -> TaskResult:
    """Return the result of a future; an error of the executor counts as a crash of the task."""
    try:
        return future.result()
    except (Exception, CancelledError) as error:
        return crash(error)


_OWN = threading.local()  # the pool of one process of each thread
if hasattr(os, "register_at_fork"):  # not on Windows
    os.register_at_fork(after_in_child=_OWN.__dict__.clear)  # two processes that share a worker would both hang


def supervised(task: Task, on_wait: Callable[[], None] = lambda: None) -> TaskResult:
    """Run a task in a process that belongs to this thread and stays for its next task.

    `on_wait` is called from time to time until the task is done.
    """
    pool: Pool | None = getattr(_OWN, "pool", None)
    if pool is None:
        pool = _OWN.pool = Pool(1, _no_listener, WorkerStart.COPY, keeps=True)
    results: list[TaskResult] = []
    pool.on_done = lambda _, result: results.append(result)
    try:
        pool.add(0, task)
        pool.fill()
        while not results:
            pool.step()
            on_wait()
    except BaseException:
        del _OWN.pool
        pool.kill()
        raise
    return results[0]


_no_listener: OnDone = lambda number, result: None  # noqa: E731 -- the annotation checks its type
