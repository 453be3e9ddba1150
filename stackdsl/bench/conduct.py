"""The pipeline of a bench: cases -> jobs -> records, each written down as it comes -> scores -> points."""

import json
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby

from stackdsl.bench.answers import Answer, answer_of
from stackdsl.bench.assessors.assessment import Assessment
from stackdsl.bench.entrants import distributions_of, entrant_named
from stackdsl.bench.journal import Journal
from stackdsl.bench.points import Point, points_of
from stackdsl.bench.run_record import NOT_TAKEN, Record, TruthHeld, finite, job_title, step_text
from stackdsl.bench.scoring import Score, scores_of
from stackdsl.bench.timing import Played, measured_or_blocked
from stackdsl.checking.cases import Case
from stackdsl.checking.results import STATUSES, held_up
from stackdsl.judging.judge import compare_with_truth
from stackdsl.language.repeats import compact
from stackdsl.results import ClaimOutcome, RunStatus, observations
from stackdsl.simulation.brick_tracks import Blocked
from stackdsl.supervising.processes import OnWait, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, WorkerStart
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import Trace

PACKAGES = (
    "stackdsl",
    "clarabel",
    "numpy",
    "pybullet",
    "scipy",
    "mujoco",
    "sapien",
    "compas_cra",
)  # that may change a figure
OnRecord = Callable[[Record], None]


@dataclass(frozen=True, slots=True)
class Job:
    """One case on one system at one time step."""

    case: Case
    name: str  # of the case, without a system
    system: str
    factor: float

    @property
    def settings(self) -> Mapping[str, float | bool | str | None]:
        """All that may change what comes of it."""
        return entrant_named(self.system).settings(self.case.timeline, self.factor)

    @property
    def title(self) -> str:
        """What people call it."""
        return job_title(self.name, self.system, self.factor)

    @property
    def id(self) -> str:
        """Of what is played, and with which settings: from what is written, so the same on every machine."""
        parts = [self.case.variant.values, self.case.variant.parameters, self.system, self.settings]
        return sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class Plan:
    """How a bench is carried out."""

    journal: Journal
    resume: bool
    workers: int
    time_limit: float  # [s] of wall time a run


@dataclass(frozen=True, slots=True)
class Bench:
    """All that came of it."""

    scores: tuple[Score, ...]
    points: tuple[Point, ...]
    answers: Mapping[str, Answer | None]  # by case
    versions: Mapping[str, str]
    wanted: int  # runs
    interrupted: bool


