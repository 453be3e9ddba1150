"""A supervised worker process: runs tasks one at a time, with a memory limit."""

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import Enum, StrEnum
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from time import monotonic
from typing import Final

from stability.process_settings import exclude_from_collection
from stackdsl.entry_points import PluginError
from stackdsl.exits import INTERRUPTS

# Limits the memory of a worker, so that no task exhausts the memory of the machine.


SHARE: Final = 0.75  # of all memory; beyond, the system may kill any process
CONTAINER: Final = Path("/sys/fs/cgroup/memory.max")
STATUS: Final = Path("/proc/self/statm")
DATA: Final = 5  # index of the size of the data segment in STATUS


def limit_memory() -> None:
    """Limit the memory of this process, so that its task crashes before the machine runs out of memory."""
    with suppress(OSError):
        _lower(int(SHARE * min(_installed(), _granted())))


@contextmanager
def memory_limited(more: int) -> Iterator[None]:
    """Limit this process to `more` additional bytes within the block; without limit if its size is unknown."""
    before = None
    with suppress(OSError):
        used = int(STATUS.read_text(encoding="ascii").split()[DATA]) * os.sysconf("SC_PAGE_SIZE")
        before = _lower(used + more)
    try:
        yield
    finally:
        if before is not None:
            import resource  # noqa: PLC0415 -- not on Windows

            resource.setrlimit(resource.RLIMIT_DATA, before)


def _lower(most: int) -> tuple[int, int] | None:
    """Lower the memory limit of this process to `most` bytes, and return the old limits; None if that is impossible."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # noqa: PLC0415 -- not on Windows

        soft, hard = before = resource.getrlimit(resource.RLIMIT_DATA)
        least = min((limit for limit in (most, soft) if limit != resource.RLIM_INFINITY), default=most)
        resource.setrlimit(resource.RLIMIT_DATA, (least, hard))
        return before
    return None


def _installed() -> int:
    """Return the memory of the machine [bytes]."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _granted() -> int:
    """Return the memory limit of the container [bytes]; the memory of the machine if there is none."""
    with suppress(OSError, ValueError):
        return int(CONTAINER.read_text(encoding="ascii"))
    return _installed()


# The worker process and its protocol.
#
# Each worker has a pipe of its own and one task at a time, so that the task that kills it is known. A task may run code
# of others, such as a plugged-in engine, which can write to the pipe. So a message is a frame: a random token of the
# task, the length of the message, the message, the token. The supervisor never waits for the rest of a frame. Bytes
# that are not a frame count as a crash of the task, and the worker is killed.


TOKEN = 16  # [bytes]
LENGTH = 8  # [bytes] of the length of a message, big-endian
LONGEST_MESSAGE = 2_000  # [characters] of the error of a task, and ten times as many of its traceback
BEGUN = b"begun"  # sent by a worker after its imports, when it calls the function
_STARTING = threading.Lock()
_OURS: set[Connection] = set()  # the open pipe ends of this process to its workers
SAFE_PATH = "PYTHONSAFEPATH"  # environment variable; keeps Python from importing from the working directory
START_LIMIT = 120.0  # [s] for a worker to start and import; then the time limit of the task begins


@dataclass(frozen=True, slots=True)
class Task:
    """A call that a worker makes."""

    function: Callable[..., object]  # importable by name, for pickle
    arguments: tuple[object, ...]  # picklable
    limit: float  # [s] of wall time


class WorkerStart(Enum):
    """The way to start a worker."""

    COPY = "copy"  # fork of this process: fastest, but unsafe with several threads, where it becomes NEW
    NEW = "new"  # a fresh process without imports
    PREPARED = "prepared"  # one process per task, forked from a process that only imported the modules of all tasks


class TaskStatus(StrEnum):
    """How a task ended."""

    DONE = "done"
    CRASHED = "crashed"  # it raised an error, or killed its worker
    TIMED_OUT = "timed out"
    NOT_RUN = "not run"  # the pool was interrupted before the task ended


@dataclass(frozen=True, slots=True)
class TaskResult:
    """The result of a task."""

    status: TaskStatus
    value: object = None  # return value of the function
    message: str = ""  # of the error
    details: str = ""  # traceback of the error, if there is one


