"""Measures the overhead of a sweep per sample, and extrapolates it to a thousand million samples.

It also tests a sweep on a cluster of which workers are killed, and whether the memory of a sweep grows.

python -m benchmarks.scale            five minutes; needs pip install 'stackdsl[dask,parquet]'
python -m benchmarks.scale --write    the same, to docs/data
"""

import json
import os
import signal
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, process_time, sleep
from typing import Final

from rich.console import Console

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.samples import case_of
from stackdsl.judging.statistics import error_of_a_look, interval, looks
from stackdsl.studies import sweep
from stackdsl.studies.sweep import Sweep
from stackdsl.studies.sweep_plan import JudgedSamples, judged_piece, packed, plan_of, program_of
from stackdsl.studies.sweep_rows import ParquetFolder, TextRows
from stackdsl.studies.sweep_workers import dask_cluster
from stackdsl.supervising.executors import SupervisedExecutor, submit_to
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus

ON_CLUSTER, CHEAP, ROWS, MESSAGES = 100_000, 1_000_000, 100_000, 2_000
MANY, CORES = 10**9, 1000
COLUMN: Final = """
scenario: column
samples: {samples}
build:
  - column: {{levels: {levels}, step: 8 mm}}
    every: 1 s
    jitter: {{position: {error}, yaw: 1 deg}}
"""
LIMIT: Final = 900.0  # [s] time limit of a sweep
DESIGNS: Final = {
    "column of 3": ("column: {levels: 3}", "{position: 1 mm}", 100_000),
    "column of 100": ("column: {levels: 100}", "{position: 1 mm, yaw: 1 deg}", 2000),
    "four-stack of 50 levels": ("four_stack: {levels: 50}", "{position: 1 mm, yaw: 1 deg}", 1000),
}


# --- the same on a cluster of which parts are killed ------------------------------------------------------------------


def cluster(folder: Path) -> Row:
    """Run samples on a cluster of two workers, of which one is killed, then the sweep itself, which is resumed."""
    scenario = folder / "column.yaml"
    scenario.write_text(COLUMN.format(samples=ON_CLUSTER, levels=8, error="4 mm"), encoding="utf-8")
    one, many = folder / "one.jsonl", folder / "many.jsonl"
    _ended(_called(scenario, one, "--jobs", "1"))
    with _dask(folder) as dask:
        options = ("--executor", "dask", "--scheduler", dask.address)
        first = _called(scenario, many, *options)
        _until(lambda: _rows(many) > 0.2 * ON_CLUSTER, first)
        at_worker = _rows(many)
        os.kill(dask.workers()[0], signal.SIGKILL)
        _until(lambda: _rows(many) > 0.6 * ON_CLUSTER, first)
        first.kill()
        first.wait()
        at_parent = _rows(many)
        _ended(_called(scenario, many, *options))
    return {
        "samples": ON_CLUSTER,
        "workers": 2,
        "rows_when_a_worker_was_killed": at_worker,
        "rows_when_the_sweep_was_killed": at_parent,
        "rows": _rows(many),
        "same_bytes_as_one_process": one.read_bytes() == many.read_bytes(),
    }


def _called(scenario: Path, out: Path, *options: str) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", "stackdsl", "sweep", str(scenario), "--out", str(out), *options]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def _ended(process: "subprocess.Popen[bytes]") -> None:
    assert process.wait(timeout=LIMIT) == 0, process.args


def _until(true: Callable[[], bool], process: "subprocess.Popen[bytes]") -> None:
    began = monotonic()
    while not true():
        assert process.poll() is None, f"{process.args!r} ended before its time"
        assert monotonic() < began + LIMIT
        sleep(0.02)


def _rows(out: Path) -> int:
    with suppress(FileNotFoundError), out.open("rb") as stream:
        return sum(chunk.count(b"\n") for chunk in iter(lambda: stream.read(1 << 20), b""))
    return 0


