"""The plan of a sweep: cases, samples, and work units."""

import json
import pickle
import platform
import zlib
from array import array
from collections.abc import Iterator, Mapping, Sequence
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
from stackdsl.judging.judge import stop_condition_of
from stackdsl.language.quantities import number_or_word
from stackdsl.sampling.sample_outcomes import SampleOutcome
from stackdsl.sampling.samples import BuildPlan, Draws, build_plan_of, timelines
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.known_systems import KNOWN, system_named
from stackdsl.simulation.systems import Method
from stackdsl.supervising.executors import TIME_LIMIT

# A piece of a sweep: consecutive samples of one case, or a case that is played once; judged by a worker.


TOGETHER: Final = 500  # samples judged together; more are hardly cheaper, and take more memory
CASES: Final = 64  # unpacked cases that a worker caches
PROVEN: Final = "proven"  # kind of decision of a case that is played once without a step of an engine


class RowKind(NamedTuple):
    """The result of a sample, or of a case that is played once: a row without its number."""

    verdict: str  # stands, collapses, undecided, unfit, failed; or the verdict of a run
    level: int | None  # under construction when it fell
    how: str  # kind of proof or decision; for a failed sample, the reason


FAILED: Final = "failed"  # verdict of a sample that crashes its worker or exceeds the time limit
NOT_FELL: Final = {SampleOutcome.STANDS: "stands", SampleOutcome.UNDECIDED: "undecided", SampleOutcome.UNFIT: "unfit"}


@dataclass(frozen=True, slots=True)
class JudgedSamples:
    """The results of the samples of a piece, in order of their numbers."""

    kinds: tuple[RowKind, ...]  # distinct results
    which: "array[int]"  # index into `kinds`, by sample
    cpu_time: float  # [s]


@dataclass(frozen=True, slots=True)
class OtherProgram:
    """The answer of a worker that has another program than the caller."""

    where: str  # its machine
    digest: str


def packed(case: Case) -> bytes:
    """Return a case packed for workers; some kilobytes."""
    return zlib.compress(pickle.dumps(case))


def program_of(systems: tuple[str, ...]) -> str:
    """Return the digest of all code that the results of these systems depend on."""
    engines = {system.engine.package.name for system in map(system_named, systems)}
    if foreign := {*systems} - KNOWN.keys():
        from stackdsl.simulation.plugins import distributions_of  # noqa: PLC0415 -- it reads what is installed

        engines |= {*distributions_of(foreign)}
    return portable_digest(tuple(sorted(engines)))


def judged_piece(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    """Judge `count` samples of a case from `first` on, or play a case without samples; runs in a worker."""
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
    """Return the results of some samples, given the kind of each."""
    number = {kind: index for index, kind in enumerate(dict.fromkeys(kinds))}
    return JudgedSamples(tuple(number), array("H", map(number.__getitem__, kinds)), cpu_time)


def joined(parts: list[JudgedSamples]) -> JudgedSamples:
    """Join the parts of a piece, in their order."""
    kinds = [part.kinds[which] for part in parts for which in part.which]
    return judged_as(kinds, sum(part.cpu_time for part in parts))


@lru_cache(maxsize=CASES)
def _unpacked(case: bytes) -> tuple[Case, BuildPlan | None]:
    """Unpack a case; also return its build plan, if that is the same in all samples."""
    whole = pickle.loads(zlib.decompress(case))
    assert isinstance(whole, Case)
    return whole, build_plan_of(whole.timeline) if whole.is_sampled and whole.scenario.uncertain is None else None


def _built(case: Case, design: BuildPlan, samples: range) -> Iterator[RowKind]:
    """Yield the results of samples that differ only by placement errors, judged in batches."""
    for at in samples[::TOGETHER]:
        draws = Draws(case.scenario.seed, case.scenario.scenario, at, min(TOGETHER, samples.stop - at))
        yield from (_kind(*each) for each in judged_each(design, case.timeline, case.system, draws))


def _varied(case: Case, number: int) -> Iterator[RowKind]:
    """Yield the result of a sample with uncertain variables. Raises InvalidSampleError."""
    draws = Draws(case.scenario.seed, case.scenario.scenario, number, 1)
    for timeline in timelines(case.variant, draws):
        yield from (_kind(*each) for each in judged_each(build_plan_of(timeline), timeline, case.system, draws))


@lru_cache(maxsize=1000)
def _kind(outcome: int, way: str) -> RowKind:
    return RowKind("collapses", outcome, way) if outcome > 0 else RowKind(NOT_FELL[SampleOutcome(outcome)], None, way)


def _played_once(case: Case) -> RowKind:
    try:
        trace = play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system))
    except BlockedPlacementError as error:
        return RowKind("blocked", None, str(error))
    proven = system_named(case.system).method is Method.PROVEN and trace.cost.steps == 0
    level = trace.collapse.level if trace.collapse is not None else None
    return RowKind(trace.reported_verdict, level, PROVEN if proven else PLAYED)


# The plan of a sweep: its cases, the number of samples of each, and the order of rows.
#
# Rows are ordered by sample, then by case, so that further samples append rows at the end.