class GarbledError(Exception):
    """The pipe of a worker contains bytes that are not a frame."""


@dataclass
class Worker:
    """A worker process, as its supervisor sees it."""

    process: BaseProcess
    connection: Connection
    index: int = -1  # of the current task
    limit: float = START_LIMIT  # [s]
    deadline: float = 0.0  # by the monotonic clock [s]
    token: bytes = b""  # of the current task
    received: bytearray = field(default_factory=bytearray)  # incomplete message

    @classmethod
    def started(cls, start: WorkerStart, imported: Sequence[str]) -> "Worker":
        """Start a worker; a prepared one is forked from a process that has only imported these modules.

        The caller must hold back interrupts during the call.
        """
        ours, theirs = multiprocessing.Pipe()
        _OURS.add(ours)
        process = _process(start, imported, theirs)
        with _may_start_processes():
            process.start()
        # While this end is open here, the death of the worker would not close the stream.
        theirs.close()
        return cls(process, ours)

    def allow(self, limit: float) -> None:
        """Set the deadline to `limit` from now [s]."""
        self.limit, self.deadline = limit, monotonic() + limit

    def order(self, order: bytes) -> None:
        """Send a task. Raises OSError if the worker is dead."""
        self.token = os.urandom(TOKEN)
        self.received.clear()
        self.connection.send_bytes(self.token + order)

    def message(self) -> bytes | None:
        """Return the next complete message; None if there is none. Does not wait.

        Raises EOFError or OSError if the worker can send no more, GarbledError for bytes that are not a frame.
        """
        message = self._complete_message()
        while message is None and self.connection.poll():
            if not (arrived := os.read(self.connection.fileno(), 1 << 20)):
                raise EOFError
            self.received += arrived
            message = self._complete_message()
        return message

    def _complete_message(self) -> bytes | None:
        head = TOKEN + LENGTH
        if self.received[:TOKEN] != self.token[: len(self.received)]:
            raise GarbledError
        if len(self.received) < head:
            return None
        end = head + int.from_bytes(self.received[TOKEN:head])
        if len(self.received) < end + TOKEN:
            return None
        if self.received[end : end + TOKEN] != self.token:
            raise GarbledError
        message = bytes(self.received[head:end])
        del self.received[: end + TOKEN]
        return message

    def kill(self) -> None:
        """Kill the worker and all processes that its tasks have started."""
        assert self.process.pid
        with suppress(ProcessLookupError, PermissionError):  # it may be dead, or may not lead its group yet
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.join()
        _OURS.discard(self.connection)
        self.connection.close()


@contextmanager
def _may_start_processes() -> Iterator[None]:
    """Let a daemon process, such as a worker of Dask, start processes, and keep these from unsafe imports.

    The standard library forbids children of daemons, since nothing would end them; our workers end with their parent.
    It starts Python by a command that would import modules from the working directory, before those of the library.
    """
    own = multiprocessing.current_process()
    with _STARTING:  # of two threads at once, one would restore the settings of the other
        was_daemon, safe_path = own.daemon, os.environ.get(SAFE_PATH)
        try:
            if was_daemon:
                own.daemon = False
            os.environ[SAFE_PATH] = "1"
            yield
        finally:
            if was_daemon:
                own.daemon = True
            if safe_path is None:
                del os.environ[SAFE_PATH]
            else:
                os.environ[SAFE_PATH] = safe_path


def _process(start: WorkerStart, imported: Sequence[str], connection: Connection) -> BaseProcess:
    if start is WorkerStart.PREPARED:
        server = multiprocessing.get_context("forkserver")
        server.set_forkserver_preload([*imported])
        return server.Process(target=_serve, args=(connection,), daemon=True)
    if start is WorkerStart.COPY:
        return multiprocessing.get_context("fork").Process(target=_serve, args=(connection,), daemon=True)
    return multiprocessing.get_context("spawn").Process(target=_serve, args=(connection,), daemon=True)


def safe(start: WorkerStart) -> WorkerStart:
    """Return NEW in place of COPY if this process has several threads, of Python or of a library.

    A copy has only one of the threads, and would wait forever for locks that the others held. Only Linux tells the
    number of threads.
    """
    if start is not WorkerStart.COPY:
        return start
    with suppress(OSError):
        if len(os.listdir("/proc/self/task")) == 1:
            return WorkerStart.COPY
    return WorkerStart.NEW


