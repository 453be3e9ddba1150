"""A sweep on a Dask cluster comes to the same bytes as one here, though a worker and the sweep itself are killed."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep

import pytest

from stackdsl.exits import ExitCode
from stackdsl.studies.sweep_workers import NoClusterError, dask_cluster
from tests.command_line import AMPLE, Stackdsl, ended, stackdsl_in_folder, started, write
from tests.paths import ROOT

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

COLUMN = """
scenario: column
samples: 100000
build:
  - column: {levels: 8, step: 8 mm}
    every: 1 s
    jitter: {position: 4 mm}
"""


@pytest.mark.slow
def test_what_no_cluster_can_be_had_for_is_told(stackdsl: Stackdsl, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    write(tmp_path, COLUMN, "column.yaml")
    nowhere = stackdsl("sweep", "column.yaml", "-o", "rows.jsonl", "--executor", "dask", "--scheduler", "nowhere")
    assert nowhere.code == ExitCode.USAGE
    assert "the scheduler at nowhere does not answer: missing port number" in nowhere.err
    assert "without --executor dask processes of this machine do the work" in nowhere.err
    unnamed = stackdsl("sweep", "column.yaml", "-o", "rows.jsonl", "--executor", "dask")
    assert unnamed.code == ExitCode.USAGE
    assert "no address of a Dask cluster; give the address of its scheduler: --scheduler tcp://HOST:8786" in unnamed.err


def test_without_dask_it_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.setitem(sys.modules, "dask", None)
    with (
        pytest.raises(
            NoClusterError, match=r"Dask needs dask, which is not installed; try: pip install 'stackdsl\[dask\]'"
        ),
        dask_cluster("tcp://127.0.0.1:9"),
    ):
        pass


@contextmanager
def cluster(folder: Path) -> Iterator[str]:
    """The address of the scheduler of a cluster of two workers, of which only these know the program."""
    noted = folder / "scheduler.json"
    common = ("--scheduler-file", str(noted), "--no-dashboard")
    begun: list[subprocess.Popen[bytes]] = []

    def begin(part: str, *arguments: str, **environment: str) -> None:
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *common, *arguments]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        begun.append(subprocess.Popen(command, cwd=folder, env=os.environ | environment, **quiet))  # type: ignore[call-overload]

    begin("scheduler", "--host", "127.0.0.1", "--port", "0", PYTHONPATH="")
    try:
        while not noted.exists():
            assert begun[0].poll() is None
            sleep(0.05)
        for _ in range(2):
            begin("worker", "--nthreads", "1", "--local-directory", str(folder), PYTHONPATH=str(ROOT))
        yield json.loads(noted.read_text(encoding="utf-8"))["address"]
    finally:
        for process in reversed(begun):
            process.terminate()
            process.wait()


def rows(out: Path) -> int:
    return max(0, out.read_bytes().count(b"\n") - 1) if out.exists() else 0


def wait_until(out: Path, count: int, sweep: "subprocess.Popen[str]") -> None:
    began = monotonic()
    while rows(out) < count:
        assert sweep.poll() is None, sweep.communicate()
        assert monotonic() < began + AMPLE
        sleep(0.02)


@pytest.mark.slow
def test_killing_a_worker_and_then_the_sweep_changes_nothing_of_the_rows(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    write(tmp_path, COLUMN, "column.yaml")
    whole = ended(tmp_path, "sweep", "column.yaml", "-o", "whole.jsonl", "--jobs", "1")
    assert whole.code == ExitCode.OK
    with cluster(tmp_path) as address:
        call = ("sweep", "column.yaml", "-o", "rows.jsonl", "--executor", "dask", "--scheduler", address)
        sweep = started(tmp_path, *call)
        wait_until(tmp_path / "rows.jsonl", 2000, sweep)
        with distributed.Client(address, set_as_default=False) as client:
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
        wait_until(tmp_path / "rows.jsonl", rows(tmp_path / "rows.jsonl") + 2000, sweep)
        sweep.kill()
        sweep.communicate()
        there = rows(tmp_path / "rows.jsonl")
        assert there < 100000
        again = ended(tmp_path, *call)
    assert again.code == ExitCode.OK
    assert f"rows.jsonl has {there} of 100000 rows" in again.err
    assert again.out == whole.out
    assert (tmp_path / "rows.jsonl").read_bytes() == (tmp_path / "whole.jsonl").read_bytes()
