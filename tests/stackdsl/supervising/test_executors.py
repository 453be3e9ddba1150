"""Supervised processes are an Executor like any other, and what any other does is done in supervised processes."""

import multiprocessing
import os
import signal
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import pytest

from stackdsl.supervising.executors import SupervisedExecutor, TaskFailedError, run_on, submit_to, supervised
from stackdsl.supervising.processes import EnoughSeenError, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from tests.command_line import AMPLE

pytestmark = pytest.mark.usefixtures("interruptible")


def square(number: int, plus: int = 0) -> int:
    return number * number + plus


def segfault() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def stumble() -> None:
    raise ValueError("no such brick")


def process_id() -> int:
    return os.getpid()


def wait_for(file: Path) -> None:
    while not file.exists():
        pass


@pytest.fixture(scope="module")
def processes() -> Iterator[SupervisedExecutor]:
    with SupervisedExecutor(1, time_limit=AMPLE) as executor:
        yield executor


@pytest.fixture(scope="module")
def threads() -> Iterator[Executor]:
    with ThreadPoolExecutor(1) as executor:
        yield executor


def test_calls_come_to_what_they_would_here(processes: SupervisedExecutor) -> None:
    assert processes.submit(square, 7, plus=1).result() == 50
    assert [*processes.map(square, range(4))] == [0, 1, 4, 9]
    assert processes.submit(process_id).result() not in {os.getpid(), None}


def test_a_call_that_brings_its_process_down_is_told_and_costs_no_other(processes: SupervisedExecutor) -> None:
    crashed, sound = processes.submit(segfault), processes.submit(square, 3)
    with pytest.raises(TaskFailedError, match="the worker was killed by SIGSEGV"):
        crashed.result()
    assert sound.result() == 9
    with pytest.raises(TaskFailedError, match="ValueError: no such brick"):
        processes.submit(stumble).result()


def test_what_waits_can_be_cancelled_and_what_is_done_cannot(processes: SupervisedExecutor, tmp_path: Path) -> None:
    busy, waiting = processes.submit(wait_for, tmp_path / "go"), processes.submit_task(Task(square, (2,), AMPLE))
    last = processes.submit(square, 3)
    if not waiting.cancel():  # it counts as begun once the executor has seen it
        assert waiting.running()
    (tmp_path / "go").touch()
    assert busy.result() is None
    assert last.result() == 9
    assert not last.cancel()


def test_once_shut_down_it_takes_no_more_and_ends_what_is_under_way(tmp_path: Path) -> None:
    executor = SupervisedExecutor(1)
    under_way = [executor.submit_task(Task(wait_for, (tmp_path / "never",), AMPLE)) for _ in range(2)]
    executor.shutdown(cancel_futures=True)
    assert all(future.cancelled() or future.result().status is TaskStatus.NOT_RUN for future in under_way)
    with pytest.raises(RuntimeError, match="is shut down"):
        executor.submit(square, 2)


def test_on_any_executor_a_thread_has_a_process_of_its_own_that_it_keeps_and_replaces(threads: Executor) -> None:
    def asked(function: object) -> TaskResult:
        assert callable(function)
        return submit_to(threads, Task(function, (), AMPLE)).result()

    first, again = asked(process_id), asked(process_id)
    assert first.value == again.value != os.getpid()
    assert asked(segfault).message == "the worker was killed by SIGSEGV"
    assert asked(process_id).value not in {first.value, os.getpid()}


def test_tasks_on_an_executor_end_as_they_do_in_processes_of_ours(threads: Executor) -> None:
    tasks = [Task(square, (number,), AMPLE) for number in range(5)] + [Task(stumble, (), AMPLE)]
    heard: list[int] = []
    found = run_on(threads, tasks, 1, lambda index, _: heard.append(index))
    assert sorted(heard) == [*range(6)]
    assert [(each.status, each.value, each.message) for each in found.results] == [
        (each.status, each.value, each.message) for each in run_supervised(tasks, 1).results
    ]

    def enough(index: int, result: TaskResult) -> None:
        raise EnoughSeenError

    statuses = [each.status for each in run_on(threads, tasks, 1, enough).results]
    assert statuses.count(TaskStatus.NOT_RUN) == 5
    assert not run_on(threads, tasks, 1, enough).interrupted


class Loses(Executor):
    def submit(self, fn: object, /, *args: object, **kwargs: object) -> "Future[TaskResult]":  # type: ignore[override]
        future: Future[TaskResult] = Future()
        future.set_exception(OSError("the network is down"))
        return future


def test_what_befalls_an_executor_is_told_as_a_crash_of_the_task() -> None:
    (result,) = run_on(Loses(), [Task(square, (2,), AMPLE)], 1).results
    assert (result.status, result.message) == (TaskStatus.CRASHED, "OSError: the network is down")


def test_a_process_that_is_a_daemon_as_workers_of_dask_are_may_have_supervised_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = multiprocessing.current_process()
    own.daemon = True
    try:
        (result,) = run_supervised([Task(square, (2,), AMPLE)], 1).results
        assert own.daemon
    finally:
        own.daemon = False
    assert result.value == 4


@pytest.mark.skipif(not hasattr(os, "fork"), reason="a system without fork")
def test_a_copy_of_a_process_has_a_supervised_process_of_its_own() -> None:
    """That of its parent answers whoever reads first, and another one would wait for ever."""
    assert supervised(Task(square, (2,), AMPLE)).value == 4
    hears, tells = multiprocessing.Pipe(duplex=False)
    if not (child := os.fork()):
        with suppress(BaseException):
            tells.send(supervised(Task(square, (3,), AMPLE)).value)
        os._exit(0)
    assert hears.poll(AMPLE)
    assert hears.recv() == 9
    os.waitpid(child, 0)
    assert supervised(Task(square, (4,), AMPLE)).value == 16
