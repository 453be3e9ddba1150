"""The pipeline of `check`: recall results, play the other cases, judge them, remember the results, and report."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import Protocol

from stackdsl.checking.cache import ResultCache, from_record, is_cacheable, to_record
from stackdsl.checking.cases import Case, Listed
from stackdsl.checking.micrometre import Nearby
from stackdsl.checking.play_case import play_case, play_nearby, play_refined, played_or_blocked
from stackdsl.checking.results import Goldens, checked, marked_skipped, missed_by, skipped
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.file_format import golden_name
from stackdsl.goldens.golden import GoldenReader, PendingStore, obsolete, remove_obsolete
from stackdsl.judging.judge import Refinement, stop_condition_of
from stackdsl.results import GoldenStatus, Report, RunStatus, VariantResult
from stackdsl.simulation.known_systems import unplayable
from stackdsl.supervising.processes import EnoughSeenError, OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from stackdsl.trace import OnDrawn, Trace, ignore_progress


class FoundCases(Protocol):
    """The cases and mistakes under some paths."""

    @property
    def cases(self) -> Sequence[Listed]:
        """All valid cases."""

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All mistakes."""


# Golden files that belong to no case.


def unused_goldens(owners: FoundCases, golden: Path, others: Iterable[str] = ()) -> tuple[str, ...]:
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
NEARBY_RUNS = 3.0  # with those to either side
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
    sensitivity: bool = False  # play each case also a micrometre to either side
    on_wait: OnWait = lambda: None  # called many times per second while cases run
    on_drawn: OnDrawn = ignore_progress  # called for each chunk of samples
    on_result: Callable[[VariantResult], None] = lambda _: None  # called after each run
    write_new_goldens: bool = False  # write missing golden files of cases that pass
    first_failure: bool = False  # stop at the first failure
    must_claim: bool = False  # a case without claims fails
    memory: ResultCache = field(default_factory=lambda: ResultCache(Path(), used=False))
    waiting: PendingStore | None = None  # stores differences until a person decides; None to drop them
    digests: Mapping[str, str] = field(default_factory=dict)  # of the inputs of each file, by displayed path
    reader: GoldenReader = field(default_factory=GoldenReader)

    @property
    def goldens(self) -> Goldens:
        """The options for golden files."""
        return Goldens(
            self.golden,
            self.update,
            self.write_new_goldens and not self.update,
            accept_failing=self.accept_failing,
            scenarios=self.scenarios,
            reader=self.reader,
        )


# Results of earlier checks. The key of a record is a digest of all inputs of the case, so a change of any of them plays
# the case again.


def recall(selected: Sequence[Listed], config: CheckConfig) -> dict[int, VariantResult]:
    """Return the cached results of cases by index, without those of which any input has changed."""
    if config.golden is None or config.update:
        return {}
    recalled = {}
    for index, case in enumerate(selected):
        if _uses_cache(case, config) and (result := _recalled(case, config.golden, config)) is not None:
            recalled[index] = result
    return recalled


def _recalled(case: Listed, directory: Path, config: CheckConfig) -> VariantResult | None:
    golden = directory / golden_name(case.identity)
    digest = config.reader.digest(golden, directory)
    result = from_record(config.memory.recall(_key(case, digest, config))) if digest else None
    if result is None or (result.unchecked and config.must_claim):
        return None
    config.reader.take(golden, directory)  # not compared
    return result


def _remember(case: Listed, result: VariantResult, config: CheckConfig) -> None:
    if is_cacheable(result) and _uses_cache(case, config) and result.golden is not None and result.golden.digest:
        config.memory.remember(_key(case, result.golden.digest, config), to_record(result))


def _uses_cache(case: Listed, config: CheckConfig) -> bool:
    """Return True if the result of a case may be cached. A file without a digest was not read completely."""
    return config.memory.used and not config.refine and not config.sensitivity and bool(config.digests.get(case.file))


def _key(case: Listed, golden_digest: str, config: CheckConfig) -> str:
    golden = (config.golden or Path()) / golden_name(case.identity)
    inputs = config.digests[case.file], case.name, case.system, config.time_limit
    return config.memory.key("case", case.file, *inputs, golden.as_posix(), golden_digest)


# Runs of cases in supervised processes.


