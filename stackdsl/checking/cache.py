"""The result cache: earlier passes and failures, keyed by a digest of the program and its inputs."""

import hmac
import json
import os
import platform
import re
import stat
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from secrets import token_bytes, token_hex
from time import time
from typing import TYPE_CHECKING, Final

from stackdsl import LOADED
from stackdsl.disk import make_folder, read_file, remove_file, remove_folder, replace_file, unlinked
from stackdsl.results import UNCHECKED, GoldenStatus, VariantResult

if TYPE_CHECKING:
    from pydantic import TypeAdapter


# The digest of the program: its code, its libraries, Python and the machine.
#
# Another program may compute another result, so each record belongs to one program.


PACKAGES: Final = ("stability", "stackdsl")
LIBRARIES: Final = ("clarabel", "mujoco", "numba", "numpy", "pint", "pybullet", "pydantic", "pyyaml", "scipy")
ARITHMETIC: Final = ("clarabel", "numpy", "scipy")  # libraries that affect every number
SUFFIXES: Final = (".py", ".json", ".yaml")  # of the files of the packages that affect results
SETTINGS: Final = ("OPENBLAS_CORETYPE",)  # environment variables that may change a last digit
CLOCK: Final = 0.05  # [s] by which file times may lag behind


def program_digest() -> str:
    """Return the digest of everything that may change the result of a case."""
    digest = sha256()
    for part in _parts():
        digest.update(len(part).to_bytes(8, "big") + part)
    return digest.hexdigest()


@cache
def portable_digest(packages: tuple[str, ...] = ()) -> str:
    """Return a digest of the code and the numeric libraries, independent of the place of installation.

    `packages` are those of the engines in use.
    """
    digest = sha256(f"Python {sys.version_info.major}.{sys.version_info.minor}".encode())
    home = _home()
    for part in (part for file in _files() for part in (file.relative_to(home).as_posix().encode(), file.read_bytes())):
        digest.update(len(part).to_bytes(8, "big") + part)
    digest.update("".join(f"{name} {_version(name)}\n" for name in (*ARITHMETIC, *packages)).encode())
    return digest.hexdigest()


def code_is_older() -> bool:
    """Whether the code on disk was last written before this process loaded it."""
    return all(file.stat().st_mtime < LOADED - CLOCK for file in _files())


def _parts() -> Iterator[bytes]:
    for file in _files():
        yield str(file).encode()
        yield file.read_bytes()
    details = (sys.version, sys.implementation.cache_tag, platform.system(), platform.machine(), platform.node())
    yield from (str(text).encode() for text in details)
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
    """Return the metadata of an installed package; reading the version alone would be slower."""
    from importlib.metadata import PackageNotFoundError, distribution  # noqa: PLC0415 -- `--help` does without

    try:
        return distribution(name).read_text("METADATA") or ""
    except PackageNotFoundError:
        return ""


# The user's secret key, which signs the records: the project may come from an untrusted author.
#
# It is created once, in the user's state directory (XDG_STATE_HOME), readable by the user only.


KEY_LENGTH: Final = 32  # [bytes]
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
            key = file.read(KEY_LENGTH + 1) if is_own else b""
            return key if len(key) == KEY_LENGTH else None
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
                stream.write(token_bytes(KEY_LENGTH))
            os.link(fresh, file)  # fails if another process was faster; then use its key
        finally:
            fresh.unlink(missing_ok=True)
    return own_key()


# The records: the cases of each file, the passes, and the names of the cases that failed last.
#
# The key of a pass is a digest of all its inputs: the program, the text of the file, the text of the golden file and
# the options. If any of them changes, the case runs again. Failed cases always run again. Each record is signed with a
# key of this user. A record that is truncated, or signed by anybody else, is ignored. Without a key, only failures are
# recorded.


MAX_AGE: Final = 14 * 86400.0  # [s] since the last use of the records of another program
PROGRAM: Final = re.compile(r"[0-9a-f]{32}")  # directory of the records of one program
RECORD: Final = re.compile(r"[0-9a-f]{64}\.json|\.[0-9a-f]{16}\.tmp")  # its files, also half-written ones
IGNORED: Final = "# A cache of stackdsl, which can be deleted at any time and is not shared.\n*\n"


