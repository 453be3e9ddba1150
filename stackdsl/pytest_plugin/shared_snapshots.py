"""Golden files for tests in Python, through syrupy: the same files, comparison and bytes as in `stackdsl check`.

A run that fails its expectations is accepted only with --accept-failing, and two tests cannot lock different runs in
one file. A file that no test uses any more is reported, and removed by --snapshot-update. A difference is pending until
it is accepted or rejected, as one of a scenario in YAML.
"""

import json
import os
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, NamedTuple

import pytest
from syrupy.assertion import SnapshotAssertion
from syrupy.data import SnapshotCollection, SnapshotCollections
from syrupy.extensions.base import AbstractSyrupyExtension
from syrupy.extensions.json import JSONSnapshotExtension
from syrupy.location import PyTestLocation
from syrupy.types import PropertyFilter, PropertyMatcher, SerializableData, SerializedData, SnapshotIndex

from stability.name_order import names_text
from stackdsl.goldens.file_format import canonical_text, directory_of, golden_name
from stackdsl.goldens.golden import (
    COMPARED,
    ELSEWHERE,
    PendingStore,
    check_golden,
    content_of,
    is_ci,
    is_lost,
    judge_text,
    keeper_in,
    keeper_of,
    kept_by_python,
    refusal,
    refuse_in_ci,
    remove_obsolete,
    with_keeper,
    write_golden,
)
from stackdsl.goldens.snapshot import Identity, Snapshot
from stackdsl.pytest_plugin.golden_directory import golden_directory, scenario_directory, state_directory
from stackdsl.pytest_plugin.scenario_file import ACCEPT, ACCEPT_FAILING, REVIEW, LockedFiles
from stackdsl.pytest_plugin.scenario_warnings import ENGINE_INDEPENDENT, OtherEngineWarning
from stackdsl.report.golden_differences import difference_lines
from stackdsl.results import GoldenResult, GoldenStatus
from stackdsl.shown_text import visible

UPDATE_OUTSIDE = "pytest --snapshot-update outside of CI, and commit the golden file"
WIDTH = 100  # of the lines of a difference, which pytest indents
Golden = Callable[[Identity], SnapshotAssertion]


class Locked(NamedTuple):
    """A golden file that a test of this session has used."""

    test: str
    text: str  # of the snapshot
    keepers: set[str]  # owners whose tests use the file


UsedFiles = pytest.StashKey[dict[Path, Locked]]()
ReplacedFiles = pytest.StashKey[dict[Path, bytes | None]]()


@dataclass(frozen=True, slots=True)
class Lock:
    """The use of golden files by one test."""

    keeper: str  # owner that written files name, see `stackdsl.goldens.golden`
    test: str
    folder: Path
    refuses_failing: bool  # whether a golden file is to be written only for a run that meets its expectations
    waiting: PendingStore | None  # of differences that await a decision; None in CI
    used: dict[Path, Locked]
    replaced: dict[Path, bytes | None]  # earlier content of each file that this session has written
    locked: dict[Path, GoldenResult]  # the same files, with what they leave unclear

    def refuse(self, snapshot: Snapshot, text: str) -> None:
        """Fail the test if another one has locked another run in its file, or if the run must not be accepted."""
        file = self.folder / golden_name(snapshot.identity)
        first = self.used.setdefault(file, Locked(self.test, text, set()))
        first.keepers.add(self.keeper)
        if first.test != self.test and not _agree(first.text, text):
            self.used[file] = first._replace(text="")  # so that no later run is written
            self.take_back(file)
            name = snapshot.identity.scenario
            pytest.fail(
                f"SD203 two tests have different runs of scenarios called '{name}', which share one golden file: "
                f"{first.test} and {self.test}\n"
                f'  = name each scenario after its parameter, such as f"{name}-{{levels}}"',
                pytrace=False,
            )
        if self.refuses_failing and snapshot.missed:
            stored = content_of(str(file))
            if not isinstance(stored, bytes) or not _agree(stored.decode("utf-8", "replace"), text):
                pytest.fail(f"{file}: {refusal(snapshot, '--accept-failing')}", pytrace=False)

    def note(self, snapshot: Snapshot) -> None:
        """Store the difference of a snapshot from its golden file, or drop an earlier one."""
        if self.waiting is not None:
            found = check_golden(replace(snapshot, kept_by=self.keeper), self.folder, update=False)
            self.waiting.note(snapshot.identity.case, found, snapshot.missed)

    def write(self, file: Path, text: str) -> None:
        """Write a golden file, and drop its pending difference."""
        before = content_of(str(file))
        self.replaced.setdefault(file, before if isinstance(before, bytes) else None)
        write_golden(file, text, directory_of(file))
        # A golden file that did not agree was shown by the failed test before.
        self.locked[file] = replace(judge_text(os.path.relpath(file), text, json.loads(text)), status=GoldenStatus.NEW)
        self._settle(file)

    def take_back(self, file: Path) -> None:
        """Restore a golden file that this session has written, and drop its pending difference."""
        self._settle(file)
        self.locked.pop(file, None)
        if file in self.replaced:
            if (before := self.replaced.pop(file)) is None:
                remove_obsolete([str(file)])
            else:
                write_golden(file, before.decode("utf-8", "replace"), directory_of(file))

    def _settle(self, file: Path) -> None:
        if self.waiting is not None:
            self.waiting.forget([str(file)])


