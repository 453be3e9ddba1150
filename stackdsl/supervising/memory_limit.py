"""How much memory one worker may take: so much that the machine goes on, whatever a case does."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

SHARE: Final = 0.75  # of the memory that there is: what takes more would have the system kill whatever it likes
CONTAINER: Final = Path("/sys/fs/cgroup/memory.max")


def limit_memory() -> None:
    """Let this process run out of memory by itself, which is a crash of its task, before the machine does."""
    with suppress(ImportError, OSError, ValueError):  # not on Windows; and who may not lower it keeps what there is
        import resource  # noqa: PLC0415 -- as said

        most = int(SHARE * min(_installed(), _granted()))
        soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
        least = min((limit for limit in (most, soft) if limit != resource.RLIM_INFINITY), default=most)
        resource.setrlimit(resource.RLIMIT_DATA, (least, hard))


def _installed() -> int:
    """Memory of the machine [bytes]."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _granted() -> int:
    """What a container grants [bytes]; all, if none says otherwise."""
    with suppress(OSError, ValueError):
        return int(CONTAINER.read_text(encoding="ascii"))
    return _installed()
