"""Which runs a bench consists of, and how it goes on after a stop; without an engine."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from stackdsl.bench import conduct
from stackdsl.bench.conduct import Job, Plan, bench, jobs_of, versions
from stackdsl.bench.journal import Journal
from stackdsl.bench.page import bench_page
from stackdsl.bench.summary import bench_json
from stackdsl.bench.table import bench_text
from stackdsl.results import RunStatus
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.supervising.processes import OnWait, PoolResult
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, WorkerStart
from tests.stackdsl.bench.runs import RECORD, case_of


def jobs() -> list[Job]:
    return jobs_of([case_of("- column: {levels: 1}")], ["exact", "tuned"], [1.0, 0.5])


def doing(only: int, asked: list[Task]) -> Callable[..., PoolResult]:
    """A pool that is interrupted after so many tasks."""

    def supervised(
        tasks: Sequence[Task], workers: int, on_done: Callable[..., None], on_wait: OnWait, start: WorkerStart
    ) -> PoolResult:
        asked.extend(tasks)
        results = [TaskResult(TaskStatus.CRASHED, message="for want of an engine")] * len(tasks)
        for index, result in enumerate(results[:only]):
            on_done(index, result)
        return PoolResult(tuple(results), interrupted=only < len(tasks))

    return supervised


@pytest.mark.parametrize(
    ("rest", "followed"),
    [
        ("truth:\n  - {collapses: {at: level 3}, source: closed form}\n", False),
        ("truth:\n  - {falls: {count: 2}, source: closed form}\n", True),
    ],
)
def test_a_collapse_is_followed_by_every_system_only_if_it_is_known_what_becomes_of_it(
    rest: str, followed: bool
) -> None:
    case = case_of("- column: {levels: 3, step: 45 mm}\n  every: 1 s", rest)
    for system in ("exact", "stock"):
        (job,) = jobs_of([case], [system], [1.0])
        trace = play(job.case.timeline, SYSTEMS[system])
        assert trace.collapse is not None
        assert (trace.cost.simulated_time > trace.collapse.time + 0.5) is followed


def test_what_is_hit_is_played_to_its_end_whatever_is_known() -> None:
    hit = "impacts:\n  - push: {brick: L1.1, impulse: [0.01 N*s, 0 N*s, 0 N*s]}\n"
    case = case_of("- column: {levels: 3}", hit + "expect:\n  - stands: all\n")
    assert jobs_of([case], ["exact"], [1.0])[0].case.timeline.aftermath


@pytest.mark.parametrize(
    ("skip", "played"),
    [("skip: too slow", []), ("skip: {reason: too slow, system: tuned}", ["exact"]), ("", ["exact", "tuned"])],
)
def test_what_its_author_wants_skipped_is_not_played(skip: str, played: list[str]) -> None:
    case = case_of("- column: {levels: 1}", f"systems: [exact, tuned]\n{skip}\n")
    assert [job.system for job in jobs_of([case], ["exact", "tuned"], [1.0])] == played


def test_every_case_is_played_on_every_system_at_every_step_whatever_its_scenario_names() -> None:
    assert [(job.name, job.system, job.factor) for job in jobs()] == [
        ("scene", "exact", 1.0),
        ("scene", "exact", 0.5),
        ("scene", "tuned", 1.0),
        ("scene", "tuned", 0.5),
    ]
    assert len({job.id for job in jobs()}) == 4
    assert [job.id for job in jobs()] == [job.id for job in jobs()]
    changed = jobs_of([case_of("- column: {levels: 2}")], ["exact"], [1.0])
    assert changed[0].id not in {job.id for job in jobs()}


def test_a_bench_that_was_interrupted_goes_on_with_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = Plan(Journal(tmp_path), resume=False, workers=1, time_limit=1.0)
    done = replace(RECORD, id=jobs()[0].id, case="scene", system="exact", versions=versions())
    stale = replace(done, id=jobs()[1].id, versions={"python": "2.7"})
    asked: list[Task] = []
    monkeypatch.setattr(conduct, "run_supervised", doing(1, asked))
    first = bench(jobs(), plan)
    assert (first.interrupted, len(first.scores), len(asked)) == (True, 1, 2)  # the first step of both systems
    for record in (done, stale):  # as if these had been played
        plan.journal.add(record)
    asked.clear()
    monkeypatch.setattr(conduct, "run_supervised", doing(4, asked))
    second = bench(jobs(), replace(plan, resume=True))
    assert [task.arguments[1:] for task in asked] == [("tuned", 1.0), ("exact", 0.5), ("tuned", 0.5)]
    assert [score.record.status for score in second.scores] == ["done"] + [RunStatus.CRASHED] * 3
    assert not second.interrupted


def test_what_takes_no_step_is_played_at_one_step_length(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = Plan(Journal(tmp_path), resume=True, workers=1, time_limit=1.0)
    proven = replace(RECORD, id=jobs()[0].id, case="scene", system="exact", versions=versions(), steps=0)
    plan.journal.add(proven)
    asked: list[Task] = []
    monkeypatch.setattr(conduct, "run_supervised", doing(4, asked))
    found = bench(jobs(), plan)
    assert [task.arguments[1:] for task in asked] == [("tuned", 1.0), ("tuned", 0.5)]
    copied = found.scores[1].record
    assert (copied.system, copied.factor, copied.wall_time) == ("exact", 0.5, proven.wall_time)
    assert copied.message == "no step is taken: as with step x 1"
    assert copied.settings["time_step"] == jobs()[1].settings["time_step"]


def test_what_did_not_finish_is_told_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conduct, "run_supervised", doing(1, []))
    found = bench(jobs(), Plan(Journal(tmp_path), resume=False, workers=1, time_limit=1.0))
    text = bench_text(found)
    assert "scene on exact, step x 1: crashed: for want of an engine" in text
    assert "0 of 4 runs done" in text
    assert "interrupted, go on with --resume" in text.splitlines()[-1]
    assert '"interrupted": true' in bench_json(found)
    assert "0 of 4 runs done" in bench_page(found, drawn=False)
