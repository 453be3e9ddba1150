"""The result of one case: its run judged and compared with its golden file, or the reason why there is no run."""

from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from stackdsl.checking.cases import STDIN_SHOWN, Case
from stackdsl.checking.failure_cause import failure_cause_of
from stackdsl.checking.micrometre import Nearby
from stackdsl.compiler.compile import origin_of, where_placed
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.file_format import golden_name
from stackdsl.goldens.golden import GoldenReader, check_golden, keeper_of, renamed_from
from stackdsl.goldens.snapshot import Snapshot, current_stamp, take
from stackdsl.judging.judge import Refinement, compare_with_truth, judge
from stackdsl.judging.notes import left_out, warnings_about
from stackdsl.project_file import SCENARIOS
from stackdsl.results import EarlyEndSummary, GoldenResult, GoldenStatus, RunStatus, VariantResult
from stackdsl.simulation.brick_tracks import Blocked
from stackdsl.simulation.known_systems import KNOWN, system_named
from stackdsl.simulation.systems import SYSTEMS, as_played
from stackdsl.supervising.worker import TaskResult, TaskStatus
from stackdsl.timeline import MoveAction
from stackdsl.trace import Trace
from stackdsl.wording import mm
from stackdsl.work import HINT

STATUSES = {
    TaskStatus.DONE: RunStatus.DONE,
    TaskStatus.CRASHED: RunStatus.CRASHED,
    TaskStatus.TIMED_OUT: RunStatus.TIMED_OUT,
    TaskStatus.NOT_RUN: RunStatus.NOT_RUN,
}
SLOW = "raise --time-limit, use fewer bricks, or simulate a shorter time"


@dataclass(frozen=True, slots=True)
class Goldens:
    """The options for golden files."""

    folder: Path | None  # None to ignore golden files
    update: bool = False  # accept all results that meet their expectations
    write_new_goldens: bool = False  # write missing golden files of cases that pass
    unused: tuple[str, ...] = ()  # golden files without a case; a case may have been renamed from one of them
    accept_failing: bool = False  # with `update`, also accept results that fail their expectations
    scenarios: Path | None = None  # golden files of this directory name no keeper; None for that beside `folder`
    reader: GoldenReader = field(default_factory=GoldenReader)


def checked(case: Case, result: TaskResult, goldens: Goldens, must_claim: bool = False) -> VariantResult:
    """Return the result of a case: expectations, truths, and the comparison with its golden file.

    With `must_claim`, a case without claims fails.
    """
    if isinstance(result.value, Refinement):
        return replace(_compared(case, result.value.trace, goldens, must_claim), refinement=result.value.changes)
    if isinstance(result.value, Nearby):
        return replace(_compared(case, result.value.trace, goldens, must_claim), sensitivity=result.value.changes)
    if isinstance(result.value, Trace):
        return _compared(case, result.value, goldens, must_claim)
    if isinstance(result.value, Blocked):
        return blocked_result(case, result.value)
    if isinstance(result.value, Diagnostic):  # of a sample with an invalid value
        return replace(_unfinished(case, RunStatus.BLOCKED, result.value.message), mistake=result.value)
    return stopped(case, result)


def stopped(case: Case, result: TaskResult) -> VariantResult:
    """Return the result of a case that crashed, took too long or was not run; an engine of a plug-in is named."""
    message = result.message
    if message and not result.details and case.system not in KNOWN:  # a signal, or the time limit
        from stackdsl.simulation.plugin_world import engine_text  # noqa: PLC0415 -- rare

        ended = "ended its process: " if result.status is TaskStatus.CRASHED else ""
        message = f"{engine_text(system_named(case.system))} {ended}{message}"
    remedy = SLOW if result.status is TaskStatus.TIMED_OUT else ""
    return replace(_unfinished(case, STATUSES[result.status], message), remedy=remedy, traceback=result.details)


def blocked_result(case: Case, blocked: Blocked) -> VariantResult:
    """Return the result of a case with an action that could not be carried out, with the position of that action."""
    mistake = _obstacle(case, blocked)
    return replace(_unfinished(case, RunStatus.BLOCKED, mistake.message), mistake=mistake)


def skipped(case: Case, why: str) -> VariantResult:
    """Return the result of a case whose engine is missing."""
    return _unfinished(case, RunStatus.SKIPPED, why)


def marked_skipped(case: Case) -> VariantResult:
    """Return the result of a case that its author skips."""
    return replace(_unfinished(case, RunStatus.SKIPPED, case.skip or ""), set_aside=True)


def _unfinished(case: Case, status: RunStatus, message: str) -> VariantResult:
    name = case.identity
    where = name.scenario, name.variant, case.system, case.source.file
    return VariantResult(*where, status, message=message, parameters=case.parameters)


