"""Sweeps from Python: every case and every sample, a row each, on processes of this machine or on any Executor."""

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
    """Judge every sample of all cases, and play those that have none; write a row for each to `out`, and count them.

    `out` ends in `.jsonl`, or in `.parquet` for a folder. Rows that are there are not judged again. `samples` is for
    each case that has some, by default as many as it says. The work is done by processes of this machine, one a core,
    or as many as `workers`; or by an Executor that does `workers` calls at a time, each in a supervised process.
    `time_limit` is for a sample, in seconds of wall time; `on_rows` hears how many rows there are. Processes begin by
    importing the main module anew where the platform asks for that, so let that begin with `if __name__ == "__main__"`.

    Raises NothingToSweepError, RowsError for a file that is of another sweep or cannot be written, and SweepError where
    the executor fails, or a worker has another program. Rows that are there are kept, whatever happens.
    """

    def those() -> AbstractContextManager[Workers]:
        if executor is None:
            return own_processes(workers)
        return nullcontext(Workers(executor, lambda: workers or os.cpu_count() or 1))

    return swept.sweep(plan_of([*cases], samples, time_limit), Path(out), those, on_rows)
