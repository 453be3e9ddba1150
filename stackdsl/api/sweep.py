"""Sweeps from Python: one row for every case and sample, on processes of this machine or on any Executor."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from stackdsl.checking.cases import Case
from stackdsl.studies import sweep as swept
from stackdsl.studies.sweep import SweptCase
from stackdsl.studies.sweep_plan import plan_of
from stackdsl.studies.sweep_workers import Workers, own_processes
from stackdsl.supervising.executors import TIME_LIMIT


def sweep(
    cases: Iterable[Case],
    out: Path | str,
    *,
    samples: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    time_limit: float = TIME_LIMIT,
    on_rows: Callable[[int], None] = lambda rows: None,
) -> tuple[SweptCase, ...]:
    """Judge every sample of all cases, and play cases without samples; write a row for each to `out`; count the rows.

    `out` ends in `.jsonl`, or in `.parquet` for a folder. Existing rows are not judged again. `samples` is the number
    for each case with samples, by default that of the case. The work is done by processes of this machine, one per core
    or `workers` in total; or by an Executor that runs `workers` calls at a time, each in a supervised process.
    `time_limit` is the wall time of a sample in seconds; `on_rows` is called with the number of rows. On some platforms
    new processes import the main module again, so guard it with `if __name__ == "__main__"`.

    Raises NothingToSweepError, RowsError for a file of another sweep or an unwritable one, and SweepError if the
    executor fails or a worker has another program. Written rows are kept in any case.
    """

    def those() -> AbstractContextManager[Workers]:
        if executor is None:
            return own_processes(workers)
        return nullcontext(Workers(executor, lambda: workers or os.cpu_count() or 1))

    return swept.sweep(plan_of([*cases], samples, time_limit), Path(out), those, on_rows)