@contextmanager
def interrupts_held_back(start: WorkerStart = WorkerStart.COPY) -> Iterator[None]:
    """Delay INTERRUPTS to the end of the block; a process started inside never gets one.

    Ctrl-C reaches the whole process group. A child inherits blocked signals. Ignored signals would be inherited, too,
    but this process would lose them. Another thread may receive a signal that this one blocks, hence the handler.
    """
    if start is not WorkerStart.COPY:
        from multiprocessing import resource_tracker  # noqa: PLC0415 -- copies do not need it

        with _may_start_processes():
            resource_tracker.ensure_running()  # started inside the block, it would unblock the signals
    received: list[int] = []
    is_main_thread = threading.current_thread() is threading.main_thread()  # only the main thread may set handlers
    numbers = INTERRUPTS if is_main_thread else ()
    handlers = {number: signal.signal(number, lambda number, _: received.append(number)) for number in numbers}
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for caught in received:
            signal.raise_signal(caught)


def crash(error: BaseException) -> TaskResult:
    """Return the result of a task that raised an error."""
    text = str(error) if isinstance(error, PluginError) else traceback.format_exception_only(error)[-1].strip()
    message = _shortened(text, LONGEST_MESSAGE)
    details = _shortened("".join(traceback.format_exception(error)), 10 * LONGEST_MESSAGE)
    return TaskResult(TaskStatus.CRASHED, message=message, details=details)


def _shortened(text: str, most: int) -> str:
    """Cut the middle out of a text of more than `most` characters; both ends of a traceback matter."""
    if len(text) <= most:
        return text
    return f"{text[: most // 2]} ... ({len(text)} characters) ... {text[-most // 2 :]}"


def cause_of_death(process: BaseProcess) -> str:
    """Return the text about the exit code or the signal that ended a worker."""
    code = process.exitcode or 0
    if code >= 0:
        return f"the worker exited with code {code}"
    try:
        return f"the worker was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was killed by signal {-code}"


def _serve(connection: Connection) -> None:
    """Run the worker: one task after the other, until the supervisor closes the pipe."""
    while _OURS:  # inherited by a copy: a task could wait for itself there, or send tasks to other workers
        _OURS.pop().close()
    os.setpgid(0, 0)  # processes that a task starts belong to this group, and die with it
    process = os.getpid()
    # The parent handles Ctrl-C. Signals that stay blocked would also be blocked in processes that a task starts.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # likewise
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a copy inherits the handler of the parent
    signal.pthread_sigmask(signal.SIG_UNBLOCK, INTERRUPTS)
    exclude_from_collection()
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _keep_off_stdout()
    limit_memory()
    with suppress(EOFError, OSError):
        while True:
            order = connection.recv_bytes()
            tell = partial(_tell, connection, process, order[:TOKEN])
            tell(_carry_out(order[TOKEN:], partial(tell, BEGUN)))


def _tell(connection: Connection, process: int, token: bytes, message: bytes) -> None:
    """Send a message; in a copy of the worker that the task has forked, exit instead."""
    if os.getpid() != process:
        os._exit(0)
    for part in (token + len(message).to_bytes(LENGTH), message, token):
        unsent = memoryview(part)
        while unsent:
            unsent = unsent[os.write(connection.fileno(), unsent) :]


def _end_with_parent() -> None:
    """End the worker with its parent: a parent that is killed cannot end it, and its task may take long."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    # Also needed for a worker whose task has closed the pipe.
    os.killpg(0, signal.SIGKILL)


def _keep_off_stdout() -> None:
    """Silence native libraries on descriptor 1, where the parent writes its report; Python prints go to stderr."""
    devnull = os.open(os.devnull, os.O_WRONLY)
    os.dup2(devnull, 1)
    os.close(devnull)
    sys.stdout = sys.stderr


def _carry_out(order: bytes, tell_begun: Callable[[], None]) -> bytes:
    try:
        function, arguments = pickle.loads(order)
        tell_begun()
        return pickle.dumps(TaskResult(TaskStatus.DONE, function(*arguments)))
    except BaseException as error:  # a task that exits Python ends only itself
        return pickle.dumps(crash(error))
