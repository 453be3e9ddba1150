"""Executors for sweeps: local processes, or a Dask cluster."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from stackdsl.supervising.executors import SupervisedExecutor

if TYPE_CHECKING:
    from distributed import Client


# Workers of a sweep.


@dataclass(frozen=True, slots=True)
class Workers:
    """An Executor and its number of parallel calls, which may change, and be 0 for a while."""

    executor: Executor
    capacity: Callable[[], int]


@contextmanager
def own_processes(count: int | None = None) -> Iterator[Workers]:
    """Start supervised processes on this machine, by default one per core; they end with the context."""
    executor = SupervisedExecutor(count)
    try:
        yield Workers(executor, lambda: executor.workers)
    finally:
        executor.shutdown(cancel_futures=True)


# A running Dask cluster as an Executor.


HINT: Final = "pip install 'stackdsl[dask]'"
NAMED: Final = (
    "give the address of its scheduler: --scheduler tcp://HOST:8786, DASK_SCHEDULER_ADDRESS, or Dask's own settings"
)
MENDED: Final = (
    "check that it runs (`dask scheduler`) and that --scheduler tcp://HOST:8786 has its address, or remove --executor "
    "dask to use processes of this machine"
)
PATIENCE: Final = 10.0  # [s] for a scheduler to answer


class NoClusterError(Exception):
    """There is no cluster, or Dask is not installed."""


@contextmanager
def dask_cluster(scheduler: str = "") -> Iterator[Workers]:
    """Connect to the scheduler at an address, such as `tcp://10.0.0.1:8786`, or to that of Dask's own settings.

    Raises NoClusterError.
    """
    try:
        client = _client(scheduler)
    except ModuleNotFoundError as error:
        raise NoClusterError(f"Dask needs {error.name}, which is not installed; try: {HINT}") from error
    try:
        # Not pure: an equal call is carried out again, as a repetition has a reason.
        yield Workers(client.get_executor(pure=False), lambda: sum(client.nthreads().values()))
    finally:
        with suppress(OSError):  # the cluster may have ended meanwhile
            client.close()


def _client(scheduler: str) -> "Client":
    """Connect to a scheduler. Raises NoClusterError, and ModuleNotFoundError without Dask."""
    import dask  # noqa: PLC0415 -- an optional extra
    from distributed import Client  # noqa: PLC0415 -- likewise
    from distributed.comm import resolve_address  # noqa: PLC0415 -- likewise

    address = scheduler or dask.config.get("scheduler-address", None)
    if not address:
        raise NoClusterError(f"no address of a Dask cluster; {NAMED}")
    try:
        return Client(resolve_address(address), timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # a time-out is an OSError
        reason = " ".join(str(error).split()) or type(error).__name__
        raise NoClusterError(f"the scheduler at {address} does not answer: {reason}; {MENDED}") from error
