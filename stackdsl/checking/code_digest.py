"""Which program this is: its own code, the libraries under it, Python and the machine, as one digest.

What one program has found out says nothing of another, so whatever is remembered is remembered of a program.
"""

import os
import platform
import sys
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Final

from stackdsl import LOADED

PACKAGES: Final = ("stability", "stackdsl")
LIBRARIES: Final = ("clarabel", "mujoco", "numpy", "pint", "pybullet", "pydantic", "pyyaml", "sapien", "scipy")
ARITHMETIC: Final = ("clarabel", "numpy", "scipy")  # those of them that every number goes through
SUFFIXES: Final = (".py", ".json", ".yaml")  # of what the packages read of themselves
SETTINGS: Final = ("OPENBLAS_CORETYPE",)  # of the environment, that may change a last digit
CLOCK: Final = 0.05  # [s] by which the clock of a disk may be behind


def program_digest() -> str:
    """A digest of all that may change what comes of a case."""
    digest = sha256()
    for part in _parts():
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()


@cache
def portable_digest(packages: tuple[str, ...] = ()) -> str:
    """A digest of what decides the results of a case, wherever it is installed: the code and what it reckons by.

    `packages` are those of engines.
    """
    digest = sha256(f"Python {sys.version_info.major}.{sys.version_info.minor}".encode())
    home = _home()
    for part in (part for file in _files() for part in (file.relative_to(home).as_posix().encode(), file.read_bytes())):
        digest.update(len(part).to_bytes(8, "big") + part)
    digest.update("".join(f"{name} {_version(name)}\n" for name in (*ARITHMETIC, *packages)).encode())
    return digest.hexdigest()


def code_is_older() -> bool:
    """Whether the code on the disk was last written before this process had loaded its own."""
    return all(file.stat().st_mtime < LOADED - CLOCK for file in _files())


def _parts() -> Iterator[bytes]:
    for file in _files():
        yield str(file).encode()
        yield file.read_bytes()
    told = (sys.version, sys.implementation.cache_tag, platform.system(), platform.machine(), platform.node())
    yield from (str(text).encode() for text in told)
    yield from (f"{name} {_metadata(name)}".encode() for name in LIBRARIES)
    yield from (f"{name}={os.environ.get(name, '')}".encode() for name in SETTINGS)


def _home() -> Path:
    return Path(__file__).parent.parent.parent


def _files() -> Iterator[Path]:
    for package in PACKAGES:
        yield from sorted(file for file in (_home() / package).rglob("*") if file.suffix in SUFFIXES)


def _version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415 -- `--help` does without

    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def _metadata(name: str) -> str:
    """What is installed under a name, in its makers' words; the version alone would take longer to read."""
    from importlib.metadata import PackageNotFoundError, distribution  # noqa: PLC0415 -- `--help` does without

    try:
        return distribution(name).read_text("METADATA") or ""
    except PackageNotFoundError:
        return ""
