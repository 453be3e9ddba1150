"""The plan of a sweep: cases, samples, and work units."""

import json
import pickle
import platform
import zlib
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from importlib.metadata import version
from time import process_time
from typing import Final, NamedTuple

from stackdsl.checking.cache import portable_digest
from stackdsl.checking.cases import Case
from stackdsl.checking.ensembles import PLAYED, judged_each
from stackdsl.checking.play_case import play_case
from stackdsl.judging.judge import known_of
from stackdsl.sampling.sample_outcomes import SampleOutcome
from stackdsl.sampling.samples import BuildPlan, Draws, build_plan_of, timelines
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.systems import Method
from stackdsl.supervising.executors import TIME_LIMIT

# A piece of a sweep: some samples of one case, or a case that is played once. What a worker does, wherever it is.


TOGETHER: Final = 500  # samples that are judged as one; more are hardly cheaper, and take more memory
CASES: Final = 64  # that a worker keeps unpacked
PROVEN: Final = "proven"  # how it is known of a case that is played once, where no engine took a step


class RowKind(NamedTuple):
    """What became of a sample, or of a case that is played once; all of a row but its number."""

    verdict: str  # stands, collapses, undecided, unfit, failed; or the verdict of a run
    level: int | None  # under construction when it fell
    how: str  # it was decided, or why it failed


FAILED: Final = "failed"  # the verdict of a sample that brings down whatever judges it
NOT_FELL: Final = {SampleOutcome.STANDS: "stands", SampleOutcome.UNDECIDED: "undecided", SampleOutcome.UNFIT: "unfit"}


@dataclass(frozen=True, slots=True)
class JudgedSamples:
    """What became of the samples of a piece, in order of their numbers."""

    kinds: tuple[RowKind, ...]  # those that there are
    which: "array[int]"  # of these each sample is
    cpu_time: float  # [s]


@dataclass(frozen=True, slots=True)
class OtherProgram:
    """What a worker says that has another program than the one that asks."""

    where: str
    digest: str


def packed(case: Case) -> bytes:
    """A case as it goes to workers; some kilobytes."""
    return zlib.compress(pickle.dumps(case))


def program_of(systems: tuple[str, ...]) -> str:
    """The digest of what decides the results of these systems."""
    engines = {system.engine.package.name for system in map(system_named, systems)}
    return portable_digest(tuple(sorted(engines)))


def judged_piece(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    """What a worker does: judge so many samples of a case from one on, or play the case that has none."""
    started = process_time()
    whole, design = _unpacked(case)
    own = program_of((whole.system,))
    if own != program:
        return OtherProgram(platform.node(), own)
    if not whole.is_sampled:
        kinds = [_played_once(whole)]
    elif design is None:
        kinds = [kind for number in range(first, first + count) for kind in _varied(whole, number)]
    else:
        kinds = [*_built(whole, design, range(first, first + count))]
    return judged_as(kinds, process_time() - started)


def judged_as(kinds: list[RowKind], cpu_time: float) -> JudgedSamples:
    """What became of some samples, each of these kinds."""
    number = {kind: index for index, kind in enumerate(dict.fromkeys(kinds))}
    return JudgedSamples(tuple(number), array("H", map(number.__getitem__, kinds)), cpu_time)


def joined(parts: list[JudgedSamples]) -> JudgedSamples:
    """The parts of a piece as one, in their order."""
    kinds = [part.kinds[which] for part in parts for which in part.which]
    return judged_as(kinds, sum(part.cpu_time for part in parts))


@lru_cache(maxsize=CASES)
def _unpacked(case: bytes) -> tuple[Case, BuildPlan | None]:
    """A case, and its design where that is the same in all samples."""
    whole = pickle.loads(zlib.decompress(case))
    assert isinstance(whole, Case)
    return whole, build_plan_of(whole.timeline) if whole.is_sampled and whole.scenario.uncertain is None else None


def _built(case: Case, design: BuildPlan, samples: range) -> Iterator[RowKind]:
    """Samples of which only the hands err, some judged together."""
    for at in samples[::TOGETHER]:
        draws = Draws(case.scenario.seed, case.scenario.scenario, at, min(TOGETHER, samples.stop - at))
        yield from (_kind(*each) for each in judged_each(design, case.timeline, case.system, draws))


def _varied(case: Case, number: int) -> Iterator[RowKind]:
    """A sample with values of its own. Raises SampleMistakeError."""
    draws = Draws(case.scenario.seed, case.scenario.scenario, number, 1)
    for timeline in timelines(case.variant, draws):
        yield from (_kind(*each) for each in judged_each(build_plan_of(timeline), timeline, case.system, draws))


@lru_cache(maxsize=1000)
def _kind(fate: int, way: str) -> RowKind:
    return RowKind("collapses", fate, way) if fate > 0 else RowKind(NOT_FELL[SampleOutcome(fate)], None, way)


def _played_once(case: Case) -> RowKind:
    try:
        trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system))
    except BlockedPlacementError as error:
        return RowKind("blocked", None, str(error))
    proven = system_named(case.system).method is Method.PROVEN and trace.cost.steps == 0
    level = trace.collapse.level if trace.collapse is not None else None
    return RowKind(trace.reported_verdict, level, PROVEN if proven else PLAYED)


# What a sweep is to find out: which cases, how many samples of each, and in which order its rows come.
#
# Rows come by sample, and of each sample by case, so that more samples are more rows at the end.


ROWS: Final = 1  # the number of the form that rows have
# What is said of a scenario that no row depends on; the choice of a variant is known by itself.
NO_MATTER: Final = frozenset(
    {"description", "tags", "samples", "confidence", "truth", "skip", "xfail", "systems", "matrix", "cases", "exclude"}
)


class NothingToSweepError(Exception):
    """A sweep without cases, or with two that cannot be told apart."""


@dataclass(frozen=True)
class PlannedCase:
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
class SweepPlan:
    """The cases of a sweep."""

    entries: tuple[PlannedCase, ...]
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


def plan_of(cases: Sequence[Case], samples: int | None = None, time_limit: float = TIME_LIMIT) -> SweepPlan:
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
    return SweepPlan(tuple(map(PlannedCase, cases, counts)), time_limit)


def _digest(case: Case) -> str:
    """Of what is built and how it varies, as written, and of what a variant chose: comments make no difference."""
    kept = {key: value for key, value in case.variant.written.values.items() if key not in NO_MATTER}
    if case.is_sampled:  # of which nothing that is expected is asked; of a run it decides how long it is played
        kept.pop("expect", None)
    told = json.dumps([kept, case.variant.choice, case.system], sort_keys=True, default=str)
    return sha256(told.encode()).hexdigest()
