"""Settings of the whole process: garbage collection, and threads of linear algebra.

The command imports this module first, so its imports must be fast.
"""

import gc
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pathlib import Path

# Garbage collection.
#
# Thousands of bricks need millions of objects without reference cycles. With default settings the collector scans each
# of them several times, which takes a quarter of the time of proof and simulation.


SELDOM: Final = 20_000  # net number of new objects that starts a collection; Python's default is 700


def collect_rarely() -> None:
    """Reduce the frequency of collections for the rest of the process, which only its owner may do."""
    gc.set_threshold(SELDOM, *gc.get_threshold()[1:])


@contextmanager
def rarely_collected() -> Iterator[None]:
    """Reduce the frequency of collections in a block, unless it is as low already or collection is off."""
    before = gc.get_threshold()
    if not 0 < before[0] < SELDOM:
        yield
        return
    try:
        collect_rarely()
        yield
    finally:
        gc.set_threshold(*before)


@contextmanager
def uncollected() -> Iterator[None]:
    """Switch collection off in a block that creates a bounded number of objects and little garbage."""
    if not gc.isenabled():  # as in an outer block
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def exclude_from_collection() -> None:
    """Exclude all existing objects from collection, which would copy their memory in a forked process."""
    gc.freeze()


# Threads of linear algebra.
#
# OpenBLAS divides matrices by the number of its threads, which it takes from the environment or the machine. So the
# same scene could have another last digit with `OPENBLAS_NUM_THREADS=4`, or if other code had loaded numpy before. The
# matrices here are small, so several threads are slower, on a busy machine tenfold, and a process with threads cannot
# fork workers. The number of threads is restored for the caller. If numpy uses another library than OpenBLAS, the
# environment decides.


SETTING: Final = "OPENBLAS_NUM_THREADS"
THREADS: Final = (SETTING, "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")  # read when numpy loads


def ask_for_one_thread(unless_set: bool = False) -> None:
    """Set the environment to one thread, for libraries loaded later and for child processes.

    With `unless_set`, existing environment variables stay, as set by users for their own use of numpy.
    """
    for name in THREADS:
        if not (unless_set and name in os.environ):
            os.environ[name] = "1"


_PACKAGES: Final = ("numpy", "scipy")  # packages whose wheels each contain a library
_SETTER_NAME: Final = "openblas_set_num_threads_local"  # returns the previous number

Setter = Callable[[int], int]


@contextmanager
def one_thread() -> Iterator[None]:
    """Run linear algebra on one thread inside the `with` block, including libraries loaded within it."""
    loaded = [package for package in _PACKAGES if package in sys.modules]
    before = [(set_threads, set_threads(1)) for set_threads in _setters(tuple(loaded))]
    try:
        if len(loaded) == len(_PACKAGES):
            yield
        else:
            yield from _loading(loaded)
    finally:
        for set_threads, count in before:
            set_threads(count)


def _loading(loaded: Sequence[str]) -> Iterator[None]:
    """Limit libraries that are loaded inside the block; restore their default number of threads after it."""
    previous = os.environ.get(SETTING)
    os.environ[SETTING] = "1"
    try:
        yield
    finally:
        if previous is None:
            del os.environ[SETTING]
        else:
            os.environ[SETTING] = previous
        default = (
            int(previous) if previous is not None and previous.isascii() and previous.isdigit() else os.cpu_count() or 1
        )
        for package in _PACKAGES:
            if package in sys.modules and package not in loaded:
                for set_threads in _setters((package,)):
                    set_threads(max(1, default))


@cache
def _setters(packages: tuple[str, ...]) -> tuple[Setter, ...]:
    """Return the functions that set the number of threads of the loaded libraries and return the previous number."""
    return tuple(setter for package in packages for file in _libraries(package) if (setter := _setter(file)))


def _libraries(package: str) -> "Iterator[Path]":
    from importlib.util import find_spec  # noqa: PLC0415 -- the command needs none of these
    from pathlib import Path  # noqa: PLC0415 -- likewise

    spec = find_spec(package)
    for home in map(Path, spec.submodule_search_locations or () if spec is not None else ()):
        for folder in (home.parent / f"{package}.libs", home / ".dylibs"):
            with suppress(OSError):
                yield from sorted(file for file in folder.iterdir() if "openblas" in file.name)


def _setter(file: "Path") -> Setter | None:
    """Return the function that sets the number of threads of a loaded library; None if it has none."""
    import ctypes  # noqa: PLC0415 -- likewise

    with suppress(OSError, AttributeError):
        set_threads: Setter = getattr(ctypes.CDLL(str(file)), _SETTER_NAME)
        return set_threads
    return None
