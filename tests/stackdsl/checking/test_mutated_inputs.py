"""Whatever is wrong with a file, it is told in its place or the file is valid, in bounded time and memory."""

import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random
from types import FrameType

import pytest

from stackdsl.checking.cases import gather
from stackdsl.diagnostics import CODES
from stackdsl.report.diagnostics import diagnostic_text
from tests.stackdsl.checking.mutations import sources, write_mutated

LONGEST = 10.0  # [s] of work for one file, on whatever machine; none takes a tenth of it where nothing else runs
LARGEST = 500  # [MB]


@contextmanager
def hang_told() -> Iterator[None]:
    """Fail where it hangs."""

    def tell(_number: int, _frame: FrameType | None) -> None:
        pytest.fail(f"it works for more than {LONGEST} s")

    before = signal.signal(signal.SIGVTALRM, tell)
    signal.setitimer(signal.ITIMER_VIRTUAL, LONGEST)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


@pytest.mark.parametrize("count", [100, pytest.param(10_000, marks=pytest.mark.slow)])
def test_a_changed_scenario_is_told_in_its_place_or_valid(count: int, tmp_path: Path) -> None:
    texts, before = sources(), megabytes()
    for seed in range(count):
        file = write_mutated(Random(seed), texts, tmp_path)
        with hang_told():
            gathered = gather([file])
        for mistake in gathered.diagnostics:
            assert mistake.code in CODES
            assert min(mistake.span.line, mistake.span.column) >= 1
            assert mistake.message
            assert diagnostic_text(mistake).isprintable() or "\n" in diagnostic_text(mistake)
        assert gathered.cases or gathered.diagnostics, f"seed {seed}: neither a case nor a mistake"
    assert megabytes() - before < LARGEST
