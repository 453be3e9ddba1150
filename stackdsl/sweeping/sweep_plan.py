"""What a sweep is to find out: which cases, how many samples of each, and in which order its rows come.

Rows come by sample, and of each sample by case, so that more samples are more rows at the end.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from importlib.metadata import version
from typing import Final

from stackdsl.checking.gathering import Case
from stackdsl.supervising.executors import TIME_LIMIT
from stackdsl.sweeping.pieces import packed, program_of

ROWS: Final = 1  # the number of the form that rows have
# What is said of a scenario that no row depends on; the choice of a variant is known by itself.
NO_MATTER: Final = frozenset(
    {"description", "tags", "samples", "confidence", "truth", "skip", "xfail", "systems", "matrix", "cases", "exclude"}
)


class NothingToSweepError(Exception):
    """A sweep without cases, or with two that cannot be told apart."""


@dataclass(frozen=True)
class Entry:
    """A case, and how many rows it has."""

    case: Case
    count: int  # of samples; 1 of a case that is played once

    @property
    def name(self) -> str:
        """What people call the case."""
        return self.case.name

    @property
    def seed(self) -> int | None:
        """Of its samples; None where there are none."""
        return self.case.scenario.seed if self.case.is_sampled else None

    @cached_property
    def packed(self) -> bytes:
        """The case as it goes to workers."""
        return packed(self.case)

    @cached_property
    def program(self) -> str:
        """The digest of what decides its results."""
        return program_of((self.case.system,))

    @cached_property
    def told(self) -> dict[str, object]:
        """What the header of a file says of it."""
        return {
            "case": self.name,
            "system": self.case.system,
            "parameters": dict(self.case.parameters),
            "seed": self.seed,
            "scenario": _digest(self.case),
        }


@dataclass(frozen=True)
class Plan:
    """The cases of a sweep."""

    entries: tuple[Entry, ...]
    time_limit: float = TIME_LIMIT  # [s] of wall time a piece

    @cached_property
    def total(self) -> int:
        """How many rows there are to be."""
        return sum(entry.count for entry in self.entries)

    @cached_property
    def header(self) -> dict[str, object]:
        """By which a file is known to be of this sweep, whatever the number of samples."""
        systems = tuple(sorted({entry.case.system for entry in self.entries}))
        return {
            "stackdsl": version("stackdsl"),
            "rows": ROWS,
            "program": program_of(systems),
            "cases": [entry.told for entry in self.entries],
        }

    def at(self, row: int) -> tuple[int, int]:
        """The sample and the case of a row, counted from 0; the sample behind the last one where it is behind all."""
        sample = 0
        for end in sorted({entry.count for entry in self.entries}):
            there = self.there(sample)
            if row < len(there) * (end - sample):
                more, which = divmod(row, len(there))
                return sample + more, there[which]
            row -= len(there) * (end - sample)
            sample = end
        return sample, 0

    def there(self, sample: int) -> list[int]:
        """The cases that have a sample of this number."""
        return [index for index, entry in enumerate(self.entries) if sample < entry.count]

    def order(self, row: int) -> Iterator[tuple[int, int]]:
        """The sample and the case of each row from one on."""
        sample, first = self.at(row)
        for end in sorted({entry.count for entry in self.entries if entry.count > sample}):
            there = self.there(sample)
            for number in range(sample, end):
                for index in there:
                    if index >= first:
                        yield number, index
                first = 0
            sample = end


def plan_of(cases: Sequence[Case], samples: int | None = None, time_limit: float = TIME_LIMIT) -> Plan:
    """The plan of a sweep, with so many samples of what has some, or as many as is written.

    Raises NothingToSweepError.
    """
    if not cases:
        raise NothingToSweepError("there is nothing to sweep")
    if samples is not None and not any(case.is_sampled for case in cases):
        told = "write under `uncertain` or `jitter` what is uncertain, and `samples: 1000`"
        raise NothingToSweepError(f"'{cases[0].name}' has no samples, so no number of them can be drawn: {told}")
    names = [case.name for case in cases]
    twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
    if twice is not None:
        raise NothingToSweepError(f"there are several cases called '{twice}', whose rows could not be told apart")
    counts = [(samples or case.scenario.samples or 1) if case.is_sampled else 1 for case in cases]
    return Plan(tuple(map(Entry, cases, counts)), time_limit)


def _digest(case: Case) -> str:
    """Of what is built and how it varies, as written, and of what a variant chose: comments make no difference."""
    kept = {key: value for key, value in case.variant.written.values.items() if key not in NO_MATTER}
    if case.is_sampled:  # of which nothing that is expected is asked; of a run it decides how long it is played
        kept.pop("expect", None)
    told = json.dumps([kept, case.variant.choice, case.system], sort_keys=True, default=str)
    return sha256(told.encode()).hexdigest()
