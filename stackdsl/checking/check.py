"""The pipeline of `check`: cases to traces, to outcomes and snapshots, to a report, in supervised processes."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Protocol

from stackdsl.checking.cache import ResultCache, from_record, is_cacheable, to_record
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
from stackdsl.trace import OnDrawn, ignore_progress

# Golden files that belong to no case.


class GoldenOwner(Protocol):
    """A case with a golden file."""

    @property
    def identity(self) -> Identity:
        """The identity of the case, which names the golden file."""

    @property
    def file(self) -> str:
        """The scenario file of the case."""


class GoldenOwners(Protocol):
    """The cases and mistakes of a whole set of scenarios."""

    @property
    def cases(self) -> Sequence[GoldenOwner]:
        """All valid cases."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


def unused_goldens(owners: GoldenOwners, golden: Path, others: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the golden files below a directory that belong to no case of a whole set of scenarios.

    Return none if the set is empty or has a mistake: its cases are unknown then. `others` are scenario files of the set
    that may have no cases.
    """
    if owners.diagnostics or not owners.cases:
        return ()
    used = [golden_name(case.identity) for case in owners.cases]
    return obsolete(golden, used, whole_set=True, checked={*others, *(case.file for case in owners.cases)})


# The pipeline.


TIME_LIMIT = 600.0  # [s] of wall time per case; many times that of the largest scenario
REFINED_COST = 5.0  # cost of a refined run in plain runs: one plain run, and one with twice the steps and iterations


@dataclass(frozen=True, slots=True)
class CheckConfig:
    """The options of a check."""

    golden: Path | None  # directory of the golden files; None to ignore them
    update: bool = False
    workers: int = 1
    time_limit: float = TIME_LIMIT  # [s] of wall time per case
    accept_failing: bool = False  # with `update`, also accept results that fail their expectations
    scenarios: Path | None = None  # directory of the whole set of scenarios; None for that beside `golden`
    update_command: str = ""  # this command line, with an update of the golden files
    refine: bool = False  # play each case again at half the step and twice the iterations
    on_wait: OnWait = lambda: None  # called many times per second while cases run
    on_drawn: OnDrawn = ignore_progress  # called for each chunk of samples
    write_new_goldens: bool = False  # write missing golden files of cases that pass
    first_failure: bool = False  # stop at the first failure
    must_claim: bool = False  # a case without claims fails
    memory: ResultCache = field(default_factory=lambda: ResultCache(Path(), used=False))
    waiting: PendingStore | None = None  # stores differences until a person decides; None to drop them
    digests: Mapping[str, str] = field(default_factory=dict)  # of the inputs of each file, by displayed path

    @property
    def goldens(self) -> Goldens:
        """The options for golden files."""
        return Goldens(
            self.golden,
            self.update,
            self.write_new_goldens and not self.update,
            accept_failing=self.accept_failing,
            scenarios=self.scenarios,
        )


OnResult = Callable[[VariantResult], None]


class FoundCases(Protocol):
    """The cases and mistakes under some paths."""

    @property
    def cases(self) -> Sequence[Listed]:
        """All valid cases."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


@dataclass(slots=True)
class _Check:
    """A check in progress, with the results by the index of the case."""

    selected: Sequence[Listed]
    config: CheckConfig
    on_result: OnResult
    goldens: Goldens
    results: dict[int, VariantResult] = field(default_factory=dict)
    cases: dict[int, Case] = field(default_factory=dict)  # those that run
    interrupted: bool = False

    def recall(self) -> None:
        """Take results from the cache; do not report them, since nothing ran."""
        for index, case in enumerate(self.selected):
            if (result := cached_result(case, self.config)) is not None:
                self.results[index] = result

    def play(self) -> None:
        """Play the remaining cases; skip those that their author or a missing engine excludes."""
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
        """Play the cases that need one run each."""

        def done(number: int, result: TaskResult) -> None:
            self._ended(playable[number], self._checked(playable[number], result))
            if self.config.first_failure and failed(self.results[playable[number]]):
                raise EnoughSeenError

        tasks = [self._task(self.cases[index]) for index in playable]
        pool = run_supervised(tasks, self.config.workers, done, self.config.on_wait)
        for index, remaining in zip(playable, pool.results, strict=True):
            if index not in self.results:
                self.results[index] = self._checked(index, remaining)
        self.interrupted = pool.interrupted

    def _draw(self, sampled: Sequence[int]) -> None:
        """Draw the samples of sampled cases, unless the check ends early."""
        for index in sampled:
            self.results[index] = self._checked(index, TaskResult(TaskStatus.NOT_RUN))
        if self.interrupted or (self.config.first_failure and any(map(failed, self._done()))):
            return
        from stackdsl.checking.ensembles import (  # noqa: PLC0415 -- imports scipy
            Drawing,
            checked_samples,
            draw,
        )

        def ended(index: int, drawing: Drawing) -> None:
            if drawing.failed is not None:
                self._ended(index, self._checked(index, drawing.failed))
            else:
                must_claim = self.config.must_claim
                self._ended(index, checked_samples(drawing.case, drawing.ensemble(), self.goldens, must_claim))
            if self.config.first_failure and failed(self.results[index]):
                raise EnoughSeenError

        drawings = {index: Drawing(self.cases[index], self._digest(index)) for index in sampled}
        config = self.config
        how = config.workers, config.time_limit, config.memory
        self.interrupted = draw(drawings, *how, ended, config.on_wait, on_drawn=config.on_drawn)

    def _done(self) -> list[VariantResult]:
        return [result for result in self.results.values() if result.status is not RunStatus.NOT_RUN]

    def _digest(self, index: int) -> str:
        """Return the digest of the inputs of a case; "" if its results must not be cached."""
        case = self.selected[index]
        return self.config.digests[case.file] if _uses_cache(case, self.config) else ""

    def _task(self, case: Case) -> Task:
        playing, runs = (play_refined, REFINED_COST) if self.config.refine else (play_case, 1.0)
        may_stop = stop_condition_of(case.scenario, case.system)
        return Task(played_or_blocked, (playing, case.timeline, case.system, may_stop), runs * self.config.time_limit)

    def _checked(self, index: int, result: TaskResult) -> VariantResult:
        return checked(self.cases[index], result, self.goldens, self.config.must_claim)

    def _ended(self, index: int, result: VariantResult) -> None:
        self.results[index] = result
        _remember(self.selected[index], result, self.config)
        if self.config.waiting is not None and result.golden is not None:
            missed = () if result.may_be_locked else tuple(_missed(each) for each in result.outcomes if not each.passed)
            self.config.waiting.note(result.name, result.golden, missed, result.file)
        self.on_result(result)


def _missed(outcome: ClaimOutcome) -> str:
    return f"{outcome.span}: {outcome.name}: expected {outcome.expected}, measured {outcome.measured}"


def failed(result: VariantResult) -> bool:
    """Whether a result is a failure, or differs from its golden file."""
    return result.status is not RunStatus.SKIPPED and (not result.passed or result.golden_failed)


def cached_result(case: Listed, config: CheckConfig) -> VariantResult | None:
    """Return the cached result of a case; None if there is none, or if any of its inputs has changed."""
    if config.golden is None or config.update or not _uses_cache(case, config):
        return None
    digest = text_digest(content(config.golden / golden_name(case.identity), config.golden))
    result = from_record(config.memory.recall(_key(case, digest, config))) if digest else None
    return None if result is not None and result.unchecked and config.must_claim else result


def _remember(case: Listed, result: VariantResult, config: CheckConfig) -> None:
    if is_cacheable(result) and _uses_cache(case, config) and result.golden is not None and result.golden.digest:
        config.memory.remember(_key(case, result.golden.digest, config), to_record(result))


def _files(cases: FoundCases, config: CheckConfig) -> set[str]:
    """Return the scenario files of a set."""
    return {*config.digests, *(case.file for case in cases.cases)}


def _uses_cache(case: Listed, config: CheckConfig) -> bool:
    """Whether the result of a case may be cached. A file without a digest was not read completely."""
    return config.memory.used and not config.refine and bool(config.digests.get(case.file))


def _key(case: Listed, golden_digest: str, config: CheckConfig) -> str:
    golden = (config.golden or Path()) / golden_name(case.identity)
    inputs = config.digests[case.file], case.name, case.system, config.time_limit
    return config.memory.key("case", case.file, *inputs, golden.as_posix(), golden_digest)


def check(
    gathered: FoundCases,
    selected: Sequence[Listed],
    whole_set: bool,
    config: CheckConfig,
    on_result: OnResult = lambda _: None,
) -> Report:
    """Play the selected cases and judge them; call `on_result` with each result.

    With `whole_set`, golden files that belong to no case in `gathered` are obsolete.
    """
    started = perf_counter()
    unused = unused_goldens(gathered, config.golden, config.digests) if whole_set and config.golden is not None else ()
    checking = _Check(selected, config, on_result, replace(config.goldens, unused=unused))
    checking.recall()
    try:
        checking.play()
    finally:
        config.memory.settle()
    if config.waiting is not None:  # cached results count, too
        goldens = [result.golden for result in checking.results.values() if result.golden is not None]
        config.waiting.forget(golden.file for golden in goldens if golden.status is GoldenStatus.SAME)
        if not gathered.diagnostics:
            config.waiting.forget_gone({case.name for case in gathered.cases}, _files(gathered, config))
    if checking.interrupted:
        unused = ()
    moved = {result.golden.renamed_from for result in checking.results.values() if result.golden is not None}
    unused = tuple(file for file in unused if file not in moved)
    removed = remove_obsolete(unused) if config.update else ()
    # After an interrupt, an update would accept results that were never reported.
    differ = any(result.golden_failed and result.may_be_locked for result in checking.results.values())
    to_accept = (unused or differ) and not checking.interrupted
    results = [checking.results[index] for index in range(len(selected))]
    shown = [result for result in results if checking.interrupted or result.status is not RunStatus.NOT_RUN]
    return Report(
        results=tuple(shown),
        diagnostics=gathered.diagnostics,
        obsolete=tuple(file for file in unused if file not in removed),
        removed=removed,
        interrupted=checking.interrupted,
        left=len(results) - len(shown),
        accept=config.update_command if to_accept and not config.update else "",
        wall_time=perf_counter() - started,
    )


def is_whole_set(paths: Sequence[Path], golden: Path, scenarios: Path | None = None) -> bool:
    """Whether the paths include all scenarios that own the golden directory.

    These are in `scenarios` if the project sets it, else in the directory `scenarios` beside `golden` or in any
    directory above. Any other directory may contain only some of them.
    """
    # Path.resolve raises an error where links form a loop.
    home = Path(os.path.realpath(golden)).parent
    beside = scenarios if scenarios is not None else home / "scenarios"
    whole_sets = [Path(os.path.realpath(beside)), home, *home.parents]
    return any(os.path.isdir(path) and Path(os.path.realpath(path)) in whole_sets for path in paths)
