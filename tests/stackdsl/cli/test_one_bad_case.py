"""Whatever one case does, the others come out as ever, it is named, and nothing is left behind."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.command_line import AMPLE, write
from tests.paths import ROOT

# The command, which plays towers of 4, 5 and 6 planks in ways that no engine should have. Once nothing is left to do
# but what hangs, its clock goes a minute ahead at every look: a limit that is ample for the others is over soon.
BAD = """
import os, resource, signal, time
from pathlib import Path
from stackdsl.supervising import processes, worker
resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, resource.getrlimit(resource.RLIMIT_DATA)[1]))
from stackdsl.checking import play_case
from stackdsl.cli.main import main
play = play_case.play

def badly_played(timeline, *rest):
    match len(timeline.placements):
        case 4:
            os.kill(os.getpid(), signal.SIGSEGV)
        case 5:
            hung.touch()
            time.sleep(1000.0)
        case 6:
            hoard = []
            while True:
                hoard.append(bytearray(1 << 26))
    return play(timeline, *rest)

def attended(pool, busy):
    global ahead
    ahead += 60.0 * (hung.exists() and len(pool.busy) == 1)
    attend(pool, busy)

ahead, hung = 0.0, Path("hung").absolute()
attend = processes.Pool._check_worker
processes.Pool._check_worker = attended
processes.monotonic = worker.monotonic = lambda: time.monotonic() + ahead
play_case.play = badly_played
main()
"""


def towers(folder: Path, count: int) -> None:
    """So many files, of which the last three are played badly."""
    for number in range(count):
        levels = max(2, number - count + 7)
        write(
            folder,
            f"scenario: s{number}\nbuild: [column: {{levels: {levels}}}]\nexpect: [stands: all]\n",
            f"{number}.yaml",
        )


def begun(folder: Path, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-c", BAD, "check", ".", "--format", "json", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "CI": ""},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )


def session(number: int) -> list[int]:
    """The processes of a session that are not over."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, its_session = entry.read_text().rpartition(")")[2].split()[:4]
        except OSError:  # it has ended meanwhile
            continue
        found += [int(entry.parent.name)] * (int(its_session) == number and state != "Z")
    return found


def comes_true(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + AMPLE
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def litter(folder: Path) -> list[str]:
    """The files that no run should leave."""
    return [path.name for path in folder.rglob("*") if "tmp" in path.name]


@pytest.mark.parametrize("count", [8, pytest.param(40, marks=pytest.mark.slow)])
def test_of_many_cases_exactly_those_three_fail_that_crash_hang_and_hoard(count: int, tmp_path: Path) -> None:
    towers(tmp_path, count)
    process = begun(tmp_path, "--jobs", "2", "--time-limit", str(AMPLE))
    out, err = process.communicate(timeout=AMPLE)
    results = json.loads(out)["results"]
    assert "Traceback" not in err
    failed = {each["scenario"]: f"{each['status']}: {each['message']}" for each in results if each["status"] != "done"}
    assert list(failed) == [f"s{number}" for number in range(count - 3, count)], failed
    crashed, hung, hoarded = failed.values()
    assert "SIGSEGV" in crashed
    assert hung.startswith("timed out")
    assert "MemoryError" in hoarded
    assert all(each["conclusion"] == "passed" for each in results if each["scenario"] not in failed)
    assert comes_true(lambda: session(process.pid) == [])
    assert litter(tmp_path) == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_killed_check_leaves_no_process_and_no_temporary_file(number: signal.Signals, tmp_path: Path) -> None:
    write(tmp_path, "scenario: hangs\nbuild: [column: {levels: 5}]\nexpect: [stands: all]\n", "hangs.yaml")
    write(tmp_path, "scenario: other\nbuild: [column: {levels: 2}]\nexpect: [stands: all]\n", "other.yaml")
    process = begun(tmp_path, "--jobs", "2")
    assert comes_true(lambda: len(session(process.pid)) > 1)
    assert comes_true((tmp_path / "golden" / "other" / "exact.json").exists)
    process.send_signal(number)
    process.communicate(timeout=AMPLE)
    assert comes_true(lambda: session(process.pid) == [])
    assert litter(tmp_path) == []


def test_a_worker_may_take_most_of_the_memory_and_not_all() -> None:
    told = subprocess.run(
        [
            sys.executable,
            "-c",
            "import os, resource\nfrom stackdsl.supervising.worker import limit_memory\nlimit_memory()\n"
            "memory = os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES')\n"
            "print(resource.getrlimit(resource.RLIMIT_DATA)[0] / memory)",
        ],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    assert 0.0 < float(told.stdout) <= 0.75
