"""A command that is interrupted, has no reader or no room: the exit code, and never a traceback."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.command_line import AMPLE, GOOD, started, write
from tests.engines_at_hand import needs_pybullet
from tests.paths import ROOT

# The command, with a Ctrl-C soon after it has begun to start workers: none has come as far as its task by then.
INTERRUPTED_AT_ONCE = """
import multiprocessing, os, signal, sys, threading, time
from stackdsl.cli.main import main

def press() -> None:
    while not multiprocessing.active_children():
        time.sleep(0.001)
    time.sleep(DELAY)
    os.killpg(0, signal.SIGINT)

if __name__ == "__main__":
    threading.Thread(target=press, daemon=True).start()
    main()
"""


pytestmark = pytest.mark.usefixtures("interruptible")

FAILING = GOOD + "  - height: 20 mm ± 1 mm\n"


@pytest.mark.parametrize(
    ("text", "call", "code"),
    [(GOOD, "check --update", 0), (FAILING, "run", 1)],
    ids=["written", "failed"],
)
def test_a_reader_who_leaves_changes_no_exit_code(tmp_path: Path, text: str, call: str, code: int) -> None:
    write(tmp_path, text)
    process = started(tmp_path, *call.split(), "scene.yaml")
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    with process.stderr as stream:
        err = stream.read()
    assert process.wait(timeout=AMPLE) == code
    assert "internal" not in err
    assert "Traceback" not in err
    assert "ignored" not in err


@pytest.mark.parametrize("redirected", [pytest.param("2>/dev/full", marks=pytest.mark.slow), "2> >(true)"])
def test_progress_that_nobody_hears_of_stops_nothing(tmp_path: Path, redirected: str) -> None:
    for number in range(3):
        write(tmp_path, FAILING.replace("good", f"good-{number}"), f"s/{number}.yaml")
    wait_a_moment = "sleep 0.2;" if "true" in redirected else ""
    shell = f"exec {redirected}; {wait_a_moment} exec '{sys.executable}' -m stackdsl check s"
    process = started(tmp_path, program=("-c", shell), executable="/bin/bash")
    out, _ = process.communicate(timeout=AMPLE)
    assert process.returncode == 1
    assert "3 failed" in out


@pytest.mark.parametrize("closed", ["<&- >&- 2>&-", ">&-"])
def test_a_run_whose_streams_were_closed_from_the_start_comes_out_as_any_other(tmp_path: Path, closed: str) -> None:
    write(tmp_path, GOOD)
    shell = f"exec '{sys.executable}' -m stackdsl check scene.yaml --update {closed}"
    process = started(tmp_path, program=("-c", shell), executable="/bin/bash")
    _, err = process.communicate(timeout=AMPLE)
    assert (process.returncode, "crashed" in err) == (0, False)
    assert (tmp_path / "golden" / "good" / "exact.json").exists()


# The command, with a signal that comes while a golden file is half written.
INTERRUPTED_WRITING = """
import os, signal
from stackdsl.cli.main import main
sync = os.fsync

def interrupted(file: int) -> None:
    signal.raise_signal(signal.SIGHUP)
    sync(file)

