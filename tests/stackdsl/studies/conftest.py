"""Sweeps whose calls are done in this process, unless a test asks for others."""

import pytest

from stackdsl.supervising import executors
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, crash


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tasks of executors that are not ours are done where they arrive, without a supervised process for each."""

    def done(task: Task) -> TaskResult:
        try:
            return TaskResult(TaskStatus.DONE, task.function(*task.arguments))
        except Exception as error:
            return crash(error)

    done.__module__, done.__qualname__ = executors.__name__, "supervised"  # it is pickled by name
    monkeypatch.setattr(executors, "supervised", done)
