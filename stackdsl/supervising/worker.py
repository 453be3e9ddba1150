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
from stackdsl.exits import INTERRUPTS

# How much memory one worker may take: so much that the machine goes on, whatever a case does.


SHARE: Final = 0.75  # of the memory that there is: what takes more would have the system kill whatever it likes
CONTAINER: Final = Path("/sys/fs/cgroup/memory.max")
STATUS: Final = Path("/proc/self/statm")
DATA: Final = 5  # its place in STATUS


def limit_memory() -> None:
    """Let this process run out of memory by itself, which is a crash of its task, before the machine does."""
    with suppress(OSError):
        _lower(int(SHARE * min(_installed(), _granted())))


@contextmanager
def memory_limited(more: int) -> Iterator[None]:
    """Let this process take at most so many more bytes meanwhile; where nobody knows what it has, as many as before."""
    before = None
    with suppress(OSError):
        held = int(STATUS.read_text(encoding="ascii").split()[DATA]) * os.sysconf("SC_PAGE_SIZE")
        before = _lower(held + more)
    try:
        yield
    finally:
        if before is not None:
            import resource  # noqa: PLC0415 -- not on Windows

            resource.setrlimit(resource.RLIMIT_DATA, before)


def _lower(most: int) -> tuple[int, int] | None:
    """Let this process have so many bytes at most, if it may have more; returns the limits before."""
    with suppress(ImportError, OSError, ValueError):  # not on Windows; and who may not lower it keeps what there is
        import resource  # noqa: PLC0415 -- as said

        soft, hard = before = resource.getrlimit(resource.RLIMIT_DATA)
        least = min((limit for limit in (most, soft) if limit != resource.RLIM_INFINITY), default=most)
        resource.setrlimit(resource.RLIMIT_DATA, (least, hard))
        return before
    return None