def _obstacle(case: Case, blocked: Blocked) -> Diagnostic:
    if blocked.unplayed and case.timeline.world.ties:
        hint = "draw the ties tighter, claim only `verdict` and `margin`, run it on `exact`, or remove `ties`"
        return Diagnostic("SD214", case.source.key_span_of(("ties",)), blocked.unplayed, hint)
    if blocked.unplayed:
        if not case.timeline.world.has_joints and not case.timeline.has_loads:
            first = next(iter(case.timeline.world.strengths))
            span = where_placed(first, case.scenario, case.source)
            hint = "change a length, a mass or a strength slightly, run it on `exact`, or remove `strength`"
            return Diagnostic("SD213", span, blocked.unplayed, hint)
        key = "joints" if case.timeline.world.has_joints else "loads"
        span = case.source.key_span_of((key,))
        return Diagnostic("SD211", span, blocked.unplayed, f"run it on `exact`, or remove `{key}`")
    if blocked.too_much:
        hint = (
            f"use fewer bricks, move hands faster, simulate a shorter time, or use claims that statics decides; {HINT}"
        )
        return Diagnostic("SD206", where_placed(blocked.brick, case.scenario, case.source), blocked.too_much, hint)
    if blocked.pressed is not None:
        return _pressed(case, blocked)
    finer = ", at half the step and twice the iterations," if blocked.refined else ""
    message = (
        f"brick '{blocked.brick}' cannot be placed at {blocked.time:g} s: by then{finer} brick '{blocked.by}' has "
        f"moved into its place, and overlaps it by {mm(blocked.depth, 3)}"
    )
    elsewhere = "throw it from elsewhere" if blocked.thrown else "place it elsewhere"
    hint = f"{elsewhere}, or earlier, or pull out '{blocked.by}' before"
    return Diagnostic("SD208", where_placed(blocked.brick, case.scenario, case.source), message, hint)


def _pressed(case: Case, blocked: Blocked) -> Diagnostic:
    """Return the diagnostic of a hand whose path is blocked by an immovable body."""
    moves = (a for a in case.timeline.actions if isinstance(a, MoveAction) and a.brick == blocked.brick)
    begun = [move for move in moves if move.time <= blocked.time]
    origin = origin_of(begun[-1], case.scenario, case.source) if begun else None
    span = origin.span if origin is not None else where_placed(blocked.brick, case.scenario, case.source)
    return Diagnostic("SD210", span, blocked.in_words(), "end its path before that, or clear the path")


def _compared(case: Case, trace: Trace, goldens: Goldens, must_claim: bool) -> VariantResult:
    result = replace(judged(case, trace), must_claim=must_claim)
    # Systems of other packages and scenarios from standard input have no golden files.
    if goldens.folder is None or case.system not in SYSTEMS or case.file == STDIN_SHOWN:
        return result
    return replace(result, golden=compare_with_golden(snapshot_of(case, trace), goldens, case.source.file, result))


def compare_with_golden(snapshot: Snapshot, goldens: Goldens, file: str, result: VariantResult) -> GoldenResult:
    """Compare a snapshot with its golden file; write failing results only with `accept_failing`."""
    assert goldens.folder is not None
    update = goldens.update and (result.may_be_locked or goldens.accept_failing)
    write_new_goldens = goldens.write_new_goldens and result.may_be_locked
    keeper = keeper_of(file, goldens.folder, goldens.scenarios or goldens.folder.parent / SCENARIOS)
    stored = goldens.reader.take(goldens.folder / golden_name(snapshot.identity), goldens.folder)
    compare = partial(check_golden, replace(snapshot, kept_by=keeper), goldens.folder, stored=stored)
    golden = compare(update, write_new_goldens and not goldens.unused)
    if golden.status is GoldenStatus.MISSING and goldens.unused:
        if old_name := renamed_from(snapshot, goldens.unused):
            return replace(golden, status=GoldenStatus.RENAMED, note=f"it was {old_name}", renamed_from=old_name)
        if write_new_goldens:
            return compare(update=False, write_new_goldens=True)
    return golden


def judged(case: Case, trace: Trace) -> VariantResult:
    """Return the result of a run without the comparison with its golden file."""
    outcomes = judge(trace, case.scenario, case.variant, case.source, case.system)
    xfail = case.scenario.xfail
    marked = xfail is not None and xfail.is_of(case.system)
    engine = system_named(case.system).engine
    return VariantResult(
        xfail=xfail.reason if xfail is not None and marked else None,
        strict=xfail is not None and marked and xfail.strict,
        scenario=case.identity.scenario,
        variant=case.identity.variant,
        system=case.system,
        file=case.source.file,
        status=RunStatus.DONE,
        verdict=trace.reported_verdict,
        numerical=trace.numerical,
        wrong_edges=trace.wrong_edges,
        wrong_friction=trace.wrong_friction,
        touching_within=trace.statics.touching_within if trace.statics is not None else 0.0,
        passed_through=trace.passed_through,
        energy_gained=trace.energy_gained,
        collapse=trace.collapse,
        moving=trace.moving,
        early_end=EarlyEndSummary.by(trace.early_end),
        warnings=(
            *case.source.warnings,
            *warnings_about(outcomes, trace),
            *left_out(case.timeline, trace, case.scenario, case.source),
        ),
        drift=trace.drift,
        engine=engine.name or engine.package.name if trace.cost.steps else "",
        modified=system_named(case.system).modification.summary,
        cost=trace.cost,
        outcomes=outcomes,
        why=None
        if (all(o.passed for o in outcomes) if outcomes else trace.collapse is None)
        else failure_cause_of(case, trace),
        truths=compare_with_truth(trace, case.scenario, case.variant, case.source),
        parameters=case.parameters,
    )


def missed_by(result: VariantResult) -> tuple[str, ...]:
    """Return the expectations because of which a result is not accepted; none if it passed or was marked to fail."""
    if result.may_be_locked:
        return ()
    return tuple(
        f"{each.span}: {each.name}: expected {each.expected}, measured {each.measured}"
        for each in result.outcomes
        if not each.passed
    )


def snapshot_of(case: Case, trace: Trace) -> Snapshot:
    """Return the snapshot of a run; positions are exact only for systems with a stabilizer."""
    system = system_named(case.system)
    stamp = current_stamp(system.engine.package.name, trace.cost.steps)
    world = as_played(case.timeline, system.modification).world
    return take(trace, world, case.identity, stamp, system.extension, case.timeline.actions)
