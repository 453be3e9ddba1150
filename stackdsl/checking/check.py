"""The pipeline: cases -> traces -> outcomes and snapshots -> report. Worlds are stepped in supervised processes."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import TypeVar

from stackdsl.checking.gathering import Case, Gathered
from stackdsl.checking.processes import OnWait, run_supervised
from stackdsl.checking.worker import Task, TaskResult, TaskStatus
from stackdsl.compiling.compiler import where_placed
from stackdsl.diagnostics import Diagnostic
from stackdsl.judging.judge import compare_with_truth, judge
from stackdsl.judging.numerical import Refinement, held_against_refined, with_numerical_collapse
from stackdsl.outcome import Report, RunStatus, VariantResult
from stackdsl.playing.clearance import Blocked, BlockedPlacementError
from stackdsl.playing.runner import play
from stackdsl.snapshots.golden import check_golden, golden_name, obsolete, remove_obsolete
from stackdsl.snapshots.record import Snapshot
from stackdsl.snapshots.snapshot import take
from stackdsl.snapshots.stamp import current_stamp
from stackdsl.systems.known_systems import system_named, unplayable
from stackdsl.systems.systems import SYSTEMS
from stackdsl.timeline import Timeline
from stackdsl.trace import Event, Trace
from stackdsl.wording import mm

STATUSES = {
    TaskStatus.DONE: RunStatus.DONE,
    TaskStatus.CRASHED: RunStatus.CRASHED,
    TaskStatus.TIMED_OUT: RunStatus.TIMED_OUT,
    TaskStatus.NOT_RUN: RunStatus.NOT_RUN,
}
REMEDIES = {
    TaskStatus.DONE: "",
    TaskStatus.CRASHED: "to see where, play it alone: STACKDSL_DEBUG=1 stackdsl run {file} -k '{name}'",
    TaskStatus.TIMED_OUT: "allow more by --time-limit, or let it build less or be watched for less",
    TaskStatus.NOT_RUN: "",
}  # for what ended so
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


Played = TypeVar("Played")
OnResult = Callable[[VariantResult], None]


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
    results: dict[int, VariantResult] = {}

    def ended(index: int, result: VariantResult) -> None:
        results[index] = result
        on_result(result)

    for index, case in enumerate(selected):
        if why := unplayable(case.system):
            ended(index, skipped(case, why))
    playable = [index for index in range(len(selected)) if index not in results]
    playing, limit = (play_refined, REFINED_COST * terms.time_limit) if terms.refine else (play_case, terms.time_limit)
    tasks = [
        Task(played_or_blocked, (playing, selected[index].timeline, selected[index].system), limit)
        for index in playable
    ]

    def done(number: int, result: TaskResult) -> None:
        ended(playable[number], checked(selected[playable[number]], result, terms))

    pool = run_supervised(tasks, terms.workers, done, terms.on_wait)
    for index, left in zip(playable, pool.results, strict=True):
        if index not in results:
            results[index] = checked(selected[index], left, terms)
    known = whole_set and bool(gathered.cases) and not gathered.diagnostics and not pool.interrupted
    unused = obsolete(terms.golden, [golden_name(case.identity) for case in gathered.cases], known)
    removed = remove_obsolete(unused) if terms.update else ()
    # After an interrupt an update would accept what nobody has seen.
    to_accept = (unused or any(result.golden_failed for result in results.values())) and not pool.interrupted
    return Report(
        results=tuple(results[index] for index in range(len(selected))),
        diagnostics=gathered.diagnostics,
        obsolete=tuple(file for file in unused if file not in removed),
        removed=removed,
        interrupted=pool.interrupted,
        accept=terms.update_command if to_accept and not terms.update else "",
        wall_time=perf_counter() - started,
    )


def play_case(timeline: Timeline, system: str, on_event: Callable[[Event], None] = lambda event: None) -> Trace:
    """What a worker does. The engine is imported there, where a scene needs it, and nowhere before."""
    trace = with_numerical_collapse(play(timeline, system_named(system), on_event), timeline, system_named(system))
    if not timeline.margins or trace.statics is None:
        return trace
    from stackdsl.judging.margins import margins_of  # noqa: PLC0415 -- programs bring numpy

    return replace(trace, margins=margins_of(trace, timeline.margins))


def played_or_blocked(playing: Callable[..., Played], *arguments: object) -> Played | Blocked:
    """What a worker does: play, or tell what keeps the run from going on, which is no crash."""
    try:
        return playing(*arguments)
    except BlockedPlacementError as error:
        return error.blocked


def play_refined(timeline: Timeline, name: str) -> Refinement:
    """What a worker does to see what of a run is the solver's; where no step was taken, nothing is."""
    trace = play_case(timeline, name)
    if trace.cost.steps == 0:
        return Refinement(trace)
    system = system_named(name).refined()
    try:
        fine = play(timeline, system)
    except BlockedPlacementError as error:
        raise BlockedPlacementError(replace(error.blocked, refined=True)) from error
    return held_against_refined(trace, with_numerical_collapse(fine, timeline, system), timeline)


