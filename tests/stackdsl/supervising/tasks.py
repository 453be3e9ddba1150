"""Tasks for supervised workers. Imports no pytest, which would double the time that a worker takes to start."""

import os
import signal
import stat
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path


def square(number: int) -> int:
    return number * number


def segfault() -> None:
    os.kill(os.getpid(), signal.SIGSEGV)


def leave(code: int) -> None:
    os._exit(code)


def leave_python() -> None:
    sys.exit(4)


def hang() -> None:
    time.sleep(600.0)


def ignore_all_and_hang() -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    hang()


def cut_all_pipes_and_hang() -> None:
    os.closerange(3, 256)
    hang()


def stumble() -> None:
    raise ValueError("no such brick")


def process_id() -> int:
    return os.getpid()


def make_noise() -> int:
    os.write(1, b"native chatter\n")
    print("chatter of Python")  # noqa: T201 -- the subject of the test
    return 1


def return_something_unpicklable() -> object:
    return lambda: None


class Unreadable:
    def __reduce__(self) -> tuple[object, ...]:
        return (stumble, ())


def return_something_unreadable() -> object:
    return Unreadable()


@dataclass(frozen=True)
class ReadOnceThere:
    """Argument that blocks its worker until a file exists, like the import of a slow module."""

    file: Path

    def __reduce__(self) -> tuple[object, ...]:
        return (wait_for, (self.file,))


def wait_for(file: Path) -> None:
    while not file.exists():
        time.sleep(0.01)


def is_nothing(value: object) -> bool:
    return value is None


def large() -> bytes:
    return bytes(5_000_000)


def interrupt_the_parent(parent: int, note: Path) -> None:
    note.write_text(str(os.getpid()), encoding="utf-8")
    os.kill(parent, signal.SIGINT)
    hang()


def pipes() -> list[int]:
    """The descriptors of this process on which one can send: of a worker, that to its supervisor is among them."""
    return [number for number in range(3, 256) if is_socket(number)]


def is_socket(number: int) -> bool:
    with suppress(OSError):
        return stat.S_ISSOCK(os.fstat(number).st_mode)
    return False


def write_into_all_pipes(what: bytes) -> int:
    for number in pipes():
        os.write(number, what)
    return 1


def promise_more_and_hang() -> None:
    write_into_all_pipes(b"\x7f\xff\xff\xff")
    hang()


def fork_and_return(note: Path) -> bool:
    """Both the worker and the copy of it come back from this call."""
    if is_worker := bool(os.fork()):
        os.wait()
    else:
        note.write_text("the copy was here", encoding="utf-8")
    return is_worker


def fork_a_child_that_stays(note: Path) -> None:
    if child := os.fork():
        note.write_text(str(child), encoding="utf-8")
        return
    hang()


def raise_a_long_text() -> None:
    raise ValueError("no such brick, " * 4_000_000)


def note_and_hang(note: Path) -> None:
    note.write_text(str(os.getpid()), encoding="utf-8")
    hang()
