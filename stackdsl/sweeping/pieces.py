"""A piece of a sweep: some samples of one case, or a case that is played once. What a worker does, wherever it is."""

import pickle
import platform
import zlib
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from time import process_time
from typing import Final, NamedTuple

from stackdsl.checking.chunks import PLAYED, judged_each
from stackdsl.checking.code_digest import portable_digest
from stackdsl.checking.gathering import Case
from stackdsl.checking.one_case import play_case
from stackdsl.judging.known import known_of
from stackdsl.playing.clearance import BlockedPlacementError
from stackdsl.sampling.design import Design, design_of
from stackdsl.sampling.draws import Draws
from stackdsl.sampling.fates import Fate
from stackdsl.sampling.materials import timelines
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.systems import Method

TOGETHER: Final = 500  # samples that are judged as one; more are hardly cheaper, and take more memory
CASES: Final = 64  # that a worker keeps unpacked
PROVEN: Final = "proven"  # how it is known of a case that is played once, where no engine took a step


class Kind(NamedTuple):
    """What became of a sample, or of a case that is played once; all of a row but its number."""

    verdict: str  # stands, collapses, undecided, unfit, failed; or the verdict of a run
    level: int | None  # under construction when it fell
    how: str  # it was decided, or why it failed


FAILED: Final = "failed"  # the verdict of a sample that brings down whatever judges it
NOT_FELL: Final = {Fate.STANDS: "stands", Fate.UNDECIDED: "undecided", Fate.UNFIT: "unfit"}


@dataclass(frozen=True, slots=True)
class Judged:
    """What became of the samples of a piece, in order of their numbers."""

    kinds: tuple[Kind, ...]  # those that there are
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


def judged_piece(case: bytes, first: int, count: int, program: str) -> Judged | OtherProgram:
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


def judged_as(kinds: list[Kind], cpu_time: float) -> Judged:
    """What became of some samples, each of these kinds."""
    number = {kind: index for index, kind in enumerate(dict.fromkeys(kinds))}
    return Judged(tuple(number), array("H", map(number.__getitem__, kinds)), cpu_time)


def joined(parts: list[Judged]) -> Judged:
    """The parts of a piece as one, in their order."""
    kinds = [part.kinds[which] for part in parts for which in part.which]
    return judged_as(kinds, sum(part.cpu_time for part in parts))


@lru_cache(maxsize=CASES)
def _unpacked(case: bytes) -> tuple[Case, Design | None]:
    """A case, and its design where that is the same in all samples."""
    whole = pickle.loads(zlib.decompress(case))
    assert isinstance(whole, Case)
    return whole, design_of(whole.timeline) if whole.is_sampled and whole.scenario.uncertain is None else None


def _built(case: Case, design: Design, samples: range) -> Iterator[Kind]:
    """Samples of which only the hands err, some judged together."""
    for at in samples[::TOGETHER]:
        draws = Draws(case.scenario.seed, case.scenario.scenario, at, min(TOGETHER, samples.stop - at))
        yield from (_kind(*each) for each in judged_each(design, case.timeline, case.system, draws))


def _varied(case: Case, number: int) -> Iterator[Kind]:
    """A sample with values of its own. Raises SampleMistakeError."""
    draws = Draws(case.scenario.seed, case.scenario.scenario, number, 1)
    for timeline in timelines(case.variant, draws):
        yield from (_kind(*each) for each in judged_each(design_of(timeline), timeline, case.system, draws))


@lru_cache(maxsize=1000)
def _kind(fate: int, way: str) -> Kind:
    return Kind("collapses", fate, way) if fate > 0 else Kind(NOT_FELL[Fate(fate)], None, way)


def _played_once(case: Case) -> Kind:
    try:
        trace = play_case(case.timeline, case.system, known_of(case.scenario, case.system))
    except BlockedPlacementError as error:
        return Kind("blocked", None, str(error))
    proven = system_named(case.system).method is Method.PROVEN and trace.cost.steps == 0
    level = trace.collapse.level if trace.collapse is not None else None
    return Kind(trace.reported_verdict, level, PROVEN if proven else PLAYED)
