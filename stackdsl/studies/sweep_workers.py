"""Executors for sweeps: local processes, or a Dask cluster."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from stackdsl.supervising.executors import SupervisedExecutor

if TYPE_CHECKING:
    from distributed import Client


# What does the work of a sweep.


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


# A Dask cluster that is there, as an Executor.


HINT: Final = "pip install 'stackdsl[dask]'"
NAMED: Final = (
    "say where its scheduler is: --scheduler tcp://HOST:8786, or DASK_SCHEDULER_ADDRESS, or Dask's own settings"
)
MENDED: Final = (
    "see that it runs (`dask scheduler`) and that --scheduler tcp://HOST:8786 says where; without --executor dask "
    "processes of this machine do the work"
)
PATIENCE: Final = 10.0  # [s] for a scheduler to answer


class NoClusterError(Exception):
    """There is no cluster, or nothing that speaks to one."""


@contextmanager
def dask_cluster(scheduler: str = "") -> Iterator[Workers]:
    """The cluster of the scheduler at an address, such as `tcp://10.0.0.1:8786`, or of that which Dask is set up for.

    Raises NoClusterError.
    """
    try:
        client = _client(scheduler)
    except ModuleNotFoundError as error:
        raise NoClusterError(f"Dask needs {error.name}, which is not installed; try: {HINT}") from error
    try:
        # Each call is one of its own, even if it asks the same: what is done again is done for a reason.
        yield Workers(client.get_executor(pure=False), lambda: sum(client.nthreads().values()))
    finally:
        with suppress(OSError):  # it may have gone meanwhile
            client.close()


def _client(scheduler: str) -> "Client":
    """A connection. Raises NoClusterError, and ModuleNotFoundError without Dask."""
    import dask  # noqa: PLC0415 -- an optional extra
    from distributed import Client  # noqa: PLC0415 -- likewise
    from distributed.comm import resolve_address  # noqa: PLC0415 -- likewise

    address = scheduler or dask.config.get("scheduler-address", None)
    if not address:
        raise NoClusterError(f"no Dask cluster is named; {NAMED}")
    try:
        return Client(resolve_address(address), timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # what it times out with is an OSError
        told = " ".join(str(error).split()) or type(error).__name__
        raise NoClusterError(f"the scheduler at {address} does not answer: {told}; {MENDED}") from error