def _agree(stored: str, text: str) -> bool:
    return bool(judge_text("", stored, json.loads(text)))


def unused_files(config: pytest.Config, tests: Iterable[Path], whole: bool) -> Iterator[Path]:
    """Yield the golden files of these test files, all of whose tests have passed, that no test has used.

    If these are all test files of the project (`whole`), golden files of test files that no longer exist are included.
    """
    used = config.stash.get(UsedFiles, {})
    for folder, keepers in _keepers_of(config, tests).items():
        for file in sorted(folder.glob("*/*.json")):
            if file not in used and str(file) not in COMPARED:
                keeper = keeper_in(content_of(str(file)))
                if keeper in keepers or (whole and is_lost(keeper, folder)):
                    yield file


def forget_gone(config: pytest.Config, tests: Iterable[Path], whole: bool) -> Iterator[str]:
    """Drop the pending differences of these test files that no test has used, if golden files are updated.

    Yield the names of their golden files. `tests` and `whole` are as for `unused_files`.
    """
    used = {os.path.abspath(file) for file in config.stash.get(UsedFiles, {})} | COMPARED
    for folder, keepers in _keepers_of(config, tests).items() if _updates(config) else ():
        waiting = PendingStore(state_directory(config, folder, folder), folder)
        for pending in waiting.all():
            keeper = keeper_in(pending.text.encode("ascii"))
            kept = keeper in keepers or (whole and is_lost(keeper, folder))
            if kept and os.path.abspath(waiting.home / pending.golden) not in used:
                waiting.reject(pending)
                yield visible(pending.golden)


def _keepers_of(config: pytest.Config, tests: Iterable[Path]) -> dict[Path, set[str]]:
    """Return the names of test files as owners, by directory of golden files."""
    owners = defaultdict[Path, set[str]](set)
    for test in tests:
        folder = golden_directory(config, test)
        owners[folder] |= {keeper_of(str(test), folder, scenario_directory(config, test))} - {"", ELSEWHERE}
    return owners


def moved_files(config: pytest.Config, tests: Iterable[Path]) -> Iterator[tuple[Path, str, str]]:
    """Yield the golden files in use whose owner does not use them, with that owner and one that does.

    The owner no longer exists, or is among `tests`, all of whose tests have passed.
    """
    owners = _keepers_of(config, tests)
    for file, locked in config.stash.get(UsedFiles, {}).items():
        folder = directory_of(file)
        keeper, users = keeper_in(content_of(str(file))), sorted(locked.keepers - {"", ELSEWHERE})
        if users and keeper not in users and (keeper in owners.get(folder, ()) or is_lost(keeper, folder)):
            yield file, keeper, users[0]


def hand_over(config: pytest.Config, file: Path, user: str) -> bool:
    """Write the owner that uses a golden file into it, if golden files are updated; return whether it was written."""
    content = content_of(str(file))
    if not _updates(config) or not isinstance(content, bytes):
        return False
    write_golden(file, with_keeper(content, user).decode("utf-8", "surrogateescape"), directory_of(file))
    return True


def _updates(config: pytest.Config) -> bool:
    return bool(config.getoption("update_snapshots", default=False)) and not is_ci(os.environ)


def remove_unused(config: pytest.Config, file: Path) -> bool:
    """Remove a golden file that no test uses, if golden files are updated; return whether it was removed."""
    if not _updates(config):
        return False
    folder = directory_of(file)
    PendingStore(state_directory(config, folder, folder), folder).forget([str(file)])
    return bool(remove_obsolete([str(file)]))