@dataclass(frozen=True)
class _Cluster:
    address: str  # of its scheduler
    scheduler: int  # process id
    workers: Callable[[], list[int]]  # their current process ids

    def scheduler_time(self) -> float:
        """Return the processor time of the scheduler so far [s]."""
        fields = Path(f"/proc/{self.scheduler}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))


@contextmanager
def _dask(folder: Path) -> Iterator["_Cluster"]:
    """Start a cluster of two workers on this machine."""
    from distributed import Client  # noqa: PLC0415 -- an optional extra

    noted = folder / "scheduler.json"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    common = ("--scheduler-file", str(noted), "--no-dashboard")
    started = [_cli("scheduler", *common, "--host", "127.0.0.1", "--port", "0", **quiet)]
    try:
        while not noted.exists():
            sleep(0.1)
        local = ("--nthreads", "1", "--local-directory", str(folder))
        started += [_cli("worker", *common, *local, **quiet) for _ in range(2)]
        address = json.loads(noted.read_text(encoding="utf-8"))["address"]
        with Client(address, set_as_default=False) as client:
            client.wait_for_workers(2)
            yield _Cluster(address, started[0].pid, lambda: [*client.run(os.getpid).values()])
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            process.wait()


def _cli(part: str, *arguments: str, **streams: int) -> "subprocess.Popen[bytes]":
    return subprocess.Popen([sys.executable, "-m", f"distributed.cli.dask_{part}", *arguments], **streams)  # type: ignore[call-overload,no-any-return]


# --- memory -----------------------------------------------------------------------------------------------------------


def memory(folder: Path) -> Rows:
    """Return the memory of a sweep of cheap samples, and of its worker processes, over time."""
    scenario, out = folder / "cheap.yaml", folder / "cheap.jsonl"
    scenario.write_text(COLUMN.format(samples=CHEAP, levels=3, error="1 mm"), encoding="utf-8")
    process = _called(scenario, out)
    rows: dict[str, Row] = {}
    for tenth in range(1, 10):
        _until(lambda tenth=tenth: _rows(out) >= 0.1 * tenth * CHEAP, process)  # type: ignore[misc]
        own, others = _resident(process.pid), [_resident(pid) for pid in _children(process.pid)]
        rows[f"at {10 * tenth} %"] = {"rows": _rows(out), "sweep_mib": own, "largest_worker_mib": max(others)}
    _ended(process)
    return rows


def _resident(pid: int) -> float:
    """Return the resident memory of a process [MiB]."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024.0
    return 0.0


def _children(pid: int) -> list[int]:
    return [int(each) for each in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]


# --- what each part costs ---------------------------------------------------------------------------------------------


class Ready(Executor):
    """Returns stored results piece by piece: the remaining time is that of the sweep itself."""

    def __init__(self, results: Iterable[JudgedSamples]) -> None:
        self.kept = iter(results)

    def submit(self, fn: object, /, *args: object, **kwargs: object) -> "Future[TaskResult]":  # type: ignore[override]
        del fn, args, kwargs
        future: Future[TaskResult] = Future()
        future.set_result(TaskResult(TaskStatus.DONE, next(self.kept)))
        return future


def costs(folder: Path) -> Row:
    """Return the time of a row in the writing process, its size on disk, and the time to resume there."""
    case = case_of("column: {levels: 8, step: 8 mm}", ROWS, "{position: 4 mm, yaw: 1 deg}")
    plan = plan_of([case])
    size = 1000
    pieces = [judged_piece(packed(case), at, size, program_of(("exact",))) for at in range(0, ROWS, size)]
    results = [piece for piece in pieces if isinstance(piece, JudgedSamples)]
    first, most = sweep.FIRST, sweep.MOST
    sweep.FIRST = sweep.MOST = size  # type: ignore[misc]
    try:
        lines = folder / "rows.jsonl"
        with TextRows(lines, plan) as file:
            writing = _taken(Sweep(plan, file, Ready(results), lambda: 8).run)
        counting = _taken(lambda: TextRows(lines, plan).close())
        with ParquetFolder(folder / "rows.parquet", plan) as parquet:
            sealing = _taken(Sweep(plan, parquet, Ready(results), lambda: 8).run)
    finally:
        sweep.FIRST, sweep.MOST = first, most  # type: ignore[misc]
    whole = sum(file.stat().st_size for file in (folder / "rows.parquet").glob("*.parquet"))
    return {
        "rows": ROWS,
        "us_a_row_written": 1e6 * writing / ROWS,
        "us_a_row_written_as_parquet": 1e6 * sealing / ROWS,
        "us_a_row_counted": 1e6 * counting / ROWS,
        "bytes_a_row": lines.stat().st_size / ROWS,
        "bytes_a_row_of_parquet": whole / ROWS,
        "bytes_a_message": len(packed(case)),
    }


def _taken(what: Callable[[], object]) -> float:
    began = process_time()
    what()
    return process_time() - began


def nothing() -> None:
    """Do nothing."""


def messages(folder: Path) -> Rows:
    """Return the cost of an empty call: on processes of this machine, and through a scheduler."""
    rows: dict[str, Row] = {}
    with SupervisedExecutor(2) as own:
        rows["processes"] = _message(own)
    with _dask(folder) as dask, dask_cluster(dask.address) as those:
        _message(those.executor, 100)  # so that the processes are running
        before = dask.scheduler_time()
        cost = _message(those.executor)
        rows["Dask"] = {**cost, "ms_of_the_scheduler": 1000.0 * (dask.scheduler_time() - before) / MESSAGES}
    return rows


def _message(executor: Executor, count: int = MESSAGES) -> Row:
    began, cpu = monotonic(), process_time()
    case = bytes(4096)  # about the size of a case
    for future in [submit_to(executor, Task(len, (case,), 60.0)) for _ in range(count)]:
        assert future.result().status is TaskStatus.DONE
    wall = monotonic() - began
    return {
        "messages": count,
        "a_second": count / wall,
        "ms_of_the_sweep": 1000.0 * (process_time() - cpu) / count,
    }


def samples() -> Rows:
    """Return the time of a sample that is judged with others."""
    rows: dict[str, Row] = {}
    for name, (layout, jitter, count) in DESIGNS.items():
        case = case_of(layout, count, jitter)
        judged = judged_piece(packed(case), 0, count, program_of(("exact",)))
        assert isinstance(judged, JudgedSamples)
        rows[name] = {"samples": count, "ms_a_sample": 1000.0 * judged.cpu_time / count}
    return rows


# --- on paper ---------------------------------------------------------------------------------------------------------


def paper(each: Rows, cost: Row, message: Rows) -> Rows:
    """Return the time of a number of samples on a number of cores, and the utilisation of each part."""
    return {name: _paper(float(str(row["ms_a_sample"])) / 1000.0, cost, message) for name, row in each.items()}


def _paper(sample: float, cost: Row, message: Rows) -> Row:
    judging = MANY * sample / CORES
    wanted = max(sweep.WANTED, CORES / sweep.MESSAGES)
    piece = max(1, int(min(sweep.MOST, wanted / sample)))
    a_second = CORES / (piece * sample)
    writing = MANY * 1e-6 * _of(cost, "us_a_row_written") + MANY / piece * 1e-3 * _of(
        message["Dask"], "ms_of_the_sweep"
    )
    sending = MANY / piece * 1e-3 * _of(message["Dask"], "ms_of_the_scheduler")
    return {
        "samples": MANY,
        "cores": CORES,
        "judging_h": judging / 3600.0,
        "samples_a_piece": piece,
        "messages_a_second_to_keep_all_busy": a_second,
        "scheduler_h": sending / 3600.0,
        "writer_h": writing / 3600.0,
        "whole_h": max(judging, sending, writing) / 3600.0,
        "slowest": max((judging, "workers"), (sending, "scheduler"), (writing, "writer"))[1],
        "cores_that_are_kept_busy": int(CORES * judging / max(judging, sending, writing)),
        "parquet_writer_h": MANY * 1e-6 * _of(cost, "us_a_row_written_as_parquet") / 3600.0,
        "json_lines_gb": 1e-9 * MANY * _of(cost, "bytes_a_row"),
        "parquet_gb": 1e-9 * MANY * _of(cost, "bytes_a_row_of_parquet"),
        "going_on_h": MANY * 1e-6 * _of(cost, "us_a_row_counted") / 3600.0,
        "lost_by_a_kill_core_h": 2 * sweep.AHEAD * CORES * piece * sample / 3600.0,
    }


def _of(row: Row, key: str) -> float:
    return float(str(row[key]))


def intervals() -> Rows:
    """Return the width of the interval around one half, for one look and for all looks of a check."""
    rows: dict[str, Row] = {}
    for count in (10**4, 10**6, 10**9):
        once, all_looks = (
            interval(count // 2, count // 2, count, error) for error in (0.05, error_of_a_look(count, 0.95))
        )
        rows[f"{count:,}"] = {
            "looks": len(looks(count)),
            "percent_once": 100.0 * (once.high - once.low),
            "percent_at_all_looks": 100.0 * (all_looks.high - all_looks.low),
        }
    return rows


def main(arguments: Namespace) -> None:
    """Measure and print the table; write it on request."""
    console = Console()
    with TemporaryDirectory() as name:
        folder = Path(name)
        message, cost, each = messages(folder), costs(folder), samples()
        tables: dict[str, Rows] = {
            "samples": each,
            "messages": message,
            "costs": {"a row": cost},
            "paper": paper(each, cost, message),
            "intervals": intervals(),
            "memory": memory(folder),
            "cluster": {"killed": cluster(folder)},
        }
    for table, rows in tables.items():
        for row, values in rows.items():
            cells = (
                f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in values.items()
            )
            console.print(f"{table}/{row}: {', '.join(cells)}")
    assert tables["cluster"]["killed"]["same_bytes_as_one_process"]
    if arguments.write:
        record("scale", "python -m benchmarks.scale --write", tables)


if __name__ == "__main__":
    main(parser(__doc__).parse_args())
