"""Settings of the whole process: how often Python collects garbage, and on how many threads linear algebra runs.

The command imports this first, so it imports nothing that takes time.
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

# Garbage.
#
# What is made of thousands of bricks are millions of objects without a cycle among them. Left alone, the collector goes
# through each of them several times, which takes a quarter of what judging and playing such a structure does.


SELDOM: Final = 20_000  # objects that are made, and stay, before the collector looks at them; Python's own is 700


def collect_rarely() -> None:
    """Make the collector look more seldom from here on, which only the owner of a process may do."""
    gc.set_threshold(SELDOM, *gc.get_threshold()[1:])


@contextmanager
def rarely_collected() -> Iterator[None]:
    """Let the collector look more seldom meanwhile, unless somebody has it look as seldom already, or not at all."""
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
    """Let nothing be collected meanwhile, where what is made is bounded, and hardly any of it is garbage."""
    if not gc.isenabled():  # somebody around does the same
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def exclude_from_collection() -> None:
    """Exclude all objects that there are from collection, which in a copy of this process would copy their memory."""
    gc.freeze()


# Threads of linear algebra.
#
# OpenBLAS decides by the number of its threads, which it takes from the environment or the machine, how it cuts
# matrices into parts. So the same scene could have another last digit under `OPENBLAS_NUM_THREADS=4`, or where somebody
# else had loaded numpy before. The matrices here are small: several threads cost more than they bring, on a busy
# machine tenfold, and a process that has some is copied for no worker. What a caller does with numpy is as it was
# afterwards. Where numpy comes with another library than OpenBLAS, the environment decides.


SETTING: Final = "OPENBLAS_NUM_THREADS"
THREADS: Final = (SETTING, "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")  # read when numpy is loaded


def ask_for_one_thread(unless_set: bool = False) -> None:
    """Set the environment, for libraries that are loaded from here on, and for processes that are started.

    With `unless_set`, whoever asks for more threads for numpy of their own has them.
    """
    for name in THREADS:
        if not (unless_set and name in os.environ):
            os.environ[name] = "1"


_BROUGHT_BY: Final = ("numpy", "scipy")  # each with a library of its own, as its wheels have it
_SETTER: Final = "openblas_set_num_threads_local"  # returns what there was

Setter = Callable[[int], int]


@contextmanager
def one_thread() -> Iterator[None]:
    """Run linear algebra on one thread inside the `with` block, libraries loaded within it included."""
    loaded = [package for package in _BROUGHT_BY if package in sys.modules]
    before = [(set_threads, set_threads(1)) for set_threads in _setters(tuple(loaded))]
    try:
        if len(loaded) == len(_BROUGHT_BY):
            yield
        else:
            yield from _loading(loaded)
    finally:
        for set_threads, count in before:
            set_threads(count)


def _loading(loaded: Sequence[str]) -> Iterator[None]:
    """Limit libraries that are loaded inside the block as well; restore their usual number of threads after it."""
    was = os.environ.get(SETTING)
    os.environ[SETTING] = "1"
    try:
        yield
    finally:
        if was is None:
            del os.environ[SETTING]
        else:
            os.environ[SETTING] = was
        usual = int(was) if was is not None and was.isascii() and was.isdigit() else os.cpu_count() or 1
        for package in _BROUGHT_BY:
            if package in sys.modules and package not in loaded:
                for set_threads in _setters((package,)):
                    set_threads(max(1, usual))


@cache
def _setters(packages: tuple[str, ...]) -> tuple[Setter, ...]:
    """The functions that set the number of threads of the loaded libraries; each returns the previous number."""
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
    """The function that sets the threads of one loaded library; None if it has none."""
    import ctypes  # noqa: PLC0415 -- likewise

    with suppress(OSError, AttributeError):
        found: Setter = getattr(ctypes.CDLL(str(file)), _SETTER)
        return found
    return None
