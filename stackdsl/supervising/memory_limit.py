"""How much memory one worker may take: so much that the machine goes on, whatever a case does."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

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