os.fsync = interrupted
if IGNORED:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
main()
"""


@pytest.mark.parametrize(("ignored", "code"), [(False, 130), (True, 0)], ids=["heard", "nohup"])
def test_a_terminal_that_is_closed_interrupts_and_leaves_nothing_half_written(
    tmp_path: Path, ignored: bool, code: int
) -> None:
    write(tmp_path, GOOD)
    program = ("-c", INTERRUPTED_WRITING.replace("IGNORED", str(ignored)))
    process = started(tmp_path, "check", "scene.yaml", "--update", program=program)
    _, err = process.communicate(timeout=AMPLE)
    assert (process.returncode, "Traceback" in err) == (code, False)
    assert [*(tmp_path / "golden").rglob("*.json")] == [tmp_path / "golden" / "good" / "exact.json"]


@pytest.mark.parametrize("command", ["check", "schema"])
def test_a_full_disk_is_no_fault_of_ours(tmp_path: Path, command: str) -> None:
    write(tmp_path, GOOD)
    arguments = [command] if command == "schema" else [command, "scene.yaml"]
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        process = started(tmp_path, *arguments, stdout=full.fileno())
        _, err = process.communicate(timeout=AMPLE)
    assert process.returncode == 4
    assert "the standard output cannot be written: No space left on device" in err
    assert "fault" not in err
    assert "ignored" not in err


@needs_pybullet
@pytest.mark.parametrize(
    ("number", "times"),
    [
        (signal.SIGINT, 30),
        (signal.SIGTERM, 1),
        pytest.param(signal.SIGTERM, 30, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, 1, marks=pytest.mark.slow),
    ],
)
def test_an_interrupt_however_often_repeated_keeps_what_is_done_and_ends_with_130(
    tmp_path: Path, number: signal.Signals, times: int
) -> None:
    write(tmp_path, GOOD, "s/a.yaml")
    write(tmp_path, GOOD.replace("good", "slow").replace("1 s", "1000 s") + "systems: [tuned]\n", "s/b.yaml")
    process = started(tmp_path, "check", "s", "--jobs", "1", "--progress", "--html", "report")
    assert process.stderr is not None
    process.stderr.readline()  # the first case is done
    time.sleep(0.3)
    for _ in range(times):
        process.send_signal(number)
        time.sleep(0.001)
    out, err = process.communicate(timeout=AMPLE)
    assert process.returncode == 130
    assert "1 passed" in out
    assert "interrupted" in out
    assert "FAILED" not in out  # of a case that did not run
    assert "Traceback" not in out + err
    assert "Interrupted: 1 of 2 cases not run" in (tmp_path / "report" / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("program", [("-m", "stackdsl"), ("-c", "from stackdsl.__main__ import main; main()")])
def test_an_interrupt_of_the_imports_is_one_like_any_other(tmp_path: Path, program: tuple[str, ...]) -> None:
    # A package that is imported early, and interrupts as a key pressed meanwhile would.
    write(tmp_path, "import signal\nsignal.raise_signal(signal.SIGINT)\n", "early/click/__init__.py")
    process = started(tmp_path, "schema", program=program, path=str(tmp_path / "early"))
    out, err = process.communicate(timeout=AMPLE)
    assert (process.returncode, out, err) == (130, "", "interrupted before the command began; nothing was written\n")


def test_an_interrupt_of_the_imports_is_heard_where_python_lets_none_through(tmp_path: Path) -> None:
    # As of what it calls when something is forgotten, such as the locks of modules.
    forgotten = "import signal, weakref\nheld = type('Held', (), {})()\n"
    told = "told = weakref.ref(held, lambda _: signal.raise_signal(signal.SIGINT))\ndel held\n"
    write(tmp_path, forgotten + told + "raise SystemExit('too late')\n", "early/click/__init__.py")
    process = started(tmp_path, "schema", path=str(tmp_path / "early"))
    out, err = process.communicate(timeout=AMPLE)
    assert (process.returncode, out, err) == (130, "", "interrupted before the command began; nothing was written\n")


@needs_pybullet
@pytest.mark.parametrize("delay", [0.0, 0.05])
def test_an_interrupt_of_the_whole_group_while_workers_start_leaves_no_traceback(tmp_path: Path, delay: float) -> None:
    for number in range(4):
        write(
            tmp_path,
            GOOD.replace("good", f"slow-{number}").replace("1 s", "1000 s") + "systems: [tuned]\n",
            f"s/{number}.yaml",
        )
    process = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED_AT_ONCE.replace("DELAY", str(delay)), "check", "s", "--jobs", "4"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )
    out, err = process.communicate(timeout=AMPLE)
    assert process.returncode == 130
    assert "interrupted" in out
    assert "Traceback" not in out + err
