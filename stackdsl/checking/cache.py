"""The result cache: what passed and failed before, keyed by a digest of the program and its inputs."""

import hmac
import json
import os
import platform
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from time import time
from typing import TYPE_CHECKING, Final

from stackdsl import LOADED
from stackdsl.checking.own_key import made_own_key, own_key
from stackdsl.disk import make_folder, read_file, remove_file, remove_folder, replace_file, unlinked
from stackdsl.results import UNCHECKED, GoldenStatus, VariantResult

if TYPE_CHECKING:
    from pydantic import TypeAdapter


# Which program this is: its own code, the libraries under it, Python and the machine, as one digest.
#
# What one program has found out says nothing of another, so whatever is remembered is remembered of a program.


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


# What is remembered from call to call: which cases a file holds, which passed, and which failed last.
#
# A pass is remembered under a digest of all that it came from: the program, the text of the file, the text of the
# golden file that it was compared with, and what was asked for. Whatever else happens to these files, it is played
# again: so is what failed, always. A record is signed with a key of this user; one that does not fit, is cut short or
# is somebody else's is none. Where there is no such key, nothing is remembered but what failed.


KEPT: Final = 14 * 86400.0  # [s] that what another program remembered is kept since it was last used
PROGRAM: Final = re.compile(r"[0-9a-f]{32}")  # the name of a directory that remembers what a program found
RECORD: Final = re.compile(r"[0-9a-f]{64}\.json|\.[0-9a-f]{16}\.tmp")  # those of its files, whole and under way
IGNORED: Final = "# Nothing is lost with this directory, and nothing here is for others.\n*\n"


@dataclass
class ResultCache:
    """What is remembered in a directory; one that cannot be written, or that is not meant to be used, stays empty.

    Whoever sent the project may have made this directory. Where it, or a part of it, is a link, nothing is read from
    there and nothing is written to it; and only what has a name that this program gives is removed.
    """

    folder: Path  # such as `.stackdsl` of a project
    used: bool = True  # whether passes and files are remembered; what failed last always is
    _written: list[tuple[str, object]] = field(default_factory=list)

    @cached_property
    def program(self) -> str:
        """The program at hand; asked for before anything is played."""
        return program_digest()

    @property
    def home(self) -> Path:
        """The folder that holds the state directory; all files of the state must lie inside it."""
        return self.folder.parent

    @property
    def _records(self) -> Path:
        """The records of this program. Raises LeadsOutsideError where a link is in its place."""
        return unlinked(self.folder, "passed", self.program[:32])

    def key(self, *parts: object) -> str:
        """The name of a record of this program."""
        return _digest(json.dumps([self.program, *map(str, parts)]).encode())

    def recall(self, key: str) -> object:
        """The JSON value of a record; None if there is none."""
        if not self.used:
            return None
        with suppress(OSError, ValueError, RecursionError):
            head, _, text = read_file(unlinked(self._records, f"{key}.json"), within=self.home).partition(b"\n")
            secret = own_key()
            if secret is not None and hmac.compare_digest(head, _signature(secret, key, text)):
                value: object = json.loads(text)
                return value
        return None

    def remember(self, key: str, value: object) -> None:
        """Keep the JSON value of a record, once `settle` is called."""
        if self.used:
            self._written.append((key, value))

    def settle(self) -> None:
        """Write down what is to be remembered, unless the code is another by now than what this process has loaded."""
        if not self._written:
            return
        with suppress(OSError):  # a disk that takes nothing costs time only
            secret = made_own_key()
            if secret is not None and code_is_older() and program_digest() == self.program:
                records = self._records
                self._prepare(records)
                for key, value in self._written:
                    text = json.dumps(value).encode()
                    signed = _signature(secret, key, text) + b"\n" + text
                    replace_file(records / f"{key}.json", signed, self.home)
                self._forget_others()
        self._written.clear()

    def _prepare(self, folder: Path) -> None:
        make_folder(folder, self.home)
        ignored = self.folder / ".gitignore"
        if not ignored.exists():
            replace_file(ignored, IGNORED.encode(), self.home)

    def _forget_others(self) -> None:
        """Let go of what other programs remembered long ago."""
        own = self._records
        os.utime(own)
        with os.scandir(own.parent) as entries:
            others = [entry for entry in entries if PROGRAM.fullmatch(entry.name)]
        for entry in others:
            if entry.is_dir(follow_symlinks=False) and time() - entry.stat(follow_symlinks=False).st_mtime > KEPT:
                _remove_records(unlinked(own.parent, entry.name), self.home)

    def failed(self) -> frozenset[str]:
        """The names of the cases that failed when they were last played."""
        with suppress(OSError, ValueError, RecursionError):
            names = json.loads(read_file(unlinked(self.folder, "failed.json"), within=self.home))
            if isinstance(names, list):
                return frozenset(name for name in names if isinstance(name, str))
        return frozenset()

    def keep_failed(self, failed: Iterable[str], played: Iterable[str]) -> None:
        """Remember which of the cases that were played failed; what is known of others stays."""
        before = self.failed()
        names = (before - frozenset(played)) | frozenset(failed)
        if names != before:
            with suppress(OSError):
                self._prepare(unlinked(self.folder))
                replace_file(self.folder / "failed.json", json.dumps(sorted(names)).encode(), self.home)


def may_be_remembered(result: VariantResult) -> bool:
    """Whether a result is a pass, or no failure, that was compared with a golden file, and the same in all of it."""
    golden = result.golden
    return (
        result.passed
        and result.conclusion in ("passed", UNCHECKED)
        and golden is not None
        and golden.status is GoldenStatus.SAME
    )


def as_record(result: VariantResult) -> object:
    """A result as a JSON value."""
    return asdict(result)


def from_record(value: object) -> VariantResult | None:
    """The result that a JSON value tells of, if it is one that may be remembered."""
    try:
        result = _adapter().validate_python(value)
    except ValueError:
        return None
    return replace(result, remembered=True) if may_be_remembered(result) else None


@cache
def _adapter() -> "TypeAdapter[VariantResult]":
    from pydantic import TypeAdapter  # noqa: PLC0415 -- where something is remembered

    return TypeAdapter(VariantResult)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()


def _signature(secret: bytes, key: str, text: bytes) -> bytes:
    return hmac.new(secret, key.encode() + text, sha256).hexdigest().encode()


def _remove_records(folder: Path, home: Path) -> None:
    """Remove the records in a directory, and it as well unless it holds something else."""
    with suppress(OSError):
        for name in os.listdir(folder):
            if RECORD.fullmatch(name):
                remove_file(folder / name, home)
        remove_folder(folder, home)