def _installed() -> int:
    """Memory of the machine [bytes]."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _granted() -> int:
    """What a container grants [bytes]; all, if none says otherwise."""
    with suppress(OSError, ValueError):
        return int(CONTAINER.read_text(encoding="ascii"))
    return _installed()


# A process that carries out tasks for another one, which supervises it.
#
# Each has a pipe of its own and one task at a time, so that whatever brings it down is known by name. A task may run
# code of others, such as an engine that is plugged in, which finds the descriptor of the pipe in its process. So a
# message is a frame: a token that is drawn for this task, the length of the message, the message, the token. The
# supervisor never waits for the rest of a frame, and what is no frame ends the worker, as a crash of its task.


TOKEN = 16  # [bytes]
LENGTH = 8  # [bytes] of the length of a message, big-endian
LONGEST_MESSAGE = 2_000  # [characters] of the error of a task, and ten times as many of its traceback
BEGUN = b"begun"  # a worker's word that it has all it needs and calls the function now
_STARTING = threading.Lock()
_OURS: set[Connection] = set()  # the ends of pipes to workers that this process has open
SAFE_PATH = "PYTHONSAFEPATH"  # what keeps Python from looking for modules in the working directory
START_LIMIT = 120.0  # [s] for a worker to start and import what a task needs, before the task's own limit counts


@dataclass(frozen=True, slots=True)
class Task:
    """A call to be made in another process."""

    function: Callable[..., object]  # importable by name, as pickle needs it
    arguments: tuple[object, ...]  # picklable
    limit: float  # [s] of wall time


class WorkerStart(Enum):
    """What a worker is when it begins."""

    COPY = "copy"  # of this process, which is quickest; of one with several threads no copy is safe, so it is NEW there
    NEW = "new"  # a process that has imported nothing
    PREPARED = "prepared"  # one for each task, which did nothing before but import what functions of tasks are in


class TaskStatus(StrEnum):
    """How a task ended."""

    DONE = "done"
    CRASHED = "crashed"  # it raised, or took its worker down with it
    TIMED_OUT = "timed out"
    NOT_RUN = "not run"  # the pool was interrupted before it ended


@dataclass(frozen=True, slots=True)
class TaskResult:
    """What became of a task."""

    status: TaskStatus
    value: object = None  # what the function returned
    message: str = ""  # why it did not
    details: str = ""  # the traceback, where there is one


class GarbledError(Exception):
    """Bytes in the pipe of a worker that are no message of it."""


@dataclass
class Worker:
    process: BaseProcess
    connection: Connection
    index: int = -1  # of the task in hand
    limit: float = START_LIMIT  # [s]
    deadline: float = 0.0  # by the monotonic clock [s]
    token: bytes = b""  # of the task in hand
    received: bytearray = field(default_factory=bytearray)  # of a message that has not arrived whole

    @classmethod
    def started(cls, start: WorkerStart, imported: Sequence[str]) -> "Worker":
        """A new worker; one that is prepared comes from a process that has imported these modules and did no more.

        Interrupts are to be held back meanwhile.
        """
        ours, theirs = multiprocessing.Pipe()
        _OURS.add(ours)
        process = _process(start, imported, theirs)
        with _may_start_processes():
            process.start()
        # As long as this end is open here, the death of the worker would not end the stream.
        theirs.close()
        return cls(process, ours)

    def allow(self, limit: float) -> None:
        """Give it so much time [s] from now."""
        self.limit, self.deadline = limit, monotonic() + limit

    def order(self, order: bytes) -> None:
        """Send it a task. Raises OSError if it is gone."""
        self.token = os.urandom(TOKEN)
        self.received.clear()
        self.connection.send_bytes(self.token + order)

    def message(self) -> bytes | None:
        """The next message that has arrived whole; None if there is none. Waits for nothing.

        Raises EOFError or OSError if nothing more can come, GarbledError for what is no message.
        """
        found = self._taken()
        while found is None and self.connection.poll():
            if not (arrived := os.read(self.connection.fileno(), 1 << 20)):
                raise EOFError
            self.received += arrived
            found = self._taken()
        return found

    def _taken(self) -> bytes | None:
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
        found = bytes(self.received[head:end])
        del self.received[: end + TOKEN]
        return found

    def kill(self) -> None:
        """End it, whatever it does, and what its tasks have started; all that was wanted of it has been received."""
        assert self.process.pid
        with suppress(ProcessLookupError, PermissionError):  # it may be gone, or may not lead its group yet
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.join()
        _OURS.discard(self.connection)
        self.connection.close()


@contextmanager
def _may_start_processes() -> Iterator[None]:
    """Let a process start others though it is a daemon, as workers of Dask are, and let them import safely.

    The library forbids the first, since nobody would end them; a worker of ours ends by itself once its parent has.
    And it starts Python by a command, which would find modules in the working directory, before those of the library.
    """
    own = multiprocessing.current_process()
    with _STARTING:  # two threads that put back what was would each see the other's
        was, path = own.daemon, os.environ.get(SAFE_PATH)
        try:
            if was:
                own.daemon = False
            os.environ[SAFE_PATH] = "1"
            yield
        finally:
            if was:
                own.daemon = True
            if path is None:
                del os.environ[SAFE_PATH]
            else:
                os.environ[SAFE_PATH] = path


def _process(start: WorkerStart, imported: Sequence[str], connection: Connection) -> BaseProcess:
    if start is WorkerStart.PREPARED:
        server = multiprocessing.get_context("forkserver")
        server.set_forkserver_preload([*imported])
        return server.Process(target=_serve, args=(connection,), daemon=True)
    if start is WorkerStart.COPY:
        return multiprocessing.get_context("fork").Process(target=_serve, args=(connection,), daemon=True)
    return multiprocessing.get_context("spawn").Process(target=_serve, args=(connection,), daemon=True)


def safe(start: WorkerStart) -> WorkerStart:
    """How to start a worker here and now: a process with several threads, of Python or of a library, is not copied.

    The copy would have one of them only, and wait in vain for what the others held. Elsewhere than on Linux nobody
    knows how many there are.
    """
    if start is not WorkerStart.COPY:
        return start
    with suppress(OSError):
        if len(os.listdir("/proc/self/task")) == 1:
            return WorkerStart.COPY
    return WorkerStart.NEW


@contextmanager
def interrupts_held_back(start: WorkerStart = WorkerStart.COPY) -> Iterator[None]:
    """Put off INTERRUPTS to the end; a process started meanwhile gets none, from its first instruction on.

    Ctrl-C reaches the whole process group. A process inherits what is blocked, as it would what is ignored, but what is
    ignored would be lost here. Another thread may take what this one blocks, hence the handler.
    """
    if start is not WorkerStart.COPY:
        from multiprocessing import resource_tracker  # noqa: PLC0415 -- copies do without

        with _may_start_processes():
            resource_tracker.ensure_running()  # else a process would start it, which lets interrupts through again
    pressed: list[int] = []
    main = threading.current_thread() is threading.main_thread()  # of another thread interrupts are no affair
    held = INTERRUPTS if main else ()
    handlers = {number: signal.signal(number, lambda number, _: pressed.append(number)) for number in held}
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for caught in pressed:
            signal.raise_signal(caught)


def crash(error: BaseException) -> TaskResult:
    message = _shortened(traceback.format_exception_only(error)[-1].strip(), LONGEST_MESSAGE)
    details = _shortened("".join(traceback.format_exception(error)), 10 * LONGEST_MESSAGE)
    return TaskResult(TaskStatus.CRASHED, message=message, details=details)


def _shortened(text: str, most: int) -> str:
    """A text without its middle, if it is longer than so many characters: of a traceback, both ends say something."""
    if len(text) <= most:
        return text
    return f"{text[: most // 2]} ... ({len(text)} characters) ... {text[-most // 2 :]}"


def cause_of_death(process: BaseProcess) -> str:
    code = process.exitcode or 0
    if code >= 0:
        return f"the worker exited with code {code}"
    try:
        return f"the worker was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"the worker was killed by signal {-code}"


def _serve(connection: Connection) -> None:
    """What a worker does: one order after the other, until nobody is left to give any."""
    while _OURS:  # which a copy has as well: a task could wait for itself there, or give orders to others
        _OURS.pop().close()
    os.setpgid(0, 0)  # what a task starts is of this group, and ends with it
    process = os.getpid()
    # The parent decides what Ctrl-C means; held back so far, it would stay so in whatever a task starts.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # likewise
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # in a copy of the parent, it would mean what it means there
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
    """Send a message, unless this is a copy of the worker that its task has made: then there is nothing more to do."""
    if os.getpid() != process:
        os._exit(0)
    for part in (token + len(message).to_bytes(LENGTH), message, token):
        left = memoryview(part)
        while left:
            left = left[os.write(connection.fileno(), left) :]


def _end_with_parent() -> None:
    """A parent that is killed ends nobody, and a task in hand may take long: nobody is left to want its result."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    # What a worker that has cut its own connections comes to as well, whoever notices first.
    os.killpg(0, signal.SIGKILL)


def _keep_off_stdout() -> None:
    """Native libraries chatter on descriptor 1, where the parent writes its report; prints of Python go to stderr."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = sys.stderr


def _carry_out(order: bytes, tell_begun: Callable[[], None]) -> bytes:
    try:
        function, arguments = pickle.loads(order)
        tell_begun()
        return pickle.dumps(TaskResult(TaskStatus.DONE, function(*arguments)))
    except BaseException as error:  # a task that exits Python ends itself, not its worker
        return pickle.dumps(crash(error))