def checked(case: Case, result: TaskResult, terms: Terms) -> VariantResult:
    """The result of a case: expectations, truths, and the comparison with its golden file."""
    if isinstance(result.value, Refinement):
        whole = _compared(case, result.value.trace, terms)
        return replace(whole, refinement=result.value.changes)
    if isinstance(result.value, Trace):
        return _compared(case, result.value, terms)
    if isinstance(result.value, Blocked):
        return held_up(case, result.value)
    remedy = REMEDIES[result.status].format(file=case.source.file, name=case.name)
    return _unfinished(case, STATUSES[result.status], "; ".join(filter(None, [result.message, remedy])))


def held_up(case: Case, blocked: Blocked) -> VariantResult:
    """The result of a case that could not go on, with the place of the action that could not be done."""
    mistake = _in_the_way(case, blocked)
    return replace(_unfinished(case, RunStatus.BLOCKED, mistake.message), mistake=mistake)


def skipped(case: Case, why: str) -> VariantResult:
    """The result of a case whose engine is not there."""
    return _unfinished(case, RunStatus.SKIPPED, why)


def _unfinished(case: Case, status: RunStatus, message: str) -> VariantResult:
    name = case.identity
    return VariantResult(name.scenario, name.variant, case.system, case.source.file, status, message=message)


def _in_the_way(case: Case, blocked: Blocked) -> Diagnostic:
    finer = ", at half the step and twice the iterations," if blocked.refined else ""
    message = (
        f"brick '{blocked.brick}' cannot be placed at {blocked.time:g} s: by then{finer} brick '{blocked.by}' has "
        f"moved into its place, and overlaps it by {mm(blocked.depth, 3)}"
    )
    elsewhere = "let it come from elsewhere" if blocked.thrown else "place it elsewhere"
    hint = f"{elsewhere}, or earlier, or pull '{blocked.by}' out before"
    return Diagnostic("SD208", where_placed(blocked.brick, case.scenario, case.source), message, hint)


def _compared(case: Case, trace: Trace, terms: Terms) -> VariantResult:
    if case.system not in SYSTEMS:  # what came with another package is nobody's snapshot
        return judged(case, trace)
    golden = check_golden(snapshot_of(case, trace), terms.golden, terms.update)
    return replace(judged(case, trace), golden=golden)


def judged(case: Case, trace: Trace) -> VariantResult:
    """The result of a case that was played, without its golden file."""
    return VariantResult(
        scenario=case.identity.scenario,
        variant=case.identity.variant,
        system=case.system,
        file=case.source.file,
        status=RunStatus.DONE,
        verdict=trace.reported_verdict,
        numerical=trace.numerical,
        wrong_edges=trace.wrong_edges,
        collapse=trace.collapse,
        drift=trace.drift,
        engine=system_named(case.system).engine.package.name if trace.cost.steps else "",
        cost=trace.cost,
        outcomes=judge(trace, case.scenario, case.variant, case.source, case.system),
        truths=compare_with_truth(trace, case.scenario, case.variant, case.source),
    )


def snapshot_of(case: Case, trace: Trace) -> Snapshot:
    """What is locked of a run. Only what a model has proven or computed is locked to the millimetre."""
    system = system_named(case.system)
    stamp = current_stamp(system.engine.package.name, trace.cost.steps)
    return take(trace, case.timeline.world, case.identity, stamp, modelled=system.extension)


def is_whole_set(paths: Sequence[Path], golden: Path) -> bool:
    """Whether all scenarios that the golden directory may belong to are checked.

    They are in `scenarios` beside it, or around it; any other directory may hold just some of them.
    """
    # Not Path.resolve, which raises where links form a loop.
    home = Path(os.path.realpath(golden)).parent
    scenarios = home / "scenarios"
    # What is gathered from around follows no links.
    around = [] if scenarios.is_symlink() else [home, *home.parents]
    wholes = [Path(os.path.realpath(scenarios)), *around]
    return any(path.is_dir() and Path(os.path.realpath(path)) in wholes for path in paths)
