"""The pipeline of `check`: cases -> traces -> outcomes and snapshots -> report, in supervised processes."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Protocol

from stackdsl.checking.cache import ResultCache, as_record, from_record, may_be_remembered
from stackdsl.checking.cases import Case, Listed
from stackdsl.checking.play_case import play_case, play_refined, played_or_blocked
from stackdsl.checking.results import Goldens, checked, marked_skipped, skipped
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.file_format import golden_name
from stackdsl.goldens.golden import PendingStore, content, obsolete, remove_obsolete, text_digest
from stackdsl.goldens.snapshot import Identity
from stackdsl.judging.judge import stop_condition_of
from stackdsl.results import ClaimOutcome, GoldenStatus, Report, RunStatus, VariantResult
from stackdsl.simulation.known_systems import unplayable
from stackdsl.supervising.processes import EnoughSeenError, OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from stackdsl.trace import OnDrawn, untold

# Finds golden files that belong to no case.


class GoldenOwner(Protocol):
    """A case, as far as its golden file goes."""

    @property
    def identity(self) -> Identity:
        """What it is called."""

    @property
    def file(self) -> str:
        """The file that has it."""


class AllFound(Protocol):
    """What was found of a whole set of scenarios."""

    @property
    def cases(self) -> Sequence[GoldenOwner]:
        """All cases without a mistake."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


def unused_goldens(found: AllFound, golden: Path, others: Iterable[str] = ()) -> tuple[str, ...]:
    """The golden files below a directory that belong to no case of a whole set of scenarios.

    None where anything in the set is mistaken, or where it is empty: then nobody knows what belongs to it.
    `others` are files of the set that may have no case.
    """
    if found.diagnostics or not found.cases:
        return ()
    used = [golden_name(case.identity) for case in found.cases]
    return obsolete(golden, used, whole_set=True, checked={*others, *(case.file for case in found.cases)})


# The pipeline: cases -> traces -> outcomes and snapshots -> report. Worlds are stepped in supervised processes.


TIME_LIMIT = 600.0  # [s] of wall time a case; many times what the largest scenario takes
REFINED_COST = 5.0  # runs' worth of time: the run, and one with twice the steps of twice the iterations


@dataclass(frozen=True, slots=True)
class CheckConfig:
    """How a check is carried out."""

    golden: Path | None  # None where golden files are not looked at
    update: bool = False
    workers: int = 1
    time_limit: float = TIME_LIMIT  # [s] of wall time a case
    accept_failing: bool = False  # with `update`, accept also what fails its expectations
    scenarios: Path | None = None  # directory of the scenarios that are checked together; None for that beside `golden`
    update_command: str = ""  # the same call, with an update of the golden files
    refine: bool = False  # play each case again at half the step and twice the iterations
    on_wait: OnWait = lambda: None  # called many times a second while cases are played
    on_drawn: OnDrawn = untold  # of the samples of a case, as they come
    write_new_goldens: bool = False  # write the golden file of what is as expected and has none
    first_failure: bool = False  # play nothing more once something has failed
    must_claim: bool = False  # let a case fail of which nothing is expected
    memory: ResultCache = field(default_factory=lambda: ResultCache(Path(), used=False))
    waiting: PendingStore | None = None  # where to keep what differs until somebody decides; None where nobody does
    digests: Mapping[str, str] = field(default_factory=dict)  # of the text of each file, by what it is called

    @property
    def goldens(self) -> Goldens:
        """What is done about golden files."""
        return Goldens(
            self.golden,
            self.update,
            self.write_new_goldens and not self.update,
            accept_failing=self.accept_failing,
            scenarios=self.scenarios,
        )


OnResult = Callable[[VariantResult], None]