@dataclass(slots=True)
class _Runs:
    """The runs of a check, and their results by the index of the case."""

    selected: Sequence[Listed]
    config: CheckConfig
    goldens: Goldens
    results: dict[int, VariantResult] = field(default_factory=dict)
    cases: dict[int, Case] = field(default_factory=dict)
    interrupted: bool = False

    def play(self, indices: Sequence[int]) -> None:
        """Play these cases; skip those that their author or a missing engine excludes."""
        self.cases = {index: self.selected[index].compiled() for index in indices}
        for index, case in self.cases.items():
            if case.skip is not None:
                self._ended(index, marked_skipped(case))
            elif why := unplayable(case.system):
                self._ended(index, skipped(case, why))
        left = [index for index in indices if index not in self.results]
        sampled = [index for index in left if self.cases[index].is_sampled]
        self._play_each([index for index in left if index not in sampled])
        if sampled:
            self._draw(sampled)

    def _play_each(self, playable: Sequence[int]) -> None:
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
        finished = [result for result in self.results.values() if result.status is not RunStatus.NOT_RUN]
        if self.interrupted or (self.config.first_failure and any(map(failed, finished))):
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

    def _digest(self, index: int) -> str:
        """Return the digest of the inputs of a case; "" if its results must not be cached."""
        case = self.selected[index]
        return self.config.digests[case.file] if _uses_cache(case, self.config) else ""

    def _task(self, case: Case) -> Task:
        playing: Callable[..., Trace | Refinement | Nearby]
        playing, runs = (play_refined, REFINED_COST) if self.config.refine else (play_case, 1.0)
        if self.config.sensitivity:
            playing, runs = play_nearby, NEARBY_RUNS
        may_stop = stop_condition_of(case.scenario, case.system)
        return Task(played_or_blocked, (playing, case.timeline, case.system, may_stop), runs * self.config.time_limit)

    def _checked(self, index: int, result: TaskResult) -> VariantResult:
        return checked(self.cases[index], result, self.goldens, self.config.must_claim)

    def _ended(self, index: int, result: VariantResult) -> None:
        self.results[index] = result
        _remember(self.selected[index], result, self.config)
        note_pending(result, self.config.waiting)
        self.config.on_result(result)


def failed(result: VariantResult) -> bool:
    """Whether a result is a failure, or differs from its golden file."""
    return result.status is not RunStatus.SKIPPED and (not result.passed or result.golden_failed)


# Differences that wait for a decision.


def note_pending(result: VariantResult, waiting: PendingStore | None) -> None:
    """Store the difference of a result from its golden file, or drop an earlier one."""
    if waiting is not None and result.golden is not None:
        waiting.note(result.name, result.golden, missed_by(result), result.file)


def _drop_settled(gathered: FoundCases, results: Iterable[VariantResult], config: CheckConfig) -> None:
    """Drop the stored differences of cases that agree now, or that no longer exist."""
    if config.waiting is None:
        return
    goldens = [result.golden for result in results if result.golden is not None]
    config.waiting.forget(golden.file for golden in goldens if golden.status is GoldenStatus.SAME)
    if not gathered.diagnostics:
        files = {*config.digests, *(case.file for case in gathered.cases)}
        config.waiting.forget_gone({case.name for case in gathered.cases}, files)


# The check.


def check(
    gathered: FoundCases,
    selected: Sequence[Listed],
    whole_set: bool,
    config: CheckConfig,
    recalled: Mapping[int, VariantResult] | None = None,
) -> Report:
    """Play the selected cases that have no cached result, judge them, and report all results.

    With `whole_set`, golden files that belong to no case in `gathered` are obsolete. `recalled` is the result of
    `recall` for the same cases, if it was called before.
    """
    started = perf_counter()
    unused = unused_goldens(gathered, config.golden, config.digests) if whole_set and config.golden is not None else ()
    recalled = recall(selected, config) if recalled is None else recalled
    runs = _Runs(selected, config, replace(config.goldens, unused=unused))
    try:
        runs.play([index for index in range(len(selected)) if index not in recalled])
    finally:
        config.memory.settle()
    results = [recalled.get(index) or runs.results[index] for index in range(len(selected))]
    _drop_settled(gathered, results, config)
    moved = {result.golden.renamed_from for result in results if result.golden is not None}
    unused = () if runs.interrupted else tuple(file for file in unused if file not in moved)
    removed = remove_obsolete(unused) if config.update else ()
    # After an interrupt, an update would accept results that were never reported.
    differ = any(result.golden_failed and result.may_be_locked for result in results)
    to_accept = (unused or differ) and not runs.interrupted
    shown = [result for result in results if runs.interrupted or result.status is not RunStatus.NOT_RUN]
    return Report(
        results=tuple(shown),
        diagnostics=gathered.diagnostics,
        obsolete=tuple(file for file in unused if file not in removed),
        removed=removed,
        interrupted=runs.interrupted,
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
