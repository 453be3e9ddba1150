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
from syrupy.extensions.json import JSONSnapshotExtension
from syrupy.location import PyTestLocation
from syrupy.types import PropertyFilter, PropertyMatcher, SerializableData, SerializedData, SnapshotIndex

from stackdsl.goldens.file_format import canonical_text, directory_of, golden_name
from stackdsl.goldens.golden import (
    COMPARED,
    ELSEWHERE,
    PendingStore,
    check_golden,
    content_of,
    is_ci,
    judge_text,
    keeper_in,
    keeper_of,
    refusal,
    refuse_in_ci,
    remove_obsolete,
    write_golden,
)
from stackdsl.goldens.snapshot import Identity, Snapshot
from stackdsl.pytest_plugin.golden_directory import golden_directory, scenario_directory, state_directory
from stackdsl.pytest_plugin.scenario_file import ACCEPT, ACCEPT_FAILING, REVIEW, LockedFiles
from stackdsl.pytest_plugin.scenario_warnings import ENGINE_INDEPENDENT, OtherEngineWarning
from stackdsl.report.golden_differences import difference_lines
from stackdsl.results import GoldenResult, GoldenStatus

UPDATE_OUTSIDE = "pytest --snapshot-update outside of CI, and commit the golden file"
WIDTH = 100  # of the lines of a difference, which pytest indents
Golden = Callable[[Identity], SnapshotAssertion]


class Locked(NamedTuple):
    """A golden file that a test of this session has used."""

    test: str
    text: str  # of the snapshot
    keeper: str


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
        first = self.used.setdefault(file, Locked(self.test, text, self.keeper))
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


def unused_files(config: pytest.Config, tests: Iterable[Path]) -> Iterator[Path]:
    """Yield the golden files of these test files, all of whose tests have passed, that no test has used."""
    used = config.stash.get(UsedFiles, {})
    owners = defaultdict[Path, set[str]](set)  # by directory of golden files
    for test in tests:
        folder = golden_directory(config, test)
        owners[folder].add(keeper_of(str(test), folder, scenario_directory(config, test)))
    for folder, keepers in owners.items():
        for file in sorted(folder.glob("*/*.json")):
            if (
                file not in used
                and str(file) not in COMPARED
                and keeper_in(content_of(str(file))) in keepers - {"", ELSEWHERE}
            ):
                yield file


def remove_unused(config: pytest.Config, file: Path) -> bool:
    """Remove a golden file that no test uses, if golden files are updated; return whether it was removed."""
    if not config.getoption("update_snapshots", default=False) or is_ci(os.environ):
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
            return
        result = judge_text("", str(snapshot_data), json.loads(serialized_data))
        yield from filter(None, [result.note])
        yield from difference_lines(result, WIDTH)

    def discover_snapshots(
        self, *, test_location: PyTestLocation, ignore_extensions: list[str] | None = None
    ) -> SnapshotCollections:
        """Return none, so that syrupy neither reports nor deletes golden files that this session does not read."""
        return SnapshotCollections()

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
