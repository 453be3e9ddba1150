"""What is remembered from call to call: which cases a file holds, which passed, and which failed last.

A pass is remembered under a digest of all that it came from: the program, the text of the file, the text of the golden
file that it was compared with, and what was asked for. Whatever else happens to these files, it is played again: so is
what failed, always. A record says its own digest; one that does not fit, is cut short or is somebody else's is none.
"""

import json
import os
import shutil
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from secrets import token_hex
from time import time
from typing import TYPE_CHECKING, Final

from stackdsl.checking.code_digest import code_is_older, program_digest
from stackdsl.outcome import GoldenStatus, VariantResult

if TYPE_CHECKING:
    from pydantic import TypeAdapter

KEPT: Final = 14 * 86400.0  # [s] that what another program remembered is kept since it was last used
IGNORED: Final = "# Nothing is lost with this directory, and nothing here is for others.\n*\n"


@dataclass
class Memory:
    """What is remembered in a directory; one that cannot be written, or that is not meant to be used, stays empty."""

    folder: Path  # such as `.stackdsl` of a project
    used: bool = True  # whether passes and files are remembered; what failed last always is
    _written: list[tuple[str, object]] = field(default_factory=list)

    @cached_property
    def program(self) -> str:
        """The program at hand; asked for before anything is played."""
        return program_digest()

    @property
    def _records(self) -> Path:
        return self.folder / "passed" / self.program[:32]

    def key(self, *parts: object) -> str:
        """The name of a record of this program."""
        return _digest(json.dumps([self.program, *map(str, parts)]).encode())

    def recall(self, key: str) -> object:
        """The JSON value of a record; None if there is none."""
        if not self.used:
            return None
        with suppress(OSError, ValueError, RecursionError):
            head, _, text = (self._records / f"{key}.json").read_bytes().partition(b"\n")
            if head.decode() == _digest(key.encode() + text):
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
            if code_is_older() and program_digest() == self.program:
                self._prepare(self._records)
                for key, value in self._written:
                    text = json.dumps(value).encode()
                    _put(self._records / f"{key}.json", _digest(key.encode() + text).encode() + b"\n" + text)
                self._forget_others()
        self._written.clear()

    def _prepare(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        ignored = self.folder / ".gitignore"
        if not ignored.exists():
            _put(ignored, IGNORED.encode())

    def _forget_others(self) -> None:
        """Let go of what other programs remembered long ago."""
        os.utime(self._records)
        for folder in self._records.parent.iterdir():
            if time() - folder.stat().st_mtime > KEPT:
                shutil.rmtree(folder, ignore_errors=True)

    def failed(self) -> frozenset[str]:
        """The names of the cases that failed when they were last played."""
        with suppress(OSError, ValueError, RecursionError):
            names = json.loads((self.folder / "failed.json").read_bytes())
            if isinstance(names, list):
                return frozenset(name for name in names if isinstance(name, str))
        return frozenset()

    def keep_failed(self, failed: Iterable[str], played: Iterable[str]) -> None:
        """Remember which of the cases that were played failed; what is known of others stays."""
        before = self.failed()
        names = (before - frozenset(played)) | frozenset(failed)
        if names != before:
            with suppress(OSError):
                self._prepare(self.folder)
                _put(self.folder / "failed.json", json.dumps(sorted(names)).encode())


def may_be_remembered(result: VariantResult) -> bool:
    """Whether a result is a pass that was compared with a golden file, and the same in all of it."""
    golden = result.golden
    return result.conclusion == "passed" and golden is not None and golden.status is GoldenStatus.SAME


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


def _put(file: Path, data: bytes) -> None:
    """Write a file as a whole: another process, or one that is killed, leaves it as it was, or as it is to be."""
    fresh = file.with_name(f".{token_hex(8)}.tmp")
    try:
        fresh.write_bytes(data)
        fresh.replace(file)
    finally:
        fresh.unlink(missing_ok=True)
