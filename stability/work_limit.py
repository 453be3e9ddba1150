"""Limit of the work of proofs, in units that do not depend on the machine.

A unit is about a microsecond. Work is estimated from sizes before it is done, so that too large a program does not
start. Without a limit nothing is counted. A limit applies to the thread that sets it, not to threads that it starts.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import inf
from typing import Final

# Units, measured: means over walls, columns, lattices, arches and towers; single ones differ by a factor of up to two.
ENTRY: Final = 0.2  # per entry of the matrix of a conic program and step of its solver
STEPS: Final = 15  # steps of a solver counted in advance; further steps count when they are done
CONE: Final = 30.0  # per friction cone in the matrix of an equilibrium
ENTRIES: Final = 18  # entries of that matrix per cone
LOAD: Final = 50.0  # per brick whose load the published method distributes
POINT: Final = 15.0  # per contact point of two moving bricks whose normal is checked
PAIR: Final = 30.0  # per pair of bricks whose distance is computed, as beside bricks in hands
BRICK: Final = 10.0  # per brick in an equilibrium
CORE: Final = 60.0  # per load core


class TooMuchWorkError(RuntimeError):
    """The request exceeds the limit of work."""


@dataclass
class WorkLimit:
    """Limit of work, with the work done so far."""

    most: float  # [units]
    largest: float = inf  # most entries of one program, which take most of the memory
    done: float = 0.0  # [units]

    def add(self, units: float) -> None:
        """Count work before it is done. Raises TooMuchWorkError if it exceeds the limit."""
        self.done += units
        if self.done > self.most:
            raise TooMuchWorkError(f"the computation needs more than the permitted {self.most:.2g} units of work")


_LIMIT: Final = ContextVar[WorkLimit | None]("work_limit", default=None)


@contextmanager
def limited(limit: WorkLimit) -> Iterator[WorkLimit]:
    """Apply a limit inside the `with` block."""
    token = _LIMIT.set(limit)
    try:
        yield limit
    finally:
        _LIMIT.reset(token)


def add_work(units: float) -> None:
    """Count work before it is done. Raises TooMuchWorkError if it exceeds the current limit."""
    limit = _LIMIT.get()
    if limit is not None:
        limit.add(units)


def add_matrix(cones: int) -> None:
    """Count an equilibrium before it is written as a matrix. Raises TooMuchWorkError, also for its size."""
    _admit(ENTRIES * cones)
    add_work(CONE * cones)


def add_program(entries: int) -> None:
    """Count a program by the entries of its matrix before it is solved. Raises TooMuchWorkError, also for its size."""
    _admit(entries)
    add_work(ENTRY * STEPS * entries)


def _admit(entries: int) -> None:
    limit = _LIMIT.get()
    if limit is not None and entries > limit.largest:
        message = f"a matrix of {entries} entries takes too much memory; the maximum is {limit.largest:.0f} entries"
        raise TooMuchWorkError(message)


def add_steps(entries: int, steps: int) -> None:
    """Count the solver steps of a program beyond `STEPS`. Raises TooMuchWorkError."""
    add_work(ENTRY * entries * max(0, steps - STEPS))