class GoldenExtension(JSONSnapshotExtension):
    """Stores snapshots in the golden files of `stackdsl check`; the index of an assertion is the file name."""

    lock: ClassVar["Lock"]
    fails: bool = False  # whether the run of the snapshot fails its expectations

    def serialize(
        self,
        data: SerializableData,
        *,
        exclude: PropertyFilter | None = None,
        include: PropertyFilter | None = None,
        matcher: PropertyMatcher | None = None,
    ) -> SerializedData:
        if not isinstance(data, Snapshot):
            raise TypeError(f"a golden file needs a Snapshot of stackdsl, not {type(data).__name__}")
        text = canonical_text(replace(data, kept_by=self.lock.keeper or None))
        self.lock.refuse(data, text)
        self.lock.note(data)
        self.fails = bool(data.missed)
        return text

    def matches(self, *, serialized_data: SerializableData, snapshot_data: SerializableData) -> bool:
        result = judge_text("", snapshot_data, json.loads(serialized_data))
        if result.status is GoldenStatus.OTHER_ENGINE:
            warnings.warn(OtherEngineWarning(f"{ENGINE_INDEPENDENT}: {result.note}"), stacklevel=2)
        return result.status in (GoldenStatus.SAME, GoldenStatus.OTHER_ENGINE)

    def diff_lines(self, serialized_data: SerializedData, snapshot_data: SerializedData) -> Iterator[str]:
        """Yield the commands, then the differences as in reports, instead of the line-by-line diff of syrupy.

        The commands come first, since pytest shows only the first lines of a long text.
        """
        yield f"accept with: {UPDATE_OUTSIDE if is_ci(os.environ) else ACCEPT_FAILING if self.fails else ACCEPT}"
        if self.lock.waiting is not None:
            yield f"decide with: {REVIEW}"
        if not snapshot_data:
            yield from self._others()
            return
        result = judge_text("", str(snapshot_data), json.loads(serialized_data))
        yield from filter(None, [result.note])
        yield from difference_lines(result, WIDTH)

    def _others(self) -> Iterator[str]:
        """Yield which golden files of the same Python file no test has used so far: the scenario may be renamed."""
        lock = self.lock
        others = [file for file in kept_by_python(lock.folder).get(lock.keeper, ()) if Path(file) not in lock.used]
        if others:
            names = names_text([os.path.relpath(file) for file in others])
            yield f"{visible(names)}: kept by this file; a golden file belongs to the name of the scenario"

    def discover_snapshots(
        self, *, test_location: PyTestLocation, ignore_extensions: list[str] | None = None
    ) -> SnapshotCollections:
        """Return none, so that syrupy neither reports nor deletes golden files that this session does not read."""
        return SnapshotCollections()

    @classmethod
    def discovery_dirname(cls, *, test_location: PyTestLocation) -> str:
        """Return one name for all tests, as no folder is searched.

        Syrupy asks for it once for each extension and each test file: to read the project file each time took minutes.
        """
        return ""

    @classmethod
    def get_snapshot_name(cls, *, test_location: PyTestLocation, index: SnapshotIndex = 0) -> str:
        """Return the test, from which syrupy requires a name to start, with its golden file."""
        file = os.path.relpath(cls.get_location(test_location=test_location, index=index))
        return AbstractSyrupyExtension.get_snapshot_name(test_location=test_location, index=file)

    @classmethod
    def dirname(cls, *, test_location: PyTestLocation) -> str:
        return str(golden_directory(test_location.item.config, test_location.item.path))

    @classmethod
    def get_location(cls, *, test_location: PyTestLocation, index: SnapshotIndex) -> str:
        return str(Path(cls.dirname(test_location=test_location)) / str(index))

    @classmethod
    def matches_test_location(cls, *, test_location: PyTestLocation, snapshot_location: str) -> bool:
        return True

    def read_snapshot_data_from_location(
        self, *, snapshot_location: str, snapshot_name: str, session_id: str
    ) -> SerializableData | None:
        # Invalid UTF-8 is also invalid JSON, which is reported as unreadable.
        content = content_of(snapshot_location)
        if isinstance(content, bytes):
            return content.decode("utf-8", "replace")
        return None if content.status is GoldenStatus.MISSING else content.note

    @classmethod
    def write_snapshot_collection(
        cls, *, snapshot_collection: SnapshotCollection, name_order: dict[str, int] | None = None
    ) -> None:
        refuse_in_ci(os.environ)
        for snapshot in snapshot_collection:
            cls.lock.write(Path(snapshot_collection.location), str(snapshot.data))


def lock_of(request: pytest.FixtureRequest) -> Lock:
    """Return the use of golden files by the test of a request."""
    config, test = request.config, request.path
    folder = golden_directory(config, test)
    updates, accept_failing = (config.getoption(name, default=False) for name in ("update_snapshots", "accept_failing"))
    return Lock(
        keeper=keeper_of(str(test), folder, scenario_directory(config, test)),
        test=request.node.nodeid,
        folder=folder,
        refuses_failing=bool(updates) and not accept_failing,
        waiting=None if is_ci(os.environ) else PendingStore(state_directory(config, test, folder), folder),
        used=config.stash.setdefault(UsedFiles, {}),
        replaced=config.stash.setdefault(ReplacedFiles, {}),
        locked=config.stash.setdefault(LockedFiles, {}),
    )


def compare_with_golden(snapshot: SnapshotAssertion, lock: Lock) -> Golden:
    """Return a function from an identity to the assertion on its golden file."""
    extension = type("GoldenExtension", (GoldenExtension,), {"lock": lock})  # syrupy creates the instances

    def golden(identity: Identity) -> SnapshotAssertion:
        return snapshot.use_extension(extension)(name=golden_name(identity))

    return golden
