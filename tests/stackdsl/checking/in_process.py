"""Tasks of a pool done here one after the other, for tests that ask what becomes of results, and not of processes."""

from collections.abc import Sequence

from stackdsl.supervising.processes import EnoughSeenError, OnDone, OnWait, PoolResult
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus


def run_here(tasks: Sequence[Task], _workers: int, on_done: OnDone, _on_wait: OnWait) -> PoolResult:
    """As `run_supervised`, without the half second that each process takes to start beside threads of a test runner."""
    results: list[TaskResult] = []
    try:
        for index, task in enumerate(tasks):
            results.append(TaskResult(TaskStatus.DONE, task.function(*task.arguments)))
            on_done(index, results[-1])
    except EnoughSeenError:
        pass
    not_run = [TaskResult(TaskStatus.NOT_RUN)] * (len(tasks) - len(results))
    return PoolResult((*results, *not_run), interrupted=False)
