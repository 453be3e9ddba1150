"""What a run costs, measured often enough and undisturbed by the runs before it."""

import os

import pytest

from benchmarks.systems.timing import ENOUGH, MOST_RUNS, enough, usual_updates
from stability.stabilizers.protocol import Update
from stackdsl.simulation.runner import play
from stackdsl.simulation.stabilizer_calls import UpdateClock
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task, WorkerStart
from stackdsl.trace import Cost, Updates
from tests.scenes import timeline_of


def test_what_takes_no_time_is_measured_several_times() -> None:
    assert enough(2.0 * ENOUGH, iter([])) == [2.0 * ENOUGH]
    assert enough(0.4 * ENOUGH, iter([0.4 * ENOUGH, 0.4 * ENOUGH, 9.0])) == [0.4 * ENOUGH] * 3
    assert len(enough(1e-6, iter([1e-6] * 100))) == MOST_RUNS


@pytest.mark.parametrize(
    ("start", "processes"), [(WorkerStart.PREPARED, 3), (WorkerStart.COPY, 1), (WorkerStart.NEW, 1)]
)
def test_each_measurement_has_a_process_of_its_own(start: WorkerStart, processes: int) -> None:
    pool = run_supervised([Task(os.getpid, (), 60.0)] * 3, 1, start=start)
    assert len({result.value for result in pool.results}) == processes


# --- what an interactive user feels -----------------------------------------------------------------------------------


def test_every_update_is_timed_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = UpdateClock()
    ticks = iter([0.0, 0.001, 5.0, 5.003, 9.0, 9.2])
    monkeypatch.setattr("stackdsl.simulation.stabilizer_calls.perf_counter", lambda: next(ticks))
    frozen = [clock.timed(lambda brick: Update(frozen=(brick,)), brick).frozen for brick in "abc"]
    assert frozen == [("a",), ("b",), ("c",)]
    told = clock.updates()
    assert told is not None
    assert [told.median, told.worst] == pytest.approx([0.003, 0.2])


def test_one_run_that_was_disturbed_does_not_tell_the_worst_update() -> None:
    def cost(median: float, worst: float) -> Cost:
        return Cost(1.0, 1.0, 1, 1, updates=Updates(median, worst))

    runs = [cost(0.001, 0.01), cost(0.002, 5.0), cost(0.003, 0.03)]
    assert usual_updates(runs) == Updates(0.002, 0.03)
    assert usual_updates([Cost(1.0, 1.0, 1, 0)]) is None


@pytest.mark.parametrize(("system", "extended"), [("exact", True), ("thesis", True), ("tuned", False)])
def test_updates_are_those_of_an_extension_and_a_part_of_the_run(system: str, extended: bool) -> None:
    cost = play(timeline_of("- column: {levels: 3}"), SYSTEMS[system]).cost
    assert (cost.updates is not None) is extended
    if cost.updates is not None:
        assert 0.0 < cost.updates.median <= cost.updates.worst <= cost.wall_time
