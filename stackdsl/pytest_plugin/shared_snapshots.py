"""Golden files for tests in Python, through syrupy: the same files, comparison and bytes as in `stackdsl check`.

A run that fails its expectations is accepted only with --accept-failing, and two tests cannot lock different runs in
one file. Files that their tests no longer use are reported, but not removed.
"""

import json
import os
import warnings
from collections.abc import Callable, Iterator, Mapping
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
    ELSEWHERE,
    content_of,
    judge_text,
    keeper_in,
    refusal,
    refuse_in_ci,
    write_golden,
)
from stackdsl.goldens.snapshot import Identity, Snapshot
from stackdsl.pytest_plugin.golden_directory import golden_directory
from stackdsl.pytest_plugin.scenario_warnings import ENGINE_INDEPENDENT, OtherEngineWarning
from stackdsl.results import GoldenStatus

Golden = Callable[[Identity], SnapshotAssertion]


class Locked(NamedTuple):
    """A golden file that a test of this session has used."""

    test: str
    text: str  # of the snapshot
    keeper: str


UsedFiles = pytest.StashKey[dict[Path, Locked]]()


@dataclass(frozen=True, slots=True)
class Lock:
    """The use of golden files by one test."""

    keeper: str  # owner that written files name, see `stackdsl.goldens.golden`
    test: str
    folder: Path
    refuses_failing: bool  # whether a golden file is to be written only for a run that meets its expectations
    used: dict[Path, Locked]

    def refuse(self, snapshot: Snapshot, text: str) -> None:
        """Fail the test if another one has locked another run in its file, or if the run must not be accepted."""
        file = self.folder / golden_name(snapshot.identity)
        first = self.used.setdefault(file, Locked(self.test, text, self.keeper))
        if first.test != self.test and not _agree(first.text, text):
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


def _agree(stored: str, text: str) -> bool:
    return bool(judge_text("", stored, json.loads(text)))


def unused_files(used: Mapping[Path, Locked]) -> list[Path]:
    """Return the golden files of the tests of this session that none of them has used."""
    keepers = {locked.keeper for locked in used.values()} - {"", ELSEWHERE}
    folders = {directory_of(file) for file in used}
    found = [file for folder in folders for file in folder.glob("*/*.json") if file not in used]
    return sorted(file for file in found if keeper_in(content_of(str(file))) in keepers)


class GoldenExtension(JSONSnapshotExtension):
    """Stores snapshots in the golden files of `stackdsl check`; the index of an assertion is the file name."""

    lock: ClassVar["Lock"]

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
        return text

    def matches(self, *, serialized_data: SerializableData, snapshot_data: SerializableData) -> bool:
        result = judge_text("", snapshot_data, json.loads(serialized_data))
        if result.status is GoldenStatus.OTHER_ENGINE:
            warnings.warn(OtherEngineWarning(f"{ENGINE_INDEPENDENT}: {result.note}"), stacklevel=2)
        return result.status in (GoldenStatus.SAME, GoldenStatus.OTHER_ENGINE)

    def diff_lines(self, serialized_data: SerializedData, snapshot_data: SerializedData) -> Iterator[str]:
        """Yield one line per difference, instead of the line-by-line diff of syrupy."""
        if not snapshot_data:
            yield "there is no golden file; write it with: pytest --snapshot-update"
            return
        result = judge_text("", str(snapshot_data), json.loads(serialized_data))
        yield from filter(None, [result.note])
        for each in result.differences:
            values = f"expected {each.expected}, got {each.got} (tolerance {each.tolerance})"
            yield f"{each.subject}: {each.quantity}: {values}"

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
            file = Path(snapshot_collection.location)
            write_golden(file, str(snapshot.data), directory_of(file))


def compare_with_golden(snapshot: SnapshotAssertion, lock: Lock) -> Golden:
    """Return a function from an identity to the assertion on its golden file."""
    extension = type("GoldenExtension", (GoldenExtension,), {"lock": lock})  # syrupy creates the instances

    def golden(identity: Identity) -> SnapshotAssertion:
        return snapshot.use_extension(extension)(name=golden_name(identity))

    return golden
