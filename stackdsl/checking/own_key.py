"""A key that this user alone has. What is remembered in a project is signed with it: others may have sent the project.

It is made once, in the folder for states of programs (XDG_STATE_HOME), and nobody else can read it.
"""

import os
import stat
from contextlib import suppress
from pathlib import Path
from secrets import token_bytes, token_hex
from typing import Final

LENGTH: Final = 32  # [bytes]
OTHERS: Final = 0o077  # what others may do with a file


def key_file() -> Path:
    """Where the key is. Raises RuntimeError where this user has no home."""
    asked = os.environ.get("XDG_STATE_HOME", "")
    states = Path(asked) if os.path.isabs(asked) else Path.home() / ".local" / "state"
    return states / "stackdsl" / "key"


def own_key() -> bytes | None:
    """The key; None if there is none, or if anybody else owns it or can read it."""
    with suppress(OSError, RuntimeError):
        descriptor = os.open(key_file(), os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(descriptor, "rb") as file:
            found = os.fstat(descriptor)
            is_own = stat.S_ISREG(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & OTHERS
            key = file.read(LENGTH + 1) if is_own else b""
            return key if len(key) == LENGTH else None
    return None


def made_own_key() -> bytes | None:
    """The key, which is made if there is none; None where that cannot be."""
    if (key := own_key()) is not None:
        return key
    with suppress(OSError, RuntimeError):
        file = key_file()
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        fresh = file.with_name(f".{token_hex(8)}.tmp")
        try:
            with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:
                stream.write(token_bytes(LENGTH))
            os.link(fresh, file)  # fails where another process was quicker, whose key it is then
        finally:
            fresh.unlink(missing_ok=True)
    return own_key()
