"""Which runs a bench consists of, and how it ends after a stop; without an engine."""

from collections.abc import Callable, Sequence

import pytest

from benchmarks.systems.bench import Job, bench, jobs_of
from benchmarks.systems.table import bench_text
from benchmarks.systems.timing import Played
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.supervising.processes import OnWait, PoolResult
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus, WorkerStart
from tests.benchmarks.systems.runs import case_of


def jobs() -> list[Job]:
    return jobs_of([case_of("- column: {levels: 1}")], ["exact", "tuned"], [1.0, 0.5])


def doing(only: int, asked: list[Task], results: Sequence[TaskResult] = ()) -> Callable[..., PoolResult]:
    """A pool that is interrupted after so many tasks; those without a result crash."""

    def supervised(
        tasks: Sequence[Task], workers: int, on_done: Callable[..., None], on_wait: OnWait, start: WorkerStart
    ) -> PoolResult:
        asked.extend(tasks)
        crashed = [TaskResult(TaskStatus.CRASHED, message="for want of an engine")] * len(tasks)
        ended = [*results, *crashed][: len(tasks)]
        for index, result in enumerate(ended[:only]):
            on_done(index, result)
        return PoolResult(tuple(ended), interrupted=only < len(tasks))

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


def test_what_was_done_before_an_interrupt_is_scored(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Task] = []
    monkeypatch.setattr("benchmarks.systems.bench.run_supervised", doing(1, asked))
    found = bench(jobs())
    assert (found.interrupted, len(found.scores), len(asked)) == (True, 1, 2)  # the first step of both systems
    text = bench_text(found)
    assert "scene on exact, step x 1: crashed: for want of an engine" in text
    assert text.splitlines()[-1].startswith("0 of 4 runs done")
    assert text.splitlines()[-1].endswith("interrupted")


def test_what_takes_no_step_is_played_at_one_step_length(monkeypatch: pytest.MonkeyPatch) -> None:
    proven = play(jobs()[0].case.timeline, SYSTEMS["exact"])
    asked: list[Task] = []
    done = TaskResult(TaskStatus.DONE, Played(proven, 0.5, None, 2**20))
    monkeypatch.setattr("benchmarks.systems.bench.run_supervised", doing(4, asked, [done]))
    found = bench(jobs())
    assert [task.arguments[1:] for task in asked] == [("exact", 1.0), ("tuned", 1.0), ("tuned", 0.5)]
    copied = found.scores[1].record
    assert (copied.system, copied.factor, copied.wall_time) == ("exact", 0.5, 0.5)
    assert copied.message == "no step is taken: as with step x 1"