@dataclass
class ResultCache:
    """Records in a directory. If the directory cannot be written, or must not be used, the cache stays empty.

    The directory may come with the project from an untrusted author. So this reads and writes nothing through symbolic
    links, and removes only files with the names of records.
    """

    folder: Path  # such as `.stackdsl` of a project
    used: bool = True  # whether passes and files are recorded; failures always are
    _written: list[tuple[str, object]] = field(default_factory=list)

    @cached_property
    def program(self) -> str:
        """The digest of this program; first read before any case runs."""
        return program_digest()

    @property
    def home(self) -> Path:
        """The folder that holds the state directory; all files of the state must lie inside it."""
        return self.folder.parent

    @property
    def _records(self) -> Path:
        """The directory with the records of this program. Raises LeadsOutsideError for a symbolic link."""
        return unlinked(self.folder, "passed", self.program[:32])

    def key(self, *parts: object) -> str:
        """Return the key of a record of this program."""
        return _digest(json.dumps([self.program, *map(str, parts)]).encode())

    def recall(self, key: str) -> object:
        """Return the JSON value of a record; None if there is no valid one."""
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
        """Add a record with a JSON value; `settle` writes it."""
        if self.used:
            self._written.append((key, value))

    def settle(self) -> None:
        """Write the added records, unless the code has changed since this process loaded it."""
        if not self._written:
            return
        with suppress(OSError):  # without records, checks only take longer
            secret = own_or_new_key()
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
        """Remove the records of other programs that have not been used for long."""
        own = self._records
        os.utime(own)
        with os.scandir(own.parent) as entries:
            others = [entry for entry in entries if PROGRAM.fullmatch(entry.name)]
        for entry in others:
            if entry.is_dir(follow_symlinks=False) and time() - entry.stat(follow_symlinks=False).st_mtime > MAX_AGE:
                _remove_records(unlinked(own.parent, entry.name), self.home)

    def failed(self) -> frozenset[str]:
        """Return the names of the cases that failed in their last run."""
        with suppress(OSError, ValueError, RecursionError):
            names = json.loads(read_file(unlinked(self.folder, "failed.json"), within=self.home))
            if isinstance(names, list):
                return frozenset(name for name in names if isinstance(name, str))
        return frozenset()

    def keep_failed(self, failed: Iterable[str], played: Iterable[str]) -> None:
        """Record which of the cases that ran failed; keep the records of other cases."""
        before = self.failed()
        names = (before - frozenset(played)) | frozenset(failed)
        if names != before:
            with suppress(OSError):
                self._prepare(unlinked(self.folder))
                replace_file(self.folder / "failed.json", json.dumps(sorted(names)).encode(), self.home)


def is_cacheable(result: VariantResult) -> bool:
    """Whether a result may be recorded: it passed or has no claims, and it equals its golden file."""
    golden = result.golden
    return (
        result.passed
        and result.conclusion in ("passed", UNCHECKED)
        and golden is not None
        and golden.status is GoldenStatus.SAME
    )


def to_record(result: VariantResult) -> object:
    """Return a result as a JSON value."""
    return asdict(result)


def from_record(value: object) -> VariantResult | None:
    """Return the result of a JSON value; None if it is invalid or not cacheable."""
    try:
        result = _adapter().validate_python(value)
    except ValueError:
        return None
    return replace(result, remembered=True) if is_cacheable(result) else None


@cache
def _adapter() -> "TypeAdapter[VariantResult]":
    from pydantic import TypeAdapter  # noqa: PLC0415 -- slow, and needed for records only

    return TypeAdapter(VariantResult)


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()


def _signature(secret: bytes, key: str, text: bytes) -> bytes:
    return hmac.new(secret, key.encode() + text, sha256).hexdigest().encode()


def _remove_records(folder: Path, home: Path) -> None:
    """Remove the records in a directory, and the directory itself if it is empty then."""
    with suppress(OSError):
        for name in os.listdir(folder):
            if RECORD.fullmatch(name):
                remove_file(folder / name, home)
        remove_folder(folder, home)
