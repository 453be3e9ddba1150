"""What does the work of a sweep."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass

from stackdsl.supervising.executors import SupervisedExecutor


@dataclass(frozen=True, slots=True)
class Workers:
    """An Executor, and how many calls it can do at a time; that may change, and be none for a while."""

    executor: Executor
    capacity: Callable[[], int]


@contextmanager
def own_processes(count: int | None = None) -> Iterator[Workers]:
    """So many supervised processes of this machine, by default one a core, which end once nobody wants them."""
    executor = SupervisedExecutor(count)
    try:
        yield Workers(executor, lambda: executor.workers)
    finally:
        executor.shutdown(cancel_futures=True)
