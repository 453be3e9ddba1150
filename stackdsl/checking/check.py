"""The pipeline: cases -> traces -> outcomes and snapshots -> report. Worlds are stepped in supervised processes."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from stackdsl.checking.gathering import Case, Gathered
from stackdsl.checking.one_case import play_case, play_refined, played_or_blocked
from stackdsl.checking.processes import OnWait, run_supervised
from stackdsl.checking.results import checked, skipped
from stackdsl.checking.worker import Task, TaskResult
from stackdsl.judging.known import known_of
from stackdsl.outcome import Report, VariantResult
from stackdsl.snapshots.golden import golden_name, obsolete, remove_obsolete
from stackdsl.systems.known_systems import unplayable

TIME_LIMIT = 600.0  # [s] of wall time a case; many times what the largest scenario takes
REFINED_COST = 5.0  # runs' worth of time: the run, and one with twice the steps of twice the iterations


@dataclass(frozen=True, slots=True)
class Terms:
    """How a check is carried out."""

    golden: Path
    update: bool = False
    workers: int = 1
    time_limit: float = TIME_LIMIT  # [s] of wall time a case
    update_command: str = ""  # the same call, with an update of the golden files
    refine: bool = False  # play each case again at half the step and twice the iterations
    on_wait: OnWait = lambda: None  # called several times a second while cases are played


OnResult = Callable[[VariantResult], None]


@dataclass(slots=True)
class _Played:
    """The results of a check by the number of the case, each told as it comes."""

    selected: Sequence[Case]
    terms: Terms
    on_result: OnResult
    results: dict[int, VariantResult] = field(default_factory=dict)
    interrupted: bool = False

    def play(self) -> None:
        """Play all that can be played here, and tell of the rest why it cannot."""
        for index, case in enumerate(self.selected):
            if why := unplayable(case.system):
                self._ended(index, skipped(case, why))
        playable = [index for index in range(len(self.selected)) if index not in self.results]

        def done(number: int, result: TaskResult) -> None:
            self._ended(playable[number], self._checked(playable[number], result))

        tasks = [self._task(self.selected[index]) for index in playable]
        pool = run_supervised(tasks, self.terms.workers, done, self.terms.on_wait)
        for index, left in zip(playable, pool.results, strict=True):
            if index not in self.results:
                self.results[index] = self._checked(index, left)
        self.interrupted = pool.interrupted

    def _task(self, case: Case) -> Task:
        playing, runs = (play_refined, REFINED_COST) if self.terms.refine else (play_case, 1.0)
        is_known = known_of(case.scenario, case.system)
        return Task(played_or_blocked, (playing, case.timeline, case.system, is_known), runs * self.terms.time_limit)

    def _checked(self, index: int, result: TaskResult) -> VariantResult:
        return checked(self.selected[index], result, self.terms.golden, self.terms.update)

    def _ended(self, index: int, result: VariantResult) -> None:
        self.results[index] = result
        self.on_result(result)


def check(
    gathered: Gathered,
    selected: Sequence[Case],
    whole_set: bool,
    terms: Terms,
    on_result: OnResult = lambda _: None,
) -> Report:
    """Play the selected cases and judge them; `on_result` hears of each as it is done.

    With `whole_set`, golden files that belong to none of all gathered cases are obsolete.
    """
    started = perf_counter()
    played = _Played(selected, terms, on_result)
    played.play()
    known = whole_set and bool(gathered.cases) and not gathered.diagnostics and not played.interrupted
    unused = obsolete(terms.golden, [golden_name(case.identity) for case in gathered.cases], known)
    removed = remove_obsolete(unused) if terms.update else ()
    # After an interrupt an update would accept what nobody has seen.
    to_accept = (unused or any(result.golden_failed for result in played.results.values())) and not played.interrupted
    return Report(
        results=tuple(played.results[index] for index in range(len(selected))),
        diagnostics=gathered.diagnostics,
        obsolete=tuple(file for file in unused if file not in removed),
        removed=removed,
        interrupted=played.interrupted,
        accept=terms.update_command if to_accept and not terms.update else "",
        wall_time=perf_counter() - started,
    )


def is_whole_set(paths: Sequence[Path], golden: Path) -> bool:
    """Whether all scenarios that the golden directory may belong to are checked.

    They are in `scenarios` beside it, or around it; any other directory may hold just some of them.
    """
    # Not Path.resolve, which raises where links form a loop.
    home = Path(os.path.realpath(golden)).parent
    scenarios = home / "scenarios"
    wholes = [Path(os.path.realpath(scenarios)), home, *home.parents]
    return any(path.is_dir() and Path(os.path.realpath(path)) in wholes for path in paths)