ROWS: Final = 2  # version of the row format
# Keys of a scenario that no row depends on; the choices of a variant are recorded separately.
NO_MATTER: Final = frozenset(
    {"description", "tags", "samples", "confidence", "truth", "skip", "xfail", "systems", "matrix", "cases", "exclude"}
)


class NothingToSweepError(Exception):
    """A sweep has no cases, or two cases of the same name."""


@dataclass(frozen=True)
class PlannedCase:
    """A case and its number of rows."""

    case: Case
    count: int  # number of samples; 1 for a case that is played once
    columns: Mapping[str, float | str | None]  # system and variables; None where the case lacks a variable of others

    @property
    def name(self) -> str:
        """The name of the case."""
        return self.case.name

    @property
    def seed(self) -> int | None:
        """The seed of its samples; None without samples."""
        return self.case.scenario.seed if self.case.is_sampled else None

    @cached_property
    def packed(self) -> bytes:
        """The case packed for workers."""
        return packed(self.case)

    @cached_property
    def program(self) -> str:
        """The digest of all code that its results depend on."""
        return program_of((self.case.system,))

    @cached_property
    def header(self) -> dict[str, object]:
        """The entry of the case in the header of a file."""
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
        """Total number of rows."""
        return sum(entry.count for entry in self.entries)

    @cached_property
    def columns(self) -> dict[str, bool]:
        """The columns of system and variables, and whether their values are words."""
        names = self.entries[0].columns
        return {name: any(isinstance(entry.columns[name], str) for entry in self.entries) for name in names}

    @cached_property
    def header(self) -> dict[str, object]:
        """The header of a file, which identifies the sweep independent of the number of samples."""
        systems = tuple(sorted({entry.case.system for entry in self.entries}))
        return {
            "stackdsl": version("stackdsl"),
            "rows": ROWS,
            "program": program_of(systems),
            "cases": [entry.header for entry in self.entries],
        }

    def at(self, row: int) -> tuple[int, int]:
        """Return the sample and the case of a row, from 0 on; for a row beyond the end, one sample after the last."""
        sample = 0
        for end in sorted({entry.count for entry in self.entries}):
            cases = self.cases_with(sample)
            if row < len(cases) * (end - sample):
                more, which = divmod(row, len(cases))
                return sample + more, cases[which]
            row -= len(cases) * (end - sample)
            sample = end
        return sample, 0

    def cases_with(self, sample: int) -> list[int]:
        """Return the cases that have a sample of this number."""
        return [index for index, entry in enumerate(self.entries) if sample < entry.count]

    def order(self, row: int) -> Iterator[tuple[int, int]]:
        """Yield the sample and the case of each row, starting at `row`."""
        sample, first = self.at(row)
        for end in sorted({entry.count for entry in self.entries if entry.count > sample}):
            cases = self.cases_with(sample)
            for number in range(sample, end):
                for index in cases:
                    if index >= first:
                        yield number, index
                first = 0
            sample = end


def plan_of(cases: Sequence[Case], samples: int | None = None, time_limit: float = TIME_LIMIT) -> SweepPlan:
    """Return the plan of a sweep. Raises NothingToSweepError.

    `samples` replaces the numbers of samples in the scenarios.
    """
    if not cases:
        raise NothingToSweepError("no cases to sweep")
    if samples is not None and not any(case.is_sampled for case in cases):
        remedy = "add `samples: 1000`, and `uncertain` or `jitter`"
        raise NothingToSweepError(f"'{cases[0].name}' has no samples; {remedy}")
    names = [case.name for case in cases]
    twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
    if twice is not None:
        raise NothingToSweepError(f"several cases are called '{twice}', but rows need unique names; rename one")
    counts = [(samples or case.scenario.samples or 1) if case.is_sampled else 1 for case in cases]
    return SweepPlan(tuple(map(PlannedCase, cases, counts, _columns(cases))), time_limit)


def _columns(cases: Sequence[Case]) -> Iterator[dict[str, float | str | None]]:
    """Yield the system and the variables of each case, named as in the CSV report of `check`.

    A column has numbers in SI, or words if any value is one.
    """
    written = [dict(case.parameters) for case in cases]
    names = dict.fromkeys(name for values in written for name in values)
    words = {name for values in written for name, text in values.items() if isinstance(number_or_word(text), str)}
    for case, values in zip(cases, written, strict=True):
        shown = {name: text if name in words else number_or_word(text) for name, text in values.items()}
        yield {"system": case.system, **{f"variable_{name}": shown.get(name) for name in names}}


def _digest(case: Case) -> str:
    """Return the digest of all parts of a case that rows depend on; comments make no difference."""
    values = {key: value for key, value in case.variant.written.values.items() if key not in NO_MATTER}
    if case.is_sampled:  # samples ignore expectations; a run ends earlier or later by them
        values.pop("expect", None)
    text = json.dumps([values, case.variant.choice, case.system], sort_keys=True, default=str)
    return sha256(text.encode()).hexdigest()
