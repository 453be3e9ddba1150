"""The pool names exactly the task that crashed or overran its time, and finishes all others."""

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from itertools import count
from pathlib import Path

import pytest

from stackdsl.exits import INTERRUPTS
from stackdsl.supervising import processes, worker
from stackdsl.supervising.processes import PoolResult, run_supervised
from stackdsl.supervising.worker import Task, TaskResult, TaskStatus
from tests.command_line import AMPLE
from tests.paths import ROOT
from tests.stackdsl.supervising import tasks
from tests.stackdsl.supervising.tasks import (
    ReadOnceThere,
    cut_all_pipes_and_hang,
    fork_a_child_that_stays,
    fork_and_return,
    hang,
    ignore_all_and_hang,
    interrupt_the_parent,
    is_nothing,
    large,
    leave,
    leave_python,
    make_noise,
    process_id,
    promise_more_and_hang,
    raise_a_long_text,
    return_something_unpicklable,
    return_something_unreadable,
    segfault,
    square,
    stumble,
    wait_for,
    write_into_all_pipes,
)

pytestmark = pytest.mark.usefixtures("interruptible")


def call(function: object, *arguments: object, limit: float = AMPLE) -> Task:
    assert callable(function)
    return Task(function, arguments, limit)


def run(*tasks: Task, workers: int = 2) -> tuple[TaskResult, ...]:
    done = run_supervised(tasks, workers)
    assert not done.interrupted
    return done.results


@pytest.mark.parametrize("workers", [1, 3])
def test_results_come_in_the_order_of_the_tasks(workers: int) -> None:
    results = run(*(call(square, number) for number in range(6)), workers=workers)
    assert [result.value for result in results] == [number * number for number in range(6)]
    assert {result.status for result in results} == {TaskStatus.DONE}


def test_no_tasks_need_no_workers() -> None:
    assert run_supervised([], workers=2) == PoolResult((), interrupted=False)


def test_even_one_worker_is_a_process_of_its_own_and_serves_many_tasks() -> None:
    ids = {result.value for result in run(*(call(process_id) for _ in range(4)), workers=1)}
    assert len(ids) == 1
    assert os.getpid() not in ids


CRASHES = [
    (call(segfault), "the worker was killed by SIGSEGV"),
    (call(leave, 3), "the worker exited with code 3"),
    (call(leave, 0), "the worker exited with code 0"),
    (call(leave_python), "SystemExit: 4"),
    (call(stumble), "ValueError: no such brick"),
    (call(return_something_unreadable), "ValueError: no such brick"),
]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_crash_is_reported_for_its_task_alone(workers: int) -> None:
    tasks = [task for number, (crash, _) in enumerate(CRASHES) for task in (call(square, number), crash)]
    results = run(*tasks, call(square, 9), workers=workers)
    assert [result.value for result in results[::2]] == [0, 1, 4, 9, 16, 25, 81]
    assert [(result.status, result.message) for result in results[1::2]] == [
        (TaskStatus.CRASHED, message) for _, message in CRASHES
    ]


@pytest.mark.parametrize("task", [call(lambda: None), call(return_something_unpicklable)], ids=["task", "result"])
def test_a_pickling_error_is_a_crash_of_its_task(task: Task) -> None:
    crashed, done = run(task, call(square, 2))
    assert crashed.status is TaskStatus.CRASHED
    assert "lambda" in crashed.message
    assert done.value == 4


def test_an_exception_brings_its_traceback() -> None:
    (crashed,) = run(call(stumble))
    assert 'raise ValueError("no such brick")' in crashed.details


@pytest.mark.parametrize("stubborn", [hang, ignore_all_and_hang])
def test_a_task_beyond_its_limit_is_ended_and_costs_no_other(stubborn: object) -> None:
    began = time.monotonic()
    late, *others = run(call(stubborn, limit=0.3), *(call(square, number) for number in range(5)), workers=2)
    assert (late.status, late.message) == (TaskStatus.TIMED_OUT, "took longer than 0.3 s")
    assert [result.value for result in others] == [0, 1, 4, 9, 16]
    assert time.monotonic() - began < AMPLE  # and not until it has hung for 600 s


def test_the_limit_does_not_count_the_start_of_the_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Before the worker has read its task, twice as much time passes as that may take.
    read, looks = tmp_path / "may be read", count()

    def clock() -> float:
        if next(looks) < 5:
            return time.monotonic()
        read.touch()
        return time.monotonic() + 2.0 * AMPLE

    for module in (processes, worker):
        monkeypatch.setattr(module, "monotonic", clock)
    monkeypatch.setattr(processes, "START_LIMIT", 10.0 * AMPLE)
    (done,) = run(call(is_nothing, ReadOnceThere(read), limit=AMPLE))
    assert (done.status, done.value) == (TaskStatus.DONE, True)


