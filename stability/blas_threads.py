"""Limits linear algebra to one thread, so that the last digit of a sum does not depend on the number of threads.

OpenBLAS decides by the number of its threads, which it takes from the environment or the machine, how it cuts matrices
into parts. So the same scene could have another last digit under `OPENBLAS_NUM_THREADS=4`, or where somebody else had
loaded numpy before. The matrices here are small: several threads cost more than they bring. What a caller does with
numpy is as it was afterwards. Where numpy comes with another library than OpenBLAS, the environment of the command
decides, which is set to one thread.
"""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Final

SETTING: Final = "OPENBLAS_NUM_THREADS"
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


def _libraries(package: str) -> Iterator[Path]:
    from importlib.util import find_spec  # noqa: PLC0415 -- the command needs neither it nor what follows

    spec = find_spec(package)
    for home in map(Path, spec.submodule_search_locations or () if spec is not None else ()):
        for folder in (home.parent / f"{package}.libs", home / ".dylibs"):
            with suppress(OSError):
                yield from sorted(file for file in folder.iterdir() if "openblas" in file.name)


def _setter(file: Path) -> Setter | None:
    """The function that sets the threads of one loaded library; None if it has none."""
    import ctypes  # noqa: PLC0415 -- likewise

    with suppress(OSError, AttributeError):
        found: Setter = getattr(ctypes.CDLL(str(file)), _SETTER)
        return found
    return None