def jobs_of(cases: Iterable[Case], systems: Sequence[str], factors: Sequence[float]) -> list[Job]:
    """Every case on every system at every time step that it has, whatever systems its scenario names.

    But for those that its author wants skipped. `xfail` says nothing here: it is of expectations, and no known answer.
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
    """What is played of a case: also where only proofs are asked for, as engines have none, and what is known of it.

    A collapse is followed, by every system, only where something hits the structure or is known of what becomes of it.
    """
    timeline = case.timeline
    hit = any(not isinstance(action, Placement) or not action.at_rest for action in timeline.actions)
    aftermath = hit or any(truth.stated.needs_post_collapse_run for truth in case.scenario.truth)
    return replace(timeline, watched=True, margins=(), aftermath=aftermath)


def case_name(case: Case) -> str:
    """What people call a case on whatever system."""
    chosen = ",".join(f"{name}={compact(text)}" for name, text in case.variant.parameters)
    return case.scenario.scenario + (f"[{chosen}]" if chosen else "")


def versions(systems: Iterable[str] = ()) -> dict[str, str]:
    """The versions of all that may change a figure of some systems."""
    found = {"python": platform.python_version()}
    for package in (*PACKAGES, *distributions_of(systems)):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def bench(
    jobs: Sequence[Job], plan: Plan, on_record: OnRecord = lambda record: None, on_wait: OnWait = lambda: None
) -> Bench:
    """Do all jobs that are not done yet; an interrupt ends that, and what is there is scored.

    `on_record` hears of each as it is done, and `on_wait` is called many times a second meanwhile.
    """
    made_with = versions({job.system for job in jobs})
    records: dict[str, Record] = {}

    def keep(record: Record) -> None:
        records[record.id] = record
        on_record(record)

    def add(record: Record) -> None:
        plan.journal.add(record)
        keep(record)

    for record in _done_before(jobs, plan, made_with):
        keep(record)
    interrupted = False
    for stage in _stages(jobs):
        for job, why in _refused(stage):
            add(replace(_planned(job, made_with), status=NOT_TAKEN, message=why))
        for job, without_steps in _needless(stage, jobs, records):
            add(as_played(job, without_steps))
        left = [job for job in stage if job.id not in records]
        interrupted = interrupted or _play(left, plan, made_with, add, on_wait)
        if interrupted:
            break
    answers = _answers(jobs)
    scores = scores_of([records[job.id] for job in jobs if job.id in records], answers)
    return Bench(tuple(scores), tuple(points_of(scores)), answers, made_with, len(jobs), interrupted)


def _done_before(jobs: Sequence[Job], plan: Plan, made_with: Mapping[str, str]) -> list[Record]:
    """What an earlier call has done of it with the same versions; nothing if this one is to begin anew."""
    if plan.resume:
        return [record for record in plan.journal.go_on({job.id for job in jobs}) if record.versions == made_with]
    plan.journal.begin()
    return []


def _stages(jobs: Sequence[Job]) -> tuple[list[Job], list[Job]]:
    """The first time step of each case on each system, then the others, which may be needless."""
    first = {(job.name, job.system): job for job in reversed(jobs)}
    return [job for job in jobs if first[job.name, job.system] is job], [
        job for job in jobs if first[job.name, job.system] is not job
    ]


def _refused(stage: Iterable[Job]) -> list[tuple[Job, str]]:
    """The jobs that their entrants cannot take, each with the reason."""
    reasons = [(job, entrant_named(job.system).refusal(job.case.timeline)) for job in stage]
    return [(job, why) for job, why in reasons if why]


def _needless(stage: Iterable[Job], jobs: Iterable[Job], records: Mapping[str, Record]) -> list[tuple[Job, Record]]:
    """The jobs that no time step can change, each with a run that took none."""
    done = [records[job.id] for job in jobs if job.id in records]
    still = {(record.case, record.system): record for record in done if record.done and record.steps == 0}
    return [
        (job, still[job.name, job.system]) for job in stage if job.id not in records and (job.name, job.system) in still
    ]


def as_played(job: Job, played: Record) -> Record:
    """The record of a job that comes to the same, since no step is taken, whatever its length."""
    message = f"no step is taken: as with {step_text(played.factor)}"
    return replace(played, id=job.id, factor=job.factor, settings=job.settings, message=message)


def _play(jobs: Sequence[Job], plan: Plan, made_with: Mapping[str, str], add: OnRecord, on_wait: OnWait) -> bool:
    """Play them, each in a process of its own; whether that was interrupted."""
    tasks = [Task(measured_or_blocked, (job.case.timeline, job.system, job.factor), plan.time_limit) for job in jobs]

    def one_more(index: int, result: TaskResult) -> None:
        add(recorded(jobs[index], result, made_with))

    return run_supervised(tasks, plan.workers, one_more, on_wait, WorkerStart.PREPARED).interrupted


def _answers(jobs: Iterable[Job]) -> dict[str, Answer | None]:
    cases = {job.name: job.case for job in jobs}
    return {name: answer_of(case.scenario, case.timeline) for name, case in cases.items()}


def recorded(job: Job, result: TaskResult, made_with: Mapping[str, str]) -> Record:
    """What is kept of a run."""
    record = replace(_planned(job, made_with), status=STATUSES[result.status].value, message=result.message)
    if isinstance(result.value, Blocked):
        stopped = held_up(job.case, result.value)
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
        runs=played.runs,
        simulated_time=cost.simulated_time,
        steps=cost.steps,
        judgements=cost.judgements,
        solves=sum(cost.proofs.values()),
        peak_memory=played.peak_memory,
        update_median=played.updates.median if played.updates else None,
        update_worst=played.updates.worst if played.updates else None,
    )


def _planned(job: Job, made_with: Mapping[str, str]) -> Record:
    """What is known of a run beforehand."""
    return Record(
        id=job.id,
        case=job.name,
        file=job.case.source.file,
        system=job.system,
        factor=job.factor,
        settings=job.settings,
        versions=made_with,
        status=RunStatus.NOT_RUN.value,
    )


def _truths(case: Case, trace: Trace) -> tuple[TruthHeld, ...]:
    """What is known from outside, held against what moved, as it was when the run ended."""
    seen = replace(trace, moving=())
    return tuple(_held(outcome) for outcome in compare_with_truth(seen, case.scenario, case.variant, case.source))


def _held(outcome: ClaimOutcome) -> TruthHeld:
    off = None if outcome.margin == 0.0 and not outcome.passed else finite(max(0.0, -outcome.margin))
    return TruthHeld(outcome.name, outcome.unit, off, outcome.passed)