class FoundCases(Protocol):
    """What was found under some paths."""

    @property
    def cases(self) -> Sequence[Listed]:
        """All cases without a mistake."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


@dataclass(slots=True)
class _Played:
    """The results of a check by the number of the case, each told as it comes."""

    selected: Sequence[Listed]
    terms: CheckConfig
    on_result: OnResult
    goldens: Goldens
    results: dict[int, VariantResult] = field(default_factory=dict)
    cases: dict[int, Case] = field(default_factory=dict)  # those that are played
    interrupted: bool = False

    def recall(self) -> None:
        """Take over what is remembered; nothing of it is told, for nothing happens."""
        for index, case in enumerate(self.selected):
            if (found := recalled(case, self.terms)) is not None:
                self.results[index] = found

    def play(self) -> None:
        """Play all that can be played here, and tell of the rest why it cannot."""
        rest = [index for index in range(len(self.selected)) if index not in self.results]
        self.cases = {index: self.selected[index].compiled() for index in rest}
        for index, case in self.cases.items():
            if case.skip is not None:
                self._ended(index, marked_skipped(case))
            elif why := unplayable(case.system):
                self._ended(index, skipped(case, why))
        sampled = [index for index in rest if index not in self.results and self.cases[index].is_sampled]
        self._play([index for index in rest if index not in self.results and index not in sampled])
        if sampled:
            self._draw(sampled)

    def _play(self, playable: Sequence[int]) -> None:
        """Play the cases of one run each."""

        def done(number: int, result: TaskResult) -> None:
            self._ended(playable[number], self._checked(playable[number], result))
            if self.terms.first_failure and failed(self.results[playable[number]]):
                raise EnoughSeenError

        tasks = [self._task(self.cases[index]) for index in playable]
        pool = run_supervised(tasks, self.terms.workers, done, self.terms.on_wait)
        for index, left in zip(playable, pool.results, strict=True):
            if index not in self.results:
                self.results[index] = self._checked(index, left)
        self.interrupted = pool.interrupted

    def _draw(self, sampled: Sequence[int]) -> None:
        """Draw the samples of all cases that have some, unless enough is known."""
        for index in sampled:
            self.results[index] = self._checked(index, TaskResult(TaskStatus.NOT_RUN))
        if self.interrupted or (self.terms.first_failure and any(map(failed, self._done()))):
            return
        from stackdsl.checking.ensembles import (  # noqa: PLC0415 -- it brings scipy
            Drawing,
            checked_samples,
            draw,
        )

        def ended(index: int, drawing: Drawing) -> None:
            if drawing.failed is not None:
                self._ended(index, self._checked(index, drawing.failed))
            else:
                must_claim = self.terms.must_claim
                self._ended(index, checked_samples(drawing.case, drawing.ensemble(), self.goldens, must_claim))
            if self.terms.first_failure and failed(self.results[index]):
                raise EnoughSeenError

        drawings = {index: Drawing(self.cases[index], self._digest(index)) for index in sampled}
        terms = self.terms
        how = terms.workers, terms.time_limit, terms.memory
        self.interrupted = draw(drawings, *how, ended, terms.on_wait, on_drawn=terms.on_drawn)

    def _done(self) -> list[VariantResult]:
        return [result for result in self.results.values() if result.status is not RunStatus.NOT_RUN]

    def _digest(self, index: int) -> str:
        """The digest of the text that a case comes from; empty where nothing of it may be remembered."""
        case = self.selected[index]
        return self.terms.digests[case.file] if _may_be_known(case, self.terms) else ""

    def _task(self, case: Case) -> Task:
        playing, runs = (play_refined, REFINED_COST) if self.terms.refine else (play_case, 1.0)
        may_stop = stop_condition_of(case.scenario, case.system)
        return Task(played_or_blocked, (playing, case.timeline, case.system, may_stop), runs * self.terms.time_limit)

    def _checked(self, index: int, result: TaskResult) -> VariantResult:
        return checked(self.cases[index], result, self.goldens, self.terms.must_claim)

    def _ended(self, index: int, result: VariantResult) -> None:
        self.results[index] = result
        _remember(self.selected[index], result, self.terms)
        if self.terms.waiting is not None and result.golden is not None:
            missed = () if result.may_be_locked else tuple(_missed(each) for each in result.outcomes if not each.passed)
            self.terms.waiting.note(result.name, result.golden, missed, result.file)
        self.on_result(result)


def _missed(outcome: ClaimOutcome) -> str:
    return f"{outcome.span}: {outcome.name}: expected {outcome.expected}, measured {outcome.measured}"


def failed(result: VariantResult) -> bool:
    """Whether a result is one to look into."""
    return result.status is not RunStatus.SKIPPED and (not result.passed or result.golden_failed)


def recalled(case: Listed, terms: CheckConfig) -> VariantResult | None:
    """What came of a case when it was last played, if that is remembered and all that it came from is as it was."""
    if terms.golden is None or terms.update or not _may_be_known(case, terms):
        return None
    digest = text_digest(content(terms.golden / golden_name(case.identity), terms.golden))
    found = from_record(terms.memory.recall(_key(case, digest, terms))) if digest else None
    return None if found is not None and found.unchecked and terms.must_claim else found


def _remember(case: Listed, result: VariantResult, terms: CheckConfig) -> None:
    if may_be_remembered(result) and _may_be_known(case, terms) and result.golden is not None and result.golden.digest:
        terms.memory.remember(_key(case, result.golden.digest, terms), as_record(result))


def _files(found: FoundCases, terms: CheckConfig) -> set[str]:
    """The files of YAML that were found."""
    return {*terms.digests, *(case.file for case in found.cases)}


def _may_be_known(case: Listed, terms: CheckConfig) -> bool:
    """Whether anything may be remembered of it: a file that was not read whole is none that can be as it was."""
    return terms.memory.used and not terms.refine and bool(terms.digests.get(case.file))


def _key(case: Listed, golden_digest: str, terms: CheckConfig) -> str:
    golden = (terms.golden or Path()) / golden_name(case.identity)
    asked = terms.digests[case.file], case.name, case.system, terms.time_limit
    return terms.memory.key("case", case.file, *asked, golden.as_posix(), golden_digest)


def check(
    found: FoundCases,
    selected: Sequence[Listed],
    whole_set: bool,
    terms: CheckConfig,
    on_result: OnResult = lambda _: None,
) -> Report:
    """Play the selected cases and judge them; `on_result` hears of each as it is done.

    With `whole_set`, golden files that belong to none of all that was found are obsolete.
    """
    started = perf_counter()
    unused = unused_goldens(found, terms.golden, terms.digests) if whole_set and terms.golden is not None else ()
    played = _Played(selected, terms, on_result, replace(terms.goldens, unused=unused))
    played.recall()
    try:
        played.play()
    finally:
        terms.memory.settle()
    if terms.waiting is not None:  # also of what is remembered, and so was not played
        goldens = [result.golden for result in played.results.values() if result.golden is not None]
        terms.waiting.forget(golden.file for golden in goldens if golden.status is GoldenStatus.SAME)
        if not found.diagnostics:
            terms.waiting.forget_gone({case.name for case in found.cases}, _files(found, terms))
    if played.interrupted:
        unused = ()
    moved = {result.golden.renamed_from for result in played.results.values() if result.golden is not None}
    unused = tuple(file for file in unused if file not in moved)
    removed = remove_obsolete(unused) if terms.update else ()
    # After an interrupt an update would accept what nobody has seen.
    differ = any(result.golden_failed and result.may_be_locked for result in played.results.values())
    to_accept = (unused or differ) and not played.interrupted
    results = [played.results[index] for index in range(len(selected))]
    shown = [result for result in results if played.interrupted or result.status is not RunStatus.NOT_RUN]
    return Report(
        results=tuple(shown),
        diagnostics=found.diagnostics,
        obsolete=tuple(file for file in unused if file not in removed),
        removed=removed,
        interrupted=played.interrupted,
        left=len(results) - len(shown),
        accept=terms.update_command if to_accept and not terms.update else "",
        wall_time=perf_counter() - started,
    )


def is_whole_set(paths: Sequence[Path], golden: Path, scenarios: Path | None = None) -> bool:
    """Whether all scenarios that the golden directory may belong to are checked.

    They are in `scenarios`, as the project says, or else in the directory of this name beside it, or around it; any
    other directory may hold just some of them.
    """
    # Not Path.resolve, which raises where links form a loop.
    home = Path(os.path.realpath(golden)).parent
    beside = scenarios if scenarios is not None else home / "scenarios"
    wholes = [Path(os.path.realpath(beside)), home, *home.parents]
    return any(os.path.isdir(path) and Path(os.path.realpath(path)) in wholes for path in paths)
