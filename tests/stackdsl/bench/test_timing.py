"""What a run costs, measured often enough and undisturbed by the runs before it."""

import os

import pytest

from stackdsl.bench.timing import ENOUGH, MOST_RUNS, enough
from stackdsl.checking.processes import run_supervised
from stackdsl.checking.worker import Start, Task


def test_what_takes_no_time_is_measured_several_times() -> None:
    assert enough(2.0 * ENOUGH, iter([])) == [2.0 * ENOUGH]
    assert enough(0.4 * ENOUGH, iter([0.4 * ENOUGH, 0.4 * ENOUGH, 9.0])) == [0.4 * ENOUGH] * 3
    assert len(enough(1e-6, iter([1e-6] * 100))) == MOST_RUNS


@pytest.mark.parametrize(("start", "processes"), [(Start.PREPARED, 3), (Start.COPY, 1), (Start.NEW, 1)])
def test_each_measurement_has_a_process_of_its_own(start: Start, processes: int) -> None:
    pool = run_supervised([Task(os.getpid, (), 60.0)] * 3, 1, start=start)
    assert len({result.value for result in pool.results}) == processes