def test_a_worker_that_cuts_its_connection_is_ended_at_once() -> None:
    cut, done = run(call(cut_all_pipes_and_hang), call(square, 2))
    assert (cut.status, cut.message) == (TaskStatus.CRASHED, "the worker was killed by SIGKILL")
    assert done.value == 4


GARBAGE = [b"x", b"begun", b"\x00\x00\x00\x05begun", bytes(3_000_000), pickle.dumps("a result")]


def test_bytes_that_a_task_writes_into_the_pipe_are_its_crash_alone() -> None:
    tasks = [task for what in GARBAGE for task in (call(write_into_all_pipes, what), call(square, 4))]
    results = run(*tasks, workers=1)
    assert [result.value for result in results[1::2]] == [16] * len(GARBAGE)
    assert {(result.status, result.message) for result in results[::2]} == {
        (TaskStatus.CRASHED, "the pipe of the worker contains bytes that the worker did not write")
    }


def test_a_message_that_promises_more_than_comes_keeps_nobody_waiting() -> None:
    results = run(call(promise_more_and_hang), call(square, 4), workers=1)
    assert [result.status for result in results] == [TaskStatus.CRASHED, TaskStatus.DONE]


def test_of_a_task_that_forks_only_the_worker_tells_the_result(tmp_path: Path) -> None:
    results = run(call(fork_and_return, tmp_path / "note"), *(call(square, n) for n in range(3)), workers=1)
    assert [result.value for result in results] == [True, 0, 1, 4]
    assert (tmp_path / "note").exists()


def test_child_processes_of_a_task_end_with_its_worker(tmp_path: Path) -> None:
    run(call(fork_a_child_that_stays, tmp_path / "note"), workers=1)
    child = int((tmp_path / "note").read_text(encoding="utf-8"))
    deadline = time.monotonic() + AMPLE
    while not is_gone(child) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert is_gone(child)


def test_of_a_text_of_fifty_megabytes_both_ends_are_told() -> None:
    (result,) = run(call(raise_a_long_text), workers=1)
    assert result.status is TaskStatus.CRASHED
    assert result.message.startswith("ValueError: no such brick")
    assert "characters) ..." in result.message
    assert len(result.message) < 3_000
    assert "raise_a_long_text" in result.details
    assert len(result.details) < 30_000


def test_large_results_arrive_whole() -> None:
    assert [result.value for result in run(*(call(large) for _ in range(3)))] == [bytes(5_000_000)] * 3


def test_on_done_is_called_once_for_each_task_with_its_index() -> None:
    told: dict[int, TaskStatus] = {}

    def on_done(index: int, result: TaskResult) -> None:
        assert index not in told
        told[index] = result.status

    run_supervised([call(square, 1), call(leave, 1), call(hang, limit=0.2)], 2, on_done)
    assert told == {0: TaskStatus.DONE, 1: TaskStatus.CRASHED, 2: TaskStatus.TIMED_OUT}


def test_chatter_of_a_worker_stays_off_the_parents_stdout(capfd: pytest.CaptureFixture[str]) -> None:
    (done,) = run(call(make_noise))
    captured = capfd.readouterr()
    assert done.value == 1
    assert captured.out == ""
    assert captured.err == "chatter of Python\n"


def test_an_interrupt_ends_all_workers_at_once_and_keeps_what_was_done(tmp_path: Path) -> None:
    note = tmp_path / "id of the worker"
    tasks = [call(square, 3), call(interrupt_the_parent, os.getpid(), note), call(square, 4), call(hang)]
    began = time.monotonic()
    done = run_supervised(tasks, workers=1)
    assert done.interrupted
    assert [result.status for result in done.results] == [TaskStatus.DONE, *[TaskStatus.NOT_RUN] * 3]
    assert done.results[0].value == 9
    assert time.monotonic() - began < AMPLE  # and not until it has hung for 600 s
    assert is_gone(int(note.read_text(encoding="utf-8")))


def test_workers_leave_the_meaning_of_an_interrupt_to_the_parent() -> None:
    (done,) = run(call(signal.raise_signal, signal.SIGINT))
    assert done.status is TaskStatus.DONE


