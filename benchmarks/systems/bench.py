"""The pipeline of a bench: cases -> jobs -> records -> scores -> points."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import isfinite

from benchmarks.figures.data import versions
from benchmarks.systems.answers import Answer, answer_of
from benchmarks.systems.assessment import Assessment
from benchmarks.systems.entrants import entrant_named
from benchmarks.systems.points import Point, points_of
from benchmarks.systems.run_record import NOT_TAKEN, Record, TruthHeld, step_text
from benchmarks.systems.scoring import Score, scores_of
from benchmarks.systems.timing import Played, measured_or_blocked
from stackdsl.checking.cases import Case
from stackdsl.checking.results import STATUSES, blocked_result
from stackdsl.judging.judge import compare_with_truth
from stackdsl.language.repeats import compact
from stackdsl.results import ClaimOutcome, RunStatus, observations
from stackdsl.simulation.brick_tracks import Blocked
from stackdsl.simulation.plugins import distributions_of
from stackdsl.supervising.processes import OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, WorkerStart
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import Trace

TIME_LIMIT = 240.0  # [s] of wall time per run
# Kinds of truth that do not constrain a structure after its collapse.
OF_NO_AFTERMATH = {"stands", "collapses", "verdict", "margin", "sway"}
OnRecord = Callable[[Record], None]


@dataclass(frozen=True, slots=True)
class Job:
    """One case on one system at one time step."""

    case: Case
    name: str  # of the case, without a system
    system: str
    factor: float

    @property
    def planned(self) -> Record:
        """Return the record of a run before its start."""
        return Record(self.name, self.system, self.factor, RunStatus.NOT_RUN.value)


@dataclass(frozen=True, slots=True)
class Bench:
    """Scores of all finished runs, and the points computed from them."""

    scores: tuple[Score, ...]
    points: tuple[Point, ...]
    answers: Mapping[str, Answer | None]  # by case
    versions: Mapping[str, str]
    wanted: int  # number of runs
    interrupted: bool


def jobs_of(cases: Iterable[Case], systems: Sequence[str], factors: Sequence[float]) -> list[Job]:
    """Return every case on every system at all its time steps, independent of the systems of its scenario.

    Cases marked `skip` are left out. `xfail` is ignored here: it concerns expectations, not known results.
    """
    jobs = []
    for _, same in groupby(cases, key=lambda case: (case.scenario.scenario, case.variant.parameters)):
        case = next(same)
        case = replace(case, timeline=_until_answered(case))
        named, runs = case_name(case), [(name, f) for name in systems for f in entrant_named(name).factors(factors)]
        jobs += [Job(case, named, system, factor) for system, factor in runs if not _is_skipped(case, system)]
    return jobs


def _is_skipped(case: Case, system: str) -> bool:
    return case.scenario.skip is not None and case.scenario.skip.is_of(system)


def _until_answered(case: Case) -> Timeline:
    """Return the timeline, played also if only proofs are required, since engines have none.

    Every system follows a collapse only if something hits the structure or a truth states its aftermath.
    """
    timeline = case.timeline
    hit = any(not isinstance(action, Placement) or not action.at_rest for action in timeline.actions)
    aftermath = hit or any(truth.kind not in OF_NO_AFTERMATH for truth in case.scenario.truth)
    return replace(timeline, watched=True, margins=(), aftermath=aftermath)


def case_name(case: Case) -> str:
    """Return the name of a case without a system."""
    chosen = ",".join(f"{name}={compact(text)}" for name, text in case.variant.parameters)
    return case.scenario.scenario + (f"[{chosen}]" if chosen else "")


def bench(jobs: Sequence[Job], on_record: OnRecord = lambda record: None, on_wait: OnWait = lambda: None) -> Bench:
    """Run all jobs one at a time, as parallel runs would disturb the times; an interrupt ends the bench.

    `on_record` is called with each record, and `on_wait` many times a second meanwhile.
    """
    records: dict[str, Record] = {}

    def add(record: Record) -> None:
        records[record.name] = record
        on_record(record)

    interrupted = False
    for stage in _stages(jobs):
        for job in stage:
            if why := entrant_named(job.system).refusal(job.case.timeline):
                add(replace(job.planned, status=NOT_TAKEN, message=why))
            elif (same := _without_steps(job, records.values())) is not None:
                add(replace(same, factor=job.factor, message=f"no step is taken: as with {step_text(same.factor)}"))
        interrupted = interrupted or _play([job for job in stage if job.planned.name not in records], add, on_wait)
        if interrupted:
            break
    answers = _answers(jobs)
    scores = scores_of([records[name] for job in jobs if (name := job.planned.name) in records], answers)
    made_with = versions(distributions_of(job.system for job in jobs))
    return Bench(tuple(scores), tuple(points_of(scores)), answers, made_with, len(jobs), interrupted)


def _stages(jobs: Sequence[Job]) -> tuple[list[Job], list[Job]]:
    """Return the first time step of each case on each system, then the others, which may turn out to be needless."""
    first = {(job.name, job.system): job for job in reversed(jobs)}
    return [job for job in jobs if first[job.name, job.system] is job], [
        job for job in jobs if first[job.name, job.system] is not job
    ]


def _without_steps(job: Job, records: Iterable[Record]) -> Record | None:
    """Return a run of the same case and system without steps, whose result does not depend on the time step."""
    same = (record for record in records if (record.case, record.system) == (job.name, job.system))
    return next((record for record in same if record.done and record.steps == 0), None)


def _play(jobs: Sequence[Job], add: OnRecord, on_wait: OnWait) -> bool:
    """Play jobs, each in a process of its own; return whether this was interrupted."""
    tasks = [Task(measured_or_blocked, (job.case.timeline, job.system, job.factor), TIME_LIMIT) for job in jobs]

    def one_more(index: int, result: TaskResult) -> None:
        add(recorded(jobs[index], result))

    return run_supervised(tasks, 1, one_more, on_wait, WorkerStart.PREPARED).interrupted


def _answers(jobs: Iterable[Job]) -> dict[str, Answer | None]:
    cases = {job.name: job.case for job in jobs}
    return {name: answer_of(case.scenario, case.timeline) for name, case in cases.items()}


def recorded(job: Job, result: TaskResult) -> Record:
    """Return the record of a run."""
    record = replace(job.planned, status=STATUSES[result.status].value, message=result.message)
    if isinstance(result.value, Blocked):
        stopped = blocked_result(job.case, result.value)
        return replace(record, status=stopped.status.value, message=stopped.message)
    if not isinstance(result.value, Played):
        return record
    played, told, cost = result.value, result.value.result, result.value.result.cost
    return replace(
        record,
        numerical=told.numerical,
        levels=job.case.timeline.levels,
        observations=told.observations if isinstance(told, Assessment) else observations(told),
        truths=() if isinstance(told, Assessment) else _truths(job.case, told),
        wall_time=played.wall_time,
        simulated_time=cost.simulated_time,
        steps=cost.steps,
        solves=sum(cost.proofs.values()),
        peak_memory=played.peak_memory,
        update_median=played.updates.median if played.updates else None,
        update_worst=played.updates.worst if played.updates else None,
    )


def _truths(case: Case, trace: Trace) -> tuple[TruthHeld, ...]:
    """Return the truths compared with the moving structure at the end of the run."""
    seen = replace(trace, moving=())
    return tuple(_held(outcome) for outcome in compare_with_truth(seen, case.scenario, case.variant, case.source))


def _held(outcome: ClaimOutcome) -> TruthHeld:
    off = max(0.0, -outcome.margin)
    has_distance = isfinite(off) and (outcome.passed or outcome.margin != 0.0)
    return TruthHeld(outcome.name, outcome.unit, off if has_distance else None)
