"""Counts the work of proofs in units that are the same on every machine, and stops what takes more than is allowed.

A unit is about a microsecond. Work is counted by sizes, before it is done, so a program that is too large does not
begin. Without a limit nothing is counted. A limit holds for the thread that sets it, and not for those that it starts.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import inf
from typing import Final

# Units, measured: the mean over walls, columns, lattices, arches and towers, of which single ones are off by up to two.
ENTRY: Final = 0.2  # for each entry of the matrix of a conic program, in each step of its solver
STEPS: Final = 15  # of a solver that are counted beforehand; more are when they are done
CONE: Final = 30.0  # for each friction cone of an equilibrium that is written as a matrix
ENTRIES: Final = 18  # of that matrix, for each of these cones
LOAD: Final = 50.0  # for each brick whose load is distributed by the published method
POINT: Final = 15.0  # for each point of two moving bricks of which the contact normal is checked
PAIR: Final = 30.0  # for each pair of bricks whose distance is found, as beside what a hand moves
BRICK: Final = 10.0  # for each brick of which an equilibrium is listed
CORE: Final = 60.0  # for each load core that is found


class TooMuchWorkError(RuntimeError):
    """What was asked takes more work than is allowed."""


@dataclass
class WorkLimit:
    """How much is allowed, and what has been done."""

    most: float
    largest: float = inf  # entries of one program, which take most of the memory
    done: float = 0.0

    def add(self, units: float) -> None:
        """Count work that is about to be done. Raises TooMuchWorkError, and then it is not to be done."""
        self.done += units
        if self.done > self.most:
            raise TooMuchWorkError(
                f"{self.done:.2g} units of work in all are estimated, and {self.most:.2g} are allowed"
            )


_LIMIT: Final = ContextVar[WorkLimit | None]("work_limit", default=None)


@contextmanager
def limited(limit: WorkLimit) -> Iterator[WorkLimit]:
    """Count what is done within, and stop what is more than a limit."""
    token = _LIMIT.set(limit)
    try:
        yield limit
    finally:
        _LIMIT.reset(token)


def work_done() -> float:
    """What has been done by now, in units; nothing is counted without a limit."""
    limit = _LIMIT.get()
    return 0.0 if limit is None else limit.done


def add_work(units: float) -> None:
    """Count work that is about to be done. Raises TooMuchWorkError where it is more than is allowed."""
    limit = _LIMIT.get()
    if limit is not None:
        limit.add(units)


def add_matrix(cones: int) -> None:
    """Count an equilibrium before it is written as a matrix. Raises TooMuchWorkError, also for its size."""
    _admit(ENTRIES * cones)
    add_work(CONE * cones)


def add_program(entries: int) -> None:
    """Count a program before it is solved, by the entries of its matrix. Raises TooMuchWorkError, also for its size."""
    _admit(entries)
    add_work(ENTRY * STEPS * entries)


def _admit(entries: int) -> None:
    limit = _LIMIT.get()
    if limit is not None and entries > limit.largest:
        message = f"one matrix of {entries} entries takes too much memory, and {limit.largest:.0f} are allowed"
        raise TooMuchWorkError(message)


def add_steps(entries: int, steps: int) -> None:
    """Count those steps that a program has taken beyond what was counted before. Raises TooMuchWorkError."""
    add_work(ENTRY * entries * max(0, steps - STEPS))
