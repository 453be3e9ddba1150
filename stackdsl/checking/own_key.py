"""The user's secret key, which signs the records of the result cache: the project may come from an untrusted author.

It is created once, in the user's state directory (XDG_STATE_HOME), readable by the user only.
"""

import os
import stat
from contextlib import suppress
from pathlib import Path
from secrets import token_bytes, token_hex
from typing import Final

LENGTH: Final = 32  # [bytes]
OTHERS: Final = 0o077  # permission bits of other users


def key_file() -> Path:
    """Return the path of the key. Raises RuntimeError if the user has no home directory."""
    configured = os.environ.get("XDG_STATE_HOME", "")
    states = Path(configured) if os.path.isabs(configured) else Path.home() / ".local" / "state"
    return states / "stackdsl" / "key"


def own_key() -> bytes | None:
    """Return the key; None if it does not exist, belongs to another user or is readable by others."""
    with suppress(OSError, RuntimeError):
        descriptor = os.open(key_file(), os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            is_own = stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid() and not status.st_mode & OTHERS
            key = file.read(LENGTH + 1) if is_own else b""
            return key if len(key) == LENGTH else None
    return None


def own_or_new_key() -> bytes | None:
    """Return the key, creating it if necessary; None if that fails."""
    if (key := own_key()) is not None:
        return key
    with suppress(OSError, RuntimeError):
        file = key_file()
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        fresh = file.with_name(f".{token_hex(8)}.tmp")
        try:
            with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:
                stream.write(token_bytes(LENGTH))
            os.link(fresh, file)  # fails if another process was faster; then use its key
        finally:
            fresh.unlink(missing_ok=True)
    return own_key()