def test_an_interrupt_reaches_no_worker_however_early(capfd: pytest.CaptureFixture[str]) -> None:
    # As Ctrl-C does, which reaches the whole process group: while the worker starts, again and again.
    stop = threading.Event()

    def interrupt_the_workers() -> None:
        while not stop.wait(0.01):
            for child in multiprocessing.active_children():
                if child.pid is not None:
                    with suppress(ProcessLookupError):  # it may have ended by itself
                        os.kill(child.pid, signal.SIGINT)

    thread = threading.Thread(target=interrupt_the_workers)
    thread.start()
    try:
        results = run(*(call(square, 2) for _ in range(4)))
    finally:
        stop.set()
        thread.join()
    assert [result.value for result in results] == [4, 4, 4, 4]
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("number", INTERRUPTS)
def test_an_interrupt_while_a_worker_is_started_is_not_lost(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = multiprocessing.process.BaseProcess.start
    started: list[multiprocessing.process.BaseProcess] = []

    def start_interrupted(process: multiprocessing.process.BaseProcess) -> None:
        signal.raise_signal(number)
        start(process)
        started.append(process)

    monkeypatch.setattr(multiprocessing.process.BaseProcess, "start", start_interrupted)
    before = signal.signal(number, signal.default_int_handler)
    try:
        assert run_supervised([call(square, 2)], workers=1).interrupted
    finally:
        signal.signal(number, before)
    assert len(started) == 1
    assert number not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_a_worker_inherits_no_blocked_signals() -> None:
    (done,) = run(call(signal.pthread_sigmask, signal.SIG_BLOCK, ()))
    assert done.value == set()


def test_a_busy_worker_does_not_outlive_a_parent_that_is_killed(tmp_path: Path) -> None:
    note = tmp_path / "id of the worker"
    program = (
        "import sys, pathlib\n"
        "from stackdsl.supervising.processes import run_supervised\n"
        "from stackdsl.supervising.worker import Task\n"
        f"from {tasks.__name__} import note_and_hang\n"
        "run_supervised([Task(note_and_hang, (pathlib.Path(sys.argv[1]),), 600.0)], 1)"
    )
    parent = subprocess.Popen([sys.executable, "-c", program, str(note)], cwd=ROOT, stderr=subprocess.PIPE)
    while not note.exists() or not note.read_text(encoding="utf-8"):
        assert parent.poll() is None
        time.sleep(0.01)
    parent.kill()
    try:
        # The worker has the same stream of errors, which ends with the last of its owners.
        parent.communicate(timeout=AMPLE)
    except subprocess.TimeoutExpired:
        os.kill(int(note.read_text(encoding="utf-8")), signal.SIGKILL)
        raise


def test_no_worker_survives_the_call() -> None:
    for result in run(*(call(process_id) for _ in range(3)), workers=3):
        assert isinstance(result.value, int)
        assert is_gone(result.value)


def test_a_listener_that_fails_ends_the_call_and_all_workers() -> None:
    heard: list[object] = []
    before = multiprocessing.active_children()  # such as the process that this one keeps to read files in

    def fail(index: int, result: TaskResult) -> None:
        heard.append(result.value)
        raise LookupError("nobody listens")

    with pytest.raises(LookupError, match="nobody listens"):
        run_supervised([call(process_id), call(hang)], 2, fail)
    assert isinstance(heard[0], int)
    assert not set(multiprocessing.active_children()) - set(before)


def is_gone(process: int) -> bool:
    try:
        os.kill(process, 0)
        status = Path(f"/proc/{process}/stat").read_text(encoding="utf-8") if sys.platform == "linux" else ""
    except (ProcessLookupError, FileNotFoundError):
        return True
    return status.rpartition(")")[2].startswith(" Z")  # dead, and nobody has asked how it ended


# Whether a worker is a copy shows in what it has imported; asked of a process without the threads of a test runner.
COPIED = """
import sys, threading
from types import ModuleType
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import Task

if __name__ == "__main__":
    sys.modules["only here"] = ModuleType("only here")
    release = threading.Event()
    threads = [threading.Thread(target=release.wait) for _ in range(THREADS)]
    for thread in threads:
        thread.start()
    (result,) = run_supervised([Task(eval, ("'only here' in __import__('sys').modules",), 60.0)], 1).results
    release.set()
    print(result.value)
"""


@pytest.mark.parametrize(("threads", "copied"), [(0, "True"), (1, "False")])
def test_a_worker_is_a_copy_of_this_process_unless_that_has_several_threads(
    tmp_path: Path, threads: int, copied: str
) -> None:
    script = tmp_path / "script.py"
    script.write_text(COPIED.replace("THREADS", str(threads)), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, script], env=environment, capture_output=True, encoding="utf-8", check=True)
    assert done.stdout == copied + "\n"


def test_on_wait_is_called_again_and_again(tmp_path: Path) -> None:
    told, enough = count(1), tmp_path / "told three times"

    def on_wait() -> None:
        if next(told) == 3:
            enough.touch()

    (result,) = run_supervised([call(wait_for, enough)], 1, on_wait=on_wait).results
    assert result.status is TaskStatus.DONE
