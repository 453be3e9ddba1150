"""Sweeps in Python: one row for every case and sample, computed by local processes or any Executor."""

import os
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from stability.notebook import Display, display_of
from stackdsl.api.arguments import with_remedy
from stackdsl.api.cases import SomeCases, some_cases
from stackdsl.api.notebook import Several, lines_display
from stackdsl.report.studies import sweep_lines
from stackdsl.studies import sweep as swept
from stackdsl.studies.sweep import SweptCase
from stackdsl.studies.sweep_plan import plan_of
from stackdsl.studies.sweep_workers import Workers, own_processes
from stackdsl.supervising.executors import TIME_LIMIT


@with_remedy("such as sweep(cases, 'rows.jsonl')")
def sweep(
    cases: SomeCases,
    out: Path | str,
    *,
    samples: int | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    time_limit: float = TIME_LIMIT,
    on_rows: Callable[[int], None] = lambda rows: None,
) -> Several[SweptCase]:
    """Judge every sample of all cases, play cases without samples, and write one row for each; return their counts.

    `cases` is a scenario, or cases of `load` or of several scenarios.
    `out` is a file that ends in `.jsonl` or `.csv`, or a folder that ends in `.parquet`. Rows that it has already are
    not judged again.
    `samples` replaces the number of samples of each sampled case. `workers` is the number of local processes, by
    default one per core, or the number of parallel calls of `executor`, each in a supervised process. `time_limit` is
    the limit of wall time for a sample [s]. `on_rows` is called with the number of rows. Processes may import the main
    module again, depending on the platform, so protect its top-level code with `if __name__ == "__main__"`.

    Raises NothingToSweepError without any case, RowsError if the file belongs to another sweep or cannot be written,
    and SweepError if the executor fails or a worker has another program. Written rows are kept in any case.
    """

    def pool() -> AbstractContextManager[Workers]:
        if executor is None:
            return own_processes(workers)
        return nullcontext(Workers(executor, lambda: workers or os.cpu_count() or 1))

    return Several(swept.sweep(plan_of(some_cases(cases), samples, time_limit), Path(out), pool, on_rows))


@display_of.register
def _(found: SweptCase) -> Display:
    return lines_display(sweep_lines([found])) if found.rows else Display(f"{found.entry.name}: no rows")
